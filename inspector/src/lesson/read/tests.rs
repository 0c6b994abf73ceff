use super::*;
use crate::command::{Command, PaneKind};
use crate::lesson::{Condition, Expect, Goal, Operand};

/// A lesson with these commands in its only step, after one that opens a scene (line 5).
fn with(commands: &str) -> Result<Lesson, LessonError> {
    let text = format!("# A title\n\n## A step\n```raystep\nopen scene=built-in:cornell-box\n{commands}\n```\n");
    Lesson::parse("a.md", &text)
}

#[test]
fn a_lesson_has_a_title_steps_texts_and_commands() {
    let text = "# Rays\n\nAbout them,\nin two lines.\n\n## One\nText of {{passes}}.\n\n- an item\n- another\n\n```raystep\n\
                open scene=a.glb size=64x32 pixel=3,4 numerics=paper\nrow 2 \"outside of\"\nonly stream ray / walk-in-3d\n\
                stream state.t\nzoom 40 at 3,4\ndo Compare with BVH\nexpect panel ray\nexpect text \"beyond\"\n\
                expect ray.triangle = 17\n```\n\n## Two\n```raystep\nend\npixel 5,6\n```\nMore.\n";
    let lesson = Lesson::parse("rays.md", text).expect("a lesson");
    assert_eq!((lesson.title.as_str(), lesson.about.len(), lesson.steps.len()), ("Rays", 1, 2));
    let [one, two] = &lesson.steps[..] else { panic!("{lesson:?}") };
    assert_eq!((one.line, one.title.as_str(), one.first.text.len(), one.first.expects.len()), (6, "One", 3, 3));
    assert_eq!(one.first.text.iter().map(|p| p.is_item).collect::<Vec<_>>(), [false, true, true]);
    assert_eq!(one.first.actions[1], (14, Action::Go(Goal::Row(2, "outside of".into()))));
    let (line, Expect::Values(comparison)) = &one.first.expects[2] else { panic!("{:?}", one.first.expects) };
    assert_eq!((*line, comparison.condition, &comparison.second), (21, Condition::Equal, &Operand::Number(17.0)));
    assert_eq!((two.first.text.len(), two.first.actions.len()), (1, 2));

    // The second step is the first one with another place and another ray.
    let (first, second) = (lesson.set_up(0, false), lesson.set_up(1, false));
    assert_eq!(first.panels, Some(vec![vec![PaneKind::Stream, PaneKind::Ray], vec![PaneKind::Walk3d]]));
    assert_eq!((first.pixel, first.commands.as_slice()), (Some([3, 4]), &[Command::Compare][..]));
    let shown = first.shown.expect("a stream");
    assert_eq!((shown.stream.to_string().as_str(), shown.zoom, shown.pan), ("state.t", Some(40.0), Some([3.5, 4.5])));
    assert_eq!((&second.link, &second.panels, second.shown), (&first.link, &first.panels, first.shown));
    assert_eq!((second.pixel, second.goal), (Some([5, 6]), Some((26, Goal::End))));
}

#[test]
fn opening_a_scene_forgets_all_but_what_was_measured_and_is_shown() {
    let text = "# T\n## One\n```raystep\nopen scene=a.glb\nmeasure slow schedule=second\nmeasure fast schedule=compact\n\
                bars slow\nonly ray\nend\ndo Judge hits\n```\n## Two\nIt took {{slow.time}}.\n```raystep\n\
                open scene=b.glb\n```\n## Three\n```raystep\nend\n```\n";
    let lesson = Lesson::parse("t.md", text).expect("a lesson");
    assert_eq!(lesson.set_up(0, false).bars, ["slow"]);
    let two = lesson.set_up(1, false);
    assert_eq!((two.panels, two.goal, two.commands.len(), two.bars.len()), (None, None, 0, 0));
    assert_eq!(two.measurements.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), ["slow"]);
    // Nobody waits for what is not shown.
    assert_eq!(lesson.set_up(2, false).measurements, []);
}

#[test]
fn exact_panels_are_not_joined_by_those_of_earlier_commands() {
    let text = "# T\n## One\n```raystep\nopen scene=a.glb\nonly ray\ndo Judge hits\n```\n## Two\n```raystep\nend\n```\n\
                ## Three\n```raystep\nonly stream\n```\n";
    let lesson = Lesson::parse("t.md", text).expect("a lesson");
    assert_eq!([0, 1, 2].map(|step| lesson.set_up(step, false).commands.len()), [1, 1, 0]);
}

/// A step that asks, answers and goes on.
const ASKING: &str = "# T\n## One\nBefore.\n```raystep\nopen scene=a.glb\nstart\n\
    question \"Which of {{cells}}?\"\nchoice \"x, or {{step.sign}}\" if step.axis = \"x\", step.changed = \"x, y\"\n\
    choice \"y\" if step.axis = \"y\" else \"It is {{step.axis}}.\"\nbefore-after axis\n```\nThe answer.\n\n```raystep\n\
    end\nexpect step.axis = \"x\"\n```\nMore.\n## Two\n```raystep\ncode cell_exit\nplay 5\nstates\n```\n";

#[test]
fn what_follows_a_question_is_its_answer() {
    let lesson = Lesson::parse("q.md", ASKING).expect("a lesson");
    let one = &lesson.steps[0];
    let question = one.question.as_ref().expect("a question");
    assert_eq!((question.line, question.choices.len()), (7, 2));
    assert_eq!(question.choices.iter().map(|choice| choice.conditions.len()).collect::<Vec<_>>(), [2, 1]);
    assert_eq!(question.choices.iter().map(|choice| choice.why_not.is_some()).collect::<Vec<_>>(), [false, true]);
    assert_eq!((one.first.text.len(), one.first.actions.len()), (1, 3), "all of the block with the question");
    assert_eq!((one.answer.text.len(), one.answer.actions.len(), one.answer.expects.len()), (2, 1, 1));
    // The answer is set up only when it is due, and for the steps after it.
    let goal = |step, is_answered| lesson.set_up(step, is_answered).goal.map(|(_, goal)| goal);
    assert_eq!(
        [goal(0, false), goal(0, true), goal(1, false)],
        [Some(Goal::Passes(0)), Some(Goal::End), Some(Goal::End)]
    );
    // A step's own table is not that of the next one.
    let shown = |step| lesson.set_up(step, false).before_after.map(|values| (values.axis, values.cell));
    assert_eq!([shown(0), shown(1)], [Some((true, false)), None]);
    let two = lesson.set_up(1, false);
    assert_eq!((two.code.as_deref(), two.play, two.has_states), (Some("cell_exit"), Some(5), true));
}

#[test]
fn exactly_one_choice_is_right() {
    use crate::lesson::{Fact, Name, Value};
    let with = |choices: &str| {
        let text = format!("# T\n## S\n```raystep\nopen scene=a.glb\nquestion \"Which?\"\n{choices}\n```\n");
        Lesson::parse("a.md", &text).expect("a lesson").steps.remove(0).question.expect("a question")
    };
    let value_of = |name: &Name| match name {
        Name::Fact(Fact::StepAxis) => Ok(Value::text("y")),
        Name::Fact(Fact::StepListed) => Ok(Value::count(0)),
        other => Err(Wrong::Name(other.to_string())),
    };
    let right = |choices: &str| with(choices).right(value_of).map_err(|(line, wrong)| (line, wrong.to_string()));
    let axes = "choice \"x\" if step.axis = \"x\"\nchoice \"y\" if step.axis = \"y\", step.listed = 0";
    assert_eq!(right(axes), Ok(1));
    let none = axes.replace("listed = 0", "listed > 0");
    assert_eq!(right(&none), Err((5, "0 choices are right, expected one".into())));
    assert_eq!(
        right(&axes.replace("axis = \"x\"", "axis != \"x\"")),
        Err((5, "2 choices are right, expected one".into()))
    );
    assert_eq!(
        right(&axes.replace("step.listed = 0", "passes = 0")).map_err(|(line, _)| line),
        Err(7),
        "a value that is not there"
    );
}

#[test]
fn mistakes_name_file_line_and_what_is_right() {
    let cases = [
        ("", 1, "expected a title"),
        ("Prose\n# Title", 1, "expected a title"),
        ("# T\n\nProse", 3, "expected a step"),
        ("# T\n## S\n# U", 3, "one title"),
        ("# T\n## S\n### U", 3, "no other headings"),
        ("# T\n```raystep\nend\n```", 2, "belong to a step"),
        ("# T\n## S\n```rust\n```", 3, "blocks begin with ```raystep"),
        ("# T\n## S\n\n```raystep\nend", 4, "has no end"),
        ("# T\n## S\n```raystep\nend\n```", 4, "has to open a scene"),
        ("# T\n## S\nText", 2, "has to open a scene"),
        ("# T\n## S\n```raystep\nopen scene=a.glb\n```\n**Text", 6, "** is not closed"),
        (
            "# T\n## S\n```raystep\nopen scene=a.glb\n```\nA\nB {{speed}}",
            7,
            "\"speed\" is not a value; the values are scene,",
        ),
        ("# T\n## S\n```raystep\nopen scene=a.glb\n```\n{{a.time}}", 6, "\"a\" was not measured"),
        ("# T\n{{a.time}}\n## S\n```raystep\nopen scene=a.glb\n```", 2, "\"a\" was not measured"),
        ("# T\n## S\n```raystep\nopen scene=a.glb\n```\n{{tie.gap}}", 6, "add the command 'candidates'"),
        ("# T\n## S\n```raystep\nopen scene=a.glb\nquestion \"A?\"\n```", 5, "0 choices follow; expected 2 to 4"),
        (
            "# T\n## S\n```raystep\nopen scene=a.glb\nquestion \"A?\"\nchoice \"x\" if a.time > 3\nchoice \"y\" if passes = 3\n```",
            6,
            "\"a\" was not measured",
        ),
    ];
    for (text, line, wanted) in cases {
        let error = Lesson::parse("a.md", text).expect_err(text).to_string();
        assert!(error.starts_with(&format!("a.md:{line}: ")) && error.contains(wanted), "{text:?}: {error}");
    }
    assert!(with("").is_ok());
    let commands = [
        ("jump 3", "the commands are open, pixel,"),
        ("open size=8x8", "expected a scene"),
        ("open scene=a.glb speed=3", "\"speed\" is not a key of a link"),
        ("open scene=a.glb size=8x8 pixel=8,0", "pixels 0,0 to 7,7"),
        ("pixel 3", "two numbers"),
        ("pass -1", "index of a pass"),
        ("pass 18446744073709551615", "index of a pass"),
        ("end now", "takes nothing"),
        ("row outside", "double quotes"),
        ("row 0 \"outside\"", "at least 1"),
        ("row \"\"", "double quotes"),
        ("only", "expected panels"),
        ("only ray / ray", "twice"),
        ("show walk", "\"walk\" is not a panel; the panels are passes,"),
        ("stream speed", "expected one of"),
        ("zoom 40 at 3,4", "name the stream first"),
        ("stream color\nzoom 0 at 3,4", "0.01 to 256"),
        ("stream color\nzoom at 3,4", "such as 'zoom 40 at"),
        ("find tie.gap", "two values with"),
        ("find tie.gap > 0, passes > 3", "passes is not a value of tie"),
        ("find tie.gap > 0, tie.size > 3", "\"tie.size\" is not a value"),
        ("do Dance", "not a command"),
        ("do Quit", "not a command that a lesson can perform"),
        ("do Lesson: a crack at a voxel face", "not a command that a lesson can perform"),
        ("measure Fast", "lower-case"),
        ("measure row schedule=second", "lower-case"),
        ("measure fast scene=b.glb", "omit scene"),
        ("measure fast\nmeasure fast", "already"),
        ("bars fast", "was not measured"),
        ("question Which?", "double quotes"),
        ("choice \"x\" if step.axis = \"x\"", "ask first"),
        ("question \"A?\"\nchoice x", "expected \"LABEL\" if"),
        ("question \"A?\"\nchoice \"x\" step.axis = \"x\"", "expected \"LABEL\" if"),
        ("question \"A?\"\nchoice \"\" if step.axis = \"x\"", "expected \"LABEL\" if"),
        ("question \"A?\"\nchoice \"x\" if axis", "two values with"),
        ("question \"A?\"\nchoice \"x\" if step.axis = \"x\" else no", "double quotes"),
        ("question \"A?\"\nchoice \"x {{speed}}\" if step.axis = \"x\"", "is not a value"),
        ("question \"A?\"\nquestion \"B?\"", "one question"),
        ("before-after now", "expected axis, cell, tmax or state"),
        ("code", "name of a function"),
        ("code f(x)", "name of a function"),
        ("play 0", "1 to 100"),
        ("play 101", "1 to 100"),
        ("states 3", "takes nothing"),
        ("expect", "expected 'panel NAME'"),
        ("expect panel walk", "is not a panel"),
        ("expect text beyond", "double quotes"),
        ("expect speed = 3", "is not a value"),
        ("expect passes > speed", "is not a value"),
        ("expect passes < fast.passes", "was not measured"),
    ];
    for (command, wanted) in commands {
        let line = 5 + command.lines().count();
        let error = with(command).expect_err(command).to_string();
        assert!(error.starts_with(&format!("a.md:{line}: ")) && error.contains(wanted), "{command:?}: {error}");
    }
}

#[test]
fn a_lesson_has_limits() {
    let step = |n: usize| format!("## {n}\n```raystep\nopen scene=a.glb\n```\n");
    let most = |steps: usize| format!("# T\n{}", (0..steps).map(step).collect::<String>());
    assert!(Lesson::parse("a.md", &most(MOST_STEPS)).is_ok());
    let wrong = |text: &str| Lesson::parse("a.md", text).expect_err("too much").wrong;
    assert_eq!(wrong(&most(MOST_STEPS + 1)), Wrong::TooManySteps);
    assert_eq!(wrong(&format!("# T\n{}", " ".repeat(MOST_BYTES))), Wrong::TooLong(MOST_BYTES + 4));
    assert!(with(&"end\n".repeat(MOST_COMMANDS - 1)).is_ok());
    assert_eq!(with(&"end\n".repeat(MOST_COMMANDS)).expect_err("too many").wrong, Wrong::TooManyCommands);
}

#[test]
fn no_text_panics() {
    let text = crate::lesson::built_in::LESSONS[0].1;
    for end in (0..text.len()).filter(|&end| text.is_char_boundary(end)) {
        let _ = Lesson::parse("a.md", &text[..end]);
    }
    let mut random = 7_u64;
    let pieces = [
        "# T\n",
        "## S\n",
        "```raystep\n",
        "```\n",
        "{{",
        "}}",
        "**",
        "`",
        "open scene=a.glb\n",
        "é",
        "\"",
        " / ",
        "expect ",
        "row ",
    ];
    for _ in 0..2000 {
        let mut text = String::from("# T\n## S\n");
        for _ in 0..12 {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            text.push_str(pieces[(random >> 33) as usize % pieces.len()]);
        }
        let _ = Lesson::parse("a.md", &text);
    }
}
