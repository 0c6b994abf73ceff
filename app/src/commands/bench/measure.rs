//! Building configurations and running them in turn.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::time::Instant;

use raystep_kernels::export::csv::RunContext;
use raystep_kernels::export::json::{CounterSums, hit_count};
use raystep_kernels::export::structure::{Structure, structure_bytes};
use raystep_kernels::plan::Plan;
use raystep_kernels::{
    Accelerator, Device, Load, Numerics, Options, Pass, RaySource, RenderError, Renderer, ScheduleKind, Stream,
};
use raystep_lab::Hash;
use raystep_lab::Machine;
use raystep_lab::RayKind;
use raystep_lab::bench::{SCHEMA_VERSION, SummaryRow, useful_steps_per_thread};
use raystep_lab::statistics::Spread;

use super::{BenchArgs, Measured, tuning_text};
use crate::args::Size;
use crate::commands::input::Input;
use crate::error::Error;
use crate::session::{MISSES_ALL, misses_all, run_id};
use crate::terminal::Progress;

/// Most bytes of configurations that are measured in turn, so that they fit on most devices together. One
/// that is larger is measured alone.
const BATCH_BYTES: u64 = 2 << 30;

/// What belongs side by side: the same rays.
#[derive(Clone)]
pub(super) struct Group<'a> {
    /// For people.
    pub(super) name: String,
    pub(super) input: &'a Input,
    pub(super) size: Size,
    pub(super) kind: RayKind,
}

/// What a row does not hold.
pub(super) struct Details {
    /// The run whose passes these are.
    pub(super) context: RunContext,
    /// Its passes.
    pub(super) passes: Vec<Pass>,
    /// Hashes of the kernels' sources, by name.
    pub(super) shaders: BTreeMap<&'static str, String>,
}

/// A configuration that is ready to run.
struct Ready {
    /// Where its group's hits can be compared.
    group: String,
    is_any_hit: bool,
    row: SummaryRow,
    details: Details,
    renderer: Renderer,
    bytes: u64,
    device_ns: Vec<f64>,
    wall_ns: Vec<f64>,
}

/// A benchmark under way.
pub(super) struct Bench<'a> {
    args: &'a BenchArgs,
    chosen: &'a Machine,
    progress: &'a Progress,
    /// What a GPU does between runs, which keeps its clocks up.
    load: Option<Load>,
    batch: Vec<Ready>,
    configurations: usize,
    first_failure: Option<Error>,
    measured: Measured,
}

impl<'a> Bench<'a> {
    pub(super) fn new(args: &'a BenchArgs, chosen: &'a Machine, progress: &'a Progress) -> Self {
        let measured = Measured { run_id: run_id(), rows: Vec::new(), details: Vec::new(), notes: Vec::new() };
        let load = match &chosen.device {
            Device::Gpu(gpu) => Some(Load::new(gpu.clone())),
            Device::Cpu(_) | Device::CpuF64(_) => None,
        };
        Self { args, chosen, progress, load, batch: Vec::new(), configurations: 0, first_failure: None, measured }
    }

    /// Something to know.
    pub(super) fn note(&mut self, text: impl Into<String>) {
        let text = text.into();
        // What is so for every configuration is said once.
        if !self.measured.notes.contains(&text) {
            self.progress.say(format_args!("note: {text}"));
            self.measured.notes.push(text);
        }
    }

    /// Something is not measured.
    pub(super) fn skip(&mut self, text: String) {
        self.note(format!("left out: {text}"));
    }

    /// Something cannot be measured. The rest can, unless the device itself has failed.
    pub(super) fn failed(&mut self, what: &str, error: Error) -> Result<(), Error> {
        self.chosen.gpu().map_or(Ok(()), |gpu| gpu.health())?;
        self.skip(format!("{what}: {}", error.message()));
        self.first_failure.get_or_insert(error);
        Ok(())
    }

    /// Builds every configuration of a group, and measures where no more fit.
    pub(super) fn group(
        &mut self,
        group: Group<'_>,
        rays: RaySource,
        ways: &[(Accelerator, ScheduleKind)],
    ) -> Result<(), Error> {
        let mut options = options(self.args, rays, group.kind);
        let mut of_group = Vec::new();
        for &(accelerator, schedule) in ways {
            let what = format!("{}, {accelerator} {schedule}", group.name);
            (options.accelerator, options.schedule) = (accelerator, schedule);
            match self.build(&group, &mut options, &what) {
                Ok(ready) => of_group.push(ready),
                Err(error) => self.failed(&what, error)?,
            }
            // The group stays together if it can; if it is too large by itself, it cannot.
            let (before, now) = (bytes(&self.batch), bytes(&of_group));
            if before + now > BATCH_BYTES && !self.batch.is_empty() {
                self.measure()?;
            }
            if now > BATCH_BYTES && ways.len() > 1 {
                self.note(format!(
                    "{}: its configurations do not fit together, and are not all measured in turn",
                    group.name
                ));
                self.batch.append(&mut of_group);
                self.measure()?;
            }
        }
        self.batch.append(&mut of_group);
        Ok(())
    }

    /// Plans, builds, compiles and uploads, each with its time. What counters and timers of passes cost is
    /// kept out of the runs that count: each has a renderer of its own, which is gone before the next is made.
    fn build(&mut self, group: &Group<'_>, options: &mut Options, what: &str) -> Result<Ready, Error> {
        let (input, chosen) = (group.input, self.chosen);
        self.progress.stage(&format!("{what}: counting"));
        (options.counters, options.timings, options.keep_passes) = (true, false, false);
        let counts = self.count(group, options);
        self.progress.stage(&format!("{what}: building"));
        (options.counters, options.timings, options.keep_passes) = (false, true, true);
        let start = Instant::now();
        let (plan, data) = Plan::new(&input.scene, options, &chosen.limits())?;
        let build_s = start.elapsed().as_secs_f64();
        if misses_all(&input.scene, options, &plan) {
            self.note(MISSES_ALL);
        }
        if options.accelerator == Accelerator::Auto {
            let Structure { accelerator, accelerator_because, .. } = Structure::of(options.accelerator, &plan, &data);
            self.note(format!("{}: auto is {accelerator}: {accelerator_because}", input.scene.name));
        }
        let run_id = format!("{}-{}", self.measured.run_id, self.configurations);
        self.configurations += 1;
        self.progress.stage(&format!("{what}: compiling kernels and timing passes"));
        let context = chosen.run_context(run_id.clone(), &input.scene, options, &plan);
        let context = RunContext { repeat: self.args.repeats, ..context };
        let compiling = Renderer::from_plan(plan.clone(), data.clone(), options, &chosen.device);
        let (details, compile_s) = self.time_passes(context, compiling)?;
        (options.timings, options.keep_passes) = (times_every_pass(chosen), false);
        let renderer = chosen.wait(Renderer::from_plan(plan, data, options, &chosen.device))?;

        let plan = renderer.plan();
        let per_ray = |count: fn(&CounterSums) -> Option<u64>| {
            counts.as_ref().filter(|_| plan.rays > 0).and_then(count).map(|sum| sum as f64 / plan.rays as f64)
        };
        let row = SummaryRow {
            schema_version: SCHEMA_VERSION,
            run_id,
            scene: input.scene.name.clone(),
            scene_hash: input.hash.to_string(),
            triangles: plan.triangles,
            accelerator: options.accelerator.to_string(),
            schedule: options.schedule.to_string(),
            numerics: options.numerics.to_string(),
            tuning: tuning_text(&self.args.tuning, options.schedule == ScheduleKind::Compact),
            rays_kind: group.kind.to_string(),
            device: chosen.name(),
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
        let (device_ns, wall_ns) = (Vec::new(), Vec::new());
        Ok(Ready { group: group.name.clone(), is_any_hit, row, details, renderer, bytes, device_ns, wall_ns })
    }

    /// The passes of a run whose every pass is timed, after one that warms up, and the seconds until it could
    /// start: it is the first to compile this configuration's kernels.
    fn time_passes(
        &self,
        context: RunContext,
        compiling: impl Future<Output = Result<Renderer, RenderError>>,
    ) -> Result<(Details, f64), Error> {
        let start = Instant::now();
        let mut renderer = self.chosen.wait(compiling)?;
        self.chosen.settle();
        let compile_s = start.elapsed().as_secs_f64();
        self.run(&mut renderer)?;
        self.run(&mut renderer)?;
        let shaders = renderer.plan().variants.iter();
        let shaders = shaders.map(|v| (v.kernel.name(), Hash::of(v.source.as_bytes()).to_string())).collect();
        let context = RunContext { host_run_ns: renderer.host_ns(), ..context };
        Ok((Details { context, passes: renderer.passes().to_vec(), shaders }, compile_s))
    }

    /// What a run with counters counts; `None` where this way of tracing cannot count.
    fn count(&self, group: &Group<'_>, options: &Options) -> Option<CounterSums> {
        let (scene, chosen) = (&group.input.scene, self.chosen);
        let (plan, data) = Plan::new(scene, options, &chosen.limits()).ok()?;
        if !plan.has_stream(Stream::Counters) {
            return None;
        }
        let mut renderer = chosen.wait(Renderer::from_plan(plan, data, options, &chosen.device)).ok()?;
        chosen.wait(renderer.run(|_| ControlFlow::Continue(()))).ok()?;
        CounterSums::of(&chosen.wait(renderer.values(Stream::Counters)).ok()?, renderer.plan())
    }

    /// Runs what is built, in turn, and forgets it.
    fn measure(&mut self) -> Result<(), Error> {
        let mut batch = std::mem::take(&mut self.batch);
        let (warmups, repeats) = (self.args.warmups, self.args.repeats);
        let of = (u64::from(warmups) + u64::from(repeats)) * batch.len() as u64;
        let mut done = 0;
        for run in 0..warmups + repeats {
            for ready in &mut batch {
                self.progress.part("measuring", done, of);
                let (wall_ns, device_ns) = self.run(&mut ready.renderer)?;
                if run >= warmups {
                    // Where the device has no true clock, the host's times count.
                    if device_ns.is_some() || !self.chosen.timer().times_passes() {
                        ready.wall_ns.push(wall_ns as f64);
                        ready.device_ns.extend(device_ns.map(|ns| ns as f64));
                    } else {
                        ready.row.invalid += 1;
                    }
                }
                done += 1;
            }
        }
        batch.into_iter().try_for_each(|ready| self.finish_one(ready))
    }

    /// One run: its wall clock and device times.
    fn run(&self, renderer: &mut Renderer) -> Result<(u64, Option<u64>), Error> {
        renderer.restart();
        // Until just before the run, and so not in its wall clock.
        self.load.iter().for_each(Load::submit);
        self.chosen.settle();
        let start = Instant::now();
        self.chosen.wait(renderer.run(|_| ControlFlow::Continue(())))?;
        let wall_ns = start.elapsed().as_nanos() as u64;
        Ok((wall_ns, device_ns(renderer)))
    }

    /// Fills the row of a configuration whose runs are over, and compares its hits with its group's.
    fn finish_one(&mut self, ready: Ready) -> Result<(), Error> {
        let Ready { group, is_any_hit, mut row, details, renderer, device_ns, wall_ns, .. } = ready;
        let hits = self.chosen.wait(renderer.hits())?;
        row.n = wall_ns.len();
        if let Some(spread) = Spread::of(&device_ns) {
            row.median_device_ns = Some(spread.median);
            (row.p05_device_ns, row.p95_device_ns) = (Some(spread.p05), Some(spread.p95));
        }
        row.median_wall_ns = Spread::of(&wall_ns).map(|spread| spread.median);
        row.rays_per_s = row.time_ns().filter(|&(ns, _)| ns > 0.0).map(|(ns, _)| row.rays as f64 / ns * 1e9);
        (row.hits, row.hits_hash) = (hit_count(&hits), Hash::of_hits(&hits, is_any_hit).to_string());

        let name = |row: &SummaryRow| format!("{} {}", row.accelerator, row.schedule);
        if row.invalid > 0 {
            let (invalid, repeats) = (row.invalid, self.args.repeats);
            self.note(format!(
                "{group}, {}: {invalid} of {repeats} times were not valid, and do not count",
                name(&row)
            ));
        }
        fn rays_of(r: &SummaryRow) -> (&str, &str, u32, u32) {
            (&r.scene_hash, &r.rays_kind, r.width_px, r.height_px)
        }
        let same_rays = |other: &&SummaryRow| rays_of(other) == rays_of(&row);
        let other = self.measured.rows.iter().find(same_rays).filter(|r| r.hits_hash != row.hits_hash);
        if let Some(other) = other {
            let (one, two, hits, others) = (name(&row), name(other), row.hits, other.hits);
            self.note(format!("{group}: {one} and {two} do not hit the same ({hits} and {others} rays hit something)"));
        }
        self.measured.details.push(details);
        self.measured.rows.push(row);
        Ok(())
    }

    /// Measures the rest.
    pub(super) fn finish(mut self) -> Result<Measured, Error> {
        self.measure()?;
        match self.first_failure {
            Some(error) if self.measured.rows.is_empty() => Err(error),
            _ if self.measured.rows.is_empty() => {
                Err(Error::failed("there is nothing to measure: no pixel has a ray of the kinds that --rays names"))
            }
            _ => Ok(self.measured),
        }
    }
}

/// The options of a group's runs. A shadow ray is over at its first hit with t < 1, whichever it is; the paper has no
/// such rays.
fn options(args: &BenchArgs, rays: RaySource, kind: RayKind) -> Options {
    let any_hit = kind == RayKind::Shadow && args.tuning.numerics == Numerics::Robust;
    Options { shade: false, any_hit, ..args.tuning.options(rays) }
}

/// Whether runs that count need the times of every pass: the twins' are what [`device_ns`] adds up.
fn times_every_pass(chosen: &Machine) -> bool {
    chosen.gpu().is_none()
}

/// Device time of the run so far; `None` where there is no valid time, or it took none.
fn device_ns(renderer: &Renderer) -> Option<u64> {
    renderer.device_ns().filter(|&ns| ns > 0)
}

fn bytes(batch: &[Ready]) -> u64 {
    batch.iter().map(|ready| ready.bytes).sum()
}

/// Bytes a triangle of the grid or tree, and of the triangles where they are packed for it.
fn bytes_per_triangle(plan: &Plan) -> Option<f64> {
    let packed = plan.buffers.iter().filter(|b| b.what == "packed_triangles").map(|b| b.bytes).sum::<u64>();
    (plan.triangles > 0).then(|| (structure_bytes(plan) + packed) as f64 / plan.triangles as f64)
}
