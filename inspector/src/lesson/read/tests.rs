use super::*;
use crate::lesson::{Condition, Goal, Operand};
use crate::ui::command::Command;
use crate::ui::pane::PaneKind;

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
    assert_eq!((one.line, one.title.as_str(), one.text.len(), one.expects.len()), (6, "One", 3, 3));
    assert_eq!(one.text.iter().map(|p| p.is_item).collect::<Vec<_>>(), [false, true, true]);
    assert_eq!(one.actions[1], (14, Action::Go(Goal::Row(2, "outside of".into()))));
    let (line, Expect::Values(comparison)) = &one.expects[2] else { panic!("{:?}", one.expects) };
    assert_eq!((*line, comparison.condition, &comparison.second), (21, Condition::Equal, &Operand::Number(17.0)));
    assert_eq!((two.text.len(), two.actions.len()), (1, 2));

    // The second step is the first one with another place and another ray.
    let (first, second) = (lesson.set_up(0), lesson.set_up(1));
    assert_eq!(first.panels, Some(vec![vec![PaneKind::Stream, PaneKind::Ray], vec![PaneKind::Walk3d]]));
    assert_eq!((first.pixel, first.commands.as_slice()), (Some([3, 4]), &[Command::Compare][..]));
    let shown = first.shown.expect("a stream");
    assert_eq!((shown.stream.to_string().as_str(), shown.zoom, shown.pan), ("state.t", Some(40.0), Some([3.5, 4.5])));
    assert_eq!((&second.link, &second.panels, second.shown), (&first.link, &first.panels, first.shown));
    assert_eq!((second.pixel, second.goal), (Some([5, 6]), Some((26, Goal::End))));
}

#[test]
fn opening_a_scene_forgets_all_but_what_was_measured() {
    let text = "# T\n## One\n```raystep\nopen scene=a.glb\nmeasure slow schedule=second\nbars slow\nonly ray\nend\n\
                do Judge hits\n```\n## Two\n```raystep\nopen scene=b.glb\n```\n";
    let lesson = Lesson::parse("t.md", text).expect("a lesson");
    assert_eq!(lesson.set_up(0).bars, ["slow"]);
    let two = lesson.set_up(1);
    assert_eq!((two.panels, two.goal, two.commands.len(), two.bars.len()), (None, None, 0, 0));
    assert_eq!(two.measurements.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), ["slow"]);
}

#[test]
fn exact_panels_are_not_joined_by_those_of_earlier_commands() {
    let text = "# T\n## One\n```raystep\nopen scene=a.glb\nonly ray\ndo Judge hits\n```\n## Two\n```raystep\nend\n```\n\
                ## Three\n```raystep\nonly stream\n```\n";
    let lesson = Lesson::parse("t.md", text).expect("a lesson");
    assert_eq!([0, 1, 2].map(|step| lesson.set_up(step).commands.len()), [1, 1, 0]);
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
