//! Small inputs that once gave a wrong picture, a wrong number, or none, and what is right for each.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::cast::{hits, npy};
use crate::common::Place;

fn case(name: &str) -> String {
    let path: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases").join(name);
    path.display().to_string()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("an array").iter().map(|number| number.as_f64().expect("a number")).collect()
}

/// Rows of a CSV file as pairs of heads and fields.
fn rows(place: &Place, name: &str) -> Vec<std::collections::HashMap<String, String>> {
    csv::Reader::from_reader(place.read(name).as_slice()).deserialize().map(|row| row.expect("a row")).collect()
}

/// File, triangles, area, bounds, and a part of the note that says what is not drawn as it stands there.
type Case = (&'static str, u64, f64, [f64; 6], &'static str);

const UNIT: [f64; 6] = [0.0, 0.0, 0.0, 1.0, 1.0, 0.0];
const PLATE: [f64; 6] = [-1.0, -1.0, 0.0, 1.0, 1.0, 0.0];

const CASES: [Case; 28] = [
    ("backslash-uri.gltf", 1, 2.0, PLATE, ""),
    ("concave-l.obj", 4, 3.0, [0.0, 0.0, 0.0, 2.0, 2.0, 0.0], ""),
    (
        "far-teapot-lattice.gltf",
        2,
        0.16,
        [12958095.124851028, 4865499.469870342, 0.0, 12958095.524851028, 4865499.869870342, 0.0],
        "",
    ),
    ("gpu-instancing.gltf", 3, 6.0, [-1.0, -1.0, 0.0, 7.0, 1.0, 0.0], ""),
    ("image-missing.gltf", 1, 2.0, PLATE, "1 material is drawn without its texture"),
    (
        "nested-offset.gltf",
        1,
        0.5,
        [5.12485102750361, 9.469870341941714, 0.0, 6.12485102750361, 10.469870341941714, 0.0],
        "",
    ),
    ("node-visibility-used.gltf", 1, 2.0, PLATE, "1 node has \"visible\": false"),
    ("obj-1e40.obj", 1, 0.5, UNIT, "1 texture coordinate has parts that are no numbers"),
    ("obj-bom.obj", 1, 0.5, UNIT, ""),
    ("obj-color-255.obj", 1, 0.5, UNIT, "read as 0 to 255"),
    ("obj-face2.obj", 1, 0.5, UNIT, "1 face has fewer than 3 corners"),
    ("obj-inf-unused.obj", 1, 0.5, UNIT, "1 vertex has a position that is not finite"),
    ("obj-nan-color.obj", 1, 0.5, UNIT, "1 vertex colour has parts that are no numbers"),
    ("obj-nan-normal-used.obj", 1, 0.5, UNIT, "1 normal has no direction"),
    ("obj-nan-normal.obj", 1, 0.5, UNIT, "1 normal has no direction"),
    ("obj-nan-vt.obj", 1, 0.5, UNIT, "1 texture coordinate has parts that are no numbers"),
    ("obj-vn-missing.obj", 1, 0.5, UNIT, "3 corners have a normal that does not exist"),
    ("obj-vt-missing.obj", 1, 0.5, UNIT, "3 corners have texture coordinates that do not exist"),
    ("ply-blank.ply", 1, 0.5, UNIT, ""),
    ("ply-color-float255.ply", 1, 0.5, UNIT, "read as 0 to 255"),
    ("ply-face2.ply", 1, 0.5, UNIT, "1 face has fewer than 3 corners"),
    ("ply-tristrips.ply", 1, 0.5, UNIT, ""),
    ("spot-equal-cones.gltf", 1, 2.0, PLATE, "1 spot light has angles"),
    ("webp-plain.gltf", 1, 2.0, PLATE, ""),
    ("webp-required.gltf", 1, 2.0, PLATE, ""),
    ("one-triangle.gltf", 1, 2.0, PLATE, ""),
    ("ball-at-0.gltf", 322, 48.33, [-3.0, -1.0, -3.0, 3.0, 1.0, 3.0], ""),
    ("ball-at-1e6.gltf", 322, 48.33, [999997.0, -1.0, -3.0, 1000003.0, 1.0, 3.0], "round their shape"),
];

#[test]
fn every_file_is_drawn_with_its_shape_and_says_what_is_missing() {
    for (name, triangles, area, bounds, note) in CASES {
        let (place, file) = (Place::new(), case(name));
        let info: Value = serde_json::from_str(&place.ok(&["info", &file, "--json"]).stdout).expect("JSON");
        assert_eq!(info["triangles"], triangles, "{name}");
        // Corners are within a rounding of f32, relative to the scene's offset; of the far ball, so is the file's data.
        let is_area = |of: &Value| (of.as_f64().expect("an area") / area - 1.0).abs() < 3e-4;
        assert!(is_area(&info["area"]), "{name}: {}", info["area"]);
        let read = [numbers(&info["bounds_min"]), numbers(&info["bounds_max"])].concat();
        assert!(read.iter().zip(bounds).all(|(read, right)| (read - right).abs() < 3e-7), "{name}: {read:?}");
        // What a scene lacks that needs neither is said anyway.
        let notes: Vec<&str> = info["notes"].as_array().expect("notes").iter().filter_map(Value::as_str).collect();
        let ours: Vec<&&str> = notes.iter().filter(|note| !note.starts_with("no ")).collect();
        assert!(if note.is_empty() { ours.is_empty() } else { ours.len() == 1 && ours[0].contains(note) }, "{notes:?}");
        let summary = ["--size", "32x32", "--device", "cpu", "-o", "a.png", "--summary-json", "s.json"];
        place.ok(&[&["render", &file], &summary[..]].concat());
        let summary: Value = serde_json::from_slice(&place.read("s.json")).expect("JSON");
        assert!(summary["hits"].as_u64() > Some(0), "{name}: {}", summary["hits"]);
    }
}

/// Each file's texture is checked by its colours: the missing one is drawn in the material's.
#[test]
fn textures_are_drawn_whatever_their_kind_and_the_separators_of_their_path() {
    let picture = |name: &str| {
        let place = Place::new();
        place.ok(&["render", &case(name), "--size", "32x32", "--device", "cpu", "-o", "a.png"]);
        image::load_from_memory(&place.read("a.png")).expect("a picture").to_rgb8().into_raw()
    };
    let plain = picture("one-triangle.gltf");
    let [by_path, webp, required, missing] =
        ["backslash-uri.gltf", "webp-plain.gltf", "webp-required.gltf", "image-missing.gltf"].map(picture);
    assert_ne!(by_path, missing);
    assert_ne!(webp, missing);
    assert_eq!(webp, required);
    assert_eq!(missing.len(), plain.len());
}

#[test]
fn geometry_that_cannot_be_decompressed_is_an_error_and_no_empty_picture() {
    let draw = ["render", &case("draco-no-fallback.gltf"), "-o", "a.png"];
    Place::new().fails(1, "KHR_draco_mesh_compression: cannot be decompressed", &draw);
}

#[test]
fn a_ray_through_the_notch_of_a_polygon_misses_it() {
    let place = Place::new();
    let ray = npy("(1, 6)", &[1.2, 1.2, 1.0, 0.0, 0.0, -1.0]);
    std::fs::write(place.path("rays.npy"), ray).expect("a file");
    place.ok(&["cast", &case("concave-l.obj"), "--rays-file", "rays.npy", "-o", "h.npy"]);
    assert_eq!(hits(&place.read("h.npy"))[0][3], u32::MAX);
}

/// t is infinite only where nothing is hit, and above 0 where something is.
#[test]
fn hits_have_a_finite_t_above_zero() {
    let place = Place::new();
    let file = case("one-triangle.gltf");
    place.ok(&["cast", &file, "--rays-file", &case("cast-t-range.npy"), "-o", "h.npy"]);
    let hits = hits(&place.read("h.npy"));
    assert_eq!(hits.len(), 2);
    for hit in hits {
        let (t, is_hit) = (f32::from_bits(hit[0]), hit[3] != u32::MAX);
        assert_eq!(is_hit, t.is_finite() && t > 0.0, "{hit:?}");
    }
}

#[test]
fn counters_of_passes_that_continue_walks_add_up() {
    let place = Place::new();
    let options = ["--size", "16x16", "--accelerator", "none", "--schedule", "fused", "--counters"];
    let outputs = ["--device", "gpu", "--passes-csv", "p.csv", "--summary-json", "s.json", "-o", "x.png"];
    place.ok(&[&["render", &case("soup-1000.gltf")], &options[..], &outputs].concat());
    let tested: Vec<u64> =
        rows(&place, "p.csv").iter().filter_map(|row| row["triangles_tested"].parse().ok()).collect();
    // Every ray tests every triangle, in as many passes as the adapter's loops are long.
    assert_eq!(tested.iter().sum::<u64>(), 256_000, "{tested:?}");
    let summary: Value = serde_json::from_slice(&place.read("s.json")).expect("JSON");
    assert_eq!(summary["counters"]["triangles_tested"], 256_000);
}

#[test]
fn rays_from_hits_do_not_depend_on_where_the_scene_lies() {
    let hits = ["ball-at-0.gltf", "ball-at-1e6.gltf"].map(|name| {
        let (place, file) = (Place::new(), case(name));
        let how = ["--accelerators", "bvh", "--schedules", "fused", "--rays", "primary,bounce,shadow"];
        let size = ["--sizes", "64x64", "--device", "cpu", "--repeats", "1", "--warmups", "0", "-o", "b"];
        place.ok(&[&["bench", &file], &how[..], &size].concat());
        let rows = rows(&place, "b/summary.csv");
        let hits: Vec<i64> = rows.iter().map(|row| row["hits"].parse().expect("a number")).collect();
        hits
    });
    // The far ball's corners are rounded to a sixteenth; a ray at a silhouette may see another side.
    assert!(hits[0].iter().zip(&hits[1]).all(|(near, far)| (near - far).abs() <= 2), "{hits:?}");
    assert!(hits[1][1] >= 78 && hits[1][2] >= 490, "{hits:?}");
}

#[test]
fn nothing_has_an_area_of_zero() {
    let empty = crate::common::scene("empty.gltf").display().to_string();
    let info: Value = serde_json::from_str(&Place::new().ok(&["info", &empty, "--json"]).stdout).expect("JSON");
    assert_eq!(info["area"].as_f64().map(f64::to_bits), Some(0));
}
