//! Where rays diverge: the first pass in which a device differs from its twin, or f32 and f64 disagree.
//!
//! Both comparisons are made one pass at a time. The twins start from the device's own streams before the pass, so that
//! a pass is not blamed for an earlier one. A difference is judged by what f32 can decide, see [`crate::rounding`].

mod fate;
mod map;
mod tree;

use std::ops::ControlFlow;

use raystep_kernels::executor::cpu::CpuExecutor;
use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::programs::closest_hit::streams::{HIT_TRIANGLE, STATE_T};
use raystep_kernels::{Kernel, Pass, Plan, Progress, RenderError, Renderer, Stream, StreamData};

use crate::rounding::{Judged, Rounding, Verdict, judging_bytes};
pub use fate::{Fate, fates};
pub use map::{Against, Class, DivergenceMap, NEVER, Parting};
pub use tree::{APART, Apart, Part};

/// Progress of the comparison, after a pass.
#[derive(Clone, Debug)]
pub struct DivergenceProgress {
    /// The pass.
    pub pass: Pass,
    /// Progress of the run.
    pub run: Progress,
    /// Rays that have diverged so far, by [`Class`].
    pub parted: [u64; Class::ALL.len()],
}

/// Maximum main memory, in bytes, for a comparison: the device's and both twins' streams before and after a pass, the
/// twins themselves, and the map. The device's own memory is in the plan.
#[must_use]
pub fn divergence_bytes(plan: &Plan) -> u64 {
    let components: u64 = plan.streams.iter().map(|s| s.what.layers() as u64).sum();
    // Words of four bytes: before, after, after in f32, after in f64 rounded to f32; then the twins (f64 takes two
    // words).
    let words = (1 + 1 + 2 + 1 + 2) * components;
    let rays = u64::from(plan.width) * u64::from(plan.height);
    rays * (4 * words + map::MOST_BYTES_A_RAY) + judging_bytes(plan)
}

/// Runs `renderer` from start to end and compares every pass with both twins. Use a separate renderer: it is restarted,
/// and left at its end. On the CPU there is no device to compare, but f32 and f64 still are.
///
/// `progress` is called after every pass and may stop the comparison.
///
/// # Errors
/// If the device fails, there is not enough memory (see [`divergence_bytes`]), or `progress` stopped it.
pub async fn divergence(
    renderer: &mut Renderer,
    mut progress: impl FnMut(&DivergenceProgress) -> ControlFlow<()>,
) -> Result<DivergenceMap, RenderError> {
    renderer.restart();
    let is_gpu = renderer.gpu().is_some();
    // The interpreter rounds as the twins do: there, a ray has no reason to take another path.
    let may_round = is_gpu || renderer.cpu_f64().is_some();
    let plan = renderer.shared_plan();
    // A user's kernel is compared with the one that it replaces.
    let own = plan.with_own_kernels()?;
    let mut single = CpuExecutor::<f32>::new(&own, None)?;
    let mut double = CpuExecutor::<f64>::new(&own, None)?;
    let mut map = DivergenceMap::new(&plan);
    let streams: Vec<Stream> = plan.streams.iter().map(|s| s.what).collect();
    let mut before = Vec::new();
    for stream in streams {
        let values = renderer.values(stream).await?;
        single.write(&values);
        double.write(&values);
        before.push(values);
    }
    while let Some(pass) = renderer.step().await? {
        single.run(pass.call(), renderer.data())?;
        double.run(pass.call(), renderer.data())?;
        map.begin(pass.kernel);
        let mut after = Vec::new();
        for stream in written(&plan, pass.kernel) {
            let Some(twin) = single.read(stream) else { continue };
            let decides = (0..stream.layers()).any(|layer| is_decision(stream, layer));
            let in_f64 = if decides { double.read(stream) } else { None };
            after.push((renderer.values(stream).await?, twin, in_f64));
        }
        let rules = Rounding { plan: &own, data: renderer.data(), kernel: pass.kernel, before: &before };
        if is_gpu || !plan.replaced().is_empty() {
            let pairs: Vec<_> = after.iter().map(|(device, twin, _)| [device, twin]).collect();
            rules.judge(
                &pairs,
                |_, _| true,
                |judged| {
                    let is_wrong = judged.verdict == Verdict::Tie && !may_round;
                    let verdict = if is_wrong { Verdict::Breach } else { judged.verdict };
                    map.record(Against::Device, &Judged { verdict, ..judged });
                },
            )?;
        }
        let pairs: Vec<_> = after.iter().filter_map(|(_, twin, in_f64)| Some([in_f64.as_ref()?, twin])).collect();
        rules.judge(&pairs, is_decision, |judged| map.record(Against::F64, &judged))?;
        map.check_memory()?;
        for (values, twin, _) in after {
            // Most streams are equal, which is quick to find out.
            if values != twin {
                single.write(&values);
            }
            double.write(&values);
            replace(&mut before, values);
        }
        let now = DivergenceProgress { pass, run: renderer.progress(), parted: map.counts() };
        if progress(&now).is_break() && renderer.next_kernel().is_some() {
            return Err(RenderError::Cancelled { passes: renderer.pass_count() });
        }
    }
    Ok(map)
}

/// The streams that a pass may have changed.
fn written(plan: &Plan, kernel: Kernel) -> Vec<Stream> {
    let variant = plan.variant(kernel).into_iter();
    variant.flat_map(|v| v.streams()).filter(|(_, binding)| binding.writes).map(|(stream, _)| stream).collect()
}

/// Whether a component determines a ray's path: its state, its cell or node, its position in a list, its triangle.
fn is_decision(stream: Stream, layer: usize) -> bool {
    (stream == streams::STATE && layer != STATE_T)
        || (stream == streams::HIT && layer == HIT_TRIANGLE)
        || stream == streams::PREVIOUS
}

fn replace(before: &mut [StreamData], values: StreamData) {
    if let Some(old) = before.iter_mut().find(|s| s.stream == values.stream) {
        *old = values;
    }
}

#[cfg(test)]
mod tests {
    use raystep_kernels::{Accelerator, Device, Options, RaySource};
    use raystep_scenes::generate;

    use super::*;
    use crate::configuration::Configuration;
    use crate::stability::{CASES, configurations};

    fn compared(scene: &raystep_scenes::Scene, options: &Options, device: &Device) -> DivergenceMap {
        pollster::block_on(async {
            let mut renderer = Renderer::new(scene, options, device).await.expect("a renderer");
            divergence(&mut renderer, |_| ControlFlow::Continue(())).await.expect("a run")
        })
    }

    fn of_case(name: &str, one: Configuration, rays: usize) -> DivergenceMap {
        let case = CASES.iter().find(|c| c.name == name).expect("a case");
        let workload = (case.make)(rays).expect("its rays");
        let one = Configuration { steps: 1, ..one };
        let options = one.of(&Options { shade: false, ..Options::new(workload.rays) });
        compared(&workload.scene, &options, &Device::Cpu(None))
    }

    #[test]
    fn rays_at_edges_are_ties_and_nothing_else() {
        for accelerator in [Accelerator::Grid, Accelerator::Bvh] {
            let robust = configurations(accelerator)[0];
            let map = of_case("edges", robust, 400);
            let ties = map.count(Class::Tie);
            assert!(ties > 40, "{accelerator}: {ties} of 400 rays at edges");
            assert_eq!(map.counts().iter().sum::<u64>(), ties, "{accelerator}: {:?}", map.counts());
            let ray = map.rays(Class::Tie).next().expect("a tie");
            let parting = map.first(Class::Tie, ray).expect("a tie");
            assert_eq!((parting.against, parting.ulps), (Against::F64, None));
            assert_eq!(map.class(ray), Some(Class::Tie));
            // Rays well inside triangles have almost none.
            let inside = of_case("inside", robust, 400);
            assert!(inside.counts().iter().sum::<u64>() <= 4, "{accelerator}: {:?}", inside.counts());
        }
    }

    #[test]
    fn a_comparison_says_how_far_it_is_and_stops_between_passes() {
        let scene = generate::cornell_box();
        let camera = scene.cameras[0].clone();
        let options = Options::new(RaySource::Camera { camera, width: 12, height: 9 });
        pollster::block_on(async {
            let mut renderer = Renderer::new(&scene, &options, &Device::Cpu(None)).await.expect("a renderer");
            let mut passes = Vec::new();
            let stopped = divergence(&mut renderer, |now| {
                passes.push(now.pass.index);
                if passes.len() == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            });
            assert!(matches!(stopped.await, Err(RenderError::Cancelled { passes: 2 })));
            assert_eq!(passes, [0, 1]);
            // The next run does not depend on where this one stopped.
            let map = divergence(&mut renderer, |_| ControlFlow::Continue(())).await.expect("a run");
            assert_eq!(map.kernels().len(), renderer.pass_count());
            assert!(renderer.next_kernel().is_none());
            assert_eq!((map.width(), map.height()), (12, 9));
            // origin, direction, state, hit, colour; seven words per component.
            let components = if renderer.plan().has_stream(streams::TMAX) { 19 } else { 16 };
            let bytes = divergence_bytes(renderer.plan()) / (12 * 9);
            assert_eq!(bytes, 4 * 7 * components + 70 + 8 + 4 * (3 * components + 3));
        });
    }
}
