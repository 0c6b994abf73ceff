//! Names with characters that a terminal, a browser or a spreadsheet would act on: no output contains them unescaped.

use std::fs;

use crate::common::{Place, scene};

/// Sets a terminal's title, moves up and clears; a C1 CSI; reverses the direction of the text that follows.
const EVIL: &str = "\u{1b}]0;mine\u{7}\u{1b}[1A\u{9b}2K\u{202e}\u{7f}";
/// How it must be shown.
const SHOWN: &str = r"\u{1b}]0;mine\u{7}\u{1b}[1A\u{9b}2K\u{202e}\u{7f}";

/// Fails if a text has a character that would be acted on, apart from line ends.
fn assert_tame(text: &str, what: &str) {
    let is_wild = |c: &char| {
        let turns =
            matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        (c.is_control() && !matches!(c, '\n' | '\r')) || turns
    };
    assert_eq!(text.chars().find(is_wild), None, "{what}: {text:?}");
    assert!(!text.replace("\r\n", "\n").contains('\r'), "{what}: a line begins again: {text:?}");
}

/// Runs, and expects the escaped name in the output.
fn shows(place: &Place, code: i32, arguments: &[&str]) {
    let outcome = place.run(arguments);
    assert_eq!(outcome.code, Some(code), "{arguments:?}: {outcome:?}");
    let said = outcome.stdout + &outcome.stderr;
    assert_tame(&said, &format!("{arguments:?}"));
    assert!(said.contains(SHOWN), "{arguments:?}: {said}");
}

/// Writes a scene with additional JSON.
fn write_scene(place: &Place, name: &str, more: &serde_json::Value) {
    let text = fs::read_to_string(scene("single-triangle.gltf")).expect("a scene");
    let mut gltf: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    for (key, value) in more.as_object().expect("an object") {
        gltf[key] = value.clone();
    }
    fs::write(place.path(name), gltf.to_string()).expect("a file");
}

#[test]
fn what_a_scene_holds_is_shown_and_not_obeyed() {
    let place = Place::new();
    write_scene(&place, "used.gltf", &serde_json::json!({ "extensionsUsed": [EVIL] }));
    write_scene(
        &place,
        "required.gltf",
        &serde_json::json!({ "extensionsUsed": [EVIL], "extensionsRequired": [EVIL] }),
    );
    write_scene(&place, "uri.gltf", &serde_json::json!({ "buffers": [{ "byteLength": 1024, "uri": EVIL }] }));
    let camera =
        serde_json::json!({ "name": EVIL, "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.01 } });
    write_scene(&place, "camera.gltf", &serde_json::json!({ "cameras": [camera] }));
    let render = ["-o", "a.png", "--size", "8x8", "--device", "cpu"];
    shows(&place, 1, &[&["render", "required.gltf"], &render[..]].concat());
    shows(&place, 1, &[&["render", "uri.gltf"], &render[..]].concat());
    shows(&place, 0, &[&["render", "used.gltf", "--summary-json", "run.json"], &render[..]].concat());
    shows(&place, 0, &["info", "used.gltf"]);
    shows(&place, 0, &["info", "camera.gltf"]);
    // In JSON the name is unchanged, and escaped according to JSON's rules.
    for text in
        [place.ok(&["info", "used.gltf", "--json"]).stdout, String::from_utf8(place.read("run.json")).expect("UTF-8")]
    {
        assert_tame(&text, "JSON");
        let about: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let notes = about["notes"].as_array().expect("notes");
        assert!(notes.iter().any(|note| note.as_str().is_some_and(|note| note.contains(EVIL))), "{text}");
    }
}

#[test]
fn what_is_typed_is_shown_and_not_obeyed() {
    let place = Place::new();
    let file = scene("single-triangle.gltf").display().to_string();
    let picture = format!("{EVIL}.jpg");
    for arguments in [
        &["render", &file, "-o", &picture][..],
        &["stability", "--case", EVIL],
        &["render", &file, "-o", "a.png", "--device", EVIL],
        &["render", &file, "-o", "a.png", "--spp", EVIL],
        &["render", &file, "-o", "a.png", "--grid", EVIL],
        &["dump", &file, "-o", "d", "--stream", EVIL],
        &["inspect", &file, "--screenshot", "a.png", "--do", EVIL],
        &["trace", "--link", EVIL],
        &[EVIL],
        &["scene", EVIL],
        &["render", &file, EVIL],
    ] {
        shows(&place, 2, arguments);
    }
    shows(&place, 1, &["render", &format!("{EVIL}.gltf"), "-o", "a.png"]);
    shows(&place, 1, &["render", &file, "-o", &format!("{EVIL}/a.png"), "--device", "cpu"]);
    shows(&place, 1, &["render", &file, "-o", "a.png", "--adapter", EVIL]);
    assert!(place.names().is_empty());
}

/// Not every file system allows every name.
#[test]
#[cfg(unix)]
fn the_name_of_a_file_is_shown_in_lines_tables_and_pages() {
    let place = Place::new();
    let name = format!("{EVIL}\n<b>\"x\",'y'&.gltf");
    fs::copy(scene("single-triangle.gltf"), place.path(&name)).expect("a copy");
    let one_line = SHOWN.to_owned() + "\\n<b>\"x\",'y'&";
    let common = ["--device", "cpu"];
    shows(&place, 0, &["scene", "cornell-box", "-o", &format!("{EVIL}.glb")]);
    shows(&place, 0, &["info", &name]);

    let bench = ["bench", &name, "--sizes", "8x8", "--repeats", "1", "--warmups", "0", "-o", "bench"];
    let outcome = place.ok(&[&bench[..], &common[..]].concat());
    assert_tame(&(outcome.stdout.clone() + &outcome.stderr), "bench");
    assert!(outcome.stdout.contains(&format!("{one_line} (1 triangles), 8x8")), "{outcome:?}");
    for file in ["bench/summary.csv", "bench/passes.csv"] {
        let bytes = place.read(file);
        assert_tame(&String::from_utf8_lossy(&bytes), file);
        let mut reader = csv::ReaderBuilder::new().flexible(false).from_reader(bytes.as_slice());
        let column = reader.headers().expect("a header").iter().position(|n| n == "scene").expect("a column");
        let mut rows = 0;
        for row in reader.records() {
            assert_eq!(row.expect("a row")[column], one_line, "{file}");
            rows += 1;
        }
        assert!(rows > 0, "{file}");
    }
    assert_tame(&String::from_utf8_lossy(&place.read("bench/run.json")), "run.json");

    let report = ["report", &name, "--quick", "--size", "8x8", "--section", "grid", "-o", "report"];
    let outcome = place.ok(&[&report[..], &common[..]].concat());
    assert_tame(&(outcome.stdout + &outcome.stderr), "report");
    let html = "&lt;b&gt;&quot;x&quot;,&#39;y&#39;&amp;";
    for file in fs::read_dir(place.path("report")).expect("the folder") {
        let path = file.expect("an entry").path();
        // Figures as PDF are compressed.
        if path.extension().is_some_and(|extension| extension == "pdf") {
            continue;
        }
        let text = fs::read_to_string(&path).expect("text");
        assert_tame(&text, &path.display().to_string());
        assert!(!text.contains("<b>\"x\"") || path.extension().is_some_and(|e| e == "csv"), "{}", path.display());
        if path.ends_with("index.html") {
            assert!(text.contains(&format!(">{SHOWN}\\n{html} <small>")), "{text}");
        }
    }
}
