//! Lessons: every step of every built-in one shows what it speaks of, in any order, and a lesson that does not is found
//! out.

mod asking;

use std::sync::atomic::{AtomicU64, Ordering};

use egui::{Key, Modifiers, Role, Vec2};
use raystep_inspector::command::{Command, Layout, PaneKind};
use raystep_inspector::lesson::Lesson;
use raystep_inspector::lesson::built_in::LESSONS;
use raystep_inspector::lesson::fact::{FACTS, FIELDS};
use raystep_inspector::lesson::words::WORDS;
use raystep_inspector::settings::{DeviceKind, Settings};
use raystep_inspector::ui::{Arrival, CheckedStep};
use raystep_kernels::{AdapterChoice, Gpu};

use crate::ui::adapter::block_on;
use crate::ui::desk::CORNELL;
use crate::ui::stage::{Plan, Stage};

/// A small window: the panels and the lesson have to fit.
const SIZE: [f32; 2] = [1280.0, 720.0];

fn stage() -> Stage {
    Stage::new(Plan { size: SIZE, ..Plan::default() })
}

fn begin(stage: &mut Stage, text: &str, step: usize) {
    let lesson = Lesson::parse("test.md", text).expect("a lesson");
    stage.inspector().begin_lesson(lesson, step);
    stage.settle();
}

fn check(stage: &Stage) -> CheckedStep {
    let shapes = &stage.harness.output().shapes;
    stage.harness.state().check_step(shapes, Vec2::from(SIZE) + Vec2::splat(16.0)).expect("a lesson")
}

/// What is wrong with the current step, as text.
fn problems(stage: &Stage) -> Vec<String> {
    check(stage).problems.iter().map(ToString::to_string).collect()
}

/// Most threads that a GPU would launch for what a step traces, so that no reader waits longer than 3 seconds: software
/// Vulkan on 2 cores runs about 20 million of those of the largest step in a second.
const MOST_WORK: u64 = 60_000_000;

/// Everything that a step sets up: the place, the ray, the panels, and all that is painted.
fn view(stage: &Stage) -> (usize, Option<[u32; 2]>, Vec<PaneKind>, Settings, Vec<String>) {
    let inspector = stage.harness.state();
    let settings = inspector.model().opened.as_ref().expect("a scene").settings.clone();
    // Times differ between two runs of the same passes.
    let is_time =
        |text: &String| [" µs", " ms", " s"].iter().any(|unit| text.contains(unit)) || text.parse::<f64>().is_ok();
    let painted = stage.painted().into_iter().filter(|text| !is_time(text)).collect();
    (stage.place(), inspector.pixel(), inspector.panes_in_view(), settings, painted)
}

/// Goes through a built-in lesson by its button, and checks each step.
fn taught(index: usize) {
    let mut stage = stage();
    stage.perform(Command::Lesson(index));
    let (_, steps) = stage.harness.state().lesson_step().expect("a lesson");
    for step in 0..steps {
        if step > 0 {
            stage.click(Role::Button, "Next");
            stage.settle();
        }
        let mut checked = check(&stage);
        while stage.inspector().go_on_with_step() {
            stage.settle();
            checked.add(check(&stage));
        }
        assert_eq!((checked.step, &checked.problems), (step, &Vec::new()), "{}\n{}", checked.title, stage.read_out());
        assert!(checked.work <= MOST_WORK, "{}: a reader waits for {} threads", checked.title, checked.work);
    }
    assert_eq!(
        stage.find(Role::Button, |name| name == "Next").map(|node| {
            use egui_kittest::kittest::NodeT as _;
            node.accesskit_node().is_disabled()
        }),
        Some(true)
    );
}

#[test]
fn how_one_ray_finds_its_triangle() {
    taught(0);
}

#[test]
fn why_the_grid_lost_in_2004() {
    taught(1);
}

#[test]
fn the_machine_of_2004() {
    taught(2);
}

#[test]
fn a_crack_at_a_voxel_face() {
    taught(3);
}

#[test]
fn what_empty_space_skipping_leaps_over() {
    taught(4);
}

#[test]
fn a_tie_that_f32_cannot_decide() {
    taught(5);
}

#[test]
fn from_ray_caster_to_path_tracer() {
    taught(6);
}

#[test]
fn why_a_pixel_is_so_bright() {
    taught(7);
}

#[test]
fn a_caustic_photon_by_photon() {
    taught(8);
}

/// The weight that a kernel gave to a hit of the lamp follows from the two pdfs that a lesson tells, which are worked out apart
/// from it.
#[test]
fn the_weight_of_a_vertex_is_that_of_its_pdfs() {
    let mut stage = stage();
    let text =
        one("{{vertex.pdf}} and {{vertex.light-pdf / vertex.pdf}} and {{vertex.weight}}.", "row 2 \"at triangle 26\"");
    let open = "scene=built-in:cornell-lamp size=96x96 accelerator=grid integrator=path spp=8 steps-per-pass=8 device=cpu \
                pixel=72,32";
    let text = text.replace("scene=built-in:cornell-box size=32x32 device=cpu pixel=20,22", open);
    begin(&mut stage, &text, 0);
    assert_eq!(problems(&stage), Vec::<String>::new());
    let said = stage.painted().into_iter().find(|text| text.contains(" and ")).expect("the text");
    let numbers: Vec<f64> =
        said.trim_end_matches('.').split(" and ").map(|text| text.parse().expect("a number")).collect();
    let [pdf, ratio, weight] = numbers[..] else { panic!("{said}") };
    // The cosine of a direction, by π.
    assert!(pdf > 0.0 && pdf < std::f64::consts::FRAC_1_PI, "{said}");
    // Both have two digits or more.
    let wanted = 1.0 / (1.0 + ratio * ratio);
    assert!(ratio > 10.0 && (weight / wanted - 1.0).abs() < 0.06, "{said}: expected {wanted}");
}

#[test]
fn lessons_have_the_titles_of_their_commands() {
    for (index, (file, text)) in LESSONS.iter().enumerate() {
        let lesson = Lesson::parse(file, text).expect("a lesson");
        let name = Command::Lesson(index).name().strip_prefix("Lesson: ").expect("a lesson");
        assert_eq!(name.to_lowercase(), lesson.title.to_lowercase());
    }
}

/// The documentation has every command and every value.
#[test]
fn the_documentation_has_all_of_the_format() {
    let docs = std::fs::read_to_string("../docs/lessons.md").expect("the documentation");
    let plain = |about: &str| about.replace('\n', " ");
    for (word, arguments, about) in WORDS {
        let arguments = if arguments.is_empty() { String::new() } else { format!("`{arguments}`") };
        let row = format!("| `{word}` | {arguments} | {} |", plain(about));
        assert!(docs.contains(&row), "not in docs/lessons.md: {row}");
    }
    let facts = FACTS.iter().map(|(_, name, about)| format!("| `{name}` | {about} |"));
    let fields = FIELDS.iter().map(|(_, name, about)| format!("| `NAME.{name}` | of a measured run: {about} |"));
    for row in facts.chain(fields) {
        assert!(docs.contains(&row), "not in docs/lessons.md: {row}");
    }
}

/// Three steps that differ in all that can be set up.
const THREE: &str = "# Three\n\n## One\n\nPass {{pass}} of {{passes}}.\n\n```raystep\n\
    open scene=built-in:cornell-box size=32x32 device=cpu pixel=20,22 stream=state\nonly stream ray\npass 3\n```\n\n\
    ## Two\n\nPass {{pass}}.\n\n```raystep\nonly ray / unfolded-walk\npixel 9,7\nrow \"outside\"\n```\n\n\
    ## Three\n\nPass {{pass}}, {{a.passes}}.\n\n```raystep\n\
    open scene=built-in:cornell-box size=32x32 device=cpu numerics=paper pixel=3,4\nshow timeline\npass 12\n\
    measure a size=16x16 schedule=second\nbars a\n```\n";

#[test]
fn a_step_is_the_same_from_wherever_it_is_reached() {
    let alone: Vec<_> = (0..3)
        .map(|step| {
            let mut stage = stage();
            begin(&mut stage, THREE, step);
            assert_eq!(problems(&stage), Vec::<String>::new());
            view(&stage)
        })
        .collect();
    assert!(alone[0] != alone[1] && alone[1] != alone[2]);
    let mut stage = stage();
    begin(&mut stage, THREE, 0);
    let (next, back) = ((Modifiers::NONE, 1), (Modifiers::SHIFT, -1));
    let mut step = 0;
    for (modifiers, by) in [next, back, next, next, back, back] {
        // The user's own clicks in between do not matter.
        stage.perform(Command::NextPass);
        stage.perform(Command::NudgeLeft);
        stage.arrange(Layout::Step);
        stage.key(modifiers, Key::F8);
        stage.settle();
        step += by;
        assert_eq!(view(&stage), alone[step as usize], "step {step}");
    }
}

#[test]
fn next_waits_for_what_is_in_progress() {
    let mut stage = stage();
    stage.inspector().begin_lesson(Lesson::parse("test.md", THREE).expect("a lesson"), 0);
    // In the middle of opening, of running, and of measuring.
    for _ in 0..2 {
        stage.frame();
        assert!(stage.harness.state().is_busy());
        stage.perform_without_waiting(Command::NextStep);
    }
    stage.settle();
    assert_eq!(stage.harness.state().lesson_step(), Some((2, 3)));
    let mut alone = self::stage();
    begin(&mut alone, THREE, 2);
    assert_eq!(view(&stage), view(&alone));
}

#[test]
fn a_stopped_set_up_says_so_and_can_be_repeated() {
    let text = THREE.replace("size=32x32", "size=512x512");
    let mut stage = stage();
    stage.inspector().begin_lesson(Lesson::parse("test.md", &text).expect("a lesson"), 0);
    stage.until("the run", |stage| stage.harness.state().model().opened.is_some());
    assert!(stage.harness.state().is_busy());
    stage.perform(Command::Cancel);
    assert_eq!(problems(&stage), ["test.md:3: not set up: it was cancelled"]);
    assert!(stage.reads("it was cancelled") && !stage.harness.state().model().is_complete, "{}", stage.read_out());
    stage.click(Role::Button, "Set up");
    stage.settle();
    assert_eq!(problems(&stage), Vec::<String>::new());
    assert_eq!(stage.place(), 4);
}

/// One step with these commands, and this text.
fn one(text: &str, commands: &str) -> String {
    format!(
        "# One\n\n## Step\n\n{text}\n\n```raystep\nopen scene=built-in:cornell-box size=32x32 device=cpu pixel=20,22\n\
         {commands}\n```\n"
    )
}

#[test]
fn what_is_not_on_the_screen_is_found() {
    let mut stage = stage();
    let cases = [
        ("Text.", "only stream\nexpect panel ray", Some("test.md:10: the panel ray is not in view")),
        ("Text.", "only ray\nexpect panel ray", None),
        ("Text.", "only ray\nrow \"outside\"\nexpect text \"outside\"", None),
        (
            "Text.",
            "only stream\nrow \"outside\"\nexpect text \"outside\"",
            Some("test.md:11: \"outside\" cannot be read"),
        ),
        // The lesson's own words do not count.
        ("The kernel `of the fifth kind`.", "only ray", Some("test.md:3: the text refers to `of the fifth kind`")),
        ("The kernel `intersect`.", "only ray\nrow \"outside\"", None),
        ("Text.", "row \"swims\"", Some("test.md:9: not set up: the ray's history has no 1. row with \"swims\"")),
        ("Text.", "pass 99999", Some("test.md:9: not set up: the run has ")),
        // A ray that is looked for has the row that the step goes to, not only the values.
        ("Text.", "only ray\nfind tie.count > 0\nrow \"outside\"\nexpect text \"outside\"", None),
        (
            "Text.",
            "find tie.count > 0\nrow \"swims\"",
            Some("test.md:9: not set up: no ray of this run on this device is like that"),
        ),
        (
            "Text.",
            "only ray\npass 0\nexpect row.kernel = \"shade\"",
            Some("test.md:11: row.kernel is generate, expected "),
        ),
        ("Text.", "expect passes > 999999", Some("test.md:9: passes is ")),
        ("Text.", "expect row.kernel contains \"ade\"\nexpect passes != 0\nexpect ray.tests < passes", None),
        ("It leaps over {{row.leapt}} cells.", "end", Some("test.md:5: row.leapt: this pass leaps over no cell")),
        ("It takes {{a.time}}.", "measure a size=16x16\nbars a", None),
    ];
    for (text, commands, wanted) in cases {
        begin(&mut stage, &one(text, commands), 0);
        let found = problems(&stage);
        match wanted {
            None => assert_eq!(found, Vec::<String>::new(), "{text} {commands}\n{}", stage.read_out()),
            Some(wanted) => {
                assert!(found.len() == 1 && found[0].starts_with(wanted), "{text} {commands}: {found:?}");
            }
        }
    }
}

/// What a GPU launches is worked out for runs on any device; here it is compared with what one has launched.
#[test]
fn launched_threads_are_those_of_a_gpu() {
    let mut stage = stage();
    for schedule in ["first", "second", "compact"] {
        let on = |device: &str, commands: &str| {
            let options = format!("size=60x44 schedule={schedule} device={device}");
            one("Text.", commands).replace("size=32x32 device=cpu", &options)
        };
        begin(&mut stage, &on("gpu", "end"), 0);
        let passes: Vec<(u64, u32)> =
            stage.harness.state().model().passes.iter().map(|pass| (pass.threads_launched, pass.rays_in)).collect();
        for place in [0, 2, 5, 20, passes.len() - 1] {
            let (threads, rays) = passes[place];
            let expects = format!("pass {place}\nexpect launched = {threads}\nexpect useful = {rays}");
            begin(&mut stage, &on("cpu", &expects), 0);
            assert_eq!(problems(&stage), Vec::<String>::new(), "{schedule}");
        }
    }
}

/// A clock that tells one second more each time.
fn slow() -> u64 {
    static SECONDS: AtomicU64 = AtomicU64::new(0);
    SECONDS.fetch_add(1, Ordering::Relaxed) * 1_000_000_000
}

#[test]
fn a_clock_that_is_not_valid_is_not_quoted() {
    let gpu = pollster::block_on(Gpu::new(&AdapterChoice::Best)).expect("an adapter");
    // By a host's clock on which everything takes seconds, the device's is too fast.
    block_on(&gpu, gpu.check_clock(slow)).expect("a device");
    let why = gpu.why_no_times().expect("a reason");
    let mut stage = Stage::new(Plan { size: SIZE, gpu, ..Plan::default() });
    let text = one("It takes {{a.device-time}}.", "measure a size=16x16\nbars a").replace("device=cpu", "device=gpu");
    begin(&mut stage, &text, 0);
    let found = problems(&stage);
    let wanted = format!("test.md:5: a.device-time: the device's clock is not valid: {why}");
    assert!(found.len() == 1 && found[0].starts_with(&wanted), "{found:?}");
    assert!(stage.paints("(host time)"), "the bars do not say whose clock it is\n{}", stage.read_out());
    // The same without a choice of clock is always allowed: it says which one it is.
    begin(&mut stage, &text.replace("device-time", "time"), 0);
    assert_eq!(problems(&stage), Vec::<String>::new());
}

#[test]
fn a_scene_that_cannot_be_opened_is_a_mistake_in_its_line() {
    let mut stage = stage();
    begin(&mut stage, "# T\n\n## S\n\n```raystep\nopen scene=built-in:palace\n```\n", 0);
    let found = problems(&stage);
    assert!(
        found.len() == 1 && found[0].starts_with("test.md:6: not set up: ") && found[0].contains("palace"),
        "{found:?}"
    );
}

#[test]
fn a_lesson_covers_no_panel_and_leaves_the_users_own_behind() {
    let mut stage = stage();
    let settings = Settings { size: [32, 32], device: DeviceKind::Cpu, ..Settings::default() };
    stage.open(CORNELL, settings, Arrival::default());
    stage.perform(Command::Show(PaneKind::Plan));
    let before = stage.harness.state().panes_in_view();
    begin(&mut stage, THREE, 1);
    assert_eq!(stage.harness.state().panes_in_view(), [PaneKind::Ray, PaneKind::Walk2d]);
    let dock = stage.get(Role::Button, "Next").rect().union(stage.get(Role::Button, "Close").rect());
    let walk = stage.find(Role::Image, |name| name.starts_with("cell ")).expect("the walk").rect();
    assert!(walk.left() > dock.right() && walk.width() > 800.0, "{walk:?} beside {dock:?}");
    stage.click(Role::Button, "Close");
    stage.settle();
    assert_eq!(stage.harness.state().panes_in_view(), before);
    assert_eq!(stage.harness.state().lesson_step(), None);
}

#[test]
fn a_lesson_looks_like_this() {
    let mut stage = stage();
    begin(&mut stage, &LESSONS[0].1.replace("size=128x128", "size=128x128 device=cpu"), 4);
    stage.snapshot("lesson");
}
