//! STL: binary and ASCII, told apart by more than their first word.

#![allow(clippy::unwrap_used, reason = "a test that cannot make its input has failed")]

use crate::mesh_common::{TRIANGLE, error, notes, read, scene};
use glam::DVec3;

const FACET: &str =
    "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1 0\n endloop\nendfacet\n";

fn ascii(facets: &str) -> String {
    format!("solid a thing\n{facets}endsolid a thing\n")
}

/// A binary file with this comment, number of triangles, and triangles.
fn binary(comment: &[u8], count: u32, triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = comment.to_vec();
    bytes.resize(80, b' ');
    bytes.extend(count.to_le_bytes());
    for triangle in triangles {
        // The normal is not read.
        let numbers = [f32::NAN; 3].iter().chain(triangle.as_flattened());
        bytes.extend(numbers.flat_map(|v| v.to_le_bytes()));
        bytes.extend([1, 2]);
    }
    bytes
}

#[test]
fn binary_and_ascii_give_the_same_triangles() {
    for bytes in [ascii(FACET).into_bytes(), binary(b"made by a test", 1, &TRIANGLE)] {
        let scene = scene("part.STL", &bytes);
        assert_eq!((scene.name.as_str(), scene.triangles.as_slice()), ("part", TRIANGLE.as_slice()));
        assert!(scene.normals.is_none() && scene.colors.is_none() && scene.notes.is_empty());
    }
}

#[test]
fn a_binary_file_may_start_with_solid() {
    for comment in [&b"solid"[..], b"solid facet normal 0 0 1\n", b"SOLID x\0"] {
        assert_eq!(scene("a.stl", &binary(comment, 1, &TRIANGLE)).triangles, TRIANGLE);
        assert_eq!(scene("no ending", &binary(comment, 1, &TRIANGLE)).triangles, TRIANGLE);
    }
    let cut = binary(b"solid x", 9, &TRIANGLE);
    assert_eq!(scene("a.stl", &cut).triangles, TRIANGLE);
}

#[test]
fn text_of_any_layout_is_read() {
    let text = ascii(FACET);
    for text in [
        format!("\u{feff}{text}"),
        format!("\n  {text}"),
        text.replace('\n', "\r\n"),
        text.replace('\n', "\r"),
        text.replace('\n', " "),
        text.replace('\n', "\n\n\t"),
        text.to_uppercase(),
        text.replace("a thing", ""),
        text.replace("a thing", "endsolid facet of a vertex"),
        text.replace("1 0 0", "1.0e+00 -0 0E0"),
        text.replace("endsolid a thing\n", ""),
        text.replace("normal 0 0 1", "normal nan -nan(ind) 1.#INF"),
    ] {
        let scene = scene("a.stl", text.as_bytes());
        assert_eq!((scene.triangles.as_slice(), scene.notes.len()), (TRIANGLE.as_slice(), 0), "{text:?}");
    }
}

#[test]
fn several_solids_are_one_scene() {
    let text = ascii(FACET) + &ascii(&FACET.repeat(2));
    assert_eq!(scene("a.stl", text.as_bytes()).triangles, TRIANGLE.repeat(3));
}

#[test]
fn a_wrong_count_is_noted() {
    let two = TRIANGLE.repeat(2);
    let more = "3 bytes after the triangles of the STL file are ignored";
    for (mut bytes, rest, triangles, note) in [
        (binary(b"", 5, &two), 0, 2, "the STL file promises 5 triangles, but has 2: all of them are drawn"),
        (
            binary(b"", u32::MAX, &two),
            7,
            2,
            "the STL file promises 4294967295 triangles, but has 2: all of them are drawn",
        ),
        (binary(b"", 0, &two), 0, 2, "the STL file promises 0 triangles, but has 2: all of them are drawn"),
        (binary(b"", 1, &two), 0, 2, "the STL file promises 1 triangles, but has 2: all of them are drawn"),
        (binary(b"", 2, &two), 3, 2, more),
        (binary(b"", 1, &two), 3, 1, "53 bytes after the triangles of the STL file are ignored"),
    ] {
        bytes.resize(bytes.len() + rest, 0);
        let scene = scene("a.stl", &bytes);
        assert_eq!((scene.triangles.len(), notes(&scene)), (triangles, vec![note]));
    }
}

#[test]
fn facets_that_cannot_be_drawn_are_left_out_and_counted() {
    for (from, to, wanted) in [
        ("1 0 0", "nan 0 0", "1 face has a corner that is not finite in 32 bits: left out"),
        ("1 0 0", "1e40 0 0", "1 face has a corner that is not finite in 32 bits: left out"),
        ("1 0 0", "1 0,5 0", "1 face has a corner that is not finite in 32 bits: left out"),
        ("vertex 1 0 0", "", "1 face has fewer than 3 corners: left out"),
    ] {
        let text = ascii(&(FACET.replace(from, to) + FACET));
        let scene = scene("a.stl", text.as_bytes());
        assert_eq!(scene.triangles, TRIANGLE, "{to}");
        assert_eq!(notes(&scene).last(), Some(&wanted));
    }
    let scene = scene("a.stl", &binary(b"", 2, &[TRIANGLE[0], [[f32::NAN; 3]; 3]]));
    assert_eq!(scene.triangles, TRIANGLE);
    // A facet of four corners is not STL, but means something.
    let four = ascii(&FACET.replace("vertex 1 0 0", "vertex 1 0 0 vertex 1 1 0"));
    assert_eq!(crate::mesh_common::scene("a.stl", four.as_bytes()).triangles.len(), 2);
}

#[test]
fn text_far_from_the_origin_keeps_its_shape() {
    let far = FACET.replace("vertex 0", "vertex 1e7").replace("vertex 1 0", "vertex 10000000.375 0");
    let scene = scene("a.stl", ascii(&far).as_bytes());
    let [a, b, _] = scene.triangles[0];
    assert_eq!((b[0] - a[0], scene.offset + DVec3::from(a.map(f64::from))), (0.375, DVec3::new(1e7, 0.0, 0.0)));
}

#[test]
fn binary_coordinates_far_from_the_origin_are_subtracted_exactly() {
    let far = |x: f32| 16_777_216.0 + x;
    let bytes = binary(b"", 1, &[[[far(0.), 0., 0.], [far(4.), 0., 0.], [far(2.), 4., 0.]]]);
    let scene = scene("a.stl", &bytes);
    assert!(scene.offset.x > 1e7);
    let [[a, ..], [b, ..], [c, ..]] = scene.triangles[0];
    assert_eq!((b - a, c - a, scene.offset.x + f64::from(a)), (4.0, 2.0, 16_777_216.0));
}

#[test]
fn a_wrong_file_is_one_line_that_says_what_is_wrong() {
    for (bytes, wanted) in [
        (b"solid".to_vec(), "a binary STL file starts with 84 bytes of header, but this has 5"),
        (ascii("").into_bytes(), "the STL file has no facet"),
        (
            ascii(&FACET.replace("1 0 0", "x 0 0")).into_bytes(),
            "facet 0: the position of its corner 2 is not finite in 32 bits, and no other facet can be drawn",
        ),
        (binary(b"", 0, &[]), "the STL file has no facet"),
        (binary(b"", 3, &[]), "the STL file promises 3 triangles, but 0 bytes follow; each takes 50"),
        (
            binary(b"", 3, &TRIANGLE)[..100].to_vec(),
            "the STL file promises 3 triangles, but 16 bytes follow; each takes 50",
        ),
        (
            binary(b"", 0, &TRIANGLE)[..100].to_vec(),
            "the STL file promises 0 triangles, but 16 bytes follow; each takes 50",
        ),
    ] {
        assert_eq!(error("bad.stl", &bytes), wanted);
    }
}

#[test]
fn a_file_cut_or_flipped_anywhere_never_panics() {
    for good in [ascii(FACET).into_bytes(), binary(b"solid", 1, &TRIANGLE)] {
        for at in 0..good.len() {
            let _ = read("cut.stl", &good[..at]);
            for bit in 0..8 {
                let mut bytes = good.clone();
                bytes[at] ^= 1 << bit;
                let _ = read("flipped.stl", &bytes);
            }
        }
    }
}
