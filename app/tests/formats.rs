//! OBJ, PLY and STL open in every command as glTF does.

use std::fs;

use serde_json::Value;

use crate::cast::{hits, npy};
use crate::common::{Place, scene};

const OBJ: &str = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 2 3 4 5 6 1\nf 1 2\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n2 0 0\n2 1 0\n1 1 0\n1 2 0\n0 2 0\n6 1 2 3 4 5 0\n";
const STL: &str = "solid l\nfacet normal 0 0 1\nouter loop\nvertex 2 0 0\nvertex 2 1 0\nvertex 1 1 0\nvertex 1 2 0\n\
    vertex 0 2 0\nvertex 0 0 0\nendloop\nendfacet\nendsolid l\n";

/// A folder with an L of three units of area in each format.
fn place() -> Place {
    let place = Place::new();
    for (name, text) in [("l.obj", OBJ), ("l.PLY", PLY), ("l.stl", STL)] {
        fs::write(place.path(name), text).expect("a file");
    }
    place
}

#[test]
fn every_command_opens_every_format() {
    let place = place();
    let on_cpu = ["--size", "16x16", "--device", "cpu"];
    for name in ["l.obj", "l.PLY", "l.stl"] {
        for (arguments, more) in [
            (vec!["info", name], &[][..]),
            (vec!["plan", name], &on_cpu),
            (vec!["render", name, "-o", "a.png"], &on_cpu),
            (vec!["trace", name, "--pixel", "8,8"], &on_cpu),
            (vec!["dump", name, "-o", "dump", "--force", "--stream", "hit"], &on_cpu),
            (vec!["build", name], &["--device", "cpu"]),
            (vec!["scene", "convert", name, "-o", "l.glb"], &[]),
            (vec!["inspect", name, "--screenshot", "a.png"], &["--size", "16x16"]),
        ] {
            place.ok(&[&arguments, more].concat());
        }
        let bench = ["bench", name, "-o", "bench", "--force", "--sizes", "16x16", "--device", "cpu", "--repeats", "1"];
        place.ok(&[&bench[..], &["--accelerators", "none", "--schedules", "fused"]].concat());
        let about: Value = serde_json::from_str(&place.ok(&["info", name, "--json"]).stdout).expect("JSON");
        assert_eq!((&about["name"], &about["triangles"]), (&"l".into(), &4.into()), "{about}");
    }
}

#[test]
fn rays_miss_the_notch_of_a_concave_polygon() {
    let place = place();
    // An origin and a direction for each ray.
    let rays = [0.2, 1.2, 1.0, 0.0, 0.0, -1.0, 1.2, 1.2, 1.0, 0.0, 0.0, -1.0];
    fs::write(place.path("rays.npy"), npy("(2, 6)", &rays)).expect("a file");
    for name in ["l.obj", "l.PLY", "l.stl"] {
        place.ok(&["cast", name, "--rays-file", "rays.npy", "-o", "hits.npy", "--device", "cpu"]);
        let times: Vec<_> = hits(&place.read("hits.npy")).iter().map(|hit| f32::from_bits(hit[0])).collect();
        // A unit in the last place depends on which triangles the polygon is cut into.
        assert!((times[0] - 1.0).abs() <= f32::EPSILON && times[1] == f32::INFINITY, "{name}: {times:?}");
        fs::remove_file(place.path("hits.npy")).expect("the hits");
    }
}

#[test]
fn convert_reads_what_opens_and_prints_its_notes() {
    let place = place();
    let outcome = place.ok(&["scene", "convert", "l.obj", "-o", "l.glb"]);
    assert!(outcome.stderr.contains("note: 1 face has fewer than 3 corners: left out\n"), "{outcome:?}");
    let outcome = place.ok(&["scene", "convert", &scene("lights.gltf").display().to_string(), "-o", "lights.glb"]);
    assert!(outcome.stderr.contains("lights.glb: "), "{outcome:?}");
    place.ok(&["info", "lights.glb"]);
    let limit = ["scene", "convert", "l.stl", "-o", "x.glb", "--max-memory", "300"];
    place.fails(1, "l.stl: vertices: this takes", &limit);
    place.fails(
        2,
        "--scene-index: scene 1 does not exist",
        &["scene", "convert", "l.PLY", "-o", "x.glb", "--scene-index", "1"],
    );
}

#[test]
fn files_of_other_kinds_are_named() {
    let place = Place::new();
    fs::write(place.path("a.fbx"), b"Kaydara FBX Binary  \0").expect("a file");
    fs::write(place.path("a.obj"), [0xff, 0xfe, b'v', 0]).expect("a file");
    fs::write(place.path("b.obj"), "v 0 0 0\np 1\n").expect("a file");
    for (name, wanted) in [
        ("a.fbx", "a.fbx: the file is FBX; raystep reads glTF 2.0, GLB, OBJ, PLY and STL"),
        ("a.obj", "a.obj: the file is UTF-16 text; save it as UTF-8"),
        ("b.obj", "b.obj: there is no face (a line like 'f 1 2 3'), only 1 vertex, 1 point; only faces can be traced"),
    ] {
        place.fails(1, wanted, &["info", name]);
    }
}
