//! Iterations: what is left of a radius, and the light that the mean comes to.

use raystep_scenes::{Light, Material, Optics, generate};

use super::{looking, matte, of_quads, options, run, values};
use crate::options::samples::Samples;
use crate::options::{Gather, Integrator, Neighbours, Options, Photons};
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
        assert!((found / expected - 1.0).abs() < 0.06, "{gather}: {found}, not {expected}");
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

/// Beside a mirror, the light of its lamp's image is a caustic. The mean of the iterations is, within its interval, what the
/// filter makes of that light with the radius of each, by quadrature in f64; and the radius falls as it should.
#[test]
fn bias_falls_with_the_radius_as_predicted() {
    const RUNS: u32 = 8;
    const ITERATIONS: u32 = 24;
    let floor = [[-2.0, 0.0, -2.0], [-2.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0f32]];
    let wall = [[-4.0, -0.5, -2.0], [4.0, -0.5, -2.0], [4.0, 4.0, -2.0], [-4.0, 4.0, -2.0f32]];
    let mirror = Material { optics: Optics::Mirror, ..matte([1.0; 3]) };
    let mut scene = of_quads(&[(floor, matte([0.5; 3])), (wall, mirror)]);
    let (height, intensity) = (0.5f64, 3.0);
    scene.lights = vec![Light::Point { position: [0.0, 0.5, -1.9], color: [1.0; 3], intensity: intensity as f32 }];
    // By the lamp, and by its image behind the wall, at a place of the floor.
    let of =
        |foot: f64, [x, z]: [f64; 2]| intensity * height / (height * height + x * x + (z - foot).powi(2)).powf(1.5);
    let at = [0.0, -1.4];
    let filtered = |radius: f64| {
        const SIDE: usize = 200;
        let ring = |i: usize| {
            let r = (i as f64 + 0.5) / SIDE as f64;
            let around = (0..SIDE).map(|j| {
                let turn = std::f64::consts::TAU * j as f64 / SIDE as f64;
                of(-2.1, [at[0] + radius * r * turn.cos(), at[1] + radius * r * turn.sin()])
            });
            around.sum::<f64>() / SIDE as f64 * (1.0 - r) * 2.0 * r / SIDE as f64
        };
        3.0 * (0..SIDE).map(ring).sum::<f64>()
    };
    let photons = Photons { count: 20_000, radius: 60, nearest: Photons::MOST_NEAREST, ..Photons::default() };
    let (mut off, mut bias) = (Vec::new(), [0.0; 2]);
    for seed in 0..RUNS {
        let samples = Samples { count: ITERATIONS, seed, sampler: Sampler::Random, ..Samples::default() };
        let rays = looking([0.0, 3.0, -1.399], [0.0, 0.0, -1.4], 1e-4, 1);
        let mut squared = Vec::new();
        let renderer = run(&scene, &Options { rays, samples, max_depth: 2, ..options(photons) }, async |renderer| {
            let now = renderer.values(SHRUNK).await.expect("values").get_f32(3, 0);
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
        off.push(color * 2.0 * std::f64::consts::PI - of(-1.9, at) - estimate);
        bias[0] += filtered(radii[0]) - of(-2.1, at);
        bias[1] += estimate - of(-2.1, at);
        // After so many iterations, each of which finds about as many photons by area.
        let rate = (squared[23] / squared[5]).powf(3.0);
        assert!((rate / (6.0 / 24.0) - 1.0).abs() < 0.25, "{rate}");
    }
    let mean = off.iter().sum::<f64>() / f64::from(RUNS);
    let variance = off.iter().map(|of| (of - mean).powi(2)).sum::<f64>() / f64::from(RUNS - 1);
    let error = (variance / f64::from(RUNS)).sqrt();
    let [first, all] = bias.map(|bias| bias / f64::from(RUNS) / of(-2.1, at));
    println!("off by {mean} with an error of {error}; bias {first} of the light at first, {all} in the mean");
    // 99.9% of such means, by Student's t with 7 degrees of freedom.
    assert!(mean.abs() < 5.41 * error, "{mean}, with an error of {error}");
    // The interval is so narrow that it tells the bias of the mean from that of the first radius, and from none.
    assert!(5.41 * error < 0.5 * all.abs().min((first - all).abs()) * of(-2.1, at), "{error}: {first}, {all}");
}
