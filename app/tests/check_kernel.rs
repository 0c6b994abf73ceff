//! `raystep check-kernel`, and `--kernel` in other commands.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::common::{Outcome, Place};
use crate::files::cornell_box;

const SMALL: [&str; 3] = ["--size", "16x12", "--quiet"];

/// The WGSL of a kernel of ours.
fn wgsl(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../kernels/src/programs/closest_hit");
    fs::read_to_string(folder.join(name).with_extension("wgsl")).expect("a kernel's file")
}

/// Writes `my.wgsl`: `intersect` with a text replaced by another.
fn write_intersect(place: &Place, from: &str, to: &str) {
    let source = wgsl("intersect");
    assert!(source.contains(from), "no {from:?}");
    fs::write(place.path("my.wgsl"), source.replacen(from, to, 1)).expect("a file");
}

fn check(place: &Place, more: &[&str]) -> Outcome {
    place.run(&[&["check-kernel", "my.wgsl", &cornell_box()], &SMALL[..], more].concat())
}

fn json(outcome: &Outcome) -> Value {
    serde_json::from_str(&outcome.stdout).unwrap_or_else(|error| panic!("{error}: {outcome:?}"))
}

#[test]
fn a_kernel_that_does_the_same_passes() {
    let place = Place::new();
    write_intersect(&place, "fn ", "fn ");
    let outcome = check(&place, &[]);
    assert_eq!((outcome.code, &*outcome.stderr), (Some(0), ""), "{outcome:?}");
    let lines: Vec<_> = outcome.stdout.lines().collect();
    assert_eq!(lines.len(), 2, "{lines:?}");
    assert!(lines[0].starts_with("my.wgsl does what intersect does, interpreted: "), "{lines:?}");
    assert!(lines[1].starts_with("my.wgsl does what intersect does, on "), "{lines:?}");
    let found = json(&check(&place, &["--json"]));
    let all = found.as_array().expect("a list");
    assert_eq!((all.len(), &all[0]["device"], &all[0]["kernel"]), (2, &"interpreted".into(), &"intersect".into()));
    for one in all {
        assert_eq!((&one["file"], &one["verdict"]), (&"my.wgsl".into(), &"same".into()));
        assert!(one["rays"].as_u64() > Some(192) && one["passes"].as_u64() > Some(2), "{one}");
    }
    // On one device alone.
    for (device, name) in [("cpu", "interpreted"), ("gpu", "on ")] {
        let outcome = check(&place, &["--device", device]);
        assert!(outcome.code == Some(0) && outcome.stdout.lines().count() == 1, "{outcome:?}");
        assert!(outcome.stdout.contains(&format!("does what intersect does, {name}")), "{outcome:?}");
    }
}

#[test]
fn a_difference_is_told_with_its_line_and_its_reason() {
    let place = Place::new();
    write_intersect(&place, "item += 1u", "item += 2u");
    let outcome = check(&place, &[]);
    assert_eq!(outcome.code, Some(1));
    assert_eq!(outcome.stderr, "error: my.wgsl does not do what intersect does\n");
    let line = 1 + wgsl("intersect").lines().position(|line| line.contains("3, vec4u(item)")).expect("a line");
    let lines: Vec<_> = outcome.stdout.lines().collect();
    assert!(lines[0].starts_with("my.wgsl differs from intersect, interpreted, first in pass "), "{lines:?}");
    assert_eq!(lines[1], "  state.item is 2, expected 1");
    assert_eq!(lines[2], format!("  stored by my.wgsl:{line}: textureStore(state, texel, 3, vec4u(item));"));
    assert!(lines[3].starts_with("  decided by "), "{lines:?}");

    let outcome = check(&place, &["--json", "--device", "cpu"]);
    assert_eq!((outcome.code, outcome.stderr.lines().count()), (Some(1), 1), "{outcome:?}");
    let found = &json(&outcome)[0];
    assert_eq!(
        (&found["verdict"], &found["stream"], &found["layer"]),
        (&"differs".into(), &"state".into(), &"item".into())
    );
    assert_eq!((&found["value"], &found["expected"]), (&"2".into(), &"1".into()));
    assert_eq!((&found["stored"]["file"], &found["stored"]["line"]), (&"my.wgsl".into(), &line.into()));
    let pixel = found["pixel"].as_array().expect("a pixel");
    assert!(pixel.len() == 2 && found["pass"].is_u64() && found["rays"].is_u64(), "{found}");
    let decided = &found["decided"];
    assert!(decided["line"].is_u64() && decided["text"].is_string() && decided["how"].is_array(), "{found}");
}

#[test]
fn a_mistake_is_told_with_the_line_and_a_caret() {
    let place = Place::new();
    write_intersect(&place, "    let cell = ", "\tlet cell: f32 = ");
    let line = 1 + wgsl("intersect").lines().position(|line| line.contains("let cell = ")).expect("a line");
    let told = format!(
        "error: my.wgsl:{line}:6: the type of `cell` is expected to be `f32`, but got `u32`\n    \tlet cell: f32 = \
         textureLoad(state, texel, 2).x;\n    \t    ^\n"
    );
    let scene = cornell_box();
    let outcome = check(&place, &[]);
    assert_eq!((outcome.code, &*outcome.stdout, &*outcome.stderr), (Some(1), "", &*told));
    for command in [
        &["render", &scene, "-o", "a.png", "--kernel", "my.wgsl"][..],
        &["trace", &scene, "--pixel", "3,3", "--kernel", "intersect=my.wgsl"],
        &["dump", &scene, "-o", "dumped", "--kernel", "my.wgsl"],
        &["plan", &scene, "--kernel", "my.wgsl"],
    ] {
        let outcome = place.run(&[command, &SMALL[..2]].concat());
        assert_eq!((outcome.code, &*outcome.stdout), (Some(1), ""), "{command:?}");
        assert!(outcome.stderr.ends_with(&told), "{command:?}: {outcome:?}");
    }
    assert_eq!(place.names(), ["my.wgsl"]);
    let outcome = check(&place, &["--json"]);
    assert_eq!((outcome.code, &*outcome.stderr), (Some(1), &*told));
    let found = &json(&outcome)[0];
    assert_eq!((&found["verdict"], &found["line"], &found["column"]), (&"invalid".into(), &line.into(), &6.into()));
    assert_eq!((&found["file"], &found["kernel"]), (&"my.wgsl".into(), &"intersect".into()));
    assert!(told.contains(found["message"].as_str().expect("a message")), "{found}");
}

#[test]
fn a_loop_without_end_fails() {
    let place = Place::new();
    let list = "let list = list_of(cell);";
    write_intersect(&place, list, "var n = 1u; while (n > 0u) { n ^= 2u; } let list = list_of(cell);");
    let line = 1 + wgsl("intersect").lines().position(|line| line.contains(list)).expect("a line");
    for (device, name) in [("cpu", "interpreted: "), ("gpu", "on ")] {
        let outcome = check(&place, &["--device", device]);
        assert_eq!((outcome.code, outcome.stderr.lines().count()), (Some(1), 1), "{outcome:?}");
        assert!(outcome.stdout.starts_with(&format!("my.wgsl fails, {name}")), "{outcome:?}");
        assert!(outcome.stdout.contains(&format!("my.wgsl:{line}: a loop has not ended after ")), "{outcome:?}");
        let found = &json(&check(&place, &["--device", device, "--json"]))[0];
        assert_eq!(found["verdict"], "fails");
        assert!(
            found["message"].as_str().is_some_and(|text| text.starts_with(&format!("my.wgsl:{line}: "))),
            "{found}"
        );
        let told = format!("my.wgsl:{line}: a loop has not ended");
        let render = ["render", &cornell_box(), "-o", "a.png", "--kernel", "my.wgsl", "--device", device];
        place.fails(1, &told, &[&render[..], &SMALL].concat());
    }
}

/// Commands that run kernels give what they give without `--kernel`, in single steps through the grid.
#[test]
fn our_own_kernels_change_no_output() {
    let place = Place::new();
    let scene = cornell_box();
    let names = ["generate", "setup", "traverse_grid", "intersect", "shade"];
    names.iter().for_each(|name| fs::write(place.path(format!("{name}.wgsl")), wgsl(name)).expect("a file"));
    let kernels: Vec<String> = names.iter().flat_map(|name| ["--kernel".into(), format!("{name}.wgsl")]).collect();
    let kernels: Vec<&str> = kernels.iter().map(String::as_str).collect();
    let steps = ["--schedule", "compact", "--steps-per-pass", "1", "--accelerator", "grid"];
    for device in ["cpu", "gpu"] {
        let both = |command: &[&str]| {
            let run = |more: &[&str]| place.ok(&[command, &SMALL[..2], &["--device", device], more].concat()).stdout;
            [run(&steps), run(&kernels)]
        };
        let mut pictures = [&steps[..], &kernels].into_iter().map(|more| {
            place.ok(&[&["render", &scene, "-o", "a.png", "--device", device], &SMALL[..], more].concat());
            place.read("a.png")
        });
        assert!(pictures.next() == pictures.next(), "{device}: the pictures differ");
        let trace = both(&["trace", &scene, "--pixel", "7,6", "--format", "json"]);
        let [own, found] = trace.map(|text| serde_json::from_str::<Value>(&text).expect("JSON"));
        assert_eq!(own["rows"], found["rows"], "{device}");
        assert!(own["rows"].as_array().is_some_and(|rows| rows.len() > 4), "{own}");
        let [own, found] =
            both(&["plan", &scene, "--json"]).map(|text| serde_json::from_str::<Value>(&text).expect("JSON"));
        assert_eq!(own, found, "{device}");
        for (folder, more) in [("own", &steps[..]), ("found", &kernels)] {
            place.ok(&[&["dump", &scene, "-o", folder, "--device", device], &SMALL[..], more].concat());
        }
        let files = |folder| {
            let names =
                fs::read_dir(place.path(folder)).expect("a folder").map(|file| file.expect("a file").file_name());
            let mut names: Vec<_> = names.filter(|name| name.to_string_lossy().ends_with(".npy")).collect();
            names.sort();
            names
                .into_iter()
                .map(|name| (fs::read(place.path(folder).join(&name)).expect("a file"), name))
                .collect::<Vec<_>>()
        };
        assert!(files("own") == files("found") && files("own").len() > 4, "{device}: the streams differ");
        ["own", "found"].iter().for_each(|folder| fs::remove_dir_all(place.path(folder)).expect("a folder"));
    }
}

#[test]
fn what_cannot_be_replaced_is_refused() {
    let place = Place::new();
    let scene = cornell_box();
    write_intersect(&place, "fn ", "fn ");
    fs::write(place.path("fused.wgsl"), wgsl("fused")).expect("a file");
    fs::write(place.path("empty.wgsl"), "// nothing\n").expect("a file");
    fs::write(place.path("latin.wgsl"), b"// gr\xf6\xdfer\n").expect("a file");
    fs::write(place.path("large.wgsl"), vec![b' '; (1 << 20) + 1]).expect("a file");
    let tell = "no @compute function tells which kernel it replaces: use --kernel NAME=FILE";
    for (kernel, more, code, wanted) in [
        ("no.wgsl", &[][..], 1, "no.wgsl: No such file or directory"),
        (".", &[], 1, ".: Is a directory"),
        ("latin.wgsl", &[], 1, "latin.wgsl: not a text in UTF-8"),
        ("large.wgsl", &[], 1, "large.wgsl: larger than 1 MiB, too large for a kernel"),
        ("empty.wgsl", &[], 1, tell),
        ("intersect=empty.wgsl", &[], 1, "empty.wgsl: it has no @compute function named intersect"),
        (
            "interest=my.wgsl",
            &[],
            1,
            "--kernel interest=my.wgsl: no kernel is named interest; this run has generate, setup,",
        ),
        ("shade=my.wgsl", &[], 1, "my.wgsl: it has no @compute function named shade"),
        (
            "fused.wgsl",
            &[],
            1,
            "--kernel fused=fused.wgsl: this run does without fused: needed only with --schedule fused",
        ),
        ("my.wgsl", &["--schedule", "fused"], 1, "this run does without intersect: "),
        ("my.wgsl", &["--mapping", "fragment"], 1, "a kernel is replaced as a compute shader: use --mapping compute"),
        ("my.wgsl", &["--mapping", "fragment", "--schedule", "second"], 1, "use --mapping compute"),
        (
            "my.wgsl",
            &["--program", "grid-build"],
            1,
            "--kernel intersect=my.wgsl: no kernel of grid_build can be replaced",
        ),
    ] {
        let device: &[&str] = if more.contains(&"--mapping") { &["--device", "gpu"] } else { &[] };
        let command = if more.contains(&"--program") { "dump" } else { "render" };
        let output = if command == "dump" { "dumped" } else { "a.png" };
        place.fails(
            code,
            wanted,
            &[&[command, &scene, "-o", output, "--kernel", kernel], &SMALL[..], more, device].concat(),
        );
    }
    place.fails(2, "--kernel", &["render", &scene, "-o", "a.png", "--kernel", "intersect="]);
    // The window needs the kernel to be right from the start.
    let shot = ["inspect", &*scene, "--kernel", "intersect=empty.wgsl", "--screenshot", "a.png"];
    place.fails(1, "empty.wgsl: it has no @compute function named intersect", &shot);
    let twice = ["check-kernel", "my.wgsl", &scene, "--kernel", "my.wgsl"];
    place.fails(2, "--kernel: check-kernel compares one kernel, that of FILE", &twice);
    place.fails(1, tell, &["check-kernel", "empty.wgsl", &scene, "--quiet"]);
    place.fails(1, "no kernel is named walks", &["check-kernel", "my.wgsl", "--for", "walks", &scene, "--quiet"]);
}

#[test]
fn runs_with_a_kernel_take_single_steps_unless_told_otherwise() {
    let place = Place::new();
    let scene = cornell_box();
    write_intersect(&place, "fn ", "fn ");
    let plan = |more: &[&str]| place.ok(&[&["plan", &scene], &SMALL[..2], more].concat()).stdout;
    let (usual, own) = (plan(&[]), plan(&["--kernel", "my.wgsl"]));
    let steps = ["--schedule", "compact", "--steps-per-pass", "1", "--accelerator", "grid"];
    assert_eq!(own, plan(&steps));
    assert_ne!(own, usual);
    let told = plan(&["--kernel", "my.wgsl", "--schedule", "second", "--accelerator", "bvh"]);
    assert_eq!(told, plan(&["--schedule", "second", "--accelerator", "bvh"]));
    // A kernel for which another schedule is needed.
    fs::write(place.path("walk.wgsl"), wgsl("walk")).expect("a file");
    let outcome = place.ok(&[&["check-kernel", "walk.wgsl", &scene, "--steps-per-pass", "8"], &SMALL[..]].concat());
    assert!(outcome.stdout.contains("walk.wgsl does what walk does, interpreted"), "{outcome:?}");
}

#[test]
fn what_a_kernel_prints_is_traced_and_dumped() {
    let place = Place::new();
    let scene = cornell_box();
    write_intersect(
        &place,
        "item += 1u;",
        "note(\"triangle tested\", entry.triangle); note(\"t\", candidate.t);\n        item += 1u;",
    );
    let with = ["--kernel", "my.wgsl", "--device", "cpu"];
    let traced = place.ok(&[&["trace", &scene, "--pixel", "8,6", "--format", "json"], &SMALL[..], &with].concat());
    let traced: Value = serde_json::from_str(&traced.stdout).expect("JSON");
    let rows = traced["rows"].as_array().expect("rows");
    let tested: Vec<_> = rows.iter().filter(|row| !row["tested"].is_null()).collect();
    assert!(!tested.is_empty(), "{traced}");
    for row in tested {
        assert_eq!(row["notes"][0], format!("triangle tested = {}", row["tested"]), "{row}");
    }
    place.ok(&[&["dump", &scene, "--pass", "all", "--stream", "state", "-o", "d"], &SMALL[..], &with].concat());
    let index: Value = serde_json::from_slice(&fs::read(place.path("d/index.json")).expect("a file")).expect("JSON");
    let passes = index["passes"].as_array().expect("passes");
    for pass in passes {
        let files = pass["files"].as_array().expect("files").iter().filter(|file| file.to_string().contains(".note."));
        assert_eq!(files.count(), if pass["kernel"] == "intersect" { 2 } else { 0 }, "{pass}");
    }
    // The first triangles that a pixel's ray tests.
    let pass = rows.iter().find(|row| !row["tested"].is_null()).expect("a test");
    let file = format!("d/pass-{:06}.note.triangle_tested.npy", pass["pass"].as_u64().expect("a pass"));
    let bytes = fs::read(place.path(&file)).expect("a file");
    let at = bytes.len() - 4 * (16 * 12 - (6 * 16 + 8));
    let value = u32::from_le_bytes(bytes[at..at + 4].try_into().expect("a word"));
    assert_eq!(u64::from(value), pass["tested"].as_u64().expect("a triangle"));
    assert!(String::from_utf8_lossy(&bytes[..128]).contains("(1, 12, 16)"));
}

/// A kernel of one's own is measured, and compared with the built-in one by a baseline.
#[test]
fn a_kernel_is_measured_beside_the_built_in_one() {
    let place = Place::new();
    let scene = cornell_box();
    let bench = |more: &[&str]| {
        let common = ["bench", &scene, "--size", "16x12", "--device", "cpu", "--warmups", "0", "--repeats", "7"];
        place.run(&[&common, more].concat())
    };
    let with = ["--kernel", "my.wgsl", "--schedules", "second", "--baseline", "before", "--at-most", "1000"];
    assert_eq!(bench(&["--schedules", "second", "-o", "before"]).code, Some(0));
    write_intersect(&place, "fn ", "fn ");
    let outcome = bench(&[&with[..], &["-o", "same"]].concat());
    assert!(outcome.code == Some(0) && outcome.stdout.contains("Pass: at most 1000 times as slow"), "{outcome:?}");
    // The second triangle of every list is left out.
    write_intersect(&place, "item += 1u", "item += 2u");
    let outcome = bench(&[&with[..], &["-o", "fewer"]].concat());
    assert!(outcome.code == Some(1) && outcome.stderr.contains("hits"), "{outcome:?}");
    // The fused kernel intersects by itself.
    let outcome = bench(&["--kernel", "my.wgsl", "--schedules", "fused", "-o", "none"]);
    let why = "error: --kernel intersect=my.wgsl: this run does without intersect";
    assert!(outcome.code == Some(1) && outcome.stderr.contains(why), "{outcome:?}");
    let this = env!("CARGO_BIN_EXE_raystep");
    let outcome = bench(&["--kernel", "my.wgsl", "--against", this, "--at-most", "2", "-o", "none"]);
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(outcome.stderr.contains("--kernel: ") && outcome.stderr.contains("--baseline"), "{outcome:?}");
    place.run(&["new", "mine"]);
    let outcome = place.run(&["bench", "mine", "--kernel", "my.wgsl", "-o", "none"]);
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(outcome.stderr.contains("a program of your own has no built-in kernels"), "{outcome:?}");
}
