//! `raystep bench FOLDER…`: programs of one's own.

use std::io::Write as _;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use raystep_kernels::plan::Plan;
use raystep_kernels::{Options, Renderer};
use raystep_lab::human::time;
use raystep_lab::meter::{Meter, Times, Turns, Valid, in_turn};
use raystep_lab::text::aligned;
use raystep_lab::tidy::SCHEMA_VERSION;
use serde::Serialize;

use super::output::{RUNS, SUMMARY};
use super::{BenchArgs, Done};
use crate::args::SightArgs;
use crate::commands::distinct;
use crate::device;
use crate::error::Error;
use crate::output::TargetFolder;
use crate::program_folder;
use crate::scene_file::{self, SceneFile};
use crate::session::{Running, Stopwatch, run_id};
use crate::terminal::Progress;

/// The times of the kernels' passes, in one run.
const KERNELS: &str = "kernels.csv";
/// All files.
pub(super) const NAMES: [&str; 3] = [SUMMARY, RUNS, KERNELS];

/// A row of `summary.csv`.
#[derive(Serialize)]
struct Summary<'a> {
    schema_version: u32,
    run_id: &'a str,
    program: &'a str,
    adapter: &'a str,
    elements: u64,
    passes: usize,
    runs: usize,
    median_ns: Option<f64>,
    low_ns: Option<f64>,
    high_ns: Option<f64>,
    clock: &'a str,
}

/// A row of `runs.csv`.
#[derive(Serialize)]
struct Timed<'a> {
    schema_version: u32,
    run_id: &'a str,
    program: &'a str,
    round: usize,
    place: usize,
    time_ns: Option<u64>,
    wall_ns: u64,
    clock: &'a str,
}

/// A row of `kernels.csv`.
#[derive(Serialize)]
struct OfKernel<'a> {
    schema_version: u32,
    run_id: &'a str,
    program: &'a str,
    kernel: &'a str,
    passes: usize,
    time_ns: Option<u64>,
}

/// Whether programs are measured, and no scenes.
pub(super) fn are_programs(args: &BenchArgs) -> Result<bool, Error> {
    let programs = args.scenes.iter().filter(|path| program_folder::find(path).is_some()).count();
    if programs > 0 && programs < args.scenes.len() {
        return Err(Error::usage("programs and scenes are measured apart: name either"));
    }
    Ok(programs > 0)
}

/// Measures programs, and writes the tables.
pub(super) fn fill(args: &BenchArgs, folder: &TargetFolder) -> Result<Done, Error> {
    let progress = Progress::new(args.quiet.quiet);
    progress.stage("looking for a device");
    let meter = Meter::new(device::choose(&args.device.for_users())?);
    let machine = &meter.machine;
    let mut subjects = Vec::new();
    for path in &distinct(&args.scenes) {
        progress.stage(&format!("compiling {}", path.display()));
        let (running, files) = prepared(args, path, &meter)?;
        folder.refuse_inputs(&files, |name| NAMES.contains(&name))?;
        subjects.push(running);
    }
    let run_id = run_id();
    let turns = Turns { seed: u64::from(args.seed), ..Turns::of(args.warmups as usize, args.repeats() as usize) };
    let mut ran = 0;
    let all = subjects.len() * (turns.warmups + turns.repeats);
    let times = in_turn(&mut subjects, turns, |running| {
        progress.part("runs", ran, all as u64);
        ran += 1;
        machine.wait(meter.run(&mut running.renderer, |_, _| ControlFlow::Continue(())))
    })?;

    let clock = machine.timer().name();
    let adapter = machine.name();
    let (mut summary, mut runs, mut kernels) = (Vec::new(), Vec::new(), Vec::new());
    for (running, times) in subjects.iter().zip(&times) {
        let program = running.scene_path.to_string_lossy().into_owned();
        let ns = |time| meter.ns(time).map(|ns| ns as u64);
        let valid = Valid::of(&times.runs.iter().map(|run| ns(run.time)).collect::<Vec<_>>());
        let interval = valid.interval();
        let plan = running.renderer.plan();
        summary.push((program.clone(), plan.rays, running.renderer.pass_count(), valid.median(), interval));
        runs.extend(times.runs.iter().map(|run| (program.clone(), *run, ns(run.time))));
        kernels.extend(of_kernels(running)?.into_iter().map(|row| (program.clone(), row)));
    }
    let about = |program| (SCHEMA_VERSION, &*run_id, program);
    let rows = summary.iter().zip(&times).map(|((program, elements, passes, median, interval), times): (_, &Times)| {
        let (schema_version, run_id, program) = about(&**program);
        Summary {
            schema_version,
            run_id,
            program,
            adapter: &adapter,
            elements: *elements,
            passes: *passes,
            runs: times.runs.len(),
            median_ns: *median,
            low_ns: interval.map(|interval| interval.low),
            high_ns: interval.map(|interval| interval.high),
            clock,
        }
    });
    write(folder, SUMMARY, rows)?;
    let rows = runs.iter().map(|(program, run, time_ns)| {
        let (schema_version, run_id, program) = about(&**program);
        let (round, place, wall_ns) = (run.round, run.place, run.time.wall_ns);
        Timed { schema_version, run_id, program, round, place, time_ns: *time_ns, wall_ns, clock }
    });
    write(folder, RUNS, rows)?;
    let rows = kernels.iter().map(|(program, (kernel, passes, time_ns))| {
        let (schema_version, run_id, program) = about(&**program);
        OfKernel { schema_version, run_id, program, kernel, passes: *passes, time_ns: *time_ns }
    });
    write(folder, KERNELS, rows)?;
    progress.finish();

    let mut table = vec![["program", "elements", "passes", "median", "95% of medians"].map(str::to_owned)];
    for (program, elements, passes, median, interval) in &summary {
        let interval = interval.map(|i| format!("{} to {}", time(i.low), time(i.high)));
        let median = median.map(time).unwrap_or_default();
        table.push([program.clone(), elements.to_string(), passes.to_string(), median, interval.unwrap_or_default()]);
    }
    let mut text = format!("{adapter}, clock: {clock}\n\n");
    aligned(&table, 3).iter().for_each(|line| text += &format!("{}\n", line.trim_end()));
    Ok(Done { text, gate: None })
}

/// A program that is ready to run, and its files.
fn prepared(args: &BenchArgs, path: &Path, meter: &Meter) -> Result<(Running, Vec<PathBuf>), Error> {
    let size = *args.sizes.first().ok_or_else(|| Error::usage("--size: no size"))?;
    let camera = args.camera.clone();
    let (SceneFile { folder, scene, inputs, .. }, rays) =
        scene_file::read_program(path, &SightArgs { size, camera, read: args.read })?;
    let options = Options { folder, ..Options::new(rays) };
    let machine = &meter.machine;
    let (plan, data) = machine.wait(Plan::on(&scene, &options, &machine.device))?;
    let renderer = machine.wait(Renderer::from_plan(plan, data, &options, &machine.device))?;
    let running = Running {
        run_id: run_id(),
        scene_path: path.to_owned(),
        scene,
        options,
        chosen: machine.clone(),
        renderer,
        watch: Stopwatch::start(),
    };
    Ok((running, inputs))
}

/// A kernel, its passes in a run, and their time together, if it is known.
type KernelTime = (&'static str, usize, Option<u64>);

/// The times of kernels in one more run, in which every pass is timed.
fn of_kernels(running: &Running) -> Result<Vec<KernelTime>, Error> {
    let options = Options { timings: true, ..running.options.clone() };
    let machine = &running.chosen;
    let mut renderer = machine.wait(running.renderer.another(&options, &machine.device))?;
    machine.wait(renderer.run(|_| ControlFlow::Continue(())))?;
    let mut all: Vec<KernelTime> = Vec::new();
    for pass in renderer.passes() {
        let name = pass.kernel.name();
        let at = all.iter().position(|(of, ..)| *of == name).unwrap_or_else(|| {
            all.push((name, 0, Some(0)));
            all.len() - 1
        });
        let (_, passes, time) = &mut all[at];
        *passes += 1;
        *time = time.zip(pass.duration_ns).map(|(sum, ns)| sum + ns);
    }
    Ok(all)
}

fn write(folder: &TargetFolder, name: &str, rows: impl Iterator<Item = impl Serialize>) -> Result<(), Error> {
    let failed = |e: &dyn std::fmt::Display| Error::failed(format!("cannot write {name}: {e}"));
    let mut csv = csv::Writer::from_writer(Vec::new());
    for row in rows {
        csv.serialize(row).map_err(|e| failed(&e))?;
    }
    let bytes = csv.into_inner().map_err(|e| failed(&e))?;
    folder.write(name, |out| out.write_all(&bytes))
}
