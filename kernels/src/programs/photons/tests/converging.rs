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
