//! Programs of users: `new`, `run`, `check`, `dump`, `plan` and `inspect` of a folder.

use std::fs;

use serde_json::Value;

use crate::common::{Outcome, Place};

fn new(place: &Place, name: &str, like: &str) {
    let made = place.run(&["new", name, "--like", like]);
    assert_eq!((made.code, &*made.stderr), (Some(0), ""), "{made:?}");
}

/// Replaces a text in a file.
fn change(place: &Place, file: &str, from: &str, to: &str) {
    let text = fs::read_to_string(place.path(file)).expect("a file");
    assert!(text.contains(from), "no {from:?}");
    fs::write(place.path(file), text.replacen(from, to, 1)).expect("written");
}

fn fails(outcome: &Outcome, code: i32, message: &str) {
    assert!(outcome.code == Some(code) && outcome.stderr.contains(message), "{outcome:?}");
}

#[test]
fn a_new_program_runs_and_its_result_is_a_picture_a_table_and_an_array() {
    let place = Place::new();
    new(&place, "mine", "life");
    change(&place, "mine/program.toml", "[256, 256]", "[24, 16]");
    change(&place, "mine/program.toml", "repeat = 200", "repeat = 8");
    for (output, begins) in [("r.png", &b"\x89PNG"[..]), ("r.csv", b"x,y,alive\n0,0,"), ("r.npy", b"\x93NUMPY")] {
        let ran = place.run(&["run", "mine", "-o", output, "--quiet"]);
        assert!(ran.code == Some(0) && ran.stdout.contains("cells     384\npasses    9\n"), "{ran:?}");
        assert!(fs::read(place.path(output)).expect("a file").starts_with(begins), "{output}");
    }
    assert_eq!(fs::read_to_string(place.path("r.csv")).expect("a table").lines().count(), 385);
    let timed = place.run(&["run", "mine", "--passes-csv", "p.csv", "--quiet"]);
    assert_eq!(timed.code, Some(0), "{timed:?}");
    assert_eq!(fs::read_to_string(place.path("p.csv")).expect("a table").lines().count(), 10);
    let plotted = place.run(&["run", "mine", "-o", "r.svg", "--quiet"]);
    assert_eq!(plotted.code, Some(0), "{plotted:?}");
    let dumped = place.run(&["dump", "mine", "--pass", "3", "-o", "d", "--quiet"]);
    assert_eq!(dumped.code, Some(0), "{dumped:?}");
    assert!(place.path("d/pass-000003.cell.npy").is_file(), "{dumped:?}");
    let planned = place.run(&["plan", "mine", "--quiet"]);
    assert!(planned.code == Some(0) && planned.stdout.contains("cell_before"), "{planned:?}");
    // An existing folder stays as it is.
    fails(&place.run(&["new", "mine"]), 1, "mine is not empty");
}

#[test]
fn a_check_compares_with_the_interpreter_and_names_what_is_wrong() {
    let place = Place::new();
    new(&place, "mine", "bitonic-sort");
    change(&place, "mine/program.toml", "1024", "200");
    change(&place, "mine/program.toml", "repeat = 10", "repeat = 8");
    let checked = place.run(&["check", "mine", "--quiet", "--json"]);
    let found: Value = serde_json::from_str(&checked.stdout).unwrap_or_else(|error| panic!("{error}: {checked:?}"));
    assert_eq!((checked.code, &found["verdict"], &found["passes"]), (Some(0), &"same".into(), &6.into()), "{found}");
    // The last partner is beyond the end.
    change(&place, "mine/exchange.wgsl", " || partner >= launch.elements", "");
    let wrong = place.run(&["check", "mine", "--quiet", "--passes", "40"]);
    assert_eq!(wrong.code, Some(1), "{wrong:?}");
    let told = wrong.stdout.clone() + &wrong.stderr;
    assert!(told.contains("mine/exchange.wgsl:22: index") || told.contains("leaves number.value"), "{wrong:?}");
}

#[test]
fn what_is_no_program_is_told_in_one_line() {
    let place = Place::new();
    fails(
        &place.run(&["run", "nothing"]),
        2,
        "nothing: neither a folder with program.toml nor a program that needs no scene",
    );
    fails(&place.run(&["run", "sotr"]), 2, "sort");
    fails(&place.run(&["check", "."]), 2, "no folder with program.toml");
    new(&place, "mine", "life");
    fails(&place.run(&["render", "mine", "-o", "a.png"]), 2, "mine is a program: expected a scene");
    fails(&place.run(&["run", "mine", "-o", "mine/program.toml"]), 2, "png");
    change(&place, "mine/program.toml", "repeat = 200", "repeat = 200 ]");
    let wrong = place.run(&["run", "mine"]);
    fails(&wrong, 1, "mine/program.toml:18:");
    assert!(!place.path("result.png").exists());
    // Every command tells a mistake of the WGSL alike.
    new(&place, "other", "life");
    change(&place, "other/generation.wgsl", "var neighbours = 0u;", "var neighbours = 0.5;");
    for command in ["run", "check", "plan"] {
        fails(&place.run(&[command, "other"]), 1, "other/generation.wgsl:15:");
    }
}

#[test]
fn a_program_that_does_not_end_is_ended() {
    let place = Place::new();
    new(&place, "mine", "sphere-tracer");
    change(&place, "mine/program.toml", "[256, 192]", "[8, 8]");
    change(&place, "mine/march.wgsl", "t > FAR", "false");
    change(&place, "mine/march.wgsl", "step < NEAR", "false");
    change(
        &place,
        "mine/program.toml",
        "{ until_idle = \"march\" }",
        "{ repeat = 3, steps = [{ repeat = 400000, steps = [{ run = \"march\" }] }] }",
    );
    fails(&place.run(&["run", "mine"]), 1, "1000000 passes");
    change(&place, "mine/program.toml", "repeat = 400000", "repeat = 4");
    let ran = place.run(&["run", "mine", "--device", "cpu", "--quiet"]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
}
