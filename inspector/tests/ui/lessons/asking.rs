//! Questions, what goes on by itself, what is shown while a step measures, and what is there after a lesson.

use egui::{Key, Modifiers, Role};
use raystep_inspector::command::{Command, PaneKind};
use raystep_inspector::lesson::Lesson;
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::Arrival;
use raystep_kernels::Accelerator;
use raystep_kernels::Choices;

use super::{THREE, begin, one, problems, stage, view};
use crate::ui::desk::CORNELL;
use crate::ui::stage::Stage;

/// A step that asks for the axis of the first step, and its answer.
const ASKING: &str = "# Asking\n\n## One\n\nAfter pass {{pass}}.\n\n```raystep\n\
    open scene=built-in:cornell-box size=32x32 grid=7 device=cpu pixel=13,27\nonly walk-in-3d unfolded-walk\n\
    row \"starts in\"\nbefore-after\nquestion \"Which axis?\"\n\
    choice \"x\" if step.axis = \"x\" else \"tMax is {{step.tmax.x}} there.\"\n\
    choice \"y\" if step.axis = \"y\" else \"tMax is {{step.tmax.y}} there.\"\n\
    choice \"z\" if step.axis = \"z\"\n```\n\nIt is {{step.axis}}, after pass {{pass}}.\n\n\
    ```raystep\nrow \"is smallest\"\nbefore-after axis cell tmax state\nexpect step.from = \"3,3,6\"\n```\n\n\
    ## Two\n\n```raystep\nend\n```\n";

#[test]
fn a_question_is_answered_only_after_the_right_choice() {
    let mut stage = stage();
    begin(&mut stage, ASKING, 0);
    let asked = stage.place();
    assert!(stage.reads("Which axis?") && stage.reads("After pass 1."), "{}", stage.read_out());
    assert!(!stage.reads("It is z") && !stage.paints("0.25357"), "the answer is there before\n{}", stage.read_out());
    // By its key, and by its button.
    for (choose, tmax) in [(0, "there."), (1, "0.12")] {
        match choose {
            0 => stage.key(Modifiers::NONE, Key::Num1),
            _ => stage.click(Role::Button, "2  y"),
        }
        stage.settle();
        assert!(stage.reads("Not right.") && stage.reads(tmax), "{}", stage.read_out());
        assert!(!stage.reads("It is z") && stage.place() == asked);
    }
    stage.key(Modifiers::NONE, Key::Num3);
    stage.settle();
    assert!(stage.reads("Right.") && !stage.reads("Not right."), "{}", stage.read_out());
    // What was said before the answer keeps the values of its own place.
    assert!(stage.reads("After pass 1.") && stage.reads("It is z, after pass 3."), "{}", stage.read_out());
    assert!(stage.place() > asked && stage.paints("0.25357"), "{}", stage.read_out());
    assert_eq!(problems(&stage), Vec::<String>::new());
    // It is asked again from the start, and nobody has to answer.
    stage.perform(Command::RepeatStep);
    assert!(stage.place() == asked && !stage.reads("It is z"), "{}", stage.read_out());
    stage.perform(Command::NextStep);
    assert_eq!(stage.harness.state().lesson_step(), Some((1, 2)));
}

#[test]
fn the_walks_do_not_show_the_answer_while_it_is_asked_for() {
    let mut stage = stage();
    begin(&mut stage, ASKING, 0);
    let tells = |stage: &Stage| stage.paints(": next") || stage.painted().iter().any(|text| text == "b");
    assert!(stage.paints("tmax z 0.089") && !tells(&stage), "{:?}", stage.painted());
    // A second walk beside the first would unfold both.
    stage.perform(Command::SecondWalk);
    assert!(!tells(&stage) && !stage.reads("B bvh: "), "{:?}", stage.painted());
    stage.perform(Command::SecondWalk);
    stage.key(Modifiers::NONE, Key::Num3);
    stage.settle();
    assert!(tells(&stage), "{:?}", stage.painted());
}

#[test]
fn a_question_without_one_right_choice_is_found() {
    for (text, wanted) in [
        (ASKING.replace("if step.axis = \"z\"", "if step.axis = \"w\""), "test.md:12: 0 choices are right"),
        (ASKING.replace("if step.axis = \"x\"", "if step.axis != \"x\""), "test.md:12: 2 choices are right"),
    ] {
        let mut stage = stage();
        begin(&mut stage, &text, 0);
        let found = problems(&stage);
        assert!(found.len() == 1 && found[0].starts_with(wanted), "{found:?}");
    }
}

#[test]
fn what_a_lesson_plays_can_be_paused_and_skipped() {
    let text = one("Iterations.", "row \"starts in\"\nplay 3\nexpect ray.cells > 3").replace("32x32", "32x32 grid=7");
    let mut stage = stage();
    // Not until it has settled: it would have ended by then.
    stage.inspector().begin_lesson(Lesson::parse("test.md", &text).expect("a lesson"), 0);
    stage.until("the first iteration", |stage| stage.reads("0 of 3 iterations"));
    let start = stage.place();
    stage.until("a pass", |stage| stage.place() > start);
    stage.key(Modifiers::NONE, Key::Space);
    stage.settle();
    let paused = stage.place();
    stage.frames(120);
    assert_eq!(stage.place(), paused);
    stage.key(Modifiers::NONE, Key::Space);
    stage.until("another pass", |stage| stage.place() > paused);
    stage.click(Role::Button, "Skip");
    stage.settle();
    assert!(stage.reads("3 of 3 iterations"), "{}", stage.read_out());
    let end = stage.place();
    stage.key(Modifiers::NONE, Key::Space);
    stage.frames(120);
    assert_eq!((stage.place(), problems(&stage)), (end, Vec::new()), "it goes no farther");
}

/// A step that measures a run, and the one before it.
const MEASURING: &str = "# Measuring\n\n## One\n\nOf {{passes}} passes.\n\n```raystep\n\
    open scene=built-in:cornell-box size=256x256 device=cpu pixel=20,22\nonly stream\n```\n\n\
    ## Two\n\nPlain.\n\nOf {{passes}} passes.\n\nIt takes {{slow.passes}} passes.\n\n```raystep\n\
    measure slow size=256x256 schedule=second accelerator=none\nbars slow\n```\n\n## Three\n\nAgain {{slow.passes}}.\n\n\
    ```raystep\nend\n```\n";

#[test]
fn a_step_shows_what_it_knows_while_it_measures_and_lets_the_reader_go_on() {
    let is_measuring = |stage: &Stage| {
        let work = stage.harness.state().model().work;
        work.is_some_and(|work| work.what == "measuring a run for the lesson")
    };
    let mut stage = stage();
    begin(&mut stage, MEASURING, 0);
    for _ in 0..2 {
        stage.perform_without_waiting(Command::NextStep);
        stage.until("the measurement", is_measuring);
        stage.frame();
        assert!(stage.reads("Plain.") && stage.reads(" passes."), "{}", stage.read_out());
        let is_missing = |text: &String| text.contains('…') || text.contains('?');
        assert!(!stage.reads("It takes") && stage.reads("measuring a run"), "{}", stage.read_out());
        let shown: Vec<String> = stage.painted().into_iter().filter(is_missing).collect();
        assert!(!shown.iter().any(|text| text.contains("passes")), "{shown:?}");
        // Neither going on nor back waits for it.
        stage.perform_without_waiting(Command::PreviousStep);
        stage.settle();
        assert_eq!((stage.harness.state().lesson_step(), problems(&stage)), (Some((0, 3)), Vec::new()));
    }
    // Whatever was not waited for, all values are there in the end.
    stage.perform_without_waiting(Command::NextStep);
    stage.until("the measurement", is_measuring);
    stage.perform_without_waiting(Command::NextStep);
    stage.settle();
    assert_eq!(problems(&stage), Vec::<String>::new());
    assert!(stage.reads("Again "), "{}", stage.read_out());
    stage.perform(Command::PreviousStep);
    assert_eq!(problems(&stage), Vec::<String>::new());
    assert!(stage.reads("It takes"), "{}", stage.read_out());
}

/// A question whose choices are right or wrong by a run that has to be measured.
const OF_MEASURED: &str =
    "question \"Which?\"\nchoice \"few\" if slow.passes < 2\nchoice \"many\" if slow.passes > 1\n";

#[test]
fn a_cancelled_measurement_is_no_mistake_and_is_offered_again() {
    let mut stage = stage();
    let text = MEASURING.replace("bars slow\n", &format!("bars slow\n{OF_MEASURED}"));
    begin(&mut stage, &text, 0);
    stage.perform_without_waiting(Command::NextStep);
    stage.until("its progress", |stage| stage.reads("measuring a run") && stage.paints("%"));
    assert!(!stage.reads("Which?"), "it cannot be answered yet\n{}", stage.read_out());
    stage.click(Role::Button, "Cancel");
    stage.settle();
    // Nor does it become one when the reader looks around.
    for command in [Command::Start, Command::NudgeLeft, Command::End] {
        stage.perform(command);
        assert!(!stage.reads("not measured") && !stage.reads("test.md"), "{}", stage.read_out());
        assert!(stage.reads("Plain.") && !stage.reads("It takes"), "{}", stage.read_out());
    }
    assert_eq!(problems(&stage), ["test.md:12: not set up: it was cancelled"]);
    assert!(stage.reads("1 run of this step still to be measured."), "{}", stage.read_out());
    stage.click(Role::Button, "Measure");
    stage.settle();
    assert_eq!(problems(&stage), Vec::<String>::new());
    assert!(stage.reads("It takes") && stage.reads("Which?"), "{}", stage.read_out());
}

#[test]
fn closing_a_lesson_brings_back_the_scene_its_options_and_the_place() {
    let settings = Settings {
        size: [40, 30],
        device: DeviceKind::Cpu,
        choices: Choices { accelerator: Accelerator::Bvh, ..Choices::stepped() },
        ..Settings::default()
    };
    let arrival = Arrival { pixel: Some([7, 9]), place: Some(5), ..Arrival::default() };
    let mut stage = Stage::with_scene(CORNELL, settings, arrival);
    stage.perform(Command::Show(PaneKind::Plan));
    // Not how far tables are scrolled.
    let state = |stage: &Stage| {
        let (place, pixel, panes, settings, _) = view(stage);
        (place, pixel, panes, settings)
    };
    let before = state(&stage);
    // Two lessons one after the other, and one that is closed before its scene is open.
    begin(&mut stage, THREE, 1);
    stage.perform(Command::NudgeLeft);
    begin(&mut stage, ASKING, 0);
    stage.perform(Command::CloseLesson);
    stage.settle();
    assert_eq!(state(&stage), before);
    stage.inspector().begin_lesson(Lesson::parse("test.md", THREE).expect("a lesson"), 0);
    stage.frame();
    stage.perform(Command::CloseLesson);
    stage.settle();
    assert_eq!(state(&stage), before);
}
