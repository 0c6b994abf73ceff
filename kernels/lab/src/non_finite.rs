//! The first value of a run that is infinite or not a number: the pass and the ray, and the line of the kernel that made it.

use std::ops::ControlFlow;

use raystep_kernels::interpret::{Element, InterpretError, Interpreter, NonFinite};
use raystep_kernels::{Kernel, Progress, RenderError, Renderer, Stream, StreamData};

use crate::text::counted;

/// The first such value.
#[derive(Clone, Debug, PartialEq)]
pub struct First {
    /// The pass after which it is in a stream.
    pub pass: usize,
    /// The pass's kernel.
    pub kernel: Kernel,
    /// The pixel of the first such ray in reading order.
    pub pixel: [u32; 2],
    /// Number of rays for which it is the first pass, too.
    pub rays: u64,
    /// The component.
    pub stream: Stream,
    /// Its layer.
    pub layer: usize,
    /// Its value.
    pub value: f32,
    /// How it came about, from the kernel's WGSL; or why that is not known.
    pub cause: Result<NonFinite, String>,
}

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Rays that were examined.
    pub rays: u64,
    /// Passes that were examined.
    pub passes: usize,
    /// The first value; `None` if all are finite.
    pub first: Option<First>,
}

impl Found {
    /// In a sentence or two.
    #[must_use]
    pub fn sentence(&self) -> String {
        let Some(First { pass, kernel, pixel: [x, y], rays, stream, layer, value, cause }) = &self.first else {
            let (rays, passes) = (counted(self.rays, "pixel"), counted(self.passes, "pass"));
            return format!("NaN or Inf: none in {rays}, {passes}.");
        };
        let others = match rays - 1 {
            0 => String::new(),
            others => format!(" and {}", counted(others, "other pixel")),
        };
        let what = match cause {
            Ok(cause) => cause.sentence(),
            Err(why) => format!("{}.{} becomes {value} ({why})", stream.name(), stream.info().layers[*layer]),
        };
        format!("NaN or Inf: first in pass {pass}, {}, pixel {x},{y}{others}: {what}.", kernel.name())
    }
}

/// Examines all streams of floats after every pass, up to the first value that is not finite. Use a separate renderer: it is
/// restarted. `progress` is called after every pass and may stop it.
///
/// # Errors
/// If the device fails, or `progress` stopped it.
pub async fn non_finite(
    renderer: &mut Renderer,
    mut progress: impl FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Found, RenderError> {
    renderer.restart();
    let plan = renderer.shared_plan();
    let rays = plan.rays;
    let has_floats = |stream: &Stream| (0..stream.layers()).any(|layer| stream.is_float_layer(layer));
    while let Some(pass) = renderer.step().await? {
        let written = plan.variant(pass.kernel).into_iter().flat_map(|variant| variant.written_streams());
        let mut first: Option<(usize, Stream, usize, f32)> = None;
        let mut bad = vec![false; rays as usize];
        for stream in written.filter(has_floats) {
            let values = renderer.values(stream).await?;
            for (ray, layer, value) in bad_values(&values) {
                let Some(is_bad) = bad.get_mut(ray) else { continue };
                *is_bad = true;
                if first.is_none_or(|(earlier, ..)| ray < earlier) {
                    first = Some((ray, stream, layer, value));
                }
            }
        }
        if let Some((ray, stream, layer, value)) = first {
            let width = plan.width.max(1) as usize;
            let pixel = [(ray % width) as u32, (ray / width) as u32];
            let cause = cause(renderer, pass.index, pass.kernel, pixel).await?;
            let rays_of_pass = bad.iter().filter(|&&is_bad| is_bad).count() as u64;
            let first =
                First { pass: pass.index, kernel: pass.kernel, pixel, rays: rays_of_pass, stream, layer, value, cause };
            return Ok(Found { rays, passes: pass.index + 1, first: Some(first) });
        }
        if progress(&renderer.progress()).is_break() && renderer.next_kernel().is_some() {
            return Err(RenderError::Cancelled { passes: renderer.pass_count() });
        }
    }
    Ok(Found { rays, passes: renderer.pass_count(), first: None })
}

/// The floats that are not finite: ray, layer, value.
fn bad_values(values: &StreamData) -> impl Iterator<Item = (usize, usize, f32)> + '_ {
    let layers = (0..values.stream.layers()).filter(|&layer| values.stream.is_float_layer(layer));
    layers.flat_map(|layer| {
        let floats = values.layer(layer).iter().map(|&bits| f32::from_bits(bits)).enumerate();
        floats.filter(|(_, value)| !value.is_finite()).map(move |(ray, value)| (ray, layer, value))
    })
}

/// Interprets the pass for the ray, from its streams before.
async fn cause(
    renderer: &mut Renderer,
    pass: usize,
    kernel: Kernel,
    [x, y]: [u32; 2],
) -> Result<Result<NonFinite, String>, RenderError> {
    let (plan, data) = (renderer.shared_plan(), renderer.shared_data());
    let made = plan.variant(kernel).ok_or(InterpretError::NotAlone(kernel.name())).and_then(Interpreter::new);
    let interpreter = match made {
        Ok(interpreter) => interpreter,
        Err(why) => return Ok(Err(why.to_string())),
    };
    renderer.restart();
    renderer.run_to(pass, |_| ControlFlow::Continue(())).await?;
    let mut texels = renderer.texels(interpreter.streams(), x, y).await?.concat();
    let element = Element { texel: [x, y], size: [plan.width, plan.height] };
    Ok(match interpreter.record(&data, element, &mut texels) {
        Ok(recording) => {
            recording.non_finite.ok_or_else(|| "only on this device: it is finite in f32 on the CPU".into())
        }
        Err(why) => Err(why.to_string()),
    })
}

#[cfg(test)]
mod tests {
    use raystep_kernels::options::{Integrator, Strategy};
    use raystep_kernels::{Accelerator, Device, Options, RaySource, ScheduleKind};
    use raystep_scenes::{Scene, generate};

    use super::*;

    fn found(glow: f32, schedule: ScheduleKind) -> Found {
        let mut scene: Scene = generate::cornell_box();
        scene.materials.iter_mut().for_each(|material| material.emissive = [glow, 0.0, 0.0]);
        let rays = RaySource::Camera { camera: scene.cameras[0].clone(), width: 8, height: 8 };
        let base = Options::new(rays);
        let options = Options {
            integrator: Integrator::Path,
            strategy: Strategy::Bsdf,
            accelerator: Accelerator::Bvh,
            schedule,
            ..base
        };
        pollster::block_on(async {
            let mut renderer = Renderer::new(&scene, &options, &Device::Cpu(None)).await.expect("a renderer");
            non_finite(&mut renderer, |_| ControlFlow::Continue(())).await.expect("a run")
        })
    }

    #[test]
    fn a_run_whose_values_are_finite_says_so() {
        let found = found(1.0, ScheduleKind::Compact);
        assert_eq!(found.first, None);
        assert!(found.passes > 20, "{found:?}");
        assert_eq!(found.sentence(), format!("NaN or Inf: none in 64 pixels, {} passes.", found.passes));
    }

    /// Two surfaces of 3e38 are more than a float holds.
    #[test]
    fn a_sum_that_overflows_is_found_with_its_line_and_operands() {
        for schedule in [ScheduleKind::Compact, ScheduleKind::Fused] {
            let found = found(3e38, schedule);
            let first = found.first.as_ref().expect("an overflow");
            let cause = first.cause.as_ref().expect("its cause");
            assert_eq!((first.stream, first.layer, first.value), (cause.stream, cause.layer, cause.value));
            let sum_of = if schedule == ScheduleKind::Fused { "color" } else { "radiance" };
            assert_eq!((first.stream.name(), first.layer, first.value), (sum_of, 0, f32::INFINITY));
            assert!(first.rays > 1 && first.rays <= 64, "{first:?}");
            let operation = cause.operation.as_ref().expect("an operation");
            assert!(operation.operands.iter().all(|(_, value)| value.is_finite()), "{operation:?}");
            let sum: f32 = operation.operands.iter().map(|(_, value)| value).sum();
            assert_eq!(sum, f32::INFINITY, "{operation:?}");
            let sentence = found.sentence();
            assert!(
                sentence.contains(", sum += emitted(at, ") && sentence.contains("), gives inf from sum = 3e38, "),
                "{sentence}"
            );
        }
    }
}
