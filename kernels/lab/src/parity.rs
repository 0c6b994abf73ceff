//! One-step parity: the twin starts from the GPU's streams before a pass, and both must agree after it.

use std::collections::BTreeSet;
use std::fmt;
use std::sync::Arc;

use raystep_kernels::executor::cpu::{CpuError, CpuExecutor};
use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::tables::kernel::Role;
use raystep_kernels::tables::state::{StateCounts, Tag};
use raystep_kernels::tables::stream::STATE_TAG;
use raystep_kernels::{
    Device, Gpu, Kernel, Limits, Options, Pass, Plan, PlanError, RenderError, Renderer, Stream, StreamData,
};
use raystep_scenes::Scene;

use crate::compared::{Compared, Sums};
use crate::rounding::{Rounding, Verdict};

/// A component that differs by more than is allowed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Breach {
    /// The kernel after which it differs.
    pub kernel: Kernel,
    /// Pass of the run.
    pub pass: usize,
    /// Stream and layer.
    pub component: (Stream, usize),
    /// The ray's index, y * width + x.
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
            write!(f, "gpu {:e}, CPU reference {:e}", f32::from_bits(self.gpu), f32::from_bits(self.twin))
        } else {
            write!(f, "gpu {}, CPU reference {}", self.gpu, self.twin)
        }
    }
}

/// Recorded numbers of rays in each state that are not those of the tags.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Miscount {
    /// The kernel that counted: that of the pass, or the one that counts after it.
    pub kernel: Kernel,
    /// The pass.
    pub pass: usize,
    /// As recorded.
    pub counted: StateCounts,
    /// The rays in each state, by their tags.
    pub found: StateCounts,
}

impl fmt::Display for Miscount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kernel, pass, counted, found } = self;
        write!(f, "{} (pass {pass}): counted {counted:?}, found {found:?}", kernel.name())
    }
}

/// The result of a comparison.
#[derive(Clone, Debug, Default)]
pub struct Parity {
    /// What was compared of each kernel. The one that counts rays is compared by its counts.
    pub compared: Compared,
    /// Every transition between states that was observed.
    pub transitions: BTreeSet<(Tag, Kernel, Tag)>,
    /// Components that differ by more than is allowed, at most 20 per kernel.
    pub breaches: Vec<Breach>,
    /// Passes after which the recorded numbers of rays in each state are wrong.
    pub miscounts: Vec<Miscount>,
    /// The streams before the first pass after which anything was wrong.
    pub before: Vec<StreamData>,
}

/// Why a comparison failed.
#[derive(Debug, thiserror::Error)]
pub enum ParityError {
    /// The scene could not be planned.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The device failed.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The device failed in a pass.
    #[error("in a pass of {}: {error}", kernel.name())]
    Pass {
        /// The kernel of the pass.
        kernel: Kernel,
        /// How it failed.
        error: RenderError,
    },
    /// The twin cannot run.
    #[error(transparent)]
    Twin(#[from] CpuError),
    /// The executors do not have the same streams; the name of one that differs.
    #[error("stream {0}: device and CPU reference do not both have it in the same size")]
    Unlike(&'static str),
}

impl Parity {
    /// Whether anything differs by more than is allowed.
    #[must_use]
    pub fn is_broken(&self) -> bool {
        !self.breaches.is_empty() || !self.miscounts.is_empty()
    }
}

/// Runs a scene on the GPU and compares every pass with the twin, until `is_enough`. `change` may modify the plan
/// first: a deliberately broken plan shows that the comparison can fail.
///
/// # Errors
/// If the scene cannot be planned or traced, or there is not enough memory.
pub async fn compare(
    gpu: &Arc<Gpu>,
    scene: &Scene,
    options: &Options,
    limits: &Limits,
    change: impl FnOnce(&mut Plan),
    is_enough: impl Fn(&Parity) -> bool,
) -> Result<Parity, ParityError> {
    let (mut plan, data) = Plan::new(scene, options, limits)?;
    change(&mut plan);
    compare_plan(&Device::Gpu(gpu.clone()), plan, data, options, true, is_enough).await
}

/// Streams that keep their initial values.
const KEPT: [Stream; 9] = [
    streams::STATE,
    streams::ACCUMULATED,
    streams::BLOCKS,
    streams::SCAN,
    streams::BOUNCE,
    streams::PDF,
    streams::PHOTON_BOUNCE,
    streams::GATHERING,
    streams::SHRUNK,
];

/// As [`compare`], on any device, for a plan that is made already. Users' kernels are compared with those that they replace;
/// the interpreter rounds as the CPU reference kernels do, so there a ray need not go another way by rounding alone, which
/// `has_ties` allows; floats may be off by its bound.
///
/// # Errors
/// If the device fails, or there is not enough memory.
pub async fn compare_plan(
    device: &Device,
    plan: Plan,
    data: SceneData,
    options: &Options,
    has_ties: bool,
    is_enough: impl Fn(&Parity) -> bool,
) -> Result<Parity, ParityError> {
    let mut renderer = Renderer::from_plan(plan, data, options, device).await?;
    let plan = renderer.shared_plan();
    let streams: Vec<Stream> = plan.streams.iter().map(|s| s.what).collect();
    let own = plan.with_own_kernels()?;
    let mut twin = CpuExecutor::<f32>::new(&own, None).map_err(CpuError::from)?;
    let mut found = Parity::default();

    // Values that no kernel writes stay poisoned on both sides, so that reading one has a visible effect.
    let makes_rays =
        renderer.next_kernel().is_some_and(|kernel| kernel.role() == Role::Source) || plan.features.eye_rays;
    let (mut before, kernels) = (Vec::new(), plan.schedule.kernels());
    for &stream in &streams {
        let mut values = renderer.values(stream).await?;
        // Some streams must keep their initial values: which kernel is next, the number of samples, the sum of no blocks of
        // samples, that no search has begun, that no ray was reflected, and how often photons were emitted and gathered.
        let keeps = |own: Stream| kernels.iter().any(|kernel| kernel.stream(own) == Some(stream));
        let is_kept = KEPT.into_iter().any(keeps);
        if makes_rays && !is_kept {
            values.bits.fill(0x7fc0_dead);
            in_both(renderer.write(&values), stream)?;
        }
        before.push(values);
    }
    while !is_enough(&found) {
        before.iter().try_for_each(|values| in_both(twin.write(values), values.stream))?;
        let Some(kernel) = renderer.next_kernel() else { break };
        let given_up = renderer.unfinished();
        let Some(pass) = renderer.step().await.map_err(|error| ParityError::Pass { kernel, error })? else { break };
        if renderer.unfinished() > given_up && plan.has_more_walks() {
            // The host has ended walks before the pass.
            let course = plan.program.course();
            for values in before.iter_mut().filter(|values| course.is_some_and(|course| course.stream == values.stream))
            {
                course.into_iter().for_each(|course| _ = course.give_up_walks(plan.program.states, values));
                in_both(twin.write(values), values.stream)?;
            }
        }
        twin.run(pass.call(), renderer.data())?;
        let mut after = Vec::new();
        for &stream in &streams {
            let of_twin = twin.read(stream).ok_or(ParityError::Unlike(stream.name()))?;
            after.push((renderer.values(stream).await?, of_twin));
        }
        let (data, kernel) = (renderer.data(), pass.kernel);
        let rules = Rounding { plan: &own, data, kernel, before: &before };
        record(&mut found, &pass, &rules, &after, has_ties)?;
        if found.is_broken() && found.before.is_empty() {
            found.before = std::mem::take(&mut before);
        }
        before = after.into_iter().map(|(on_gpu, _)| on_gpu).collect();
    }
    Ok(found)
}

fn in_both(is_written: bool, stream: Stream) -> Result<(), ParityError> {
    is_written.then_some(()).ok_or(ParityError::Unlike(stream.name()))
}

/// `has_ties` says whether a ray may go another way by rounding alone.
fn record(
    found: &mut Parity,
    pass: &Pass,
    rules: &Rounding<'_>,
    after: &[(StreamData, StreamData)],
    has_ties: bool,
) -> Result<(), CpuError> {
    let program = pass.kernel.program();
    let course = pass.kernel.course();
    // For a kernel that generates its rays itself, they are unwritten before.
    let makes = rules.data.features.eye_rays && pass.kernel.role() == Role::Whole;
    let unborn = course.filter(|_| makes).map(|course| course.unborn);
    let is_own = |s: &&StreamData| course.is_some_and(|course| course.stream == s.stream);
    let tags = after.iter().map(|(s, _)| s).find(is_own).map(|s| s.layer(STATE_TAG)).unwrap_or_default();
    let tags_before = rules.before.iter().find(is_own).map(|s| s.layer(STATE_TAG)).unwrap_or_default();
    let mut counts = pass.counts.clone();
    counts.clear(course.into_iter().flat_map(|course| program.states_of(course)));
    for (ray, &tag) in tags.iter().enumerate() {
        counts.add(tag, 1);
        let before = tags_before.get(ray).copied().unwrap_or_default();
        if pass.kernel.takes().contains(&before) || unborn == Some(before) {
            found.transitions.insert((before, pass.kernel, tag));
        }
    }
    // A fragment cannot count.
    let is_recounted = pass.kernel.is_counted_anew(&rules.plan.features) || rules.plan.drawn.is_some();
    let is_counter =
        |kernel: &Kernel| kernel.role() == Role::Count && kernel.instance().over == pass.kernel.instance().over;
    let counter = program.kernels().find(|kernel| is_recounted && is_counter(kernel));
    if let Some(counter) = counter {
        found.compared.add(counter, Sums { passes: 1, components: counts.len() as u64, ..Sums::default() });
    }
    if counts != pass.counts {
        let (kernel, pass, counted) = (counter.unwrap_or(pass.kernel), pass.index, pass.counts.clone());
        found.miscounts.push(Miscount { kernel, pass, counted, found: counts });
    }
    let rays = u64::from(pass.rays_in);
    let mut sums = Sums {
        passes: 1,
        components: after.iter().map(|(on_gpu, _)| on_gpu.bits.len() as u64).sum(),
        rays,
        rays_in_parts: if rules.plan.features.turns > 0 { rays } else { 0 },
        ..Sums::default()
    };
    let pairs: Vec<_> = after.iter().map(|(on_gpu, on_cpu)| [on_gpu, on_cpu]).collect();
    let judged = rules.judge(
        &pairs,
        |_, _| true,
        |judged| {
            sums.tolerated += judged.components.iter().filter(|c| c.is_allowed).count() as u64;
            sums.undecided += u64::from(judged.verdict == Verdict::Tie && has_ties);
            if judged.verdict == Verdict::Rounding || judged.verdict == Verdict::Tie && has_ties {
                return;
            }
            for c in judged.components.iter().filter(|c| !c.is_allowed) {
                let component = (c.stream, c.layer);
                let (kernel, pass, ray) = (pass.kernel, pass.index, judged.ray);
                if found.breaches.iter().filter(|b| b.kernel == kernel).count() < 20 {
                    found.breaches.push(Breach { kernel, pass, component, ray, gpu: c.ours, twin: c.twin });
                }
            }
        },
    );
    found.compared.add(pass.kernel, sums);
    judged
}
