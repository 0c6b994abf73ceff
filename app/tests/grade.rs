//! `raystep course` and `raystep grade`.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::common::Place;

/// A file of the course in the repository.
fn text(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/course");
    fs::read_to_string(folder.join(name)).expect("a file of the course")
}

#[test]
fn the_exercises_are_written_once_and_are_untouched() {
    let place = Place::new();
    let told = place.ok(&["course", "c"]).stdout;
    assert_eq!(told, "c/README.md is where it begins\n");
    assert_eq!(place.names(), ["c"]);
    assert_eq!(place.read("c/1-tmax.wgsl"), text("1-tmax.wgsl").into_bytes());
    let page = String::from_utf8(place.read("c/1-tmax.md")).expect("text");
    assert!(page.contains("](images/1-tmax.svg)") && !page.contains(".png)"), "renderings are not written: {page}");
    assert!(place.path("c/images/1-tmax.svg").exists() && !place.path("c/solutions").exists());
    // Nothing that a student has written is replaced.
    place.fails(1, "is not empty", &["course", "c"]);

    let outcome = place.run(&["grade", "c", "--device", "cpu", "--quiet"]);
    assert_eq!((outcome.code, &*outcome.stderr), (Some(1), "error: 0 of 8 exercises passed\n"), "{outcome:?}");
    let lines: Vec<_> = outcome.stdout.lines().collect();
    assert_eq!(lines.len(), 8, "{lines:?}");
    assert!(lines[0].starts_with("1 tMax at the start") && lines[0].contains("untouched"), "{lines:?}");
    fs::remove_file(place.path("c/8-shadow.wgsl")).expect("a file");
    let outcome = place.run(&["grade", "c", "--device", "cpu", "--quiet"]);
    assert!(outcome.stdout.lines().last().is_some_and(|line| line.contains("missing")), "{outcome:?}");
}

#[test]
fn solutions_pass_with_exit_code_0() {
    let place = Place::new();
    fs::create_dir(place.path("c")).expect("a folder");
    let names = [
        "1-tmax.wgsl",
        "2-step.wgsl",
        "3-triangle.wgsl",
        "4-list-end.wgsl",
        "5-schedule.toml",
        "6-resolution.wgsl",
        "7-crack.wgsl",
        "8-shadow.wgsl",
    ];
    for name in names {
        fs::write(place.path(format!("c/{name}")), text(&format!("solutions/{name}"))).expect("a file");
    }
    let outcome = place.ok(&["grade", "c", "--device", "cpu", "--json", "--quiet"]);
    let found: Value = serde_json::from_str(&outcome.stdout).expect("JSON");
    assert_eq!((&found["passed"], &found["of"], &found["folder"]), (&8.into(), &8.into(), &"c".into()));
    let exercises = found["exercises"].as_array().expect("a list");
    assert_eq!(exercises.len(), 8);
    for (one, name) in exercises.iter().zip(names) {
        assert_eq!((&one["verdict"], one["file"].as_str()), (&"passed".into(), Some(&*format!("c/{name}"))));
        assert!(one["views"].as_u64() >= Some(3) && one["rays"].as_u64() > Some(500), "{one}");
        assert!(
            one["number"].as_u64() == name[..1].parse().ok() && one["kernel"].is_string() && one["title"].is_string()
        );
        assert!(one.get("hint").is_none() && one.get("view").is_none(), "{one}");
    }
}

#[test]
fn a_wrong_answer_is_told_by_its_ray_and_a_mistake_by_its_line_and_neither_says_what_is_right() {
    let place = Place::new();
    place.ok(&["course", "c"]);
    // Steps along x in place of z, which is stored by a module of ours: the line is that of the student's call.
    let hole = text("2-step.wgsl");
    let call = 1 + hole.lines().position(|line| line.contains("return arrive(")).expect("a line");
    let along_x = hole
        .replace("cell.z += forward.z", "cell.x += forward.x")
        .replace("tmax.z += t_delta.z", "tmax.x += t_delta.x");
    fs::write(place.path("c/2-step.wgsl"), along_x).expect("a file");
    let hole = text("6-resolution.wgsl");
    let line = 1 + hole.lines().position(|line| line.contains("return 0u;")).expect("a line");
    fs::write(place.path("c/6-resolution.wgsl"), hole.replace("return 0u;", "return 0.5;")).expect("a file");
    let crack = text("solutions/7-crack.wgsl");
    let strict = crack.replacen(" >= ", " > ", 3).replacen(" <= ", " < ", 3);
    fs::write(place.path("c/7-crack.wgsl"), strict).expect("a file");

    let outcome = place.run(&["grade", "c", "--device", "cpu", "--quiet"]);
    assert_eq!(outcome.code, Some(1));
    let told = &outcome.stdout;
    assert!(told.contains("c/2-step.wgsl differs from traverse_grid, interpreted, first in pass "), "{told}");
    assert!(told.contains("  state.cell is ") && told.contains("  hint: The ray goes to another cell."), "{told}");
    let stored = format!("  stored by c/2-step.wgsl:{call}: return arrive(texel, cell_index(next.cell), next.tmax);\n");
    assert!(told.contains(&stored) && !told.contains("package::"), "lines of ours are not told: {told}");
    assert!(told.contains(" is cell ("), "{told}");
    assert!(told.contains(&format!("c/6-resolution.wgsl:{line}:")) && told.contains("\n    return 0.5;\n"), "{told}");
    assert!(told.contains("c/7-crack.wgsl leaks, interpreted: "), "{told}");
    // The commands below a difference are right.
    let command = told.lines().find_map(|line| line.split_once("as it should be: raystep ")).expect("a command").1;
    let arguments: Vec<&str> = command.split(' ').chain(["--quiet", "--device", "cpu"]).collect();
    place.ok(&arguments);

    let outcome = place.run(&["grade", "c", "--device", "cpu", "--json", "--quiet"]);
    let found: Value = serde_json::from_str(&outcome.stdout).expect("JSON");
    let exercises = &found["exercises"];
    let [step, resolution, crack] = [1, 5, 6].map(|i| &exercises[i]);
    assert_eq!(
        (&step["verdict"], &step["stream"], &step["layer"]),
        (&"differs".into(), &"state".into(), &"cell".into())
    );
    let stored = &step["stored"];
    assert_eq!((&stored["file"], &stored["line"]), (&"c/2-step.wgsl".into(), &call.into()));
    assert!(step["also"].is_array() && step["cells"].as_array().is_some_and(|cells| cells.len() == 2), "{step}");
    let view = &step["view"];
    assert_eq!(view["device"], "interpreted");
    assert_eq!(view["arguments"], "cornell-box --size 16x16 --grid 5 --numerics paper");
    assert!(view["why"].is_string() && step["hint"].is_string() && step["pixel"].is_array(), "{step}");
    assert_eq!((&resolution["verdict"], &resolution["line"]), (&"mistake".into(), &line.into()));
    assert_eq!((&crack["verdict"], crack["rays"].as_u64() > Some(1)), (&"leaks".into(), true));
    assert_eq!(exercises[0]["verdict"], "untouched");
}

#[test]
fn wrong_usage_and_a_missing_folder_are_errors() {
    let place = Place::new();
    assert_eq!(place.run(&["grade"]).code, Some(2));
    assert_eq!(place.run(&["course"]).code, Some(2));
    place.fails(1, "no such folder; 'raystep course nowhere' makes one", &["grade", "nowhere"]);
}
