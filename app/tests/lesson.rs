//! Lessons from the command line: checked and drawn without a display, or rejected with file and line.

use crate::common::{Place, scene};

/// A lesson of two steps about a scene in its folder.
const LESSON: &str = "# Two\n\n## One\n\nIt hits {{ray.triangle}}.\n\n```raystep\n\
    open scene=box.gltf size=32x32 device=cpu pixel=20,22\nonly ray\nrow \"accepted\"\nexpect text \"accepted\"\n```\n\n\
    ## Two\n\n```raystep\nonly stream\nend\n```\n";

fn place(lesson: &str) -> Place {
    let place = Place::new();
    std::fs::copy(scene("cornell-box.gltf"), place.path("box.gltf")).expect("a scene");
    std::fs::create_dir(place.path("inner")).expect("a folder");
    std::fs::write(place.path("two.md"), lesson).expect("a lesson");
    std::fs::write(place.path("inner/two.md"), lesson.replace("scene=box.gltf", "scene=../box.gltf"))
        .expect("a lesson");
    place
}

#[test]
fn a_lesson_is_checked_step_by_step() {
    let place = place(LESSON);
    let done = place.ok(&["inspect", "--lesson", "two.md", "--check"]);
    let lines: Vec<&str> = done.stdout.lines().collect();
    for (line, start) in
        lines.iter().zip(["step 1, One: 2 things checked, ready after ", "step 2, Two: 0 things checked, "])
    {
        assert!(line.starts_with(start) && line.ends_with(" s"), "{line}");
    }
    assert_eq!(lines.len(), 2, "{lines:?}");

    std::fs::write(place.path("two.md"), LESSON.replace("text \"accepted\"", "text \"refused\"")).expect("a lesson");
    let failed = place.run(&["inspect", "--lesson", "two.md", "--check"]);
    assert_eq!(failed.code, Some(1), "{failed:?}");
    assert!(failed.stdout.contains("step 1, One: 1 wrong"), "{failed:?}");
    assert!(failed.stderr.contains("error: two.md:11: \"refused\" cannot be read"), "{failed:?}");
}

#[test]
fn a_step_can_be_drawn() {
    let place = place(LESSON);
    for (step, name) in [("1", "one.png"), ("2", "two.png")] {
        let inspect = ["inspect", "--lesson", "two.md", "--window", "640x400", "--step", step, "--screenshot", name];
        place.ok(&inspect);
    }
    let [one, two] = ["one.png", "two.png"].map(|name| image::open(place.path(name)).expect("a picture").into_rgba8());
    let differing = one.pixels().zip(two.pixels()).filter(|(a, b)| a != b).count();
    assert!(differing > 10_000, "{differing} pixels differ");
}

#[test]
fn what_is_wrong_has_a_file_and_a_line() {
    let place = place(LESSON);
    std::fs::write(place.path("bytes.md"), [0xff, 0xfe]).expect("a file");
    std::fs::write(place.path("long.md"), " ".repeat(300_000)).expect("a file");
    std::fs::write(place.path("jump.md"), "# T\n## S\n```raystep\njump\n```").expect("a file");
    let absolute = LESSON.replace("box.gltf", "/box.gltf");
    std::fs::write(place.path("absolute.md"), absolute).expect("a file");
    std::fs::write(place.path("none.md"), LESSON.replace("box.gltf", "none.gltf")).expect("a file");
    let cases: &[(i32, &str, &[&str])] = &[
        (1, "nothing.md: No such file", &["nothing.md"]),
        (1, "bytes.md:1: the lesson is not UTF-8", &["bytes.md"]),
        (1, "long.md:1: the lesson has 300000 bytes; the most are 262144", &["long.md"]),
        (1, "jump.md:4: \"jump\" is not a command; the commands are open,", &["jump.md"]),
        (1, "none.md:8: open: none.gltf: No such file", &["none.md"]),
        (1, "absolute.md:8: open: /box.gltf: an absolute path", &["absolute.md"]),
        (1, "inner/two.md:8: open: ../box.gltf: ", &["inner/two.md"]),
        (2, "--step 3: the lesson has 2 steps", &["two.md", "--step", "3", "--screenshot", "out.png"]),
        (2, "--size", &["two.md", "--size", "8x8"]),
    ];
    for (code, message, arguments) in cases {
        let check: &[&str] = if arguments.len() == 1 { &["--check"] } else { &[] };
        let outcome = place.run(&[&["inspect", "--lesson"], *arguments, check].concat());
        assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(*code), ""), "{arguments:?}: {outcome:?}");
        assert!(outcome.stderr.contains(message), "{arguments:?}: {outcome:?}");
    }
    place.ok(&["inspect", "--lesson", "inner/two.md", "--check", "--allow-outside"]);
}
