//! `raystep build`, and the streams of a build in a dump.

use serde_json::Value;

use crate::common::{Place, scene};

#[test]
fn a_build_is_checked_against_the_hosts_on_both_devices() {
    let place = Place::new();
    let teapot = scene("teapot.glb").display().to_string();
    for device in ["cpu", "gpu"] {
        let csv = format!("{device}.csv");
        let outcome =
            place.ok(&["build", &teapot, "--device", device, "--check", "--repeats", "2", "--passes-csv", &csv]);
        for line in [
            "triangles 994\n",
            // Most of it is empty, so rays leap, through a finer grid.
            "grid      48 x 24 x 42 cells, 42713 empty\n",
            "lists     13748 references, longest list 23; 7842 spans of up to 32 cells tested\n",
            "passes    36\n",
            "check     the same grid as the host's build, bit for bit\n",
        ] {
            assert!(outcome.stdout.contains(line), "{line:?} is not in {}", outcome.stdout);
        }
        let text = String::from_utf8(place.read(&csv)).expect("UTF-8");
        let kernels: Vec<_> =
            text.lines().skip(1).filter_map(|line| line.split(',').find(|f| f.starts_with("scatter_"))).collect();
        assert_eq!(
            (text.lines().count(), kernels),
            (37, vec!["scatter_even", "scatter_odd", "scatter_even", "scatter_odd"])
        );
    }
}

#[test]
fn an_irregular_grid_is_built_and_traced_through_on_the_device() {
    let place = Place::new();
    let teapot = scene("teapot.glb").display().to_string();
    let irregular = ["--accelerator", "irregular", "--device", "gpu"];
    let outcome = place.ok(&[&["build", &teapot, "--check"][..], &irregular].concat());
    for line in [
        "top level 31 x 15 x 27 cells, 7364 references\n",
        "octrees   54625 leaves up to 8 levels below, 91243 map entries\n",
        "grid      23078 cells after merging, 12079 empty\n",
        "lists     22988 references, longest list 17\n",
        "check     the same grid as the host's build, bit for bit\n",
    ] {
        assert!(outcome.stdout.contains(line), "{line:?} is not in {}", outcome.stdout);
    }
    let render = |build: &str, file: &str| {
        let size = ["--size", "32x24", "--build", build, "-o", file];
        place.ok(&[&["render", &teapot][..], &irregular, &size].concat());
        place.read(file)
    };
    assert!(render("device", "device.png") == render("host", "host.png"));
    for (accelerator, expected) in [
        ("bvh", "--build device builds grids: use --accelerator grid or irregular"),
        ("none", "--build device builds grids: use --accelerator grid or irregular"),
    ] {
        let wrong = place.run(&["render", &teapot, "--accelerator", accelerator, "--build", "device", "-o", "x.png"]);
        assert_eq!(wrong.code, Some(2));
        assert!(wrong.stderr.contains(expected), "{}", wrong.stderr);
    }
    let wrong = place.run(&["build", &teapot, "--accelerator", "bvh"]);
    assert!(wrong.stderr.contains("the program grid-build builds grids"), "{}", wrong.stderr);
}

#[test]
fn a_dump_of_a_build_has_streams_from_the_pass_on_that_counts_their_elements() {
    let place = Place::new();
    let file = scene("cornell-box.gltf").display().to_string();
    let build = ["dump", &file, "--program", "grid-build", "--device", "cpu", "-o"];
    place.ok(&[&build[..], &["all", "--pass", "all"]].concat());
    let index: Value = serde_json::from_slice(&place.read("all/index.json")).expect("JSON");
    let files = |pass: usize| index["passes"][pass]["files"].as_array().expect("files").len();
    let has = |pass: usize, stream: &str| place.path(format!("all/pass-{pass:06}.{stream}.npy")).is_file();
    assert_eq!(index["passes"].as_array().map(Vec::len), Some(26));
    assert!(files(0) < files(4) && files(4) < files(8) && files(25) == 24, "{index}");
    assert!(has(0, "box") && !has(0, "mask") && has(4, "mask") && !has(4, "cell_even") && has(8, "cell_even"));
    let wrong = place.run(&[&build[..], &["none", "--stream", "hit"]].concat());
    assert_eq!(wrong.code, Some(2));
    assert!(
        wrong.stderr.contains("--stream hit: no such stream; the streams are box, first_span,"),
        "{}",
        wrong.stderr
    );
}
