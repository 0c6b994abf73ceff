//! One-step parity: the twin starts from the GPU's streams before a pass, and both must agree after it.

use std::fmt;
use std::sync::Arc;

use raystep_kernels::executor::cpu::CpuExecutor;
use raystep_kernels::{Device, Gpu, Kernel, Limits, Options, Plan, Renderer, Stream, StreamData};
use raystep_scenes::Scene;

use crate::{block_on, differences, streams_of, ulp};

/// What may differ between the GPU and the twin after one kernel, in units in the last place: the sum of
/// what WGSL allows the operations that the value goes through.
///
/// * tmax: a division (2.5) and a product: 4.
/// * t, u, v: two divisions for the shear, products and sums of those, and one for the determinant; the
///   sums cancel where the ray is near an edge, so the bound is absolute: see [`within`].
/// * color: square roots, whose error WGSL bounds by that of an inverse square root and a division.
///
/// Integers, and what is only copied, must be equal.
fn within(stream: Stream, layer: usize, a: u32, b: u32) -> bool {
    let (x, y) = (f32::from_bits(a), f32::from_bits(b));
    match (stream, layer) {
        (Stream::TMax, _) => ulp(a, b) <= 4,
        // u and v are weights in [0, 1].
        (Stream::Hit, 0 | 1) => (x - y).abs() <= 16.0 * f32::EPSILON,
        (Stream::State, 1) => (x - y).abs() <= 16.0 * f32::EPSILON * x.abs().max(y.abs()).max(1.0),
        (Stream::Color, _) => (x - y).abs() <= 64.0 * f32::EPSILON * x.abs().max(y.abs()).max(1.0),
        _ => false,
    }
}

/// A component that differs by more than it may.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Breach {
    /// The kernel after which it differs.
    pub kernel: Kernel,
    /// Pass of the run.
    pub pass: usize,
    /// Stream and layer.
    pub component: (Stream, usize),
    /// The ray's place, y * width + x.
    pub ray: usize,
    /// The GPU's bits.
    pub gpu: u32,
    /// The twin's bits.
    pub twin: u32,
}

impl fmt::Display for Breach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (stream, layer) = self.component;
        write!(f, "{} (pass {}): ", self.kernel.name(), self.pass)?;
        write!(f, "ray {} {}.{}: ", self.ray, stream.name(), stream.info().layers[layer])?;
        if stream.is_float_layer(layer) {
            write!(f, "gpu {:e}, twin {:e}", f32::from_bits(self.gpu), f32::from_bits(self.twin))
        } else {
            write!(f, "gpu {}, twin {}", self.gpu, self.twin)
        }
    }
}

/// What a comparison found.
#[derive(Clone, Debug, Default)]
pub struct Parity {
    /// Passes compared.
    pub passes: usize,
    /// Components compared.
    pub components: u64,
    /// Components that differ, but by no more than they may.
    pub tolerated: u64,
    /// Kernels that were compared on at least one ray.
    pub kernels: Vec<Kernel>,
    /// What differs by more, at most 20.
    pub breaches: Vec<Breach>,
}

/// Runs a scene on the GPU and compares every pass with the twin.
#[must_use]
pub fn compare(gpu: &Arc<Gpu>, scene: &Scene, options: &Options) -> Parity {
    compare_with(gpu, scene, options, |_| {})
}

/// The same after `change` had its way with the plan: a comparison that cannot fail proves nothing.
#[must_use]
pub fn compare_with(gpu: &Arc<Gpu>, scene: &Scene, options: &Options, change: impl FnOnce(&mut Plan)) -> Parity {
    block_on(Some(gpu), async {
        let device = Device::Gpu(gpu.clone());
        let limits = Limits::from(&gpu.device.limits());
        let (mut plan, data) = Plan::new(scene, options, &limits).expect("a plan");
        change(&mut plan);
        let mut renderer = Renderer::from_plan(plan, data, options, &device).await.expect("a renderer");
        let streams = streams_of(renderer.plan());
        let mut twin = CpuExecutor::<f32>::new(renderer.plan(), None);
        let mut found = Parity::default();

        // What no kernel writes keeps the poison on both sides and shows where it should not.
        let generates = renderer.next_kernel() == Some(Kernel::Generate);
        for &stream in streams.iter().filter(|&&s| generates && s != Stream::State) {
            let mut poison = renderer.values(stream).await.expect("values");
            poison.bits.fill(0x7fc0_dead);
            assert!(renderer.write(&poison));
        }
        loop {
            for &stream in &streams {
                assert!(twin.write(&renderer.values(stream).await.expect("values")));
            }
            let Some(pass) = renderer.step().await.expect("a pass") else { break };
            twin.run(pass.kernel, renderer.data());
            found.passes += 1;
            if pass.rays_in > 0 && !found.kernels.contains(&pass.kernel) {
                found.kernels.push(pass.kernel);
            }
            for &stream in &streams {
                let on_gpu = renderer.values(stream).await.expect("values");
                let on_cpu = twin.read(stream).expect("the same plan");
                record(&mut found, pass.kernel, pass.index, &on_gpu, &on_cpu);
            }
        }
        found
    })
}

fn record(found: &mut Parity, kernel: Kernel, pass: usize, on_gpu: &StreamData, on_cpu: &StreamData) {
    found.components += on_gpu.bits.len() as u64;
    for (layer, ray, gpu, twin) in differences(on_gpu, on_cpu) {
        if within(on_gpu.stream, layer, gpu, twin) {
            found.tolerated += 1;
        } else if found.breaches.len() < 20 {
            found.breaches.push(Breach { kernel, pass, component: (on_gpu.stream, layer), ray, gpu, twin });
        }
    }
}
