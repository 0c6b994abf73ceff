//! The families: each a table entry with its parameter's values. A new family is an entry here, built from functions in
//! `scenes`.

use raystep_kernels::options::{Integrator, MAX_DEPTH};

use super::{lit, scenes};
use crate::Error;
use crate::stability::Workload;

/// Scenes that differ in one parameter, with rays towards what the parameter makes hard.
#[derive(Clone, Copy, Debug)]
pub struct Family {
    /// Its name in files.
    pub name: &'static str,
    /// Its heading.
    pub title: &'static str,
    /// Scene and rays, in a sentence.
    pub what: &'static str,
    /// What the parameter is: the label of its axis.
    pub parameter: &'static str,
    /// The parameter's values, ascending.
    pub points: &'static [f64],
    /// How the rays' targets are chosen.
    pub stratum: &'static str,
    /// The light that is computed at the hits; none but the hits themselves if it is local.
    pub integrator: Integrator,
    /// Most bounces of paths, by parameter.
    pub max_depth: fn(f64) -> u32,
    /// Generates scene and rays, by parameter, number of rays and seed.
    pub(super) make: Make,
}

type Make = fn(f64, usize, u32) -> Result<Workload, Error>;

/// Random points on random edges of the object.
const EDGES: &str = "edges";
/// Random points in random triangles.
const SURFACE: &str = "surface";
/// Vertices on the edges of other triangles.
const T_VERTICES: &str = "t_vertices";

/// Powers of ten and their triples, then powers of ten.
const WIDE: &[f64] = &[1.0, 3.0, 10.0, 30.0, 100.0, 1e3, 1e4, 1e5, 1e6, 1e7];
const SLIVERS: &[f64] = &[1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8];

const fn family(name: &'static str, title: &'static str, stratum: &'static str, make: Make) -> Family {
    let (integrator, max_depth): (_, fn(f64) -> u32) = (Integrator::Local, |_| MAX_DEPTH);
    Family { name, title, what: "", parameter: "", points: &[], stratum, integrator, max_depth, make }
}

impl Family {
    const fn of(self, what: &'static str) -> Self {
        Self { what, ..self }
    }

    /// Rays to lights are traced, too.
    const fn lit(self) -> Self {
        Self { integrator: Integrator::Shadows, ..self }
    }

    /// Light is followed along paths.
    const fn along_paths(self) -> Self {
        Self { integrator: Integrator::Path, ..self }
    }

    /// The parameter is the number of bounces.
    const fn deep(self) -> Self {
        Self { max_depth: |bounces| bounces as u32, ..self }
    }

    /// Whether the light at the hits is computed, with rays to lights.
    #[must_use]
    pub fn is_lit(&self) -> bool {
        self.integrator != Integrator::default()
    }

    const fn over(self, parameter: &'static str, points: &'static [f64]) -> Self {
        Self { parameter, points, ..self }
    }
}

/// Every family.
pub static FAMILIES: &[Family] = &[
    family("room", "A small object in a large room", EDGES, scenes::room)
        .of("a sphere of 5,120 triangles in a room, seen from nearby (the teapot in a stadium)")
        .over("extent of the room / extent of the object", &[4.0, 10.0, 30.0, 100.0, 300.0, 1e3, 1e4, 1e5, 3e5, 1e6]),
    family("plane", "A large plane under an object", EDGES, scenes::plane)
        .of("a sphere of 5,120 triangles on a square of two, seen from nearby")
        .over("side of the square / diameter of the sphere", WIDE),
    family("extents", "Unequal extents", EDGES, scenes::extents)
        .of("a sphere of 5,120 triangles, flattened along an axis")
        .over("longest extent / shortest", &[1.0, 3.0, 10.0, 30.0, 100.0, 1e3, 1e4, 1e5, 1e6]),
    family("slivers", "Slivers along an axis", SURFACE, scenes::slivers)
        .of("a strip of 800 triangles, cut along an axis")
        .over("length of a sliver / width", SLIVERS),
    family("slivers-aslant", "Slivers aslant", SURFACE, scenes::slivers_aslant)
        .of("the same, turned so that no edge lies along an axis: their boxes overlap")
        .over("length of a sliver / width", SLIVERS),
    family("crowd", "A crowded cell", EDGES, scenes::crowd)
        .of("5,000 random triangles, some of them in a cube of 1/64 of the scene's extent")
        .over("share of triangles in the small cube", &[0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99]),
    family("layers", "Coincident layers", EDGES, scenes::layers)
        .of("copies of a sphere of 320 triangles, one in the other, seen from inside")
        .over("number of copies", &[1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0]),
    family("offset", "Offset from the origin", EDGES, scenes::offset)
        .of("a sphere of 1,280 triangles, seen from inside, away from the origin of coordinates")
        .over("distance from the origin / radius", &[1.0, 10.0, 100.0, 1e3, 1e4, 3e4, 1e5, 3e5, 1e6]),
    family("walk", "Long walks", SURFACE, scenes::walk)
        .of("a wall at the end of a diagonal through a flat grid of given resolution: a walk of twice as many cells")
        .over("cells along each side", &[4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0, 512.0, 1024.0, 2048.0]),
    family("outlier", "One far outlier", EDGES, scenes::outlier)
        .of("a sphere of 5,120 triangles and a single triangle far away, seen from near the sphere")
        .over(
            "distance of the outlier / radius of the sphere",
            &[3.0, 10.0, 30.0, 100.0, 300.0, 1e3, 1e4, 1e5, 1e6, 1e7],
        ),
    family("t-junctions", "T-junctions", T_VERTICES, scenes::t_junctions)
        .of("panels whose long edge meets a row of smaller triangles; rays to the vertices on that edge")
        .over("edges that meet one edge", &[1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0, 512.0]),
    family("grazing", "Grazing angles", SURFACE, scenes::grazing)
        .of("a tilted plane of 5,000 triangles, and rays that meet it at a small angle")
        .over("1 / sine of the angle between ray and plane", &[1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1e3, 1e4, 1e5, 1e6]),
    family("light-distance", "A light near and far", SURFACE, lit::distance)
        .lit()
        .of("a tilted plane of 5,000 triangles with a sphere on it, and a light above a point of the plane")
        .over(
            "distance of the light / side of the plane",
            &[1e-6, 1e-5, 1e-4, 1e-3, 0.01, 0.1, 1.0, 10.0, 100.0, 1e4, 1e6],
        ),
    family("light-ratio", "A bright and a dim light", SURFACE, lit::ratio)
        .lit()
        .of("the same with two lights, whose shadows of the sphere overlap in part")
        .over("brightness of one / of the other", &[1.0, 3.0, 10.0, 30.0, 100.0, 1e3, 1e4, 1e5, 1e6]),
    family("lights", "Many lights", SURFACE, lit::many)
        .lit()
        .of("the same with lights all around, of which half are below the plane")
        .over("number of lights", &[1.0, 2.0, 5.0, 10.0, 30.0, 100.0, 300.0, 1e3]),
    family("light-grazing", "Grazing light", SURFACE, lit::grazing)
        .lit()
        .of("the same with directional light at a small angle to the plane")
        .over(
            "1 / sine of the angle between light and plane",
            &[1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1e3, 1e4, 1e5, 1e6],
        ),
    family("depth", "Deep paths", SURFACE, lit::depth)
        .along_paths()
        .deep()
        .of("a ball of 320 triangles, which is a mirror, in a bright sphere of 1,280, of which eight glow")
        .over("most bounces of a path", &[1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 32.0, 64.0]),
    family("pdfs", "Unequal pdfs", SURFACE, lit::pdfs)
        .along_paths()
        .of("a tilted plane of 5,000 triangles with a sphere on it, under two lamps of the same power, of which one is smaller: \
             the pdfs of its points are larger by the square of that, and so are the ranges of weights")
        .over("side of one lamp / of the other", &[1.0, 3.0, 10.0, 30.0, 100.0, 1e3, 1e4, 3e4, 1e5]),
];

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use glam::DVec3;
    use raystep_kernels::{GridSize, Ray, RaySource};
    use raystep_scenes::Light;

    use super::*;

    fn vec(p: [f32; 3]) -> DVec3 {
        glam::Vec3::from(p).as_dvec3()
    }

    /// The longest side of the box of some triangles.
    fn extents(triangles: &[[[f32; 3]; 3]]) -> DVec3 {
        let points = || triangles.iter().flatten().map(|&p| vec(p));
        points().fold(DVec3::NEG_INFINITY, DVec3::max) - points().fold(DVec3::INFINITY, DVec3::min)
    }

    /// A family's parameter, worked out from what was generated.
    fn measured(name: &str, Workload { scene, rays, grid }: &Workload) -> f64 {
        let all = &scene.triangles[..];
        let longest = |triangles: &[[[f32; 3]; 3]]| extents(triangles).max_element();
        let RaySource::Given(rays) = rays else { panic!("input rays") };
        let of_points = scene.lights.iter().filter_map(|light| match light {
            Light::Point { position, color, .. } => Some((glam::Vec3::from(*position), color[1])),
            _ => None,
        });
        let (positions, colors): (Vec<_>, Vec<f32>) = of_points.unzip();
        match name {
            "room" | "plane" => longest(all) / longest(&all[..5120]),
            "extents" => longest(all) / extents(all).min_element(),
            "slivers" | "slivers-aslant" => {
                let [a, b, c] = all[0].map(vec);
                b.distance(c) / a.distance(b)
            }
            "crowd" => {
                let small = |t: &&[[f32; 3]; 3]| longest(&[**t]) < 2e-3;
                all.iter().filter(small).count() as f64 / all.len() as f64
            }
            "layers" => all.iter().filter(|t| **t == all[0]).count() as f64,
            "offset" => {
                let corners: Vec<DVec3> = all.iter().flatten().map(|&p| vec(p)).collect();
                corners.iter().sum::<DVec3>().length() / corners.len() as f64
            }
            "walk" => match grid {
                GridSize::Cells([x, _, 1]) => f64::from(*x) * longest(all) / extents(all).x,
                _ => panic!("a flat grid"),
            },
            "outlier" => vec(all[all.len() - 1][0]).length(),
            "t-junctions" => all.len() as f64 / 16.0 - 1.0,
            "grazing" => {
                let normal = DVec3::new(-1.0, 0.0, 1.0).normalize();
                let sine = |r: &Ray| vec(r.direction).normalize().dot(normal).abs();
                rays.len() as f64 / rays.iter().map(sine).sum::<f64>()
            }
            // The plane is x = z.
            "light-distance" => f64::from((positions[0].z - positions[0].x).abs()) / 2f64.sqrt(),
            "light-ratio" => f64::from(colors[0] / colors[1]),
            "lights" => scene.lights.len() as f64,
            "light-grazing" => match scene.lights[..] {
                [Light::Directional { direction, .. }] => {
                    1.0 / vec(direction).dot(DVec3::new(1.0, 0.0, -1.0).normalize())
                }
                _ => panic!("a directional light"),
            },
            // Two triangles of each lamp.
            "pdfs" => {
                let area = |t: &[[f32; 3]; 3]| (vec(t[1]) - vec(t[0])).cross(vec(t[2]) - vec(t[0])).length();
                let glows = |material: &u32| scene.materials[*material as usize].emissive != [0.0; 3];
                let lamps = all.iter().zip(&scene.triangle_materials).filter(|(_, material)| glows(material));
                let areas: Vec<f64> = lamps.map(|(triangle, _)| area(triangle)).collect();
                ((areas[0] + areas[1]) / (areas[2] + areas[3])).sqrt()
            }
            _ => panic!("{name}: how is its parameter measured?"),
        }
    }

    #[test]
    fn each_familys_geometry_follows_its_parameter() {
        let names: BTreeSet<&str> = FAMILIES.iter().map(|family| family.name).collect();
        assert_eq!((names.len(), FAMILIES.len()), (18, 18));
        for family in FAMILIES {
            assert!((8..=12).contains(&family.points.len()), "{}", family.name);
            let mut before = 0.0;
            let Workload { scene, .. } = (family.make)(family.points[0], 1, 7).expect("a scene");
            let glows = scene.materials.iter().any(|material| material.emissive != [0.0; 3]);
            assert_eq!(
                (family.is_lit(), family.integrator == Integrator::Path),
                (glows || !scene.lights.is_empty(), glows)
            );
            for &point in family.points {
                let made = (family.make)(point, 32, 7).expect("a scene");
                let measure = match family.name {
                    "depth" => f64::from((family.max_depth)(point)),
                    name => measured(name, &made),
                };
                assert!(measure > before, "{} at {point}: {measure} after {before}", family.name);
                // Rounding to f32 moves the corners of the thinnest slivers and the origins of the flattest rays.
                let is_rounded = matches!(family.name, "slivers-aslant" | "grazing" | "light-grazing") && point > 1e4;
                assert!(is_rounded || (measure / point - 1.0).abs() < 0.1, "{} at {point}: {measure}", family.name);
                before = if is_rounded { 0.0 } else { measure };
                let RaySource::Given(rays) = &made.rays else { panic!("{}: input rays", family.name) };
                assert_eq!(rays.len(), 32);
                let numbers = rays.iter().flat_map(|r| r.origin.into_iter().chain(r.direction));
                assert!(made.scene.triangles.iter().flatten().flatten().copied().chain(numbers).all(f32::is_finite));
            }
        }
    }

    #[test]
    fn rays_are_independent_and_the_same_for_the_same_seed() {
        for family in FAMILIES {
            let rays = |count: usize, seed: u32| match (family.make)(family.points[3], count, seed) {
                Ok(Workload { rays: RaySource::Given(rays), .. }) => rays,
                _ => panic!("{}: input rays", family.name),
            };
            let first = rays(64, 1);
            assert_eq!(first[..], rays(128, 1)[..64], "{}: more rays begin with the same", family.name);
            let bits = |r: &Ray| (r.origin.map(f32::to_bits), r.direction.map(f32::to_bits));
            let different: BTreeSet<_> = first.iter().map(bits).collect();
            assert_eq!(different.len(), 64, "{}", family.name);
            assert!(rays(64, 2).iter().all(|ray| !different.contains(&bits(ray))), "{}", family.name);
        }
    }
}
