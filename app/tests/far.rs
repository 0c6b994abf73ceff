//! Scenes far from the origin: what is read, asked and reported there is as exact as at the origin.

use std::fs;

use serde_json::Value;

use crate::cast::{hits, npy};
use crate::common::Place;

/// Where the far scene lies, in metres: a place on a map. f32 knows only every metre here.
const FAR: [f64; 3] = [12_958_095.125, 4_865_499.5, -31.0];

/// Two squares of 0.4 m, one behind the other.
fn write(place: &Place, name: &str, [x, y, z]: [f64; 3]) {
    let quad = |depth: f64| {
        [[0.0, 0.0], [0.4, 0.0], [0.4, 0.4], [0.0, 0.4]]
            .map(|[u, v]: [f64; 2]| format!("v {} {} {}\n", x + u, y + v, z + depth))
    };
    let text = [quad(0.0), quad(-0.25)].concat().concat() + "f 1 2 3 4\nf 5 6 7 8\n";
    fs::write(place.path(name), text).expect("a file");
}

fn place() -> Place {
    let place = Place::new();
    write(&place, "near.obj", [0.0; 3]);
    write(&place, "far.obj", FAR);
    place
}

fn vector(at: [f64; 3], [x, y, z]: [f64; 3]) -> String {
    format!("{},{},{}", at[0] + x, at[1] + y, at[2] + z)
}

fn info(place: &Place, scene: &str) -> Value {
    serde_json::from_str(&place.ok(&["info", scene, "--json"]).stdout).expect("JSON")
}

#[test]
fn info_shows_the_files_coordinates_and_the_offset() {
    let place = place();
    let [near, far] = ["near.obj", "far.obj"].map(|scene| info(&place, scene));
    assert_eq!(near["offset"], serde_json::json!([0.0, 0.0, 0.0]));
    let number = |value: &Value, axis: usize| value[axis].as_f64().expect("a number");
    for (axis, place) in FAR.into_iter().enumerate() {
        assert!((number(&far["offset"], axis) - place).abs() < 1.0, "{far}");
        for bound in ["bounds_min", "bounds_max"] {
            // An eighth of the steps of f32 within the scene.
            let expected = place + number(&near[bound], axis);
            assert!((number(&far[bound], axis) - expected).abs() < 1e-8, "{bound} {axis}: {far}");
        }
    }
    let area = |info: &Value| info["area"].as_f64().expect("a number");
    assert!((area(&far) - 0.32).abs() < 1e-7 && (area(&near) - 0.32).abs() < 1e-7, "{far}");
    assert!(place.ok(&["info", "far.obj"]).stdout.contains("offset     [12958095."), "{far}");
}

#[test]
fn the_picture_is_that_of_the_scene_at_the_origin() {
    let place = place();
    for (scene, at, output) in [("near.obj", [0.0; 3], "near.png"), ("far.obj", FAR, "far.png")] {
        let (eye, target) = (vector(at, [0.3, 0.5, 1.0]), vector(at, [0.2, 0.2, 0.0]));
        let view =
            ["render", scene, "--eye", &eye, "--look-at", &target, "--size", "64x64", "--device", "cpu", "--quiet"];
        place.ok(&[&view[..], &["-o", output]].concat());
    }
    let [near, far] = ["near.png", "far.png"].map(|name| image::open(place.path(name)).expect("a picture").to_rgb8());
    let lit = |picture: &image::RgbImage| picture.pixels().filter(|p| p.0 != [0; 3]).count();
    assert!(lit(&near) > 300, "{} pixels", lit(&near));
    // Corners are rounded at other places of the lattice: pixels at the squares' edges may differ.
    let differing =
        near.pixels().zip(far.pixels()).filter(|(a, b)| a.0.iter().zip(&b.0).any(|(a, b)| a.abs_diff(*b) > 2));
    let differing = differing.count();
    assert!(differing <= 4, "{differing} pixels differ");
}

#[test]
fn rays_are_given_and_hits_reported_in_the_files_coordinates() {
    let place = place();
    let (x, y) = (0.1, 0.3);
    let ray = |[ox, oy, oz]: [f64; 3]| format!("{},{},{},0,0,-2", ox + x, oy + y, oz + 1.0);
    let t = |scene: &str, at| -> f64 {
        let run = ["trace", scene, "--ray", &ray(at), "--device", "cpu", "--format", "json"];
        let trace: Value = serde_json::from_str(&place.ok(&run).stdout).expect("JSON");
        let rows = trace["rows"].as_array().expect("rows");
        let last = &rows.last().expect("a row")["after"];
        assert_eq!(last["triangle"], 1, "{trace}");
        last["t"].as_f64().expect("t") * trace["t_scale"].as_f64().expect("a scale")
    };
    assert!((t("near.obj", [0.0; 3]) - 0.5).abs() < 1e-6 && (t("far.obj", FAR) - 0.5).abs() < 1e-6);

    // In float64, a ray hits the square that it would miss by half a metre in float32.
    let numbers = [FAR[0] + x, FAR[1] + y, FAR[2] + 1.0, 0.0, 0.0, -2.0];
    let mut wide = npy("(1, 6)", &[]);
    let kind = wide.windows(3).position(|text| text == b"<f4").expect("a type");
    wide[kind..kind + 3].copy_from_slice(b"<f8");
    wide.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    fs::write(place.path("wide.npy"), wide).expect("a file");
    fs::write(place.path("narrow.npy"), npy("(1, 6)", &numbers.map(|number| number as f32))).expect("a file");
    for (rays, is_hit) in [("wide.npy", true), ("narrow.npy", false)] {
        place.ok(&["cast", "far.obj", "--rays-file", rays, "-o", "hits.npy", "--device", "cpu", "--quiet"]);
        let [t, _, _, triangle, _] = hits(&place.read("hits.npy"))[0];
        assert_eq!(triangle != u32::MAX, is_hit, "{rays}");
        assert!(!is_hit || (f32::from_bits(t) - 0.5).abs() < 1e-6);
    }
}

#[test]
fn exports_say_where_the_scene_is() {
    let place = place();
    let offset = info(&place, "far.obj")["offset"].clone();
    let common = ["--size", "8x8", "--device", "cpu", "--quiet"];
    place.ok(&[&["render", "far.obj", "--summary-json", "s.json", "-o", "p.png"], &common[..]].concat());
    place.ok(&[&["dump", "far.obj", "--stream", "hit", "-o", "d"], &common[..]].concat());
    for file in ["s.json", "d/index.json"] {
        let json: Value = serde_json::from_slice(&place.read(file)).expect("JSON");
        assert_eq!(json["scene_offset"], offset, "{file}");
    }
    // And a converted scene is where it was.
    place.ok(&["scene", "convert", "far.obj", "-o", "far.glb", "--quiet"]);
    let [text, glb] = ["far.obj", "far.glb"].map(|scene| info(&place, scene));
    assert_eq!(
        [&text["bounds_min"], &text["offset"], &text["area"]],
        [&glb["bounds_min"], &glb["offset"], &glb["area"]]
    );
}
