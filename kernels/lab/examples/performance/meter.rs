//! Interleaves runs of several configurations, so that a temporary slowdown of the machine affects all of them.
//!
//! On a GPU, the paper's tables are replayed: a first run finds the passes one at a time, and later runs submit exactly
//! those. A normal run submits passes before it knows whether they are needed; without lists of active rays each such
//! pass launches every ray, and `first` has such passes in every iteration of its loop.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::{Duration, Instant};

use raystep_kernels::executor::gpu::{GpuExecutor, MOST_PASSES};
use raystep_kernels::export::json::{CounterSums, hit_count};
use raystep_kernels::export::structure::structure_bytes;
use raystep_kernels::plan::Plan;
use raystep_kernels::program::schedule::Call;
use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::tables::state::StateCounts;
use raystep_kernels::{
    Accelerator, Gpu, GridSize, Numerics, Options, Pass, RaySource, RenderError, Renderer, ScheduleKind, Skip,
};
use raystep_lab::meter::{Ended, Time, Times, Turns, Valid, in_turn};
use raystep_scenes::Scene;

use crate::machine::Machine;
use crate::row::{Row, median_low_high};
use crate::scenes::Viewed;
use crate::sections::Deadline;

/// A configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Way {
    pub(crate) accelerator: Accelerator,
    pub(crate) schedule: ScheduleKind,
    pub(crate) numerics: Numerics,
    pub(crate) grid: GridSize,
    pub(crate) skip: Skip,
    pub(crate) steps: u32,
}

impl Way {
    /// Robust numerics, the automatic grid, no empty-space skipping, one step per pass.
    pub(crate) fn new(accelerator: Accelerator, schedule: ScheduleKind) -> Self {
        let (numerics, grid, skip) = (Numerics::Robust, GridSize::Auto, Skip::Off);
        Self { accelerator, schedule, numerics, grid, skip, steps: 1 }
    }

    pub(crate) fn fused(accelerator: Accelerator) -> Self {
        Self::new(accelerator, ScheduleKind::Fused)
    }

    pub(crate) fn compact(accelerator: Accelerator, steps: u32) -> Self {
        Self { steps, ..Self::new(accelerator, ScheduleKind::Compact) }
    }

    pub(crate) fn skip(self, skip: Skip) -> Self {
        Self { skip, ..self }
    }

    fn options(&self, rays: RaySource, is_any_hit: bool) -> Options {
        Options {
            accelerator: self.accelerator,
            schedule: self.schedule,
            numerics: self.numerics,
            grid: self.grid,
            skip: self.skip,
            steps_per_pass: self.steps,
            any_hit: is_any_hit,
            shade: false,
            ..Options::new(if is_any_hit { rays.until(1.0) } else { rays })
        }
    }
}

/// What the configurations of a group share: the same rays.
pub(crate) struct Group<'a> {
    pub(crate) viewed: &'a Viewed,
    pub(crate) size: (u32, u32),
    pub(crate) rays: RaySource,
    pub(crate) rays_kind: &'static str,
    pub(crate) counted: Option<Counted>,
}

/// The rays for a counting run (the same kind, perhaps fewer), and which configurations need one.
pub(crate) type Counted = (RaySource, fn(&Way) -> bool);

struct Ready {
    at: usize,
    renderer: Renderer,
    replay: Option<Replay>,
}

/// Measures the configurations of a section.
pub(crate) struct Meter<'a> {
    pub(crate) machine: &'a Machine,
    pub(crate) section: &'static str,
    pub(crate) deadline: Deadline,
    pub(crate) rows: Vec<Row>,
}

impl Meter<'_> {
    /// Time limits for all runs of one configuration, and for one run.
    fn bounds(&self) -> (Duration, Duration) {
        let seconds = match (self.machine.quick, self.machine.is_fast()) {
            (true, _) => (0.6, 3.0),
            (false, true) => (0.4, 1.5),
            (false, false) => (2.0, 20.0),
        };
        (Duration::from_secs_f64(seconds.0), Duration::from_secs_f64(seconds.1))
    }

    /// Builds, warms up and then measures in interleaved runs. Returns one row per configuration, in the same order.
    pub(crate) fn group(&mut self, group: &Group<'_>, ways: &[Way]) {
        let mut ready = Vec::new();
        for way in ways {
            let mut row = self.row(group, way);
            let what = format!("{}: {} {} {}", self.section, group.viewed.name, row.triangles, row.way());
            eprintln!("{what}, {} {}x{}", group.rays_kind, group.size.0, group.size.1);
            if self.deadline.is_over() {
                row.reason = Deadline::OVER.into();
            } else {
                match self.prepare(group, way, &mut row) {
                    Ok((renderer, replay)) => {
                        ready.push(Ready { at: self.rows.len(), renderer, replay });
                    }
                    Err(reason) => row.reason = reason,
                }
            }
            if !row.reason.is_empty() {
                eprintln!("{what}: {}", row.reason);
            }
            self.rows.push(row);
        }
        let times = self.measure(&mut ready);
        for (r, times) in ready.into_iter().zip(&times) {
            self.finish(r, times);
        }
    }

    /// A row with everything known before anything is built.
    pub(crate) fn row(&self, group: &Group<'_>, way: &Way) -> Row {
        let grid = match (way.accelerator, way.grid) {
            (Accelerator::Grid, GridSize::Auto) => "auto".into(),
            (Accelerator::Grid, GridSize::Cells([x, y, z])) => format!("{x}x{y}x{z}"),
            _ => String::new(),
        };
        Row {
            section: self.section.into(),
            scene: group.viewed.name.clone(),
            triangles: group.viewed.scene.triangles.len() as u64,
            rays_kind: group.rays_kind.into(),
            width_px: group.size.0,
            height_px: group.size.1,
            accelerator: way.accelerator.to_string(),
            schedule: way.schedule.to_string(),
            numerics: way.numerics.to_string(),
            skip: if way.accelerator == Accelerator::Grid { way.skip.to_string() } else { String::new() },
            grid,
            steps_per_pass: way.steps,
            ..Row::default()
        }
    }

    fn options(&self, group: &Group<'_>, way: &Way, rays: &RaySource) -> Options {
        way.options(rays.clone(), group.rays_kind == "shadow")
    }

    /// Counts steps, builds, compiles, and runs once.
    fn prepare(&self, group: &Group<'_>, way: &Way, row: &mut Row) -> Result<(Renderer, Option<Replay>), String> {
        let machine = self.machine;
        let sums =
            group.counted.as_ref().filter(|(_, wanted)| wanted(way)).and_then(|(rays, _)| self.count(group, way, rays));
        let mut options = self.options(group, way, &group.rays);
        options.timings = machine.gpu().is_none();
        let text = |e: &dyn std::fmt::Display| e.to_string();
        let (plan, data, build_s) = planned(machine, &group.viewed.scene, &options)?;
        row.build_s = build_s;
        row.rays = plan.rays;
        if plan.features.grid {
            row.leaps = Some(plan.features.skip);
            row.cells = data.grid.cells.map(|n| n.to_string()).join("x");
        }
        row.bytes_per_triangle = (plan.triangles > 0).then(|| structure_bytes(&plan) as f64 / plan.triangles as f64);
        machine.forget_kernels();
        let start = Instant::now();
        let renderer = machine.wait(Renderer::from_plan(plan, data, &options, machine.device()));
        let mut renderer = renderer.map_err(|e| text(&e))?;
        machine.settle();
        row.prepare_s = Some(start.elapsed().as_secs_f64());

        let most = self.bounds().1;
        let too_long = || format!("a run takes more than {} s", most.as_secs_f64());
        let mut replay = None;
        let is_papers = matches!(way.schedule, ScheduleKind::First | ScheduleKind::Second);
        match machine.gpu().filter(|_| is_papers && self.section == "paper") {
            Some(gpu) => {
                let start = Instant::now();
                while machine.wait(renderer.step()).map_err(|e| text(&e))?.is_some() {
                    if start.elapsed() > most {
                        return Err(too_long());
                    }
                }
                replay = Some(Replay::new(machine, gpu, &renderer)?);
            }
            None => {
                let Ended::Done(first) = machine.run(&mut renderer, most).map_err(|e| text(&e))? else {
                    return Err(too_long());
                };
                if u128::from(first.wall_ns) < (most / 20).as_nanos()
                    && machine.run(&mut renderer, most).map_err(|e| text(&e))? == Ended::GivenUp
                {
                    return Err(too_long());
                }
            }
        }
        row.is_replay = replay.is_some();
        let passes = renderer.passes();
        let threads: u64 = passes.iter().map(|p| p.threads_launched).sum();
        row.passes = Some(passes.len());
        row.threads_launched = Some(threads);
        row.threads_with_ray = Some(passes.iter().map(|p| u64::from(p.rays_in)).sum());
        if let Some((sums, rays)) = sums {
            let per_ray = |count: u64| Some(count as f64 / rays.max(1) as f64);
            row.counted_rays = Some(rays);
            row.cells_per_ray = per_ray(sums.cells_visited).filter(|_| way.accelerator != Accelerator::None);
            row.tests_per_ray = per_ray(sums.triangles_tested);
            row.repeated_per_ray = sums.repeated_tests.and_then(per_ray);
            let steps = row.cells_per_ray.unwrap_or(0.0) + row.tests_per_ray.unwrap_or(0.0);
            row.useful_steps_per_thread = (threads > 0).then(|| steps * row.rays as f64 / threads as f64);
        }
        Ok((renderer, replay))
    }

    /// Counters from a run of their own, and how many rays it traced. `None` if that took too long.
    fn count(&self, group: &Group<'_>, way: &Way, rays: &RaySource) -> Option<(CounterSums, u64)> {
        let (machine, mut options) = (self.machine, self.options(group, way, rays));
        options.counters = true;
        // The same steps in another order, without passes submitted ahead.
        if way.schedule == ScheduleKind::First {
            options.schedule = ScheduleKind::Second;
        }
        let renderer = machine.wait(Renderer::new(&group.viewed.scene, &options, machine.device()));
        let mut renderer = renderer.ok()?;
        let Ok(Ended::Done(_)) = machine.run(&mut renderer, self.bounds().1) else { return None };
        let counters = machine.wait(renderer.values(streams::COUNTERS)).ok()?;
        Some((CounterSums::of(&counters, renderer.plan())?, renderer.plan().rays))
    }

    fn measure(&self, ready: &mut [Ready]) -> Vec<Times> {
        let (budget, most) = self.bounds();
        self.machine.raise_clocks();
        let turns = Turns {
            warmups: 0,
            repeats: self.machine.repeats(),
            fewest: 1,
            all: Some(self.deadline.left()),
            each: Some(budget),
            seed: 0,
        };
        let times = in_turn(ready, turns, |r| {
            let run = match &mut r.replay {
                Some(replay) => replay.run(self.machine).map(Ended::Done),
                None => self.machine.run(&mut r.renderer, 2 * most),
            };
            // A run that fails is treated like one that takes too long.
            Ok::<_, Infallible>(run.unwrap_or(Ended::GivenUp))
        });
        let Ok(times) = times;
        times
    }

    fn finish(&mut self, ready: Ready, times: &Times) {
        let row = &mut self.rows[ready.at];
        let device = Valid::of(&times.device_ns());
        (row.n, row.invalid) = (device.ns.len(), device.invalid);
        [row.median_device_ns, row.low_device_ns, row.high_device_ns] = median_low_high(&device);
        let wall: Vec<_> = times.runs.iter().map(|run| run.time.device_ns.map(|_| run.time.wall_ns)).collect();
        row.median_wall_ns = Valid::of(&wall).median();
        match self.machine.wait(ready.renderer.hits()) {
            Ok(hits) => row.hits = Some(hit_count(&hits)),
            Err(error) => row.reason = error.to_string(),
        }
        if row.n == 0 && row.reason.is_empty() {
            row.reason = "no time was valid".into();
        }
    }
}

/// A plan, and the seconds for building its grid or BVH: the shortest of a few builds. The first one also composes the
/// shaders, which are kept; the others only build.
fn planned(machine: &Machine, scene: &Scene, options: &Options) -> Result<(Plan, SceneData, Option<f64>), String> {
    let times = if scene.triangles.len() < 10_000 { 4 } else { 2 };
    let (mut made, mut shortest_s) = (None, f64::MAX);
    for _ in 0..times {
        // Free the previous one first, so that two are never in memory.
        drop(made.take());
        let start = Instant::now();
        let planned = Plan::new(scene, options, &machine.limits()).map_err(|e| e.to_string())?;
        shortest_s = shortest_s.min(start.elapsed().as_secs_f64());
        made = Some(planned);
    }
    let (plan, data) = made.ok_or("nothing was planned")?;
    Ok((plan, data, Some(shortest_s).filter(|&s| s > 0.0)))
}

/// The passes of a run, without any that turn out not to be needed.
struct Replay {
    executor: GpuExecutor,
    /// The kernels of each submission, and the rays in each state before it.
    submissions: Vec<(Vec<Call>, StateCounts)>,
}

impl Replay {
    /// Takes the passes of a completed run.
    fn new(machine: &Machine, gpu: &Arc<Gpu>, renderer: &Renderer) -> Result<Self, String> {
        let plan = renderer.shared_plan();
        let executor = GpuExecutor::new(gpu.clone(), &plan, renderer.data(), false);
        let executor = machine.wait(executor).map_err(|e| e.to_string())?;
        let mut before = StateCounts::default();
        let submissions = renderer.passes().chunks(MOST_PASSES).map(|passes| {
            let counts = before.clone();
            passes.last().into_iter().for_each(|pass| before.clone_from(&pass.counts));
            (passes.iter().map(Pass::call).collect(), counts)
        });
        Ok(Self { executor, submissions: submissions.collect() })
    }

    fn run(&mut self, machine: &Machine) -> Result<Time, RenderError> {
        self.executor.clear();
        machine.keep_clocks();
        let start = Instant::now();
        for (calls, counts) in &self.submissions {
            machine.wait(self.executor.run(calls, counts))?;
        }
        let wall_ns = start.elapsed().as_nanos() as u64;
        Ok(Time { wall_ns, device_ns: self.executor.device_ns().filter(|&ns| ns > 0) })
    }
}
