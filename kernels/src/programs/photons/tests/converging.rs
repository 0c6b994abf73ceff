//! Iterations: what is left of a radius, and the light that the mean comes to.

use glam::DVec3;
use raystep_scenes::{Camera, Light, Material, Optics, Projection, Scene, generate};

use super::{few, looking, matte, of_quads, options, run, values};
use crate::options::samples::Samples;
use crate::options::{Gather, Integrator, Neighbours, Options, Photons, RaySource};
use crate::programs::closest_hit::streams::{COLOR, SHRUNK};
use crate::shared::samples::Sampler;
use crate::tables::stream::StreamData;

fn iterated(iterations: u32, photons: Photons) -> Options {
    let samples = Samples { count: iterations, ..Samples::default() };
    Options { rays: looking([0.0, 0.0, 3.3], [0.0; 3], 0.75, 12), samples, max_depth: 4, ..options(photons) }
}

/// Of the photons that each iteration finds, two thirds count on, and the circle shrinks by as many.
#[test]
fn the_radius_shrinks_by_the_photons_that_no_longer_count() {
    let scene = generate::cornell_box();
    let photons = Photons { count: 2000, radius: 60, nearest: 20, ..Photons::default() };
    let after: Vec<StreamData> =
        [2, 3, 4].map(|n| values(&run(&scene, &iterated(n, photons), async |_| {}), SHRUNK)).into();
    let mut shrunk = 0;
    for pixel in 0..144 {
        for pair in after.windows(2) {
            let [[before, radius], [kept, squared]] =
                [&pair[0], &pair[1]].map(|of| [0, 1].map(|layer| f64::from(of.get_f32(layer, pixel))));
            // Nothing was hit, or nothing was found.
            if kept == before {
                assert_eq!(radius, squared, "pixel {pixel}");
                continue;
            }
            let found = (kept - before) * 1.5;
            assert!((found - found.round()).abs() < 1e-3, "pixel {pixel}: {found}");
            let expected = radius * kept / (before + found);
            assert!((squared / expected - 1.0).abs() < 1e-5, "pixel {pixel}: {squared}, not {expected}");
            shrunk += 1;
        }
    }
    assert!(shrunk > 150, "{shrunk}");
}

/// The mean light of a picture is that of paths that bounce as often, looked up at once or after a bounce.
#[test]
fn the_light_is_that_of_paths() {
    let scene = generate::cornell_box();
    let mean = |options: &Options| -> f64 {
        let color = values(&run(&scene, options, async |_| {}), COLOR);
        let sum = |layer| color.layer(layer).iter().map(|&bits| f64::from(f32::from_bits(bits))).sum::<f64>();
        (sum(0) + sum(1) + sum(2)) / 432.0
    };
    let path = Options { integrator: Integrator::Path, ..iterated(256, Photons::default()) };
    let direct = Options { max_depth: 1, ..path.clone() };
    let (expected, direct) = (mean(&path), mean(&direct));
    for (gather, tolerance) in [(Gather::Direct, 0.06), (Gather::Final, 0.03)] {
        let photons = Photons { count: 2000, radius: 40, gather, ..Photons::default() };
        let found = mean(&iterated(32, photons));
        eprintln!("{gather}: {found}, path {expected}, direct {direct}");
        // Circles that reach over edges lose light, the less the smaller they are.
        assert!((found / expected - 1.0).abs() < tolerance, "{gather}: {found}, not {expected}");
    }
}

/// With mirrors and a lamp that glows, too: what a ray finds by a mirror, after a diffuse surface, is in the map of caustics.
#[test]
fn light_by_mirrors_counts_once() {
    let mut scene = generate::cornell_lamp();
    let white = scene.materials.iter().position(|of| of.emissive == [0.0; 3] && of.base_color[0] == of.base_color[1]);
    scene.materials[white.expect("a white material")].optics = Optics::Mirror;
    let mean = |options: &Options| -> f64 {
        let color = values(&run(&scene, options, async |_| {}), COLOR);
        let sum = |layer| color.layer(layer).iter().map(|&bits| f64::from(f32::from_bits(bits))).sum::<f64>();
        (sum(0) + sum(1) + sum(2)) / 432.0
    };
    let expected = mean(&Options { integrator: Integrator::Path, ..iterated(1024, Photons::default()) });
    for gather in [Gather::Direct, Gather::Final] {
        let found = mean(&iterated(48, Photons { count: 2000, radius: 40, gather, ..Photons::default() }));
        println!("{gather}: {found}, path {expected}");
        // Chance and circles over edges cost 0.3%; a lamp that counts twice adds 3%.
        assert!((found / expected - 1.0).abs() < 0.012, "{gather}: {found}, not {expected}");
    }
}

/// On a flat, evenly lit plane, the mean of estimates from the nearest photons is the irradiance: there is no bias.
#[test]
fn on_an_evenly_lit_plane_the_estimate_is_the_irradiance() {
    const RUNS: u32 = 12;
    let floor = [[-2.0, 0.0, -2.0], [-2.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0f32]];
    let wall = [[-2.0, 0.0, 2.0], [-2.0, 0.0, -2.0], [-2.0, 4.0, -2.0], [-2.0, 4.0, 2.0f32]];
    let mirror = Material { optics: Optics::Mirror, ..matte([1.0; 3]) };
    let mut scene = of_quads(&[(floor, matte([0.5; 3])), (wall, mirror)]);
    // From 45 degrees: what the wall reflects lights the whole floor, from 45 degrees on the other side.
    let of = |color| Light::Directional { direction: [-0.5f32.sqrt(), -0.5f32.sqrt(), 0.0], color, intensity: 2.0 };
    scene.lights = vec![of([1.0; 3])];
    let expected = 0.5 / std::f64::consts::PI * 2.0 * 0.5f64.sqrt();
    let reflected: Vec<f64> = (0..RUNS)
        .map(|seed| {
            // Independent photons, of which 50 are found within about a tenth of the floor's side.
            let samples = Samples { seed, sampler: Sampler::Random, ..Samples::default() };
            let photons = Photons { count: 60_000, radius: 60, neighbours: Neighbours::Exact, ..Photons::default() };
            let rays = looking([0.1, 4.0, 0.1], [0.1, 0.0, 0.0], 0.2, 6);
            let color =
                values(&run(&scene, &Options { rays, samples, max_depth: 2, ..options(photons) }, async |_| {}), COLOR);
            (0..36).map(|pixel| f64::from(color.get_f32(0, pixel))).sum::<f64>() / 36.0 - expected
        })
        .collect();
    let mean = reflected.iter().sum::<f64>() / f64::from(RUNS);
    let variance = reflected.iter().map(|of| (of - mean).powi(2)).sum::<f64>() / f64::from(RUNS - 1);
    let error = (variance / f64::from(RUNS)).sqrt();
    println!("{mean} by photons, {expected} by the closed form, standard error {error}");
    // 99.9% of such means, by Student's t with 11 degrees of freedom.
    assert!((mean - expected).abs() < 4.44 * error, "{mean}, not {expected}, with an error of {error}");
    assert!(error < 0.03 * expected, "{error}");
}

/// What the photons of a pixel come to, beside what they should.
struct Converging {
    scene: Scene,
    rays: RaySource,
    /// How often light bounces.
    depth: u32,
    /// Photons of an iteration, and the first radius, in thousandths of the diagonal.
    photons: [u32; 2],
    /// Of the squared radius, in [`SHRUNK`].
    layer: usize,
    /// The light without photons.
    direct: f64,
    /// That which photons bring.
    reflected: f64,
}

impl Converging {
    /// The mean of the iterations is, within its interval, what the filter makes of the light with the radius of each, and the
    /// radius falls as it should. `filtered`: the light that is estimated with a radius, in scene units.
    fn assert(self, filtered: impl Fn(f64) -> f64) {
        const RUNS: u32 = 8;
        const ITERATIONS: u32 = 24;
        let [count, radius] = self.photons;
        let photons = Photons { count, radius, nearest: Photons::MOST_NEAREST, ..Photons::default() };
        let (mut off, mut bias) = (Vec::new(), [0.0; 2]);
        for seed in 0..RUNS {
            let samples = Samples { count: ITERATIONS, seed, sampler: Sampler::Random, ..Samples::default() };
            let options = Options { rays: self.rays.clone(), samples, max_depth: self.depth, ..options(photons) };
            let mut squared = Vec::new();
            let renderer = run(&self.scene, &options, async |renderer| {
                let now = renderer.values(SHRUNK).await.expect("values").get_f32(self.layer, 0);
                if squared.last() != Some(&now) {
                    squared.push(now);
                }
            });
            let (data, color) = (renderer.data(), f64::from(values(&renderer, COLOR).get_f32(0, 0)));
            squared[0] = data.photon_map.radius.powi(2);
            squared.truncate(ITERATIONS as usize);
            assert_eq!(squared.len(), ITERATIONS as usize, "{squared:?}");
            let unit = data.units.scene_units_per_stream_unit();
            let radii: Vec<f64> = squared.iter().map(|&squared| f64::from(squared).sqrt() * unit).collect();
            let estimate = radii.iter().map(|&radius| filtered(radius)).sum::<f64>() / radii.len() as f64;
            off.push(color - self.direct - estimate);
            bias[0] += filtered(radii[0]) - self.reflected;
            bias[1] += estimate - self.reflected;
            // After so many iterations, each of which finds about as many photons by area.
            let rate = (squared[23] / squared[5]).powf(3.0);
            assert!((rate / (6.0 / 24.0) - 1.0).abs() < 0.25, "{rate}");
        }
        let mean = off.iter().sum::<f64>() / f64::from(RUNS);
        let variance = off.iter().map(|of| (of - mean).powi(2)).sum::<f64>() / f64::from(RUNS - 1);
        let error = (variance / f64::from(RUNS)).sqrt();
        let [first, all] = bias.map(|bias| bias / f64::from(RUNS));
        println!(
            "off by {mean} with an error of {error}; bias {first} of {} at first, {all} in the mean",
            self.reflected
        );
        // 99.9% of such means, by Student's t with 7 degrees of freedom.
        assert!(mean.abs() < 5.41 * error, "{mean}, with an error of {error}");
        // The interval is so narrow that it tells the bias of the mean from that of the first radius, and from none.
        assert!(5.41 * error < 0.5 * all.abs().min((first - all).abs()), "{error}: {first}, {all}");
    }
}

/// The mean of a cone over a circle, with its weight: of values by distance and turn.
fn cone(radius: f64, value: impl Fn([f64; 2]) -> f64) -> f64 {
    const SIDE: usize = 200;
    let ring = |i: usize| {
        let r = (i as f64 + 0.5) / SIDE as f64;
        let around = (0..SIDE).map(|j| {
            let turn = std::f64::consts::TAU * j as f64 / SIDE as f64;
            value([radius * r * turn.cos(), radius * r * turn.sin()])
        });
        around.sum::<f64>() / SIDE as f64 * (1.0 - r) * 2.0 * r / SIDE as f64
    };
    3.0 * (0..SIDE).map(ring).sum::<f64>()
}

/// Beside a mirror, the light of its lamp's image is a caustic, which is known in f64.
#[test]
fn bias_falls_with_the_radius_as_predicted() {
    let floor = [[-2.0, 0.0, -2.0], [-2.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0f32]];
    let wall = [[-4.0, -0.5, -2.0], [4.0, -0.5, -2.0], [4.0, 4.0, -2.0], [-4.0, 4.0, -2.0f32]];
    let mirror = Material { optics: Optics::Mirror, ..matte([1.0; 3]) };
    let mut scene = of_quads(&[(floor, matte([0.5; 3])), (wall, mirror)]);
    let (height, intensity) = (0.5f64, 3.0);
    scene.lights = vec![Light::Point { position: [0.0, 0.5, -1.9], color: [1.0; 3], intensity: intensity as f32 }];
    // What the floor reflects of the lamp, and of its image behind the wall, at a place of it.
    let of = |foot: f64, [x, z]: [f64; 2]| {
        let squared = height * height + x * x + (z - foot).powi(2);
        0.5 / std::f64::consts::PI * intensity * height / squared.powf(1.5)
    };
    let at = [0.0, -1.4];
    let rays = looking([0.0, 3.0, -1.399], [0.0, 0.0, -1.4], 1e-4, 1);
    let (direct, reflected) = (of(-1.9, at), of(-2.1, at));
    let converging = Converging { scene, rays, depth: 2, photons: [20_000, 60], layer: 3, direct, reflected };
    converging.assert(|radius| cone(radius, |[x, z]| of(-2.1, [at[0] + x, at[1] + z])));
}

/// In a diffuse box, a lamp close to a wall makes a spot of light, which lights the wall across. There, what it is without
/// bias is that of paths.
#[test]
fn bias_falls_in_a_diffuse_box_as_paths_predict() {
    const SIDE: u32 = 24;
    // The first radius is 0.34.
    const HALF: f64 = 0.36;
    const DEPTH: u32 = 3;
    let (x, y, z) = ([-0.25, 0.25f32], [-1.0, 1.0f32], [-1.0, 1.0f32]);
    let corner = |i: usize, j: usize, k: usize| [x[i], y[j], z[k]];
    let wall = |corners: [[usize; 3]; 4]| (corners.map(|[i, j, k]| corner(i, j, k)), matte([0.8; 3]));
    let mut scene = of_quads(&[
        wall([[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]]),
        wall([[1, 0, 0], [1, 0, 1], [1, 1, 1], [1, 1, 0]]),
        wall([[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0]]),
        wall([[0, 1, 0], [1, 1, 0], [1, 1, 1], [0, 1, 1]]),
        wall([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]),
        wall([[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]]),
    ]);
    scene.lights = vec![Light::Point { position: [-0.1, 0.0, 0.0], color: [1.0; 3], intensity: 1.0 }];
    let seen = |side: u32, half: f64| {
        let projection = Projection::Orthographic { half_height: half };
        let (eye, target) = (DVec3::new(-0.05, 0.0, 0.0), DVec3::new(0.25, 0.0, 0.0));
        let camera = Camera::look_at(eye, target, DVec3::Y, projection).expect("a camera");
        RaySource::Camera { camera, width: side, height: side }
    };
    let light = |side: u32, half: f64, depth: u32, spp: u32| -> Vec<f64> {
        let samples = Samples { count: spp, ..Samples::default() };
        let path = Options { integrator: Integrator::Path, rays: seen(side, half), samples, ..options(few()) };
        let color = values(&run(&scene, &Options { max_depth: depth, ..path }, async |_| {}), COLOR);
        color.layer(0).iter().map(|&bits| f64::from(f32::from_bits(bits))).collect()
    };
    let direct = light(1, 1e-6, 1, 1)[0];
    let reflected = light(1, 1e-6, DEPTH, 1 << 14)[0] - direct;
    let [all, lamps] = [(DEPTH, 512), (1, 16)].map(|(depth, spp)| light(SIDE, HALF, depth, spp));
    let at = |[y, z]: [f64; 2]| {
        let texel = |along: f64| (((along / HALF + 1.0) * 0.5 * f64::from(SIDE)) as usize).min(SIDE as usize - 1);
        let pixel = texel(y) * SIDE as usize + texel(z);
        all[pixel] - lamps[pixel]
    };
    let rays = seen(1, 1e-6);
    let photons = [10_000, 120];
    let converging = Converging { scene: scene.clone(), rays, depth: DEPTH, photons, layer: 1, direct, reflected };
    converging.assert(|radius| cone(radius, at));
}
