//! The table of cases. A new case is an entry here, built from functions in `make` and `planes`.

use glam::DVec3;
use raystep_kernels::options::Accelerator::Grid;

use crate::Error;
use crate::stability::claims::{
    AT_CORNERS, AT_EDGES, BY_CHANCE, EDGES_CRACK, HALF_AT_EDGES, NONE, OUTSIDE, SMALL, fails, up_to,
};
use crate::stability::make::{self, At};
use crate::stability::planes::{On, on_planes};
use crate::stability::{Case, Paper, Truth, Workload};

/// Rays inside a closed sphere, on which the paper's numerics may fail, but need not.
const CASE: Case = Case {
    name: "",
    what: "",
    rays: 2048,
    make: |n| Ok(make::given(make::sphere(3, |p| p)?, make::inside(0.5, n))),
    truth: Truth::Closed,
    undecided: BY_CHANCE,
    paper: Paper { fails_on: &[], because: "" },
};

fn closed(n: usize, at: At) -> Result<Workload, Error> {
    Ok(make::aimed(make::sphere(3, |p| p)?, n, at, DVec3::ZERO))
}

/// Every case.
pub static CASES: &[Case] = &[
    Case { name: "inside", what: "random rays inside a closed sphere: nothing extreme, for comparison", ..CASE },
    // Directions.
    Case {
        name: "axis-0",
        what: "rays along an axis, the other components 0 and -0",
        make: |n| make::near_axis(n, 0.0),
        ..CASE
    },
    Case {
        name: "axis-below-1e-3",
        what: "rays nearly along an axis: components just below the paper's threshold",
        make: |n| make::near_axis(n, 0.000_999),
        paper: fails(&[Grid], "the ray is treated as parallel, but crosses a plane"),
        ..CASE
    },
    Case {
        name: "axis-above-1e-3",
        what: "rays nearly along an axis: components just above the paper's threshold",
        make: |n| make::near_axis(n, 0.001_001),
        ..CASE
    },
    Case {
        name: "axis-1e-7",
        what: "rays nearly along an axis: components of 1e-7",
        make: |n| make::near_axis(n, 1e-7),
        ..CASE
    },
    Case {
        name: "axis-1e-20",
        what: "rays nearly along an axis: components of 1e-20, near the robust threshold for parallel rays",
        make: |n| make::near_axis(n, 1e-20),
        ..CASE
    },
    Case {
        name: "axis-subnormal",
        what: "rays nearly along an axis: subnormal components",
        make: |n| make::near_axis(n, 1e-40),
        ..CASE
    },
    // The grid's cells.
    Case { name: "cell-faces", what: "rays that lie in a face of cells", make: |n| on_planes(n, On::Face), ..CASE },
    Case { name: "cell-edges", what: "rays along an edge of cells", make: |n| on_planes(n, On::Edge), ..CASE },
    Case {
        name: "cell-corners",
        what: "rays through the corners of cells, one after the other",
        make: |n| on_planes(n, On::Corner),
        ..CASE
    },
    Case { name: "origin-on-face", what: "origins on faces of cells", make: make::on_faces, ..CASE },
    Case {
        name: "walls-on-planes",
        what: "the paper's box, whose walls are planes of the grid",
        rays: 4096,
        make: make::walls,
        truth: Truth::Open,
        ..CASE
    },
    Case {
        name: "long-walk",
        what: "a walk of 3,000 cells along a diagonal",
        make: make::long_walk,
        truth: Truth::Open,
        paper: fails(&[Grid], "the accumulated tMax deviates from the planes at the end of the walk"),
        ..CASE
    },
    // Triangles.
    Case {
        name: "edges",
        what: "rays at edges of a closed mesh, from inside",
        make: |n| closed(n, At::Edges),
        undecided: AT_EDGES,
        paper: EDGES_CRACK,
        ..CASE
    },
    Case {
        name: "corners",
        what: "rays at corners of a closed mesh, from inside",
        make: |n| closed(n, At::Corners),
        undecided: AT_CORNERS,
        paper: EDGES_CRACK,
        ..CASE
    },
    Case {
        name: "in-plane",
        what: "rays in the plane of triangles that lie in a coordinate plane",
        make: make::in_plane,
        truth: Truth::Nothing,
        undecided: NONE,
        ..CASE
    },
    Case {
        name: "in-tilted-plane",
        what: "rays in the plane of a tilted triangle",
        make: make::in_tilted_plane,
        truth: Truth::Open,
        undecided: up_to(0.25, "three edge functions that are 0 but for rounding have the same sign in 1 of 4 rays"),
        ..CASE
    },
    Case {
        name: "without-area",
        what: "triangles with two or three identical corners",
        make: make::without_area,
        truth: Truth::Nothing,
        undecided: NONE,
        ..CASE
    },
    Case {
        name: "slivers-1e4",
        what: "slivers 10,000 times longer than wide, side by side",
        make: |n| make::slivers(n, 1e4),
        undecided: up_to(0.1, "two edges a sliver, each 20 to 40 roundings wide on both sides: a tenth of its width"),
        paper: OUTSIDE,
        ..CASE
    },
    Case {
        name: "slivers-1e8",
        what: "slivers 100,000,000 times longer than wide, side by side",
        make: |n| make::slivers(n, 1e8),
        undecided: up_to(8.0 / 9.0, "three roundings of 0.4 move the ray by up to four slivers either way, evenly"),
        paper: SMALL,
        ..CASE
    },
    Case { name: "duplicates", what: "a closed sphere with every triangle twice", make: make::duplicates, ..CASE },
    Case {
        name: "coplanar",
        what: "overlapping triangles in one tilted plane",
        make: make::coplanar,
        truth: Truth::Open,
        undecided: up_to(2.0 / 3.0, "any of three sheets may be nearest"),
        paper: OUTSIDE,
        ..CASE
    },
    // Origins.
    Case {
        name: "origin-on-surface",
        what: "origins on a triangle of a sphere",
        make: make::on_surface,
        truth: Truth::Open,
        undecided: up_to(0.5, "the sign of t is that of its rounding"),
        ..CASE
    },
    Case {
        name: "origin-outside",
        what: "origins three radii from a sphere",
        make: |n| make::from_afar(n, 3.0),
        truth: Truth::Open,
        undecided: up_to(0.004, "as for any ray, from three times as far"),
        paper: OUTSIDE,
        ..CASE
    },
    Case {
        name: "origin-far-1e3",
        what: "origins a thousand radii from a sphere",
        make: |n| make::from_afar(n, 1e3),
        truth: Truth::Open,
        undecided: up_to(0.25, "edges are as wide as 20 to 40 roundings of 1,000 radii: a quarter of a triangle"),
        paper: OUTSIDE,
        ..CASE
    },
    Case {
        name: "origin-far-1e6",
        what: "origins a million radii from a sphere",
        make: |n| make::from_afar(n, 1e6),
        truth: Truth::Open,
        undecided: up_to(0.5, "rounding moves edges by as much as triangles are wide, to either side"),
        ..CASE
    },
    // Places and sizes.
    Case {
        name: "moved-1e3",
        what: "a closed sphere a thousand radii from the origin, half of the rays at its edges",
        make: |n| make::moved(n, 1e3),
        undecided: HALF_AT_EDGES,
        paper: EDGES_CRACK,
        ..CASE
    },
    Case {
        name: "moved-1e4",
        what: "a closed sphere ten thousand radii from the origin, half of the rays at its edges",
        make: |n| make::moved(n, 1e4),
        undecided: HALF_AT_EDGES,
        paper: EDGES_CRACK,
        ..CASE
    },
    Case {
        name: "moved-1e5",
        what: "a closed sphere a hundred thousand radii from the origin, half of the rays at its edges",
        make: |n| make::moved(n, 1e5),
        undecided: HALF_AT_EDGES,
        paper: EDGES_CRACK,
        ..CASE
    },
    Case {
        name: "moved-1e6",
        what: "a closed sphere a million radii from the origin, where f32 has 16 steps to a radius",
        make: |n| make::moved(n, 1e6),
        undecided: HALF_AT_EDGES,
        ..CASE
    },
    Case {
        name: "scaled-1e-20",
        what: "a closed sphere of radius 1e-20, rays at its edges",
        make: |n| make::scaled(n, 1e-20),
        undecided: AT_EDGES,
        paper: EDGES_CRACK,
        ..CASE
    },
    Case {
        name: "scaled-1e20",
        what: "a closed sphere of radius 1e20, rays at its edges",
        make: |n| make::scaled(n, 1e20),
        undecided: AT_EDGES,
        paper: EDGES_CRACK,
        ..CASE
    },
    Case {
        name: "tiny-detail",
        what: "a sphere in a room 100,000 times as large, from close to it",
        make: make::tiny_detail,
        undecided: up_to(0.005, "as for any ray, with edges rounded by the room's coordinates"),
        paper: SMALL,
        ..CASE
    },
    // Scenes.
    Case {
        name: "flat",
        what: "a scene that is flat along an axis",
        make: make::flat,
        truth: Truth::Open,
        paper: OUTSIDE,
        ..CASE
    },
    Case {
        name: "line",
        what: "a scene that is flat along two axes: triangles that are stretches of a line",
        make: |n| make::line(n, 100.0),
        truth: Truth::Nothing,
        undecided: NONE,
        ..CASE
    },
    Case {
        name: "line-aslant",
        what: "triangles that are stretches of a line, from one side, so that the rounded corners are not in a line",
        make: |n| make::line(n, 5.0),
        truth: Truth::Open,
        undecided: up_to(0.25, "rounding must move the middle corner to the ray's side, beyond the ray: 1 in 4"),
        ..CASE
    },
    Case {
        name: "one-triangle",
        what: "a single triangle",
        make: make::one_triangle,
        truth: Truth::Open,
        paper: OUTSIDE,
        ..CASE
    },
    Case {
        name: "no-triangle",
        what: "a scene without triangles",
        rays: 256,
        make: make::no_triangle,
        truth: Truth::Nothing,
        undecided: NONE,
        ..CASE
    },
    Case {
        name: "crowded-cell",
        what: "10,000 triangles in one cell",
        rays: 192,
        make: make::crowd,
        truth: Truth::Open,
        undecided: up_to(0.02, "20 roundings of the distance are a hundredth of these triangles' widths"),
        paper: SMALL,
    },
    Case {
        name: "deep-tree",
        what: "40 triangles, each half as large and at half the distance of the one before",
        make: |n| make::halving(n, 0..40),
        truth: Truth::Open,
        paper: SMALL,
        ..CASE
    },
    Case {
        name: "deeper-tree",
        what: "60 triangles, each half as large and at half the distance of the one before; rays at the last 20",
        make: |n| make::halving(n, 40..60),
        truth: Truth::Open,
        paper: SMALL,
        ..CASE
    },
    Case {
        name: "identical",
        what: "2,000 identical triangles, which no BVH can separate",
        rays: 128,
        make: make::identical,
        truth: Truth::Open,
        paper: OUTSIDE,
        ..CASE
    },
    // Pictures.
    Case { name: "image-1x1", what: "an image of one pixel", rays: 1, make: |_| make::picture(1, 1, 40.0), ..CASE },
    Case {
        name: "image-1x8192",
        what: "an image of one column",
        rays: 8192,
        make: |_| make::picture(1, 8192, 40.0),
        ..CASE
    },
    Case {
        name: "image-8192x1",
        what: "an image of one row",
        rays: 8192,
        make: |_| make::picture(8192, 1, 40.0),
        ..CASE
    },
    Case {
        name: "view-0.001-degrees",
        what: "a field of view of a thousandth of a degree, along a plane of the grid",
        rays: 4096,
        make: |n| make::picture_on_plane(n.isqrt() as u32, 1e-3),
        undecided: up_to(0.15, "an edge in the image is as wide as 20 roundings on both sides, a seventh of it"),
        paper: fails(&[Grid], "every ray is treated as parallel to the plane, but some cross it"),
        ..CASE
    },
    Case {
        name: "view-179.9-degrees",
        what: "a field of view of nearly half the sphere",
        rays: 4096,
        make: |n| make::picture(n.isqrt() as u32, n.isqrt() as u32, 179.9),
        ..CASE
    },
];

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use raystep_kernels::options::RaySource;

    use super::*;

    #[test]
    fn no_ray_at_an_edge_or_corner_is_traced_twice() {
        for name in ["edges", "corners", "moved-1e4", "scaled-1e20"] {
            let case = CASES.iter().find(|case| case.name == name).expect("a case");
            let RaySource::Given(rays) = (case.make)(case.rays).expect("a case").rays else { panic!("input rays") };
            let bits = rays.iter().map(|ray| (ray.origin.map(f32::to_bits), ray.direction.map(f32::to_bits)));
            assert_eq!((bits.collect::<BTreeSet<_>>().len(), rays.len()), (2048, 2048), "{name}");
        }
    }

    #[test]
    fn every_case_is_made_says_what_it_is_and_may_fail() {
        let names: BTreeSet<&str> = CASES.iter().map(|case| case.name).collect();
        assert_eq!(names.len(), CASES.len(), "names are unique");
        for case in CASES {
            let Workload { scene, rays, .. } = (case.make)(64).unwrap_or_else(|e| panic!("{}: {e}", case.name));
            assert!(!case.what.is_empty() && !case.undecided.because.is_empty(), "{}", case.name);
            assert_eq!(case.paper.fails_on.is_empty(), case.paper.because.is_empty(), "{}", case.name);
            assert!((0.0..1.0).contains(&case.undecided.share), "{}", case.name);
            assert!(scene.triangles.iter().flatten().flatten().all(|v| v.is_finite()), "{}", case.name);
            match rays {
                RaySource::Given(rays) => assert_eq!(rays.len(), 64, "{}", case.name),
                RaySource::Camera { width, height, .. } => assert!(width * height > 0, "{}", case.name),
            }
        }
    }
}
