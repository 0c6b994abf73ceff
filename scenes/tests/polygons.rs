//! Polygons: the area of their triangles is theirs, whatever their shape.

#![allow(clippy::unwrap_used, reason = "a test that cannot make its input has failed")]

use crate::mesh_common::{area, notes, obj, read};
use glam::{DMat3, DVec2, DVec3};
use raystep_scenes::{LoadOptions, NoFiles, Scene, load};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::time::{Duration, Instant};

/// A debug build takes 1 to 3 s for 100,000 corners, a busy machine ten times as long; quadratic time is above 10 min.
const SOON: Duration = Duration::from_secs(120);

/// A file of one polygon.
fn file(corners: &[DVec3]) -> String {
    let mut text = String::new();
    for DVec3 { x, y, z } in corners {
        writeln!(text, "v {x:?} {y:?} {z:?}").unwrap();
    }
    text += "f";
    (1..=corners.len()).for_each(|i| write!(text, " {i}").unwrap());
    text
}

fn flat(corners: &[DVec2]) -> Vec<DVec3> {
    corners.iter().map(|corner| corner.extend(0.0)).collect()
}

fn points(corners: &[[f64; 2]]) -> Vec<DVec2> {
    corners.iter().copied().map(DVec2::from).collect()
}

fn shoelace(corners: &[DVec2]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f64>().abs() / 2.0
}

/// Deterministic numbers of 0 to 1 (Knuth's multiplier).
fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Rounds to f32, so that a polygon's area is that of what is traced.
fn rounded(corners: &[DVec2]) -> Vec<DVec2> {
    corners.iter().map(|corner| corner.as_vec2().as_dvec2()).collect()
}

/// A polygon around the origin.
fn star(count: usize, seed: u64) -> Vec<DVec2> {
    let mut random = random(seed);
    let corner = |i: usize| DVec2::from_angle(i as f64 / count as f64 * TAU) * (0.1 + 0.9 * random());
    (0..count).map(corner).collect()
}

/// A band that winds inwards.
fn spiral(count: usize, turns: f64) -> Vec<DVec2> {
    let at = |i: usize, width: f64| {
        let t = i as f64 / (count / 2) as f64;
        DVec2::from_angle(t * turns * TAU) * (1.0 + t * turns + width)
    };
    (0..count / 2).map(|i| at(i, 0.0)).chain((0..count / 2).rev().map(|i| at(i, 0.4))).collect()
}

#[track_caller]
fn expect_area(corners: &[DVec3], wanted: f64) -> Scene {
    let scene = obj(&file(corners));
    // Coordinates are those of f32 already, so only sums are rounded.
    let area = area(&scene);
    assert!((area - wanted).abs() <= 1e-9 * wanted, "{area} instead of {wanted}, of {} corners", corners.len());
    assert!(scene.triangles.len() <= corners.len() - 2);
    scene
}

#[test]
fn a_concave_polygon_has_its_area_from_every_first_corner_and_in_both_directions() {
    let l = points(&[[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]]);
    let arrow = points(&[[0., 0.], [2., -1.], [1., 0.], [2., 1.]]);
    let comb =
        points(&[[0., 0.], [7., 0.], [7., 2.], [6., 2.], [6., 1.], [5., 1.], [5., 2.], [4., 2.], [4., 1.], [0., 1.]]);
    for shape in [l, arrow, comb] {
        for start in 0..shape.len() {
            let mut turned = shape.clone();
            turned.rotate_left(start);
            for _ in 0..2 {
                let scene = expect_area(&flat(&turned), shoelace(&shape));
                assert!(scene.notes.is_empty());
                // All triangles face the way in which the polygon winds.
                let up = scene.triangles.iter().map(|t| {
                    let [a, b, c] = t.map(|p| DVec3::from(p.map(f64::from)));
                    (b - a).cross(c - a).z > 0.0
                });
                let ups = up.filter(|up| *up).count();
                assert!(ups == 0 || ups == scene.triangles.len());
                turned.reverse();
            }
        }
    }
}

#[test]
fn random_simple_polygons_have_their_area() {
    for seed in 0..300 {
        let count = 4 + seed as usize % 60;
        let star = rounded(&star(count, seed));
        assert!(expect_area(&flat(&star), shoelace(&star)).notes.is_empty(), "{seed}");
        // At least 16 corners per turn, so that it does not cross itself.
        let spiral = rounded(&spiral(2 * count, 0.2 + (seed % 4) as f64 / 20.0 * count as f64 / 16.0));
        assert!(expect_area(&flat(&spiral), shoelace(&spiral)).notes.is_empty(), "{seed}");
    }
}

#[test]
fn polygons_in_any_plane_have_their_area() {
    for seed in 0..50 {
        let flat = star(30, seed);
        let plane = DMat3::from_euler(glam::EulerRot::XYZ, seed as f64, 2.0 * seed as f64, 0.7 * seed as f64);
        let corners: Vec<_> = flat.iter().map(|corner| plane * corner.extend(1.0)).collect();
        let scene = obj(&file(&corners));
        // Rounded to f32, whose relative error is at most 6e-8 per coordinate.
        let relative = area(&scene) / shoelace(&flat) - 1.0;
        assert!(relative.abs() < 1e-6 && scene.notes.is_empty(), "{relative} {:?}", scene.notes);
    }
}

#[test]
fn holes_joined_by_a_doubled_edge_stay_open() {
    let outer = points(&[[0., 0.], [6., 0.], [6., 6.], [0., 6.]]);
    let hole = points(&[[1., 1.], [1., 2.], [2., 2.], [2., 1.]]);
    let other = points(&[[4., 4.], [4., 5.], [5., 5.], [5., 4.]]);
    let closed = |ring: &[DVec2]| [ring, &ring[..1]].concat();
    let one = [closed(&outer), closed(&hole)].concat();
    let two = [closed(&outer), closed(&hole), closed(&other), hole[..1].to_vec()].concat();
    for (ring, wanted) in [(one, 35.0), (two, 34.0)] {
        for start in 0..ring.len() {
            let mut turned = ring.clone();
            turned.rotate_left(start);
            assert!(expect_area(&flat(&turned), wanted).notes.is_empty());
        }
    }
    // By index, as exporters write it.
    let scene = obj("v 0 0 0\nv 6 0 0\nv 6 6 0\nv 0 6 0\nv 1 1 0\nv 1 2 0\nv 2 2 0\nv 2 1 0\nf 1 2 3 4 1 5 6 7 8 5\n");
    assert_eq!((area(&scene), scene.triangles.len()), (35.0, 8));
}

#[test]
fn corners_that_touch_or_repeat_and_spikes_do_not_change_the_area() {
    for (shape, wanted) in [
        // A corner on another edge, and one on another corner.
        (points(&[[0., 0.], [4., 0.], [4., 4.], [2., 0.], [0., 4.]]), 8.0),
        (points(&[[0., 0.], [2., 2.], [4., 0.], [4., 4.], [2., 2.], [0., 4.]]), 8.0),
        // Corners in the middle of edges.
        (points(&[[0., 0.], [1., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 1.5], [1., 2.], [0., 2.], [0., 1.]]), 3.0),
        // Repeated corners.
        (
            points(&[
                [0., 0.],
                [0., 0.],
                [2., 0.],
                [2., 1.],
                [1., 1.],
                [1., 1.],
                [1., 1.],
                [1., 2.],
                [0., 2.],
                [0., 2.],
            ]),
            3.0,
        ),
        // A spike outwards and one inwards.
        (points(&[[0., 0.], [2., 0.], [2., 1.], [3., 1.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]]), 3.0),
        (points(&[[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.], [0., 1.], [0.5, 1.], [0., 1.]]), 3.0),
    ] {
        for start in 0..shape.len() {
            let mut turned = shape.clone();
            turned.rotate_left(start);
            assert!(expect_area(&flat(&turned), wanted).notes.is_empty(), "{turned:?}");
        }
    }
}

#[test]
fn every_corner_on_an_edge_is_kept_so_that_neighbours_meet_in_it() {
    let scene = obj(&file(&flat(&points(&[
        [0., 0.],
        [1., 0.],
        [2., 0.],
        [2., 1.],
        [1.5, 1.],
        [1., 1.],
        [1., 1.5],
        [1., 2.],
        [0., 2.],
        [0., 1.],
    ]))));
    let used: std::collections::HashSet<_> = scene.triangles.iter().flatten().map(|p| p.map(f32::to_bits)).collect();
    assert_eq!((used.len(), area(&scene)), (10, 3.0));
}

#[test]
fn almost_convex_polygons_keep_their_fan() {
    // On a circle in a tilted plane, with corners in the middle of edges: convex but for rounding.
    let plane = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, 0.5, 0.7);
    let on_circle = |i: usize| plane * DVec2::from_angle(i as f64 / 20.0 * TAU).extend(5.0);
    let mut corners: Vec<_> = (0..20).flat_map(|i| [on_circle(i), on_circle(i).midpoint(on_circle(i + 1))]).collect();
    for _ in 0..corners.len() {
        corners.rotate_left(1);
        let scene = obj(&file(&corners));
        let first = corners[0].as_vec3().to_array();
        assert!(scene.triangles.iter().all(|t| t[0] == first) && scene.triangles.len() == 38);
        assert!(scene.notes.is_empty());
    }
}

#[test]
fn every_scale_and_place_has_its_shape() {
    let l = points(&[[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]]);
    // Powers of two, so that no coordinate is rounded.
    for exponent in [-140, -100, -60, 0, 60, 100, 125] {
        let scale = f64::from(exponent).exp2();
        let mut corners = flat(&l);
        corners.rotate_left(1);
        corners.iter_mut().for_each(|corner| *corner *= scale);
        assert!(expect_area(&corners, 3.0 * scale * scale).notes.is_empty());
        let far = DVec3::new(1e7, -2e7, 1024.0);
        corners.iter_mut().for_each(|corner| *corner = *corner / scale * 0.5 + far);
        assert!(expect_area(&corners, 0.75).notes.is_empty());
    }
    // Beside a large triangle.
    let text = "v 0 0 0\nv 1e30 0 0\nv 0 1e30 0\nv 2e-30 0 0\nv 2e-30 1e-30 0\nv 1e-30 1e-30 0\nv 1e-30 2e-30 0\nv 0 2e-30 0\n\
        f 1 2 3\nf 4 5 6 7 8 1\n";
    assert_eq!(obj(text).triangles.len(), 5);
}

#[test]
fn polygons_off_their_plane_are_drawn_and_noted() {
    const NOTE: &str = "1 polygon has corners off the best plane by over 1% of the size";
    let bent = |z: f64| {
        let l = [[0., 0., 0.], [2., 0., z], [2., 1., 0.], [1., 1., 0.], [1., 2., 0.], [0., 2., 0.]];
        obj(&file(&l.map(DVec3::from)))
    };
    for (z, wanted) in [(0.0, vec![]), (0.01, vec![]), (0.1, vec![NOTE]), (1.0, vec![NOTE])] {
        let scene = bent(z);
        assert_eq!((notes(&scene), scene.triangles.len()), (wanted, 4), "{z}");
        // From above, it is still the L.
        let seen: f64 =
            scene.triangles.iter().map(|t| shoelace(&t.map(|p| DVec2::new(p[0].into(), p[1].into())))).sum();
        assert!((seen - 3.0).abs() < 1e-6, "{z} {seen}");
    }
    // Seen along its normal, a bumpy star is as simple as a flat one; along an axis, its edges would cross.
    let plane = DMat3::from_euler(glam::EulerRot::XYZ, 0.8, 0.6, 0.0);
    let mut bump = random(3);
    let bumpy: Vec<_> = star(40, 7).iter().map(|corner| plane * corner.extend(0.4 * bump())).collect();
    let scene = obj(&file(&bumpy));
    assert_eq!((notes(&scene), scene.triangles.len()), (vec![NOTE], 38));
    // Corners that are nowhere near a plane keep all their edges, so that a mesh of them stays closed.
    let wild = obj("v 0 0 0\nv 1 0 9\nv 1 1 -9\nv 0 1 9\nv 0 0.5 -9\nf 1 2 3 4 5\nf 1 2 3 4\n");
    assert_eq!(wild.triangles.len(), 5);
    let saddle = obj("v 0 0 0\nv 1 0 1\nv 1 1 0\nv 0 1 1\nf 1 2 3 4\n");
    assert_eq!((notes(&saddle), saddle.triangles.len()), (vec![NOTE], 2));
}

#[test]
fn polygons_that_cross_themselves_or_have_no_area_are_noted() {
    const NOTE: &str = "1 polygon has edges that cross, or no area: drawn approximately";
    for shape in [
        points(&[[0., 0.], [1., 1.], [1., 0.], [0., 1.]]),
        points(&[[0., 0.], [3., 3.], [3., 0.], [0., 1.]]),
        points(&[[0., 0.], [1., 0.], [2., 0.], [5., 0.]]),
        points(&[[1., 1.]; 5]),
        // A pentagram from an inner corner.
        points(&[[0., 3.], [2., -3.], [-3., 1.], [3., 1.], [-2., -3.]]),
    ] {
        let scene = obj(&file(&flat(&shape)));
        assert_eq!(notes(&scene), [NOTE], "{shape:?}");
        assert!(!scene.triangles.is_empty());
    }
    // In a tilted plane, where the normal of a symmetric bow-tie is only rounding.
    let plane = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, 0.5, 0.7);
    let tie: Vec<_> =
        [[0., 0.], [1., 1.], [1., 0.], [0., 1.]].iter().map(|&[x, y]| plane * DVec3::new(x, y, 0.)).collect();
    assert_eq!(notes(&obj(&file(&tie))), [NOTE]);
    // A crossing far smaller than the polygon costs nothing visible.
    let tiny = points(&[[0., 0.], [4., 0.], [4., 4.], [2., -1e-4], [0., 4.]]);
    let scene = obj(&file(&flat(&tiny)));
    assert!(notes(&scene) == [NOTE] && (area(&scene) - 8.0).abs() < 0.01, "{}", area(&scene));
}

#[test]
fn huge_polygons_take_no_quadratic_time() {
    let count = 100_000;
    let outlier = |mut corners: Vec<DVec2>| {
        corners.insert(corners.len() / 2, DVec2::splat(1e6));
        corners
    };
    let comb = (0..count - 2).map(|i| DVec2::new(i as f64, if i % 2 == 0 { 1.0 } else { 1000.0 }));
    let comb: Vec<_> = comb.chain(points(&[[count as f64, 0.], [0., 0.]])).collect();
    let line =
        (0..count).map(|i| DVec2::new(i as f64, 0.0)).chain(points(&[[1e5, 1e5], [5e4, 1.], [0., 1e5]])).collect();
    for (name, corners) in [
        ("star", rounded(&star(count, 1))),
        ("spiral", rounded(&spiral(count, 50.0))),
        ("spiral and a corner far outside", outlier(rounded(&spiral(count, 50.0)))),
        ("comb", comb),
        ("line below a notch", line),
    ] {
        let text = file(&flat(&corners));
        let start = Instant::now();
        let scene = obj(&text);
        assert!(start.elapsed() < SOON, "{name}: {:?}", start.elapsed());
        let relative = area(&scene) / shoelace(&corners) - 1.0;
        assert!(relative.abs() < 1e-9 && scene.notes.is_empty(), "{name}: {relative:e} {:?}", scene.notes);
    }
}

#[test]
fn hostile_polygons_end_soon() {
    let mut random = random(5);
    let mut draw = |range: f64| (random() * range).floor();
    let count = 50_000;
    let everywhere: Vec<_> = (0..count).map(|_| DVec2::new(draw(1e6), draw(1e6))).collect();
    let lattice: Vec<_> = (0..count).map(|_| DVec2::new(draw(4.0), draw(4.0))).collect();
    let line: Vec<_> = (0..count).map(|_| DVec2::new(draw(1e6), 0.0)).chain(points(&[[0., 9.]])).collect();
    let same: Vec<_> =
        (0..count).map(|i| DVec2::splat(if i == 7 { 2.0 } else { 1.0 })).chain(points(&[[0., 9.]])).collect();
    for corners in [everywhere, lattice, line, same] {
        let start = Instant::now();
        assert!(!obj(&file(&flat(&corners))).triangles.is_empty());
        assert!(start.elapsed() < SOON, "{:?}", start.elapsed());
    }
}

#[test]
fn a_polygon_beyond_the_limit_of_memory_is_drawn_as_a_fan() {
    let text = file(&flat(&star(10_000, 1)));
    let load =
        |max_bytes| load("a.obj", text.as_bytes(), &NoFiles, &LoadOptions { max_bytes, ..LoadOptions::default() });
    let scene = load(4 << 20).unwrap();
    assert_eq!((scene.triangles.len(), scene.notes.len()), (9_998, 1));
    assert!(load(1 << 20).is_err() && load(16 << 20).unwrap().notes.is_empty());
    assert!(read("a.obj", text.as_bytes()).is_ok());
}
