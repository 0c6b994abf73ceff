//! One pixel's light by each strategy of a path tracer: their means agree, their errors do not.

use raystep_kernels::history::RunSoFar;
use raystep_kernels::history::light_tree::LightTree;
use raystep_kernels::options::Strategy;
use raystep_kernels::plan::{Limits, PlanError};
use raystep_kernels::{Options, Plan, Samples, ScheduleKind};
use raystep_scenes::Scene;

/// A pixel's light by a strategy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The strategy.
    pub strategy: Strategy,
    /// Number of samples.
    pub samples: u32,
    /// Mean of the samples, linear light.
    pub mean: [f64; 3],
    /// Standard error of the mean, from the variance of the samples: as if they did not depend on each other. With points of a
    /// sequence, the mean is closer.
    pub error: [f64; 3],
}

/// Traces a pixel's samples by a strategy with the CPU reference kernels in f32, and adds up the light trees. `None` if the
/// rays of a run with these options cannot be followed alone, or have no light tree.
///
/// # Errors
/// If the scene or options make no plan.
pub fn estimate(
    scene: &Scene,
    options: &Options,
    strategy: Strategy,
    pixel: [u32; 2],
    samples: u32,
) -> Result<Option<Estimate>, PlanError> {
    let options = Options {
        strategy,
        // Few passes for each walk, and one at least between bounces.
        schedule: ScheduleKind::Compact,
        steps_per_pass: STEPS,
        counters: false,
        samples: Samples { count: samples, first: 0, ..options.samples },
        ..options.clone()
    };
    let (plan, data) = Plan::new(scene, &options, &Limits::CPU)?;
    let run = RunSoFar { plan: &plan, data: &data, passes: &[], is_complete: false };
    let tree = run.follow::<f32>(pixel).and_then(|life| LightTree::of(&life.rows, plan.program, &data));
    Ok(tree.map(|tree| of_tree(strategy, &tree)))
}

/// Steps of a pass.
const STEPS: u32 = 1024;

/// The mean of a tree's samples, and its standard error.
fn of_tree(strategy: Strategy, tree: &LightTree) -> Estimate {
    let count = f64::from(tree.samples);
    let mut of_sample = vec![[0.0; 3]; tree.samples as usize];
    for vertex in &tree.vertices {
        if let Some(sum) = of_sample.get_mut(vertex.sample as usize) {
            // Contributions are parts of the mean.
            (0..3).for_each(|c| sum[c] += vertex.contribution[c] * count);
        }
    }
    let mean = [0, 1, 2].map(|c| of_sample.iter().map(|light| light[c]).sum::<f64>() / count);
    let error = [0, 1, 2].map(|c| {
        let squares = of_sample.iter().map(|light| (light[c] - mean[c]).powi(2)).sum::<f64>();
        (squares / (count - 1.0).max(1.0) / count).sqrt()
    });
    Estimate { strategy, samples: tree.samples, mean, error }
}

#[cfg(test)]
mod tests {
    use raystep_kernels::options::Integrator;
    use raystep_kernels::{Accelerator, Device, RaySource, Renderer};
    use raystep_scenes::generate;

    use super::*;

    fn options(scene: &Scene) -> Options {
        let rays = RaySource::Camera { camera: scene.cameras[0].clone(), width: 16, height: 16 };
        let base = Options::new(rays);
        let samples = Samples { count: 4, seed: 5, ..Samples::default() };
        Options { integrator: Integrator::Path, accelerator: Accelerator::Bvh, max_depth: 3, samples, ..base }
    }

    /// The mean is the colour of the pixel in a run with as many samples.
    #[test]
    fn the_mean_is_the_pixels_colour() {
        let mut scene = generate::whitted(1).expect("a scene");
        scene.materials[0].emissive = [0.25, 0.5, 0.0];
        let options = Options { strategy: Strategy::Light, ..options(&scene) };
        let image = pollster::block_on(async {
            let mut renderer = Renderer::new(&scene, &options, &Device::Cpu(None)).await.expect("a renderer");
            renderer.run(|_| std::ops::ControlFlow::Continue(())).await.expect("a run");
            renderer.image().await.expect("an image")
        });
        for [x, y] in [[3, 12], [8, 9], [14, 13]] {
            let found = estimate(&scene, &options, Strategy::Light, [x, y], 4).expect("a plan").expect("a tree");
            let color = &image.pixels[(y * 16 + x) as usize];
            for c in 0..3 {
                // Each of some dozen vertices adds one rounding of the sum so far.
                assert!((found.mean[c] - f64::from(color[c])).abs() < 1e-5, "{found:?} {color:?}");
            }
        }
    }

    /// All strategies have the same mean; in sight of a large emitter, picking a point of it has another error than hitting it
    /// by chance, and both together are no worse than the worse one.
    #[test]
    fn strategies_agree_within_their_errors() {
        let mut scene = generate::whitted(1).expect("a scene");
        scene.materials[0].emissive = [0.25, 0.5, 0.0];
        scene.lights.clear();
        let base = options(&scene);
        let of = |strategy| estimate(&scene, &base, strategy, [8, 9], 512).expect("a plan").expect("a tree");
        let found = [Strategy::Mis, Strategy::Light, Strategy::Bsdf].map(of);
        for pair in [[0, 1], [0, 2], [1, 2]] {
            let [a, b] = pair.map(|i| found[i]);
            for c in 0..2 {
                // Four standard errors: one of 16,000 such differences is larger.
                let within = 4.0 * a.error[c].hypot(b.error[c]) + 1e-9;
                assert!((a.mean[c] - b.mean[c]).abs() <= within, "{found:?}");
            }
        }
        assert!(found.iter().all(|estimate| estimate.samples == 512 && estimate.mean[1] > 0.0), "{found:?}");
    }

    /// Of n samples of variance s², the standard error is s / √n.
    #[test]
    fn the_standard_error_is_that_of_a_mean() {
        use raystep_kernels::history::light_tree::{Place, Vertex, VertexKind};
        let light = |sample, light: f64| Vertex {
            sample,
            contribution: [light / 4.0; 3],
            ..Vertex::new(VertexKind::Light, Place::Point([0.0; 3]))
        };
        // Samples 1, 3, 0 and 4: mean 2, variance (1 + 1 + 4 + 4) / 3.
        let vertices = vec![light(0, 1.0), light(1, 2.0), light(1, 1.0), light(3, 4.0)];
        let found = of_tree(Strategy::Mis, &LightTree { samples: 4, vertices });
        assert_eq!(found.mean, [2.0; 3]);
        assert!((found.error[0] - (10f64 / 3.0 / 4.0).sqrt()).abs() < 1e-12, "{found:?}");
    }
}
