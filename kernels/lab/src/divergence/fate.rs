//! What one pass decides in f64, from the same streams as in f32.

use std::sync::Arc;

use raystep_kernels::executor::cpu::{CpuError, CpuExecutor};
use raystep_kernels::program::schedule::Call;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::{Plan, StreamData};

use super::{is_decision, written};

/// How a ray differs after a pass in f64; later ones are more serious.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Fate {
    /// At most in the digits of floats.
    #[default]
    Same,
    /// In its state, its cell or node, or its position in a list; its hit is the same so far.
    Path,
    /// In the triangle that it hits.
    Hit,
}

/// Runs a pass in f32 and in f64 on the CPU and compares each ray. `before` has the streams that its kernel reads.
/// `None` for a program whose rays hit nothing.
///
/// # Errors
/// If there is not enough memory.
pub fn fates(
    plan: &Arc<Plan>,
    data: &SceneData,
    call: Call,
    before: &[StreamData],
) -> Result<Option<Vec<Fate>>, CpuError> {
    let triangle = plan.program.results.map(|results| results.triangle);
    let Some(triangle) = triangle.filter(|triangle| plan.has_stream(triangle.stream)) else { return Ok(None) };
    let (mut single, mut double) = (CpuExecutor::<f32>::new(plan, None)?, CpuExecutor::<f64>::new(plan, None)?);
    for values in before {
        single.write(values);
        double.write(values);
    }
    single.run(call, data)?;
    double.run(call, data)?;
    let mut fates = vec![Fate::Same; plan.rays as usize];
    for stream in written(plan, call.kernel) {
        for layer in (0..stream.layers()).filter(|&layer| is_decision(stream, layer)) {
            let is_hit = (stream, layer) == (triangle.stream, triangle.layer);
            let other = if is_hit { Fate::Hit } else { Fate::Path };
            let Some((ours, wide)) = single.read(stream).zip(double.read(stream)) else { continue };
            for (ray, fate) in fates.iter_mut().enumerate() {
                if ours.get(layer, ray) != wide.get(layer, ray) {
                    *fate = (*fate).max(other);
                }
            }
        }
    }
    Ok(Some(fates))
}

#[cfg(test)]
mod tests {
    use raystep_kernels::{Accelerator, Device, Options, Renderer};

    use super::*;
    use crate::divergence::{Against, Class, divergence};
    use crate::stability::{CASES, configurations};

    /// How many rays end their pass in each way; a ray's first difference is where the map of differences has it.
    fn seen(case: &str, accelerator: Accelerator) -> [usize; 3] {
        let case = CASES.iter().find(|known| known.name == case).expect("a case");
        let workload = (case.make)(200).expect("its rays");
        let one = configurations(accelerator)[0];
        let options = one.of(&Options { shade: false, ..Options::new(workload.rays) });
        let mut seen = [0; 3];
        pollster::block_on(async {
            let mut renderer = Renderer::new(&workload.scene, &options, &Device::Cpu(None)).await.expect("a renderer");
            let map = divergence(&mut renderer, |_| std::ops::ControlFlow::Continue(())).await.expect("a map");
            renderer.restart();
            let plan = renderer.shared_plan();
            let mut first = vec![None; plan.rays as usize];
            loop {
                let mut before = Vec::new();
                for stream in &plan.streams {
                    before.push(renderer.values(stream.what).await.expect("values"));
                }
                let Some(pass) = renderer.step().await.expect("a pass") else { break };
                let found = fates(&plan, renderer.data(), pass.call(), &before).expect("a pass").expect("hits");
                for (ray, fate) in found.into_iter().enumerate() {
                    seen[fate as usize] += 1;
                    if fate != Fate::Same && first[ray].is_none() {
                        first[ray] = Some(pass.index);
                    }
                }
            }
            for (ray, pass) in first.into_iter().enumerate() {
                let of = |class| map.first(class, ray).filter(|parting| parting.against == Against::F64);
                let expected = [Class::Tie, Class::Precision].into_iter().filter_map(of).map(|p| p.pass).min();
                assert_eq!(pass, expected, "{}: ray {ray}", case.name);
            }
        });
        seen
    }

    #[test]
    fn a_ray_whose_pass_ends_otherwise_in_f64_is_one_that_diverges_there() {
        for (case, fate) in [("edges", Fate::Hit), ("cell-corners", Fate::Path)] {
            let seen = seen(case, Accelerator::Grid);
            assert!(seen[fate as usize] > 0 && seen[Fate::Same as usize] > 0, "{case}: {seen:?}");
        }
    }
}
