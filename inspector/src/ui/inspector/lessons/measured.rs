//! Whole runs that a lesson compares.

use std::sync::Arc;

use raystep_kernels::options::mapping::Mapping;
use raystep_kernels::plan::DrawnPlan;
use raystep_kernels::programs::closest_hit::states;
use raystep_kernels::shared::constants::{LIST_GROUPS, LIST_SIDE};
use raystep_kernels::{Choices, Options, Pass, Plan, Progress, Renderer};
use raystep_lab::work::Launch;

use crate::lesson::{Clock, Lesson, Measurement};
use crate::session::request::{Job, JobContext, Request, answered, flow, job};
use crate::settings::Settings;

/// The name of the engine's job.
pub(super) const MEASURING: &str = "measuring a run for the lesson";

/// A measured run.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Measured {
    /// Its name in the lesson.
    pub(super) name: String,
    /// Its options in words.
    pub(super) options: String,
    /// Its passes.
    pub(super) passes: usize,
    /// Whether they ran on a GPU.
    pub(super) is_gpu: bool,
    /// Threads that a GPU launches for them, or fragment programs that it runs.
    pub(super) launched: u64,
    /// Threads with a ray to work on.
    pub(super) useful: u64,
    /// What was drawn, if its kernels are fragment programs.
    pub(super) drawn: Option<Drawn>,
    /// Rays that hit nothing; `None` where that is not known.
    pub(super) misses: Option<u64>,
    /// The time of all passes by the device's clock, if that is valid.
    pub(super) device_ns: Option<u64>,
    /// The same by the host's clock, including the wait for a GPU.
    pub(super) host_ns: Option<u64>,
    /// Why the device's clock is not valid.
    pub(super) why_no_times: Option<String>,
    /// How often it was traced.
    runs: u64,
    /// The lesson that asked for it.
    lesson: Arc<Lesson>,
}

/// What the passes of a run of fragment programs drew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Drawn {
    /// Draws of kernels and of depths.
    pub(super) draws: u64,
    /// Bytes copied between them.
    pub(super) copied: u64,
}

impl Measured {
    /// The request of a measurement; the answer is a `Measured`.
    pub(super) fn request(wanted: &Measurement, lesson: &Arc<Lesson>) -> Request {
        let settings = Settings { counters: false, ..Settings::from(&wanted.link) };
        Request::Job(MEASURING, job(wanted.name.clone(), settings, lesson.clone()))
    }

    /// Whether this lesson asked for it.
    pub(super) fn is_of(&self, lesson: &Arc<Lesson>) -> bool {
        Arc::ptr_eq(&self.lesson, lesson)
    }

    /// Threads launched, or fragments drawn, for all of its runs.
    pub(super) fn work(&self) -> u64 {
        self.launched * self.runs
    }

    /// Its time, by the best valid clock.
    pub(super) fn time(&self) -> Option<(u64, Clock)> {
        let device = self.device_ns.map(|ns| (ns, Clock::Device));
        device.or(self.host_ns.map(|ns| (ns, Clock::Host)))
    }

    /// Useful threads as a part of those launched.
    pub(super) fn share(&self) -> f64 {
        if self.launched == 0 { 0.0 } else { self.useful as f64 / self.launched as f64 }
    }
}

/// Most runs that count; the fastest of them was disturbed least by other work of the machine.
const RUNS: u64 = 3;

/// At least so many runs: one that counts after one that does not.
const LEAST_RUNS: u64 = 2;

/// No run begins after this time: the reader waits.
const ENOUGH_NS: u64 = 300_000_000;

/// Traces the scene once more than that: in the first run, memory is touched and code is loaded for the first time. At
/// least one run counts.
fn job(name: String, settings: Settings, lesson: Arc<Lesson>) -> Job {
    job!(context, {
        let JobContext { scene, device, progress, .. } = context;
        let options = Options { keep_passes: true, ..settings.options(scene) };
        let mut renderer = Renderer::new(scene, &options, &device).await.map_err(|e| e.to_string())?;
        let (mut device_ns, mut host_ns) = (None, None);
        let (mut runs, mut spent_ns) = (0, 0);
        while runs < LEAST_RUNS || runs <= RUNS && spent_ns < ENOUGH_NS {
            renderer.restart();
            // Only runs that nobody waits for are more than the least.
            let of = LEAST_RUNS.max(runs + 1);
            let go_on = |p: &Progress| flow(progress(runs * p.rays + p.rays_decided, of * p.rays));
            renderer.run(go_on).await.map_err(|e| e.to_string())?;
            spent_ns += renderer.host_ns().unwrap_or(0);
            runs += 1;
            if runs > 1 {
                device_ns = least(device_ns, renderer.device_ns());
                host_ns = least(host_ns, renderer.host_ns());
            }
        }
        let (plan, passes) = (renderer.plan(), renderer.passes());
        let why_no_times = match &device {
            raystep_kernels::Device::Gpu(gpu) => gpu.why_no_times(),
            _ => None,
        };
        let measured = Measured {
            name,
            options: options_of(&settings),
            passes: passes.len(),
            is_gpu: device.is_gpu(),
            launched: launched_by(plan, passes),
            useful: passes.iter().map(|pass| useful(plan, pass)).sum(),
            drawn: plan.drawn.as_ref().map(|drawn| drawn_by(plan, drawn, passes)),
            misses: misses(plan, passes),
            device_ns: device_ns.filter(|_| why_no_times.is_none()),
            host_ns,
            why_no_times,
            runs,
            lesson,
        };
        answered(measured)
    })
}

/// The smaller of two times, as far as they are known.
fn least(a: Option<u64>, b: Option<u64>) -> Option<u64> {
    a.into_iter().chain(b).min()
}

/// The options of a run in words.
fn options_of(settings: &Settings) -> String {
    let Choices { accelerator, schedule, mapping, skip, .. } = settings.choices;
    let rules = settings.rules();
    let mapping = if mapping == Mapping::Compute { String::new() } else { format!(", {mapping}") };
    let structure = match accelerator {
        raystep_kernels::Accelerator::None => "no structure".to_owned(),
        other => other.to_string(),
    };
    let skip = if skip == raystep_kernels::Skip::Auto { String::new() } else { format!(", skip {skip}") };
    format!("{structure}, {schedule} schedule{mapping}, {rules}{skip}")
}

/// Draws of the kernel in a pass.
fn draws_of(drawn: &DrawnPlan, pass: &Pass) -> u64 {
    drawn.of(pass.kernel).map_or(0, |kernel| kernel.draws.len() as u64)
}

fn drawn_by(plan: &Plan, drawn: &DrawnPlan, passes: &[Pass]) -> Drawn {
    let of_depths = u64::from(drawn.depths.is_some());
    Drawn {
        draws: passes.iter().map(|pass| draws_of(drawn, pass) + of_depths).sum(),
        copied: passes.iter().map(|pass| drawn.copied_bytes(pass.kernel, plan.size())).sum(),
    }
}

/// Threads that a GPU launches for these passes.
pub(super) fn launched_by(plan: &Plan, passes: &[Pass]) -> u64 {
    passes.iter().map(|pass| launched(plan, pass)).sum()
}

/// Threads or fragments with a ray to work on: each draw of a kernel works on all of its rays.
fn useful(plan: &Plan, pass: &Pass) -> u64 {
    u64::from(pass.rays_in) * plan.drawn.as_ref().map_or(1, |drawn| draws_of(drawn, pass))
}

/// Threads that a GPU launches for a pass, whatever device the pass ran on: whole workgroups that cover the image, or
/// full rows of workgroups that hold the list of rays; or fragments that run a program.
pub(super) fn launched(plan: &Plan, pass: &Pass) -> u64 {
    const LIST: u64 = (LIST_SIDE * LIST_SIDE * LIST_GROUPS) as u64;
    let kernel = pass.kernel;
    if let Some(drawn) = &plan.drawn {
        let (texels, draws) = (plan.size().texels(), draws_of(drawn, pass));
        // A depth test excludes the other fragments, but the depths are drawn in every texel.
        return if drawn.depths.is_some() { texels + draws * u64::from(pass.rays_in) } else { texels * draws };
    }
    if Launch::of(kernel, &plan.features) == Launch::List {
        return u64::from(pass.rays_in).div_ceil(LIST) * LIST;
    }
    match kernel.info().launch {
        raystep_kernels::tables::kernel::Launch::List { .. } => pass.threads_launched,
        _ => {
            [plan.width, plan.height].map(|side| u64::from(side.next_multiple_of(kernel.workgroup()))).iter().product()
        }
    }
}

/// Rays that hit nothing: those that wait for their background before the image is shaded.
pub(super) fn misses(plan: &Plan, passes: &[Pass]) -> Option<u64> {
    let is_known = plan.can_go_alone() && !passes.is_empty();
    let most = passes.iter().map(|pass| u64::from(pass.counts[states::BACKGROUND as usize])).max();
    most.filter(|_| is_known)
}
