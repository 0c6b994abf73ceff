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
            "grid      24 x 12 x 21 cells, 4703 empty\n",
            "lists     5548 references, longest list 34; 3391 spans of up to 32 cells tested\n",
            "passes    34\n",
            "check     the same lists as the host's build, bit for bit\n",
        ] {
            assert!(outcome.stdout.contains(line), "{line:?} is not in {}", outcome.stdout);
        }
        let text = String::from_utf8(place.read(&csv)).expect("UTF-8");
        let kernels: Vec<_> =
            text.lines().skip(1).filter_map(|line| line.split(',').find(|f| f.starts_with("scatter_"))).collect();
        assert_eq!((text.lines().count(), kernels), (35, vec!["scatter_0", "scatter_1", "scatter_2", "scatter_3"]));
    }
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
    assert_eq!(index["passes"].as_array().map(Vec::len), Some(24));
    assert!(files(0) < files(4) && files(4) < files(8) && files(23) == 22, "{index}");
    assert!(has(0, "box") && !has(0, "mask") && has(4, "mask") && !has(4, "cell_even") && has(8, "cell_even"));
    let wrong = place.run(&[&build[..], &["none", "--stream", "hit"]].concat());
    assert_eq!(wrong.code, Some(2));
    assert!(
        wrong.stderr.contains("--stream hit: no such stream; the streams are box, first_span,"),
        "{}",
        wrong.stderr
    );
}
