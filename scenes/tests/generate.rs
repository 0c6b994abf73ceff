//! Generated scenes: counts, closed surfaces, windings, reproducible bits, errors.

#![allow(clippy::unwrap_used, reason = "a test that cannot make its input has failed")]

use glam::Vec3;
use raystep_scenes::generate::{self, GENERATORS, GenerateError, MAX_TRIANGLES};
use raystep_scenes::{Light, Scene};
use std::collections::HashMap;

/// FNV-1a (Fowler, Noll and Vo) over the bits of all positions, normals and colours.
fn hash(scene: &Scene) -> u64 {
    let lists = [Some(&scene.triangles), scene.normals.as_ref(), scene.colors.as_ref()];
    let floats = lists.into_iter().flatten().flat_map(|l| l.as_flattened().as_flattened());
    floats
        .flat_map(|f| f.to_bits().to_le_bytes())
        .fold(0xcbf2_9ce4_8422_2325, |h, byte| (h ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

#[test]
fn cornell_box_has_26_triangles_that_face_the_room() {
    let scene = generate::cornell_box();
    assert_eq!(scene.triangles.len(), 26);
    assert!(scene.normals.is_none() && scene.texcoords.is_none() && scene.colors.is_none());
    let bounds = scene.bounds();
    let eye = scene.cameras[0].eye.as_vec3();
    assert!(eye.cmpgt(bounds.min).all() && eye.cmplt(bounds.max).all(), "the camera is outside {bounds:?}");
    let [Light::Point { position, .. }] = scene.lights[..] else { panic!("not one point light: {:?}", scene.lights) };
    assert!(Vec3::from(position).cmpgt(bounds.min).all() && Vec3::from(position).cmplt(bounds.max).all());

    let on_wall =
        |t: &[Vec3; 3]| (0..3).any(|a| [bounds.min[a], bounds.max[a]].iter().any(|&w| t.iter().all(|p| p[a] == w)));
    let (walls, blocks): (Vec<_>, Vec<_>) = scene.triangles.iter().map(|t| t.map(Vec3::from)).partition(on_wall);
    assert_eq!((walls.len(), blocks.len()), (10, 16));
    let middle = (bounds.min + bounds.max) * 0.5;
    for t in walls {
        assert!((t[1] - t[0]).cross(t[2] - t[0]).dot(middle - t[0]) > 0.0, "a wall faces outward: {t:?}");
    }
    for block in blocks.chunks(8) {
        let inside = block.iter().flatten().sum::<Vec3>() / 24.0 - Vec3::Y * 0.1;
        for t in block {
            assert!((t[1] - t[0]).cross(t[2] - t[0]).dot(inside - t[0]) < 0.0, "a side faces inward: {t:?}");
        }
    }
}

#[test]
fn every_edge_of_an_icosphere_has_two_triangles_in_opposite_directions() {
    for subdivisions in 0..=5 {
        let scene = generate::icosphere(subdivisions).unwrap();
        assert_eq!(scene.triangles.len(), 20 << (2 * subdivisions));
        let mut edges = HashMap::new();
        for t in &scene.triangles {
            let t = t.map(|p| p.map(f32::to_bits));
            for k in 0..3 {
                *edges.entry((t[k], t[(k + 1) % 3])).or_insert(0) += 1;
            }
            let [a, b, c] = t.map(|p| Vec3::from(p.map(f32::from_bits)));
            assert!((b - a).cross(c - a).dot(a) > 0.0, "a face points inward at {subdivisions}");
        }
        for (&(a, b), &count) in &edges {
            assert_eq!((count, edges.get(&(b, a))), (1, Some(&1)), "an edge is open at {subdivisions}");
        }
        // Euler: vertices − edges + faces = 2.
        let corners: std::collections::HashSet<_> = edges.keys().map(|e| e.0).collect();
        assert_eq!(corners.len() + scene.triangles.len(), edges.len() / 2 + 2);
    }
}

#[test]
fn the_knot_is_closed_and_faces_outward() {
    let scene = generate::tiny_in_room(2_000, 500).unwrap();
    let knot = &scene.triangles[..scene.triangles.len() - 12];
    let mut edges = HashMap::new();
    for (t, n) in knot.iter().zip(scene.normals.as_ref().unwrap()) {
        let bits = t.map(|p| p.map(f32::to_bits));
        (0..3).for_each(|k| *edges.entry((bits[k], bits[(k + 1) % 3])).or_insert(0) += 1);
        let [a, b, c] = t.map(Vec3::from);
        assert!((b - a).cross(c - a).dot(Vec3::from(n[0])) > 0.0, "a triangle faces away from its normals: {t:?}");
    }
    assert!(edges.keys().all(|&(a, b)| edges.get(&(b, a)) == Some(&1)), "an edge is open");
    let lowest = knot.iter().flatten().map(|p| p[1]).fold(f32::INFINITY, f32::min);
    assert!((0.0..0.1).contains(&lowest), "the knot is at {lowest} over the floor");
}

#[test]
fn the_same_numbers_give_the_same_bits() {
    // These need only operations whose rounding IEEE 754 prescribes, so the hashes hold on every machine.
    assert_eq!(hash(&generate::cornell_box()), CORNELL_BOX);
    assert_eq!(hash(&generate::soup(1_000, 1).unwrap()), SOUP);
    assert_eq!(hash(&generate::terrain(2_000, 1).unwrap()), TERRAIN);
    assert_eq!(hash(&generate::icosphere(3).unwrap()), ICOSPHERE);
    for generator in GENERATORS {
        assert_eq!(generator.make(&[]), generator.make(&[]), "{} differs from itself", generator.name);
    }
    assert_ne!(hash(&generate::soup(1_000, 2).unwrap()), SOUP);
    assert_ne!(hash(&generate::terrain(2_000, 2).unwrap()), TERRAIN);
    assert_ne!(generate::hair(10, 1).unwrap().triangles, generate::hair(10, 2).unwrap().triangles);
}

const CORNELL_BOX: u64 = 0x2f35_c03e_3f32_5198;
const SOUP: u64 = 0x42c8_b2e5_8292_8801;
const TERRAIN: u64 = 0xaf24_9aad_7cc5_511e;
const ICOSPHERE: u64 = 0xf98c_02b8_bfb4_1775;

#[test]
fn every_generator_makes_a_whole_scene_with_its_defaults() {
    for generator in GENERATORS {
        let scene = generator.make(&[]).unwrap();
        let (name, count) = (generator.name, scene.triangles.len());
        assert_eq!(scene.name, name);
        assert!(count > 0 && scene.triangle_materials.len() == count, "{name}");
        assert!(scene.triangle_materials.iter().all(|&m| (m as usize) < scene.materials.len()), "{name}");
        assert!(scene.triangle_materials.is_sorted(), "{name} would be reordered when written");
        assert!(scene.triangles.as_flattened().as_flattened().iter().all(|v| v.is_finite()), "{name}");
        let glows = scene.materials.iter().any(|material| material.emissive != [0.0; 3]);
        assert!((!scene.lights.is_empty() || glows) && !scene.cameras.is_empty(), "{name}");
        if let Some(normals) = &scene.normals {
            assert_eq!(normals.len(), count, "{name}");
            let unit = |n: &[f32; 3]| (Vec3::from(*n).length() - 1.0).abs() < 1e-5;
            assert!(normals.as_flattened().iter().all(unit), "{name} has normals that are not unit vectors");
        }
        assert!(scene.colors.as_ref().is_none_or(|c| c.len() == count), "{name}");
        for p in generator.parameters {
            assert!(p.range.contains(&p.default), "{name} {}", p.name);
        }
    }
}

/// The triangles of a material, each with its area along its normal by its corners.
fn of_material(scene: &Scene, name: &str) -> Vec<([Vec3; 3], Vec3)> {
    let material = scene.materials.iter().position(|material| material.name == name).unwrap() as u32;
    let own = scene.triangles.iter().zip(&scene.triangle_materials).filter(|(_, of)| **of == material);
    own.map(|(t, _)| t.map(Vec3::from)).map(|t| (t, (t[1] - t[0]).cross(t[2] - t[0]) * 0.5)).collect()
}

/// Photons and paths leave a lamp at its front: it has to face what makes the caustic, and nothing may touch.
#[test]
fn lamps_of_caustics_face_what_they_light() {
    for (scene, what) in [(generate::glass_ball(2).unwrap(), "glass"), (generate::ring(24).unwrap(), "metal")] {
        let lamp = of_material(&scene, "lamp");
        let area: f32 = lamp.iter().map(|(_, normal)| normal.length()).sum();
        assert!(lamp.len() == 2 && (area - 0.04).abs() < 1e-5, "{}: {area}", scene.name);
        for (corners, normal) in lamp {
            for (of, _) in of_material(&scene, what) {
                let toward = (of[0] - corners[0]).normalize();
                assert!(toward.dot(normal.normalize()) > 0.7, "{}: {toward}", scene.name);
            }
        }
        let [floor] = of_material(&scene, "floor")[..1] else { panic!("no floor") };
        assert!(floor.1.normalize() == Vec3::Y && floor.0.iter().all(|p| p.y == 0.0));
    }
    let mut balls = generate::cornell_balls(2).unwrap();
    assert_eq!((balls.triangles.len(), balls.materials.len()), (12 + 2 * 320, 6));
    for (ball, center) in [("mirror", Vec3::new(-0.42, -0.62, -0.35)), ("glass", Vec3::new(0.42, -0.62, 0.3))] {
        for (corners, normal) in of_material(&balls, ball) {
            assert!(corners.iter().all(|p| p.x.abs() < 0.8 && p.y > -0.99 && p.z > -0.8), "{ball}: {corners:?}");
            assert!(corners.iter().all(|&p| normal.dot(p - center) > 0.0), "{ball}: {corners:?} faces inward");
        }
    }
    balls.triangles.truncate(6);
    assert_eq!(balls.triangles, generate::cornell_box().triangles[..6]);
}

/// Around the ring, every side shares its two upright edges with its neighbours, bit for bit.
#[test]
fn a_ring_is_closed_and_open_at_its_ends() {
    for sides in [3, 24, 128] {
        let scene = generate::ring(sides).unwrap();
        let mut edges = HashMap::new();
        let metal = of_material(&scene, "metal");
        assert_eq!(metal.len() as u64, 2 * sides);
        for (corners, normal) in metal {
            assert!(normal.dot(Vec3::new(corners[0].x, 0.0, corners[0].z)) > 0.0, "{corners:?} faces inward");
            let bits = corners.map(|p| p.to_array().map(f32::to_bits));
            (0..3).for_each(|k| *edges.entry((bits[k], bits[(k + 1) % 3])).or_insert(0) += 1);
        }
        let open = edges.keys().filter(|&&(a, b)| !edges.contains_key(&(b, a))).count() as u64;
        assert_eq!((open, edges.values().all(|&count| count == 1)), (2 * sides, true), "{sides} sides");
    }
    let error = generate::ring(2).unwrap_err().to_string();
    assert_eq!(error, "ring: sides is 2, but must be from 3 to 1000000");
}

#[test]
fn counts_are_what_was_asked_for() {
    assert_eq!(generate::soup(1_234, 0).unwrap().triangles.len(), 1_234);
    assert_eq!(generate::soup(1, 0).unwrap().triangles.len(), 1);
    assert_eq!(generate::terrain(20_000, 1).unwrap().triangles.len(), 20_000);
    assert_eq!(generate::terrain(2, 1).unwrap().triangles.len(), 2);
    assert_eq!(generate::sphere_flake(2, 0).unwrap().triangles.len(), 91 * 20);
    assert_eq!(generate::hair(0, 1).unwrap().triangles.len(), 5_120);
    assert_eq!(generate::hair(7, 1).unwrap().triangles.len(), 5_120 + 7 * 15);
    for wanted in [18, 100, 5_000] {
        let made = generate::tiny_in_room(wanted, 100).unwrap().triangles.len() as u64 - 12;
        assert!(made <= wanted && made * 2 > wanted, "{made} of {wanted}");
    }
}

#[test]
fn a_soup_is_as_dense_whatever_its_count() {
    for count in [1_000u64, 100_000] {
        let scene = generate::soup(count, 3).unwrap();
        assert!(scene.triangles.as_flattened().as_flattened().iter().all(|v| (0.0..=1.0).contains(v)));
        let size: f64 = scene.triangles.iter().map(|t| f64::from((Vec3::from(t[1]) - Vec3::from(t[0])).length())).sum();
        let scaled = size / count as f64 * (count as f64).cbrt();
        // Two points in a cube of edge 1.5 are 0.66 * 1.5 apart on average (Robbins 1978).
        assert!((scaled - 0.9926).abs() < 0.03, "mean edge times the cube root of {count}: {scaled}");
    }
}

#[test]
fn absurd_counts_are_refused_before_memory_is_taken() {
    let too_many = |r: Result<Scene, GenerateError>| r.unwrap_err().to_string();
    for (error, wanted) in [
        (
            too_many(generate::soup(u64::MAX, 1)),
            "soup: triangles is 18446744073709551615, but must be from 1 to 200000000",
        ),
        (too_many(generate::soup(0, 1)), "soup: triangles is 0, but must be from 1 to 200000000"),
        (
            too_many(generate::terrain(MAX_TRIANGLES + 1, 1)),
            "terrain: triangles is 200000001, but must be from 2 to 200000000",
        ),
        (too_many(generate::icosphere(12)), "icosphere: subdivisions is 12, but must be from 0 to 11"),
        (
            too_many(generate::hair(u64::MAX, 1)),
            "hair: strands is 18446744073709551615, but must be from 0 to 13332992",
        ),
        (too_many(generate::hair(13_333_333, 1)), "hair: strands is 13333333, but must be from 0 to 13332992"),
        (too_many(generate::tiny_in_room(18, 0)), "tiny-in-room: ratio is 0, but must be from 4 to 1000000"),
        (
            too_many(generate::sphere_flake(6, 8)),
            "sphere-flake would have 783641477120 triangles with these parameters; the most is 200000000",
        ),
    ] {
        assert_eq!(error, wanted);
    }
}

#[test]
fn the_table_takes_what_it_names_and_nothing_else() {
    let soup = generate::find("soup").unwrap();
    assert_eq!(soup.make(&[("seed", 7), ("triangles", 5)]), generate::soup(5, 7));
    let error = soup.make(&[("depth", 1)]).unwrap_err().to_string();
    assert_eq!(error, "soup has no parameter 'depth'; it takes triangles, seed");
    let error = generate::find("cornell-box").unwrap().make(&[("seed", 1)]).unwrap_err().to_string();
    assert_eq!(error, "cornell-box has no parameter 'seed'; it takes none");
    let error = generate::find("teapot").unwrap_err().to_string();
    assert!(error.starts_with("there is no generator 'teapot'; there are cornell-box, cornell-lamp, soup"), "{error}");
}
