//! One point of a family: every structure and rule on the same rays, interleaved and judged.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use raystep_kernels::options::Integrator;
use raystep_kernels::plan::structure_bytes;
use raystep_kernels::{Accelerator, Device, GridSize, Options, Progress, RaySource, Renderer};
use raystep_scenes::Scene;

use super::light::Reference;
use super::number::Predicted;
use super::row::{self, RUN_COLUMNS, Verdicts};
use super::{Cost, Wanted};
use crate::configuration::Configuration;
use crate::judge::{Cracks, Judge, Traced};
use crate::meter::{Ended, Meter, Run, Time, Turns, in_turn};
use crate::reporter::Reporter;
use crate::statistics::interval::FEWEST;
use crate::tidy::Row;
use crate::{Error, Hash};

/// Rays that are traced first, to find out how many the structure can trace in a run.
const PILOT: usize = 64;
/// Cells and tests of a run, about; and the most of its rays.
const STEPS: [u64; 2] = [1 << 21, 1 << 17];
pub(super) const MOST_RAYS: [usize; 2] = [8192, 1024];
/// Ray/triangle tests of the judge at one point.
const JUDGED_TESTS: [usize; 2] = [1 << 26, 1 << 23];
/// Counted runs of each configuration, and their time limit after the first six, which an interval needs.
const REPEATS: [usize; 2] = [9, 6];
const REPEATS_TAKE: [Duration; 2] = [Duration::from_millis(500), Duration::from_millis(100)];
/// Pass limit of a run.
const MOST_PASSES: usize = 100_000;

/// What to measure.
pub(super) struct Point<'a> {
    pub(super) family: &'a str,
    /// `None` for a scene that is of no family.
    pub(super) parameter: Option<f64>,
    pub(super) name: String,
    pub(super) stratum: &'a str,
    pub(super) scene: &'a Scene,
    /// More rays begin with the same ones.
    pub(super) rays: &'a [raystep_kernels::Ray],
    pub(super) grid: GridSize,
    /// The light that is computed at the hits; local for none.
    pub(super) integrator: Integrator,
    /// Most bounces of its paths.
    pub(super) max_depth: u32,
    /// Whether the family has spent its time: then each configuration makes one run of few rays.
    pub(super) is_late: bool,
}

impl Point<'_> {
    fn is_lit(&self) -> bool {
        self.integrator != Integrator::default()
    }
}

/// A configuration's id at a point: the structure, and the rule left out.
pub(super) fn id(configuration: &Configuration, point: &str) -> String {
    format!("{point}/{}/{}", configuration.accelerator, configuration.rules())
}

/// A configuration that is ready to run.
struct Ready {
    configuration: Configuration,
    renderer: Renderer,
    rays: usize,
    build_s: f64,
    cells_per_ray: f64,
    tests_per_ray: f64,
    /// Whether the few rays of the pilot already took too long: then there is one run of them.
    is_slow: bool,
    /// That run.
    only: Option<Time>,
    /// The time at which a run was stopped.
    stopped: Option<Duration>,
}

pub(super) struct Work<'a> {
    pub(super) wanted: &'a Wanted,
    pub(super) meter: &'a Meter,
    pub(super) reporter: &'a dyn Reporter,
}

impl Work<'_> {
    fn either<T: Copy>(&self, [normal, quick]: [T; 2]) -> T {
        if self.wanted.is_quick { quick } else { normal }
    }

    fn options(&self, point: &Point<'_>, configuration: Configuration, rays: usize, counters: bool) -> Options {
        let rays = RaySource::Given(point.rays[..rays].to_vec());
        configuration.of(&Options {
            grid: if configuration.accelerator == Accelerator::Grid { point.grid } else { GridSize::Auto },
            shade: point.is_lit(),
            integrator: point.integrator,
            max_depth: point.max_depth,
            counters,
            timings: !counters && self.meter.machine.timer().times_passes(),
            keep_passes: false,
            ..Options::new(rays)
        })
    }

    fn build(&self, point: &Point<'_>, options: &Options) -> Result<(Renderer, f64), Error> {
        let machine = &self.meter.machine;
        let begin = Instant::now();
        let (plan, data) = raystep_kernels::Plan::new(point.scene, options, &machine.limits())?;
        let build_s = begin.elapsed().as_secs_f64();
        Ok((machine.wait(Renderer::from_plan(plan, data, options, &machine.device))?, build_s))
    }

    /// One run, until it ends or takes too long; then also its time so far.
    fn run(&self, renderer: &mut Renderer) -> Result<(Ended, Duration), Error> {
        let longest = self.wanted.longest_run;
        let mut so_far = Duration::ZERO;
        let watch = |progress: &Progress, spent| {
            so_far = spent;
            let is_over = progress.rays_decided == progress.rays;
            match !is_over && (spent > longest || progress.passes >= MOST_PASSES) {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        };
        let ended = self.meter.machine.wait(self.meter.run(renderer, watch))?;
        Ok((ended, so_far))
    }

    /// Traces rays with counters: their number's cells and tests, the renderer, and the run.
    fn counted(
        &self,
        point: &Point<'_>,
        configuration: Configuration,
        rays: usize,
    ) -> Result<([f64; 2], Ended, Duration), Error> {
        let (mut renderer, _) = self.build(point, &self.options(point, configuration, rays, true))?;
        let (ended, spent) = self.run(&mut renderer)?;
        let stream = renderer.plan().counters().ok_or(Error::NothingBuilt)?;
        let counters = self.meter.machine.wait(renderer.values(stream))?;
        let mean = |layer| (0..rays).map(|ray| f64::from(counters.get(layer, ray))).sum::<f64>() / rays.max(1) as f64;
        Ok(([mean(0), mean(1)], ended, spent))
    }

    /// Builds a configuration with as many rays as it can trace in a run. Their number follows from counts, not from
    /// times: it is the same in every run.
    fn ready(&self, point: &Point<'_>, configuration: Configuration) -> Result<Ready, Error> {
        let pilot = PILOT.min(point.rays.len());
        let ([cells, tests], ended, spent) = self.counted(point, configuration, pilot)?;
        let (is_done, is_slow) = (matches!(ended, Ended::Done(_)), spent > self.wanted.longest_run);
        let affordable = (self.either(STEPS) as f64 / (cells + tests).max(1.0)) as usize;
        let judged = self.either(JUDGED_TESTS) / point.scene.triangles.len().max(1);
        let most = affordable.min(judged).max(PILOT).min(point.rays.len());
        // A power of two: rules of a structure, which differ a little, trace as many.
        let rays = if !is_done || is_slow || point.is_late || most == 0 { pilot } else { 1 << most.ilog2() };
        let [cells_per_ray, tests_per_ray] =
            if rays == pilot { [cells, tests] } else { self.counted(point, configuration, rays)?.0 };
        let (renderer, build_s) = self.build(point, &self.options(point, configuration, rays, false))?;
        let (only, stopped) = (None, None);
        Ok(Ready { configuration, renderer, rays, build_s, cells_per_ray, tests_per_ray, is_slow, only, stopped })
    }

    /// Measures some configurations; adds a row of each, and of each run.
    pub(super) fn measure(
        &self,
        point: &Point<'_>,
        configurations: &[Configuration],
        cost: &mut Cost,
    ) -> Result<(), Error> {
        let mut ready: Vec<Ready> = Vec::new();
        for &configuration in configurations {
            match self.ready(point, configuration) {
                Ok(one) => ready.push(one),
                Err(error) => {
                    self.meter.machine.health()?;
                    let name = id(&configuration, &point.name);
                    cost.notes.push(format!("{name}: {}", self.reporter.explain(&error)));
                }
            }
        }
        let turns = match point.is_late {
            true => Turns::of(0, 1),
            false => Turns {
                fewest: FEWEST,
                each: Some(self.either(REPEATS_TAKE)),
                seed: u64::from(self.wanted.seed),
                ..Turns::of(1, self.either(REPEATS))
            },
        };
        let times = in_turn(&mut ready, turns, |one| -> Result<Ended, Error> {
            let (ended, spent) = self.run(&mut one.renderer)?;
            match ended {
                Ended::Done(time) if one.is_slow => one.only = Some(time),
                Ended::Done(_) => return Ok(ended),
                Ended::GivenUp => one.stopped = Some(spent),
            }
            Ok(Ended::GivenUp)
        })?;
        let mut judges: BTreeMap<usize, Judge> = BTreeMap::new();
        let mut reference = Reference::default();
        let mut rows: Vec<Row> = Vec::new();
        for (one, times) in ready.iter().zip(&times) {
            let verdicts = self.judge(one, judges.entry(one.rays).or_default())?;
            let runs = match one.only {
                Some(time) => vec![Run { round: 0, place: 0, time }],
                None if one.stopped.is_some() => Vec::new(),
                None => times.runs.clone(),
            };
            let row = self.row(point, one, &cost.run_id);
            let ns: Vec<Option<f64>> = runs.iter().map(|run| self.meter.ns(run.time)).collect();
            let row = verdicts.fill(row::times(row, &ns, one.stopped, one.rays));
            let row = if point.is_lit() && one.stopped.is_none() {
                self.light(point, one, row, &mut reference)?
            } else {
                row
            };
            cost.runs.rows.extend(runs.iter().map(|run| self.meter.fill_run(run, Row::new(RUN_COLUMNS).like(&row))));
            rows.push(row);
        }
        for i in 0..rows.len() {
            let of_robust = Configuration { without: None, ..ready[i].configuration };
            let robust = ready.iter().position(|r| r.configuration == of_robust);
            if let Some(robust) = robust.filter(|&r| r != i && ready[r].rays == ready[i].rays) {
                let of = |k: usize| -> Vec<Option<f64>> {
                    times[k].runs.iter().map(|run| self.meter.ns(run.time)).collect()
                };
                rows[i] =
                    row::ratio(rows[i].clone(), &of(i), &of(robust), &id(&ready[robust].configuration, &point.name));
            }
        }
        cost.rows.rows.extend(rows);
        Ok(())
    }

    /// Fills the columns of light.
    fn light(&self, point: &Point<'_>, one: &Ready, row: Row, reference: &mut Reference) -> Result<Row, Error> {
        let machine = &self.meter.machine;
        let options = |of: Configuration| Options { timings: false, ..self.options(point, of, one.rays, false) };
        let (plan, data) = (one.renderer.plan().clone(), one.renderer.data().clone());
        let of_found = options(one.configuration);
        let mut found = machine.wait(Renderer::from_plan(plan, data, &of_found, &machine.device))?;
        let of_exact = options(Configuration::usual(Accelerator::Bvh, self.wanted.schedule));
        let exact = Renderer::new(point.scene, &of_exact, &Device::CpuF64(None));
        Ok(machine.wait(reference.fill(row, &mut found, exact))?)
    }

    fn judge(&self, one: &Ready, judge: &mut Judge) -> Result<Verdicts, Error> {
        let traced = self.meter.machine.wait(Traced::read(&one.renderer))?;
        self.meter.machine.wait(judge.prepare(&traced, (0..traced.rays()).collect()));
        let mut verdicts = Verdicts::default();
        let verdict_of = judge.of(&traced, Cracks::Missed);
        for ray in 0..traced.rays() {
            if traced.is_decided(ray) {
                let judged = verdict_of.judge(ray);
                verdicts.counts.add(judged.mistake.verdict);
                verdicts.hits += u64::from(judged.hit.is_some());
            } else {
                verdicts.at_bound += 1;
            }
        }
        Ok(verdicts)
    }

    /// The row's keys, counts and predictions.
    fn row(&self, point: &Point<'_>, one: &Ready, run_id: &str) -> Row {
        let (wanted, data) = (self.wanted, one.renderer.data());
        let predicted = Predicted::of(data, wanted.seed);
        let row = wanted.settings(&self.meter.machine).fill(Row::new(row::COLUMNS));
        row.set("run_id", run_id)
            .set("configuration", id(&one.configuration, &point.name))
            .configured(&one.configuration)
            .set("family", point.family)
            .set("parameter", point.parameter)
            .set("scene", &*point.name)
            .set("scene_hash", Hash::of_triangles(&point.scene.triangles))
            .set("triangles", point.scene.triangles.len())
            .set("stratum", point.stratum)
            .set("integrator", point.integrator.name())
            .set("rays", one.rays)
            .set("clock", self.meter.machine.timer().name())
            .set("build_s", one.build_s)
            .set("passes", one.renderer.pass_count())
            .set("cells_per_ray", one.cells_per_ray)
            .set("tests_per_ray", one.tests_per_ray)
            .set("structure_bytes", structure_bytes(one.renderer.plan()))
            .set("predicted_line", predicted.and_then(|p| p.line))
            .set("stiffness", predicted.map(|p| p.end))
    }
}
