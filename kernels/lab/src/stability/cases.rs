//! The table of cases. A new case is an entry here, built from functions in `make` and `planes`.

use glam::DVec3;
use raystep_kernels::options::Accelerator::Grid;

use crate::Error;
use crate::stability::claims::{
    AT_CORNERS, AT_EDGES, BY_CHANCE, EDGES_CRACK, HALF_AT_EDGES, NONE, OUTSIDE, SMALL, fails, up_to,
};
use crate::stability::make::{self, At};
use crate::stability::planes::{On, on_planes};
use crate::stability::{Case, Ceiling, Paper, Truth, Workload};

/// Rays inside a closed sphere, on which the paper's numerics may fail, but need not.
const fn case(name: &'static str, what: &'static str, make: fn(usize) -> Result<Workload, Error>) -> Case {
    let paper = Paper { fails_on: &[], because: "" };
    Case { name, what, rays: 2048, make, truth: Truth::Closed, undecided: BY_CHANCE, paper }
}

impl Case {
    const fn rays(self, rays: usize) -> Self {
        Self { rays, ..self }
    }

    const fn truth(self, truth: Truth) -> Self {
        Self { truth, ..self }
    }

    const fn undecided(self, undecided: Ceiling) -> Self {
        Self { undecided, ..self }
    }

    const fn paper(self, paper: Paper) -> Self {
        Self { paper, ..self }
    }
}

fn inside(n: usize) -> Result<Workload, Error> {
    Ok(make::given(make::sphere(3, |p| p)?, make::inside(0.5, n)))
}

fn closed(n: usize, at: At) -> Result<Workload, Error> {
    Ok(make::aimed(make::sphere(3, |p| p)?, n, at, DVec3::ZERO))
}

/// Every case.
pub static CASES: &[Case] = &[
    case("inside", "random rays inside a closed sphere: nothing extreme, for comparison", inside),
    // Directions.
    case("axis-0", "rays along an axis, the other components 0 and -0", |n| make::near_axis(n, 0.0)),
    case("axis-below-1e-3", "rays nearly along an axis: components just below the paper's threshold", |n| {
        make::near_axis(n, 0.000_999)
    })
    .paper(fails(&[Grid], "the ray is treated as parallel, but crosses a plane")),
    case("axis-above-1e-3", "rays nearly along an axis: components just above the paper's threshold", |n| {
        make::near_axis(n, 0.001_001)
    }),
    case("axis-1e-7", "rays nearly along an axis: components of 1e-7", |n| make::near_axis(n, 1e-7)),
    case(
        "axis-1e-20",
        "rays nearly along an axis: components of 1e-20, near the robust threshold for parallel rays",
        |n| make::near_axis(n, 1e-20),
    ),
    case("axis-subnormal", "rays nearly along an axis: subnormal components", |n| make::near_axis(n, 1e-40)),
    // The grid's cells.
    case("cell-faces", "rays that lie in a face of cells", |n| on_planes(n, On::Face)),
    case("cell-edges", "rays along an edge of cells", |n| on_planes(n, On::Edge)),
    case("cell-corners", "rays through the corners of cells, one after the other", |n| on_planes(n, On::Corner)),
    case("origin-on-face", "origins on faces of cells", make::on_faces),
    case("walls-on-planes", "the paper's box, whose walls are planes of the grid", make::walls)
        .rays(4096)
        .truth(Truth::Open),
    case("long-walk", "a walk of 3,000 cells along a diagonal", make::long_walk)
        .truth(Truth::Open)
        .paper(fails(&[Grid], "the accumulated tMax deviates from the planes at the end of the walk")),
    // Triangles.
    case("edges", "rays at edges of a closed mesh, from inside", |n| closed(n, At::Edges))
        .undecided(AT_EDGES)
        .paper(EDGES_CRACK),
    case("corners", "rays at corners of a closed mesh, from inside", |n| closed(n, At::Corners))
        .undecided(AT_CORNERS)
        .paper(EDGES_CRACK),
    case("in-plane", "rays in the plane of triangles that lie in a coordinate plane", make::in_plane)
        .truth(Truth::Nothing)
        .undecided(NONE),
    case("in-tilted-plane", "rays in the plane of a tilted triangle", make::in_tilted_plane)
        .truth(Truth::Open)
        .undecided(up_to(0.25, "three edge functions that are 0 but for rounding have the same sign in 1 of 4 rays")),
    case("without-area", "triangles with two or three identical corners", make::without_area)
        .truth(Truth::Nothing)
        .undecided(NONE),
    case("slivers-1e4", "slivers 10,000 times longer than wide, side by side", |n| make::slivers(n, 1e4))
        .undecided(up_to(0.1, "two edges a sliver, each 20 to 40 roundings wide on both sides: a tenth of its width"))
        .paper(OUTSIDE),
    case("slivers-1e8", "slivers 100,000,000 times longer than wide, side by side", |n| make::slivers(n, 1e8))
        .undecided(up_to(8.0 / 9.0, "three roundings of 0.4 move the ray by up to four slivers either way, evenly"))
        .paper(SMALL),
    case("duplicates", "a closed sphere with every triangle twice", make::duplicates),
    case("coplanar", "overlapping triangles in one tilted plane", make::coplanar)
        .truth(Truth::Open)
        .undecided(up_to(2.0 / 3.0, "any of three sheets may be nearest"))
        .paper(OUTSIDE),
    // Origins.
    case("origin-on-surface", "origins on a triangle of a sphere", make::on_surface)
        .truth(Truth::Open)
        .undecided(up_to(0.5, "the sign of t is that of its rounding")),
    case("origin-outside", "origins three radii from a sphere", |n| make::from_afar(n, 3.0))
        .truth(Truth::Open)
        .undecided(up_to(0.004, "as for any ray, from three times as far"))
        .paper(OUTSIDE),
    case("origin-far-1e3", "origins a thousand radii from a sphere", |n| make::from_afar(n, 1e3))
        .truth(Truth::Open)
        .undecided(up_to(0.25, "edges are as wide as 20 to 40 roundings of 1,000 radii: a quarter of a triangle"))
        .paper(OUTSIDE),
    case("origin-far-1e6", "origins a million radii from a sphere", |n| make::from_afar(n, 1e6))
        .truth(Truth::Open)
        .undecided(up_to(0.5, "rounding moves edges by as much as triangles are wide, to either side")),
    // Places and sizes.
    case("moved-1e3", "a closed sphere a thousand radii from the origin, half of the rays at its edges", |n| {
        make::moved(n, 1e3)
    })
    .undecided(HALF_AT_EDGES)
    .paper(EDGES_CRACK),
    case("moved-1e4", "a closed sphere ten thousand radii from the origin, half of the rays at its edges", |n| {
        make::moved(n, 1e4)
    })
    .undecided(HALF_AT_EDGES)
    .paper(EDGES_CRACK),
    case("moved-1e5", "a closed sphere a hundred thousand radii from the origin, half of the rays at its edges", |n| {
        make::moved(n, 1e5)
    })
    .undecided(HALF_AT_EDGES)
    .paper(EDGES_CRACK),
    case("moved-1e6", "a closed sphere a million radii from the origin, where f32 has 16 steps to a radius", |n| {
        make::moved(n, 1e6)
    })
    .undecided(HALF_AT_EDGES),
    case("scaled-1e-20", "a closed sphere of radius 1e-20, rays at its edges", |n| make::scaled(n, 1e-20))
        .undecided(AT_EDGES)
        .paper(EDGES_CRACK),
    case("scaled-1e20", "a closed sphere of radius 1e20, rays at its edges", |n| make::scaled(n, 1e20))
        .undecided(AT_EDGES)
        .paper(EDGES_CRACK),
    case("tiny-detail", "a sphere in a room 100,000 times as large, from close to it", make::tiny_detail)
        .undecided(up_to(0.005, "as for any ray, with edges rounded by the room's coordinates"))
        .paper(SMALL),
    // Scenes.
    case("flat", "a scene that is flat along an axis", make::flat).truth(Truth::Open).paper(OUTSIDE),
    case("line", "a scene that is flat along two axes: triangles that are stretches of a line", |n| {
        make::line(n, 100.0)
    })
    .truth(Truth::Nothing)
    .undecided(NONE),
    case(
        "line-aslant",
        "triangles that are stretches of a line, from one side, so that the rounded corners are not in a line",
        |n| make::line(n, 5.0),
    )
    .truth(Truth::Open)
    .undecided(up_to(0.25, "rounding must move the middle corner to the ray's side, beyond the ray: 1 in 4")),
    case("one-triangle", "a single triangle", make::one_triangle).truth(Truth::Open).paper(OUTSIDE),
    case("no-triangle", "a scene without triangles", make::no_triangle).rays(256).truth(Truth::Nothing).undecided(NONE),
    case("crowded-cell", "10,000 triangles in one cell", make::crowd)
        .rays(192)
        .truth(Truth::Open)
        .undecided(up_to(0.02, "20 roundings of the distance are a hundredth of these triangles' widths"))
        .paper(SMALL),
    case("deep-tree", "40 triangles, each half as large and at half the distance of the one before", |n| {
        make::halving(n, 0..40)
    })
    .truth(Truth::Open)
    .paper(SMALL),
    case(
        "deeper-tree",
        "60 triangles, each half as large and at half the distance of the one before; rays at the last 20",
        |n| make::halving(n, 40..60),
    )
    .truth(Truth::Open)
    .paper(SMALL),
    case("identical", "2,000 identical triangles, which no BVH can separate", make::identical)
        .rays(128)
        .truth(Truth::Open)
        .paper(OUTSIDE),
    // Pictures.
    case("image-1x1", "an image of one pixel", |_| make::picture(1, 1, 40.0)).rays(1),
    case("image-1x8192", "an image of one column", |_| make::picture(1, 8192, 40.0)).rays(8192),
    case("image-8192x1", "an image of one row", |_| make::picture(8192, 1, 40.0)).rays(8192),
    case("view-0.001-degrees", "a field of view of a thousandth of a degree, along a plane of the grid", |n| {
        make::picture_on_plane(n.isqrt() as u32, 1e-3)
    })
    .rays(4096)
    .undecided(up_to(0.15, "an edge in the image is as wide as 20 roundings on both sides, a seventh of it"))
    .paper(fails(&[Grid], "every ray is treated as parallel to the plane, but some cross it")),
    case("view-179.9-degrees", "a field of view of nearly half the sphere", |n| {
        make::picture(n.isqrt() as u32, n.isqrt() as u32, 179.9)
    })
    .rays(4096),
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
