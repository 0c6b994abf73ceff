//! Builds configurations: everything that is done before they are timed.

use std::time::{Duration, Instant};

use raystep_kernels::export::csv::{DrawnPart, RunContext};
use raystep_kernels::export::json::{CounterSums, hit_count};
use raystep_kernels::export::structure::{Structure, structure_bytes};
use raystep_kernels::options::Integrator;
use raystep_kernels::options::rows::ROWS;
use raystep_kernels::plan::Plan;
use raystep_kernels::{Accelerator, Choices, Keep, Numerics, Options, RaySource, RenderError, Renderer, ScheduleKind};

use super::summary::THIS;
use super::{Details, SCHEMA_VERSION, SummaryRow, Wanted, useful_steps_per_thread};
use crate::configuration::Configuration;
use crate::meter::{Ended, Meter};
use crate::outside::{MISSES_ALL, misses_all};
use crate::subject::{Size, Subject};
use crate::work::Cast;
use crate::{Error, Hash, Machine};

/// Configurations to compare: they trace the same rays.
#[derive(Clone)]
pub(super) struct Group<'a> {
    /// For display.
    pub(super) name: String,
    pub(super) subject: &'a Subject,
    /// Size of the image that the rays are from; `None` if they are from a file.
    pub(super) size: Option<Size>,
    /// Kind of rays.
    pub(super) kind: String,
    /// Whether rays end at any hit with t < 1, like shadow rays.
    pub(super) ends_early: bool,
}

/// A configuration that is ready to run.
pub(super) struct Ready {
    /// Name of the group whose hits can be compared.
    pub(super) group: String,
    pub(super) row: SummaryRow,
    pub(super) details: Details,
    pub(super) renderer: Renderer,
    pub(super) bytes: u64,
    is_any_hit: bool,
}

impl Ready {
    /// Fills in the hits of its last run.
    pub(super) fn set_hits(&mut self, machine: &Machine) -> Result<(), RenderError> {
        let hits = machine.wait(self.renderer.hits())?;
        (self.row.hits, self.row.hits_hash) =
            (Some(hit_count(&hits)), Hash::of_hits(&hits, self.is_any_hit).to_string());
        Ok(())
    }
}

/// A structure that takes longer to build takes far longer than to compose kernels.
const QUICK: Duration = Duration::from_secs(1);

/// What is done beside building.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Extent {
    /// The work is counted, and passes are timed.
    Full,
    /// Neither.
    Brief,
}

/// Builds configurations.
#[derive(Clone, Copy)]
pub(super) struct Builder<'a> {
    pub(super) wanted: &'a Wanted,
    pub(super) meter: &'a Meter,
    pub(super) extent: Extent,
}

impl<'a> Builder<'a> {
    fn machine(&self) -> &'a Machine {
        &self.meter.machine
    }

    /// Plans, builds, compiles and uploads, each timed. Counters and timers of passes do not slow the counted runs:
    /// they use renderers of their own, each dropped before the next is made. `stage` and `note` are told.
    pub(super) fn build(
        &self,
        [run_id, configuration]: [String; 2],
        group: &Group<'_>,
        one: &Configuration,
        base: &Options,
        stage: impl Fn(&str),
        mut note: impl FnMut(&str),
    ) -> Result<Ready, Error> {
        let (subject, machine) = (group.subject, self.machine());
        stage("building");
        let options = one.of(base);
        // Hits alone, unless it is the light that is asked for.
        let shade = options.integrator != Integrator::default();
        let mut options = Options { shade, counters: false, timings: true, keep_passes: true, ..options };
        machine.forget_kernels();
        let plan = || {
            let start = Instant::now();
            let planned = machine.wait(Plan::on(&subject.scene, &options, &machine.device))?;
            Ok::<_, RenderError>((planned, start.elapsed()))
        };
        let mut planned = plan()?;
        if planned.1 < QUICK {
            // Most of it may be composing the kernels, which are kept. Two plans need twice the memory.
            drop(planned);
            planned = plan()?;
        }
        let ((plan, data), building) = planned;
        if misses_all(&subject.scene, &options, &plan) {
            note(MISSES_ALL);
        }
        if options.accelerator == Accelerator::Auto {
            let Structure { accelerator, accelerator_because, .. } = Structure::of(options.accelerator, &plan, &data);
            note(&format!("{}: auto is {accelerator}: {accelerator_because}", subject.scene.name));
        }
        stage("compiling kernels and timing passes");
        let context = machine.run_context(run_id.clone(), &subject.scene, &options, &plan);
        let (width_px, height_px) = group.size.map(|size| (size.width, size.height)).unzip();
        let context = RunContext { configuration: configuration.clone(), width_px, height_px, ..context };
        let clock = context.timer.map_or("", |timer| timer.name()).to_owned();
        let cells = plan.features.grid.then_some(data.grid.cells);
        let (details, start_s) = match self.extent {
            Extent::Full => {
                let compiling = Renderer::from_plan(plan.clone(), data.clone(), &options, &machine.device);
                self.time_passes(context, compiling)?
            }
            Extent::Brief => (Details::without_passes(context), 0.0),
        };
        stage("counting");
        let counts = match self.extent {
            Extent::Full if (self.wanted.is_counted)(one) => {
                machine.wait(machine.counts(&subject.scene, &options, self.wanted.longest_run))
            }
            _ => None,
        };
        let cast = match (&self.extent, plan.features.whole_paths) {
            (_, false) => details.cast.filter(|_| shade),
            (Extent::Full, true) => machine.wait(machine.cast(&subject.scene, &options, self.wanted.longest_run)),
            (Extent::Brief, true) => None,
        };
        (options.timings, options.keep_passes) = (times_every_pass(machine), false);
        let mut renderer = machine.wait(Renderer::from_plan(plan, data, &options, &machine.device))?;
        if (self.wanted.is_replayed)(one) {
            renderer.foresee(&details.passes);
        }

        let plan = renderer.plan();
        let per_ray = |count: fn(&CounterSums) -> Option<u64>| {
            counts.as_ref().filter(|_| plan.rays > 0).and_then(count).map(|sum| sum as f64 / plan.rays as f64)
        };
        let row = SummaryRow {
            schema_version: SCHEMA_VERSION,
            run_id,
            configuration,
            build: THIS.into(),
            scene: subject.scene.name.clone(),
            scene_hash: subject.hash.to_string(),
            triangles: plan.triangles,
            accelerator: options.accelerator.to_string(),
            schedule: options.schedule.to_string(),
            mapping: options.mapping.to_string(),
            traversal: options.traversal.to_string(),
            numerics: options.numerics.to_string(),
            grid: options.grid.to_string(),
            skip: options.skip.to_string(),
            steps_per_pass: (options.schedule == ScheduleKind::Compact).then_some(options.steps_per_pass),
            keep_all: options.keep == Keep::ALL,
            rays_kind: group.kind.clone(),
            seed: self.wanted.seed,
            adapter: machine.name(),
            width_px,
            height_px,
            rays: plan.rays,
            build_s: building.as_secs_f64(),
            start_s,
            clock,
            cells_per_ray: per_ray(|sums| Some(sums.cells_visited)),
            tests_per_ray: per_ray(|sums| Some(sums.triangles_tested)),
            repeated_per_ray: per_ray(|sums| sums.repeated_tests),
            structure_bytes: structure_bytes(plan),
            bytes_per_triangle: bytes_per_triangle(plan),
            passes: details.passes.len(),
            useful_steps_per_thread: useful_steps_per_thread(&details.passes),
            integrator: options.integrator.to_string(),
            secondary_rays: cast.map(|cast| cast.secondary),
            shadow_rays: cast.map(|cast| cast.shadow),
            integrator_options: of_light(&options),
            ..SummaryRow::default()
        };
        let (bytes, is_any_hit) = (plan.bytes(), options.any_hit);
        let details = Details { cells, ..details };
        Ok(Ready { group: group.name.clone(), row, details, renderer, bytes, is_any_hit })
    }

    /// The passes of a run in which every pass is timed, after a warm-up run, and the seconds until it could start,
    /// which include compiling the kernels; planning has already composed them.
    fn time_passes(
        &self,
        context: RunContext,
        compiling: impl Future<Output = Result<Renderer, RenderError>>,
    ) -> Result<(Details, f64), Error> {
        let start = Instant::now();
        let mut renderer = self.machine().wait(compiling)?;
        self.machine().wait(self.machine().settle());
        let start_s = start.elapsed().as_secs_f64();
        for _ in 0..2 {
            let run = self.meter.run_within(self.wanted.longest_run, &mut renderer);
            if self.machine().wait(run)? == Ended::GivenUp {
                return Err(Error::GivenUp);
            }
        }
        let shaders = renderer.plan().variants.iter();
        let shaders = shaders.map(|v| (v.kernel.name(), Hash::of(v.source.as_bytes()).to_string())).collect();
        let context = RunContext { host_run_ns: renderer.host_ns(), ..context };
        let passes = renderer.passes().to_vec();
        let parts = passes.iter().zip(renderer.draws()).map(|(p, draws)| DrawnPart::of(renderer.plan(), p, draws));
        let parts = parts.collect();
        let cast = renderer.totals().rays_in().map(|_| Cast::of(renderer.plan(), &passes));
        Ok((Details { passes, parts, shaders, cast, ..Details::without_passes(context) }, start_s))
    }
}

/// The options of a group's runs. A shadow ray ends at the first hit found with t < 1, whichever it is; the paper has
/// no such rays.
pub(super) fn options(wanted: &Wanted, configurations: &[Configuration], rays: RaySource, ends_early: bool) -> Options {
    let any_hit = ends_early && configurations.iter().all(|one| one.numerics == Numerics::Robust);
    let rays = if any_hit { rays.until(1.0) } else { rays };
    Options { rays, shade: false, any_hit, ..wanted.tuning.clone() }
}

/// The options that hits do not have, such as `max_depth=5 strategy=mis`.
fn of_light(options: &Options) -> String {
    let choices = options.choices();
    let of_hits = Choices { integrator: Integrator::default(), ..choices };
    let own = ROWS.iter().filter(|row| (row.applies)(&choices) && !(row.applies)(&of_hits));
    own.map(|row| format!("{}={}", row.key(), row.get(&choices))).collect::<Vec<_>>().join(" ")
}

/// Whether counted runs need a time for every pass: on the CPU, the device time is their sum.
fn times_every_pass(machine: &Machine) -> bool {
    machine.gpu().is_none()
}

/// Bytes per triangle of the grid or BVH, plus those of packed triangles.
fn bytes_per_triangle(plan: &Plan) -> Option<f64> {
    let packed = plan.buffers.iter().filter(|b| b.what == "packed_triangles").map(|b| b.bytes).sum::<u64>();
    (plan.triangles > 0).then(|| (structure_bytes(plan) + packed) as f64 / plan.triangles as f64)
}
