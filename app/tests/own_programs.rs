//! Programs of users: `new`, `run`, `check`, `dump`, `plan` and `inspect` of a folder.

use std::fs;

use serde_json::Value;

use crate::common::{Outcome, Place, scene};

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
    // What a kernel prints is dumped for every element.
    change(
        &place,
        "mine/generation.wgsl",
        "neighbours -= alive;",
        "neighbours -= alive; note(\"around\", neighbours);",
    );
    let dumped = place.run(&["dump", "mine", "--pass", "3", "--stream", "cell", "-o", "n", "--quiet"]);
    assert_eq!(dumped.code, Some(0), "{dumped:?}");
    let noted = place.read("n/pass-000003.note.around.npy");
    assert!(String::from_utf8_lossy(&noted[..128]).contains("(1, 16, 24)"), "{dumped:?}");
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
fn a_check_has_other_witnesses_than_the_interpreter() {
    let place = Place::new();
    new(&place, "mine", "life");
    change(&place, "mine/program.toml", "[256, 256]", "[24, 16]");
    change(&place, "mine/program.toml", "repeat = 200", "repeat = 8");
    let ran = place.run(&["run", "mine", "-o", "right.npy", "--quiet"]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let against = |file: &str| place.run(&["check", "mine", "--reference", file, "--quiet"]);
    let same = against("cell=right.npy");
    assert!(
        same.code == Some(0) && same.stdout.contains("384 values after 1 of 9 passes are those of right.npy"),
        "{same:?}"
    );
    // Another rule, after the last pass.
    change(&place, "mine/generation.wgsl", "neighbours == 3u", "neighbours == 4u");
    let other = against("cell=right.npy");
    assert!(other.code == Some(1) && other.stdout.contains(": pass 8, generation, leaves cell."), "{other:?}");
    assert!(other.stdout.contains("where right.npy has "), "{other:?}");
    fails(&against("cells=right.npy"), 2, "no stream is named cells; the streams are cell");
    fails(&against("cell=none.npy"), 1, "none.npy");
    fs::write(place.path("short.npy"), "no array").expect("written");
    fails(&against("cell=short.npy"), 1, "short.npy: ");

    let info = place.run(&["info", "--json"]);
    let info: Value = serde_json::from_str(&info.stdout).unwrap_or_else(|error| panic!("{error}: {info:?}"));
    let Some(adapter) = info["adapters"][0]["name"].as_str() else { return };
    let same = place.run(&["check", "mine", "--against", adapter, "--quiet"]);
    assert!(same.code == Some(0) && same.stdout.contains(" passes are those of "), "{same:?}");
    fails(&place.run(&["check", "mine", "--against", "no such adapter"]), 1, "no such adapter");
}

#[test]
fn an_element_that_is_counted_in_another_state_than_its_own_is_found() {
    let place = Place::new();
    new(&place, "mine", "sphere-tracer");
    change(&place, "mine/program.toml", "[256, 192]", "[8, 8]");
    let text = fs::read_to_string(place.path("mine/march.wgsl")).expect("a file");
    let line = text.lines().position(|line| line.contains("book(lane, tag);")).expect("the line") + 1;
    for (from, to, wrong) in [
        ("book(lane, tag)", "book(lane, NOBODY)", "it tells the state NOBODY, but leaves the element in MARCH"),
        (
            "book(lane, tag)",
            "book(lane, select(tag, MARCH, tag == NOBODY))",
            "it tells the state MARCH, but the pass does not work on this element",
        ),
        (
            "book(lane, tag)",
            "if (tag != NOBODY) { tag = SKY; } book(lane, tag)",
            "it tells the state SKY, but leaves the element in ",
        ),
    ] {
        change(&place, "mine/march.wgsl", from, to);
        let found = place.run(&["check", "mine", "--passes", "400", "--quiet"]);
        assert!(found.code == Some(1) && found.stdout.contains(wrong), "{to}: {found:?}");
        assert!(found.stdout.contains(&format!("mine/march.wgsl:{line}: ")), "{found:?}");
        change(&place, "mine/march.wgsl", to, from);
    }
    change(&place, "mine/march.wgsl", "{MARCH, SKY, SURFACE}", "{DONE, MARCH, SURFACE}");
    change(&place, "mine/march.wgsl", "SKY", "DONE");
    let found = place.run(&["check", "mine", "--passes", "400", "--quiet"]);
    assert!(
        found.stdout.contains("it sends the element from MARCH to DONE, which the kernel's 'sends' does not list"),
        "{found:?}"
    );
    change(&place, "mine/march.wgsl", "    book(lane, tag);\n", "");
    fails(&place.run(&["run", "mine"]), 1, "mine/march.wgsl:15:4: it does not tell where its elements go");
}

#[test]
fn lines_are_those_of_the_file_where_elements_are_loaded_from_copies() {
    let place = Place::new();
    new(&place, "mine", "reaction-diffusion");
    change(&place, "mine/program.toml", "[192, 192]", "[16, 16]");
    let text = fs::read_to_string(place.path("mine/react.wgsl")).expect("a file");
    let lines: Vec<&str> = text.lines().collect();
    let line = lines.iter().rposition(|line| line.contains("textureStore")).expect("a store") + 1;
    let found = place.run(&["stop", "mine", "--at", &format!("react:{line}"), "--quiet"]);
    assert!(found.code == Some(0) && found.stdout.contains(&format!("react.wgsl:{line}: 256 of 256")), "{found:?}");
    assert!(found.stdout.contains(lines[line - 1].trim()), "{found:?}");
    let cost = place.run(&["cost", "mine", "--for", "react", "--pass", "2", "--csv", "lines.csv", "--quiet"]);
    assert_eq!(cost.code, Some(0), "{cost:?}");
    let table = fs::read_to_string(place.path("lines.csv")).expect("a table");
    let column = table.lines().next().expect("a head").split(',').position(|name| name == "stream_bytes_written");
    for row in table.lines().skip(1) {
        let bytes: f64 =
            row.split(',').nth(column.expect("the column")).and_then(|cell| cell.parse().ok()).expect("a number");
        assert_eq!(bytes > 0.0, row.contains("textureStore"), "{row}");
    }
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
    // It has states, and no rays through a scene.
    let planned = place.run(&["plan", "mine", "--quiet"]);
    assert!(planned.stdout.contains("elements\n  pixels") && !planned.stdout.contains("triangles"), "{planned:?}");
    let ran = place.run(&["run", "mine", "--device", "cpu", "--quiet"]);
    assert_eq!(ran.code, Some(0), "{ran:?}");
}

#[test]
fn a_program_reads_a_scene_that_is_named_beside_it() {
    let place = Place::new();
    new(&place, "mine", "grid-walk");
    let picture = |program: &str, output: &str| {
        let ran = place.run(&["run", program, "--size", "24x16", "-o", output, "--quiet"]);
        assert!(ran.code == Some(0) && ran.stdout.contains("rays      384\n"), "{ran:?}");
        place.read(output)
    };
    let room = picture("mine", "a.png");
    let other = picture(&format!("mine@{}", scene("lights.gltf").display()), "b.png");
    assert!(room.starts_with(b"\x89PNG") && room != other);
    let checked = place.run(&["check", "mine", "--size", "24x16", "--quiet"]);
    assert_eq!(checked.code, Some(0), "{checked:?}");
    fails(&place.run(&["run", "mine@nothing"]), 1, "nothing");
    change(&place, "mine/program.toml", "file = \"cornell-box\"", "");
    fails(&place.run(&["run", "mine"]), 2, "mine reads a scene: name one, as in mine@cornell-box");
    new(&place, "alone", "life");
    fails(&place.run(&["run", "alone@cornell-box"]), 2, "alone reads no scene");
    // A scene elsewhere is not the folder's to name.
    change(&place, "mine/program.toml", "[scene]\n", "[scene]\nfile = \"../a.png\"\n");
    fails(&place.run(&["run", "mine"]), 1, "no file ../a.png is in the folder");
}

#[test]
fn our_tracer_gives_the_same_picture_from_its_folder() {
    let place = Place::new();
    let view = ["--size", "24x18", "--quiet"];
    for (options, name) in
        [(&["--schedule", "second"][..], "a"), (&["--integrator", "shadows", "--schedule", "second"], "b")]
    {
        let written = place.run(&[&["export-program", "cornell-box", "-o", name], options, &view].concat());
        assert_eq!(written.code, Some(0), "{written:?}");
        let image = format!("{name}.png");
        let drawn = place.run(&[&["render", "cornell-box", "-o", &*image], options, &view].concat());
        assert_eq!(drawn.code, Some(0), "{drawn:?}");
        let from_folder = format!("{name}-own.png");
        let ran = place.run(&[&["run", name, "-o", &*from_folder], &view[..]].concat());
        assert_eq!(ran.code, Some(0), "{ran:?}");
        let [ours, theirs] =
            [image, from_folder].map(|path| image::open(place.path(path)).expect("a picture").into_rgb8());
        assert!(ours == theirs, "{name}");
    }
    fails(&place.run(&["export-program", "cornell-box", "-o", "a"]), 1, "a is not empty");
}

#[test]
fn programs_are_timed_and_their_elements_followed() {
    let place = Place::new();
    new(&place, "mine", "life");
    change(&place, "mine/program.toml", "[256, 256]", "[16, 8]");
    change(&place, "mine/program.toml", "repeat = 200", "repeat = 3");
    let timed = place.run(&["bench", "mine", "--repeats", "3", "--warmups", "0", "-o", "b", "--quiet"]);
    assert_eq!(timed.code, Some(0), "{timed:?}");
    let lines = |name: &str| fs::read_to_string(place.path(name)).expect("a table").lines().count();
    assert_eq!([lines("b/summary.csv"), lines("b/runs.csv"), lines("b/kernels.csv")], [2, 4, 3]);
    fails(&place.run(&["bench", "mine", "cornell-box", "-o", "c"]), 2, "measured apart");
    let told = place.run(&["trace", "mine", "--pixel", "3,4", "--quiet"]);
    assert!(told.code == Some(0) && told.stdout.contains("generation"), "{told:?}");
    assert!(told.stdout.contains("mine/generation.wgsl:"), "{told:?}");
    let found = place.run(&["trace", "mine", "--pixel", "3,4", "--format", "json", "--quiet"]);
    let found: Value = serde_json::from_str(&found.stdout).expect("JSON");
    assert_eq!(found.as_array().map(Vec::len), Some(4), "{found}");
    fails(&place.run(&["trace", "mine", "--pixel", "30,4"]), 1, "no element 30,4");
    fails(&place.run(&["trace", "mine"]), 2, "--pixel");
}

#[test]
fn a_zip_file_is_a_program() {
    let place = Place::new();
    new(&place, "mine", "prefix-sum");
    let mut zip = zip::ZipWriter::new(fs::File::create(place.path("mine.zip")).expect("a file"));
    for name in ["program.toml", "fill.wgsl", "scan.wgsl", "add.wgsl"] {
        zip.start_file(format!("mine/{name}"), zip::write::SimpleFileOptions::default()).expect("a file");
        std::io::Write::write_all(&mut zip, &place.read(&format!("mine/{name}"))).expect("written");
    }
    zip.finish().expect("written");
    for (program, output) in [("mine", "a.csv"), ("mine.zip", "b.csv")] {
        let ran = place.run(&["run", program, "-o", output, "--quiet"]);
        assert_eq!(ran.code, Some(0), "{ran:?}");
    }
    assert_eq!(place.read("a.csv"), place.read("b.csv"));
    fs::write(place.path("mine.zip"), b"PK\x03\x04").expect("written");
    fails(&place.run(&["run", "mine.zip"]), 1, "mine.zip: ");
}
