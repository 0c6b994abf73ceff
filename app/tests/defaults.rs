//! Defaults: the paper's grid and schedule where passes are stepped or recorded, otherwise the fastest, which is said.

use serde_json::Value;

use crate::common::{Place, scene};

const SMALL: [&str; 4] = ["--size", "8x8", "--device", "cpu"];
const DRAWN: [&str; 6] = ["--size", "8x8", "--device", "gpu", "--mapping", "fragment"];

/// The steps that readers of the paper expect, which are not the fastest.
const RECORDED: &str = "grid, compact: passes are recorded; faster: --accelerator auto --schedule fused; as in the paper: --schedule second";

fn cornell_box() -> String {
    scene("cornell-box.gltf").display().to_string()
}

/// What the summary of `render` says about how rays were traced.
fn traced(place: &Place, small: &[&str], more: &[&str]) -> String {
    let said = place.ok(&[&["render", &cornell_box(), "-o", "a.png"], small, more].concat()).stderr;
    let line = said.lines().find_map(|line| line.strip_prefix("tracing   "));
    line.unwrap_or_else(|| panic!("{more:?}: {said}")).to_owned()
}

#[test]
fn an_image_is_traced_by_what_is_fastest_unless_passes_or_a_grid_are_asked_for() {
    let place = Place::new();
    for (more, wanted) in [
        (&[][..], "bvh, fused: chosen for this scene"),
        (&["--spp", "4", "--check"], "bvh, fused: chosen for this scene"),
        (&["--schedule", "auto"], "bvh, fused: chosen for this scene"),
        (&["--accelerator", "auto", "--schedule", "second"], "bvh, second: structure chosen for this scene"),
        (&["--accelerator", "irregular"], "irregular, fused"),
        (&["--passes-csv", "p.csv"], RECORDED),
        (&["--trace-json", "t.json"], RECORDED),
        (&["--passes-csv", "p.csv", "--accelerator", "bvh"], "bvh, compact"),
        (&["--passes-csv", "p.csv", "--schedule", "fused"], "bvh, fused: chosen for this scene"),
        (&["--schedule", "first"], "grid, first"),
        (&["--steps-per-pass", "2"], "grid, compact"),
        (&["--numerics", "paper"], "grid, compact"),
        (&["--numerics", "paper", "--traversal", "3d-dda"], "grid, compact"),
        (&["--grid", "8"], "grid, fused"),
        (&["--grid", "auto"], "grid, fused"),
        (&["--skip", "on"], "grid, fused"),
        (&["--build", "device"], "grid, fused"),
    ] {
        assert_eq!(traced(&place, &SMALL, more), wanted, "{more:?}");
    }
    assert_eq!(traced(&place, &DRAWN, &[]), "grid, second");
}

#[test]
fn a_scene_of_a_few_triangles_is_traced_without_a_structure() {
    let place = Place::new();
    let file = scene("single-triangle.gltf").display().to_string();
    let said = place.ok(&[&["render", &file, "-o", "a.png"], &SMALL[..]].concat()).stderr;
    assert!(said.contains("\ntracing   none, fused: chosen for this scene\n"), "{said}");
}

#[test]
fn commands_with_steps_keep_the_grid_and_several_passes() {
    let place = Place::new();
    let file = cornell_box();
    let plan = place.ok(&[&["plan", &file], &SMALL[..]].concat()).stdout;
    assert!(plan.contains("\ngrid ") && plan.contains("\n  walk "), "{plan}");
    let trace = place.ok(&[&["trace", &file, "--pixel", "3,4"], &SMALL[..]].concat()).stdout;
    assert!(trace.contains("traverse_grid"), "{trace}");
    place.ok(&[&["dump", &file, "--stream", "hit", "-o", "d"], &SMALL[..]].concat());
    let index: Value = serde_json::from_slice(&place.read("d/index.json")).expect("JSON");
    let options = &index["options"];
    assert_eq!((&options["accelerator"], &options["schedule"]), (&"grid".into(), &"compact".into()));
    assert!(place.ok(&[&["build", &file], &SMALL[..]].concat()).stdout.contains("\ngrid "));
    place.fails(2, "--schedule auto: expected first, second, compact or fused", &["plan", &file, "--schedule", "auto"]);
}

#[test]
fn cast_says_by_what_it_traced_and_has_the_hits_of_all_others() {
    let place = Place::new();
    let rays: Vec<u8> = (0..64_u16)
        .flat_map(|i| [f32::from(i % 8) / 8.0 - 0.4, f32::from(i / 8) / 8.0 + 0.1, 5.0, 0.0, 0.0, 0.0, -1.0, 0.0])
        .flat_map(f32::to_le_bytes)
        .collect();
    std::fs::write(place.path("rays.f32"), rays).expect("a file");
    let file = cornell_box();
    let cast = |more: &[&str]| {
        let said =
            place.ok(&[&["cast", &file, "--rays-file", "rays.f32", "-o", "h.npy", "--device", "cpu"], more].concat());
        (said.stdout, place.read("h.npy"))
    };
    let (said, hits) = cast(&[]);
    assert!(said.ends_with(" on CPU; bvh, fused: chosen for this scene\n"), "{said}");
    for (more, wanted) in [
        (&["--accelerator", "grid"][..], "grid, fused"),
        (&["--schedule", "second"], "grid, second"),
        (&["--steps-per-pass", "4"], "grid, compact"),
        (&["--accelerator", "none"], "none, fused"),
    ] {
        let (said, same) = cast(more);
        assert!(said.ends_with(&format!(" on CPU; {wanted}\n")) && same == hits, "{more:?}: {said}");
    }
}

#[test]
fn parts_of_an_image_record_what_was_chosen() {
    let place = Place::new();
    let render = ["render", &cornell_box(), "--spp", "32", "--shard", "1/2", "-o", "part", "--quiet"];
    place.ok(&[&render[..], &SMALL[..]].concat());
    let part: Value = serde_json::from_slice(&place.read("part/shard.json")).expect("JSON");
    let options = &part["options"];
    let said = ["accelerator", "structure", "schedule"].map(|name| options[name].as_str().expect("a name"));
    assert_eq!(said, ["auto", "bvh", "fused"]);
}
