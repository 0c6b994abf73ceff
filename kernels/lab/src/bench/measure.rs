//! Builds configurations and times them in interleaved runs.

use std::ops::ControlFlow;
use std::time::Instant;

use raystep_kernels::export::csv::RunContext;
use raystep_kernels::export::json::{CounterSums, hit_count};
use raystep_kernels::export::structure::{Structure, structure_bytes};
use raystep_kernels::plan::Plan;
use raystep_kernels::{Accelerator, Numerics, Options, RaySource, RenderError, Renderer, ScheduleKind};

use super::{Details, Measured, SCHEMA_VERSION, SummaryRow, Wanted, tuning_text, useful_steps_per_thread};
use crate::meter::{Meter, Time, Times, Turns, in_turn};
use crate::rays::RayKind;
use crate::reporter::Reporter;
use crate::statistics::{Spread, median};
use crate::subject::{Size, Subject};
use crate::ways::{MISSES_ALL, misses_all};
use crate::{Error, Hash, Machine};

/// Maximum size of the configurations that are measured together, chosen to fit on most devices. A larger configuration
/// is measured alone.
const BATCH_BYTES: u64 = 2 << 30;

/// Configurations to compare: they trace the same rays.
#[derive(Clone)]
pub(super) struct Group<'a> {
    /// For display.
    pub(super) name: String,
    pub(super) subject: &'a Subject,
    pub(super) size: Size,
    pub(super) kind: RayKind,
}

/// A configuration that is ready to run.
struct Ready {
    /// Name of the group whose hits can be compared.
    group: String,
    is_any_hit: bool,
    row: SummaryRow,
    details: Details,
    renderer: Renderer,
    bytes: u64,
}

/// A benchmark in progress.
pub(super) struct Bench<'a> {
    wanted: &'a Wanted,
    meter: &'a Meter,
    reporter: &'a dyn Reporter,
    batch: Vec<Ready>,
    configurations: usize,
    first_failure: Option<Error>,
    measured: Measured,
}

impl<'a> Bench<'a> {
    pub(super) fn new(wanted: &'a Wanted, run_id: String, meter: &'a Meter, reporter: &'a dyn Reporter) -> Self {
        let measured = Measured { run_id, rows: Vec::new(), details: Vec::new(), notes: Vec::new() };
        Self { wanted, meter, reporter, batch: Vec::new(), configurations: 0, first_failure: None, measured }
    }

    fn machine(&self) -> &'a Machine {
        &self.meter.machine
    }

    /// Adds a note.
    pub(super) fn note(&mut self, text: impl Into<String>) {
        let text = text.into();
        // A note that applies to every configuration appears once.
        if !self.measured.notes.contains(&text) {
            self.reporter.note(&text);
            self.measured.notes.push(text);
        }
    }

    /// Notes that something is not measured.
    pub(super) fn skip(&mut self, text: String) {
        self.note(format!("omitted: {text}"));
    }

    /// Notes an error. The rest can still be measured, unless the device itself has failed.
    pub(super) fn failed(&mut self, what: &str, error: Error) -> Result<(), Error> {
        self.machine().gpu().map_or(Ok(()), |gpu| gpu.health())?;
        self.skip(format!("{what}: {}", self.reporter.explain(&error)));
        self.first_failure.get_or_insert(error);
        Ok(())
    }

    /// Builds every configuration of a group. Measures what is built so far when memory is full.
    pub(super) fn group(
        &mut self,
        group: Group<'_>,
        rays: RaySource,
        ways: &[(Accelerator, ScheduleKind)],
    ) -> Result<(), Error> {
        let mut options = options(self.wanted, rays, group.kind);
        let mut of_group = Vec::new();
        for &(accelerator, schedule) in ways {
            let what = format!("{}, {accelerator} {schedule}", group.name);
            (options.accelerator, options.schedule) = (accelerator, schedule);
            match self.build(&group, &mut options, &what) {
                Ok(ready) => of_group.push(ready),
                Err(error) => self.failed(&what, error)?,
            }
            // Keep the group together if it fits; split it only if it is too large by itself.
            let (before, now) = (bytes(&self.batch), bytes(&of_group));
            if before + now > BATCH_BYTES && !self.batch.is_empty() {
                self.measure()?;
            }
            if now > BATCH_BYTES && ways.len() > 1 {
                self.note(format!(
                    "{}: its configurations do not fit together, so not all of them are interleaved",
                    group.name
                ));
                self.batch.append(&mut of_group);
                self.measure()?;
            }
        }
        self.batch.append(&mut of_group);
        Ok(())
    }

    /// Plans, builds, compiles and uploads, each timed. Counters and timers of passes do not slow the counted runs:
    /// they use renderers of their own, each dropped before the next is made.
    fn build(&mut self, group: &Group<'_>, options: &mut Options, what: &str) -> Result<Ready, Error> {
        let (subject, machine) = (group.subject, self.machine());
        self.reporter.stage(&format!("{what}: counting"));
        (options.counters, options.timings, options.keep_passes) = (true, false, false);
        let counts = self.count(group, options);
        self.reporter.stage(&format!("{what}: building"));
        (options.counters, options.timings, options.keep_passes) = (false, true, true);
        machine.forget_kernels();
        let start = Instant::now();
        let (plan, data) = Plan::new(&subject.scene, options, &machine.limits())?;
        let build_s = start.elapsed().as_secs_f64();
        if misses_all(&subject.scene, options, &plan) {
            self.note(MISSES_ALL);
        }
        if options.accelerator == Accelerator::Auto {
            let Structure { accelerator, accelerator_because, .. } = Structure::of(options.accelerator, &plan, &data);
            self.note(format!("{}: auto is {accelerator}: {accelerator_because}", subject.scene.name));
        }
        let run_id = format!("{}-{}", self.measured.run_id, self.configurations);
        self.configurations += 1;
        self.reporter.stage(&format!("{what}: compiling kernels and timing passes"));
        let context = machine.run_context(run_id.clone(), &subject.scene, options, &plan);
        let context = RunContext { repeat: self.wanted.repeats, ..context };
        let compiling = Renderer::from_plan(plan.clone(), data.clone(), options, &machine.device);
        let (details, compile_s) = self.time_passes(context, compiling)?;
        (options.timings, options.keep_passes) = (times_every_pass(machine), false);
        let renderer = machine.wait(Renderer::from_plan(plan, data, options, &machine.device))?;

        let plan = renderer.plan();
        let per_ray = |count: fn(&CounterSums) -> Option<u64>| {
            counts.as_ref().filter(|_| plan.rays > 0).and_then(count).map(|sum| sum as f64 / plan.rays as f64)
        };
        let row = SummaryRow {
            schema_version: SCHEMA_VERSION,
            run_id,
            scene: subject.scene.name.clone(),
            scene_hash: subject.hash.to_string(),
            triangles: plan.triangles,
            accelerator: options.accelerator.to_string(),
            schedule: options.schedule.to_string(),
            numerics: options.numerics.to_string(),
            tuning: tuning_text(&self.wanted.tuning, options.schedule == ScheduleKind::Compact),
            rays_kind: group.kind.to_string(),
            device: machine.name(),
            width_px: group.size.width,
            height_px: group.size.height,
            rays: plan.rays,
            build_s,
            compile_s,
            timer_source: details.context.timer.map(|timer| timer.name().into()),
            cells_per_ray: per_ray(|sums| Some(sums.cells_visited)),
            tests_per_ray: per_ray(|sums| Some(sums.triangles_tested)),
            repeated_per_ray: per_ray(|sums| sums.repeated_tests),
            bytes_per_triangle: bytes_per_triangle(plan),
            passes: details.passes.len(),
            useful_steps_per_thread: useful_steps_per_thread(&details.passes),
            ..SummaryRow::default()
        };
        let bytes = plan.bytes();
        let is_any_hit = options.any_hit;
        Ok(Ready { group: group.name.clone(), is_any_hit, row, details, renderer, bytes })
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
        self.machine().settle();
        let compile_s = start.elapsed().as_secs_f64();
        self.run(&mut renderer)?;
        self.run(&mut renderer)?;
        let shaders = renderer.plan().variants.iter();
        let shaders = shaders.map(|v| (v.kernel.name(), Hash::of(v.source.as_bytes()).to_string())).collect();
        let context = RunContext { host_run_ns: renderer.host_ns(), ..context };
        Ok((Details { context, passes: renderer.passes().to_vec(), shaders }, compile_s))
    }

    /// Sums of the counters; `None` if this configuration cannot count.
    fn count(&self, group: &Group<'_>, options: &Options) -> Option<CounterSums> {
        let (scene, machine) = (&group.subject.scene, self.machine());
        let (plan, data) = Plan::new(scene, options, &machine.limits()).ok()?;
        let counters = plan.counters()?;
        let mut renderer = machine.wait(Renderer::from_plan(plan, data, options, &machine.device)).ok()?;
        machine.wait(renderer.run(|_| ControlFlow::Continue(()))).ok()?;
        CounterSums::of(&machine.wait(renderer.values(counters)).ok()?, renderer.plan())
    }

    /// Times everything that is built, interleaved, and drops it.
    fn measure(&mut self) -> Result<(), Error> {
        let mut batch = std::mem::take(&mut self.batch);
        let turns = Turns::of(self.wanted.warmups as usize, self.wanted.repeats as usize);
        let of = ((turns.warmups + turns.repeats) * batch.len()) as u64;
        let mut done = 0;
        let times = in_turn(&mut batch, turns, |ready| {
            self.reporter.part("measuring", done, of);
            done += 1;
            self.meter.run(&mut ready.renderer, |_, _| ControlFlow::Continue(()))
        })?;
        batch.into_iter().zip(times).try_for_each(|(ready, times)| self.finish_one(ready, &times))
    }

    /// One run that is not timed.
    fn run(&self, renderer: &mut Renderer) -> Result<(), Error> {
        self.meter.run(renderer, |_, _| ControlFlow::Continue(()))?;
        Ok(())
    }

    /// Fills the row of a measured configuration, and compares its hits with its group's.
    fn finish_one(&mut self, ready: Ready, times: &Times) -> Result<(), Error> {
        let Ready { group, is_any_hit, mut row, details, renderer, .. } = ready;
        // If the device has no reliable clock, the host's times are used.
        let needs_device = self.machine().timer().times_passes();
        let is_valid = |time: &Time| time.device_ns.is_some() || !needs_device;
        let valid: Vec<Time> = times.runs.iter().map(|run| run.time).filter(is_valid).collect();
        row.invalid = times.runs.len() - valid.len();
        let device_ns: Vec<f64> = valid.iter().filter_map(|time| time.device_ns).map(|ns| ns as f64).collect();
        let wall_ns: Vec<f64> = valid.iter().map(|time| time.wall_ns as f64).collect();
        let hits = self.machine().wait(renderer.hits())?;
        row.n = wall_ns.len();
        if let Some(spread) = Spread::of(&device_ns) {
            row.median_device_ns = Some(spread.median);
            (row.p05_device_ns, row.p95_device_ns) = (Some(spread.p05), Some(spread.p95));
        }
        row.median_wall_ns = median(&wall_ns);
        row.rays_per_s = row.time_ns().filter(|&(ns, _)| ns > 0.0).map(|(ns, _)| row.rays as f64 / ns * 1e9);
        (row.hits, row.hits_hash) = (hit_count(&hits), Hash::of_hits(&hits, is_any_hit).to_string());

        let name = |row: &SummaryRow| format!("{} {}", row.accelerator, row.schedule);
        if row.invalid > 0 {
            let (invalid, repeats) = (row.invalid, self.wanted.repeats);
            self.note(format!("{group}, {}: {invalid} of {repeats} times were invalid and do not count", name(&row)));
        }
        fn rays_of(r: &SummaryRow) -> (&str, &str, u32, u32) {
            (&r.scene_hash, &r.rays_kind, r.width_px, r.height_px)
        }
        let same_rays = |other: &&SummaryRow| rays_of(other) == rays_of(&row);
        let other = self.measured.rows.iter().find(same_rays).filter(|r| r.hits_hash != row.hits_hash);
        if let Some(other) = other {
            let (one, two, hits, others) = (name(&row), name(other), row.hits, other.hits);
            self.note(format!("{group}: {one} and {two} have different hits ({hits} and {others} rays hit something)"));
        }
        self.measured.details.push(details);
        self.measured.rows.push(row);
        Ok(())
    }

    /// Measures what remains.
    pub(super) fn finish(mut self) -> Result<Measured, Error> {
        self.measure()?;
        match self.first_failure {
            Some(error) if self.measured.rows.is_empty() => Err(error),
            _ if self.measured.rows.is_empty() => Err(Error::NoRays),
            _ => Ok(self.measured),
        }
    }
}

/// The options of a group's runs. A shadow ray ends at the first hit found with t < 1, whichever it is; the paper has
/// no such rays.
fn options(wanted: &Wanted, rays: RaySource, kind: RayKind) -> Options {
    let any_hit = kind == RayKind::Shadow && wanted.tuning.numerics == Numerics::Robust;
    let rays = if any_hit { rays.until(1.0) } else { rays };
    Options { rays, shade: false, any_hit, ..wanted.tuning.clone() }
}

/// Whether counted runs need a time for every pass: on the CPU, the device time is their sum.
fn times_every_pass(machine: &Machine) -> bool {
    machine.gpu().is_none()
}

fn bytes(batch: &[Ready]) -> u64 {
    batch.iter().map(|ready| ready.bytes).sum()
}

/// Bytes per triangle of the grid or BVH, plus those of packed triangles.
fn bytes_per_triangle(plan: &Plan) -> Option<f64> {
    let packed = plan.buffers.iter().filter(|b| b.what == "packed_triangles").map(|b| b.bytes).sum::<u64>();
    (plan.triangles > 0).then(|| (structure_bytes(plan) + packed) as f64 / plan.triangles as f64)
}
