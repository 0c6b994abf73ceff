//! Wrong files of sweeps are refused before anything runs.

use std::fs;

use super::{place, run};

#[test]
fn what_is_wrong_in_the_file_is_named_before_anything_runs() {
    let place = place("");
    let render = "what = \"render\"\nscenes = [\"scenes/*.gltf\"]\n";
    let bench = "what = \"bench\"\nscenes = [\"scenes/*.gltf\"]\n";
    let stability = "what = \"stability\"\n";
    for (text, wanted) in [
        ("what = ".to_owned(), "sweep.toml, line 1: "),
        (format!("{render}\nx = 1 2"), "sweep.toml, line 4: "),
        (String::new(), "what is missing: expected bench, stability, report or render"),
        ("what = \"trace\"".into(), "what = \"trace\": expected \"bench\""),
        (format!("scene = []\n{render}"), "sweep.toml: scene: no such key; did you mean scenes?"),
        ("what = \"render\"".into(), "scenes is missing: expected a list of files or patterns"),
        ("what = \"render\"\nscenes = []".into(), "scenes: expected a list of files or patterns"),
        ("what = \"render\"\nscenes = [1]".into(), "scenes: expected a list of files or patterns"),
        ("what = \"render\"\nscenes = [\"none/*.glb\"]".into(), "scenes: \"none/*.glb\" matches no file in "),
        ("what = \"render\"\nscenes = [\"a***b\"]".into(), "scenes: \"a***b\" is not a pattern"),
        ("what = \"render\"\nscenes = [\"sweep.toml\"]".into(), "job sweep: "),
        (format!("{stability}scenes = [\"scenes/*.gltf\"]"), "scenes: stability has cases of its own"),
        (format!("options = 1\n{render}"), "options: expected a table"),
        (
            format!("{render}[options]\nszie = \"16x16\""),
            "options.szie: raystep render has no option --szie; did you mean size?",
        ),
        (format!("{render}[options]\nsize = \"16\""), "job cornell-box: --size 16: expected two integers"),
        (format!("{render}[options]\nsize = true"), "options.size: expected the value of --size"),
        (format!("{render}[options]\neye = [true]"), "options.eye: expected a list of numbers"),
        (
            format!("{render}[options]\nsize = [\"1x1\", \"2x2\"]"),
            "options.size: --size takes one value; to run a job with each",
        ),
        (
            format!("{render}[options]\ncounters = 1"),
            "options.counters: --counters has no value; expected true or false",
        ),
        (format!("{render}[options]\noutput = \"x.png\""), "options.output: a sweep sets --output itself"),
        (format!("{render}[options]\nforce = true"), "options.force: a sweep sets --force itself"),
        (format!("{render}[options]\nquiet = true"), "options.quiet: a sweep sets --quiet itself"),
        (format!("{bench}[options]\nbaseline = \"x\""), "options.baseline: --baseline cannot be used in a sweep"),
        (format!("{bench}[options]\nserve = true"), "options.serve: raystep bench has no option --serve"),
        (format!("{render}[each]\nspp = 4"), "each.spp: expected a list of values"),
        (format!("{render}[each]\nspp = []"), "each.spp: expected a list of values"),
        (format!("{render}[each]\nspp = [4, 4]"), "each.spp: 4 is listed twice"),
        (format!("{render}[each]\nspp = [4, 0]"), "job cornell-box-spp-0: --spp 0: expected"),
        (format!("{render}[options]\nspp = 2\n[each]\nspp = [4]"), "spp is under [options] and under [each]"),
        (
            format!("{bench}[each]\naccelerators = [\"grid\", \"bvh\"]"),
            "each.accelerators: bench compares accelerators within one job",
        ),
        (format!("{render}format = \"jpg\""), "format: expected \"png\" or \"exr\""),
        (format!("{bench}format = \"exr\""), "format: bench makes no image"),
        (format!("{bench}parts = 2"), "parts: only what = \"render\" can be divided"),
        (
            format!("{render}parts = 3\n[options]\nspp = 32"),
            "parts = 3: expected at most 2, the number of blocks of 16 samples",
        ),
        (format!("{render}parts = 0"), "parts = 0: expected an integer from 1 to 10000"),
        (format!("{render}retries = -1"), "retries = -1: expected an integer from 0"),
    ] {
        fs::write(place.path("sweep.toml"), &text).expect("a file");
        let before = place.names();
        let outcome = run(&place, &["sweep.toml", "-o", "out"]);
        assert!(matches!(outcome.code, Some(1 | 2)), "{text}: {outcome:?}");
        let lines: Vec<&str> = outcome.stderr.lines().collect();
        assert!(
            matches!(lines[..], [line] if line.starts_with("error: sweep.toml") && line.contains(wanted)),
            "{text}: {outcome:?}"
        );
        assert!(place.names().len() <= before.len() + 1 && !place.path("out").exists(), "{text}: files are left");
    }
    place.fails(2, "--on ray is only in the Python package", &["sweep", "sweep.toml", "-o", "out", "--on", "ray"]);
    place.fails(1, "missing.toml: No such file", &["sweep", "missing.toml", "-o", "out"]);
    place.fails(2, "SWEEP.toml", &["sweep", "-o", "out"]);
}
