//! `raystep stability`

mod instruments;
mod output;
mod page;
mod picture;
mod table;

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use picture::Picture;
use raystep_kernels::{Accelerator, Device, Numerics, RaySource, ScheduleKind};
use raystep_lab::judge::Judge;
use raystep_lab::reference::Verdict;
use raystep_lab::stability::{self, CASES, Case, Place, Row, StabilityError, Variant, Workload, drift, probe};
use raystep_lab::{Machine, block_on};

use crate::args::{DeviceArgs, DeviceKind, QuietArgs, named};
use crate::device;
use crate::error::Error;
use crate::output::TargetFolder;
use crate::terminal::{Progress, print};
use crate::usage::did_you_mean;

/// Trace extreme cases, and compare every ray with f64 brute force
///
/// Each case is a scene and rays on which tracers break: rays along axes, in faces, at edges and corners, slivers,
/// scenes far away, huge or tiny, flat or crowded. It is traced by the robust rules and by the paper's, through grid
/// and tree and without either, on a GPU and by the CPU twins in f32 and f64. Robust rules must make no error at all;
/// the paper's must fail where theory says so. If either is not so, the exit code is 1.
///
/// How far tMax is off along a walk of 3,000 cells is measured for each way to keep it, and pairs of rays and triangles
/// are tested by every pipeline that has the triangle test in it.
///
/// DIR/stability.csv has a row a case and way, DIR/tmax.csv one a sample of the walk, DIR/pipelines.csv one a pipeline;
/// DIR/stability.html shows all of it, and where the errors are.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  raystep stability -o stability
  raystep stability --case axis --case cell-faces
  raystep stability --quick --device cpu --accelerator grid
  raystep stability --list")]
pub(crate) struct StabilityArgs {
    /// The folder to write: new, or empty
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Replace the report in a folder that is not empty; other files stay
    #[arg(long, requires = "output")]
    force: bool,
    /// Only cases with this in their names; may be given several times
    #[arg(long = "case", value_name = "NAME")]
    cases: Vec<String>,
    /// List the cases and what is expected of each
    #[arg(long)]
    list: bool,
    /// What keeps a ray from testing every triangle
    #[arg(long, value_name = "A,B…", value_delimiter = ',', default_value = "grid,bvh,none",
          value_parser = named(ACCELERATORS, Accelerator::name))]
    accelerator: Vec<Accelerator>,
    /// An eighth of the rays
    #[arg(long)]
    quick: bool,
    #[command(flatten)]
    quiet: QuietArgs,
    /// Where to trace
    #[arg(long, value_enum, default_value_t = Devices::Auto, help_heading = "Device")]
    device: Devices,
    /// The GPU adapter with this in its name, see 'raystep info'
    #[arg(long, value_name = "NAME", help_heading = "Device")]
    adapter: Option<String>,
}

/// Those that are built as asked for.
const ACCELERATORS: &[Accelerator] = &[Accelerator::Grid, Accelerator::Bvh, Accelerator::None];

/// `--device`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Devices {
    /// The best adapter, software too, and the CPU twins
    Auto,
    /// The best adapter, software too
    Gpu,
    /// The CPU twins in f32 and in f64
    Cpu,
}

/// What came of a case.
struct Outcome {
    case: &'static Case,
    /// One a way.
    rows: Vec<Row>,
    /// Where its errors are.
    pictures: Vec<Picture>,
    /// The first ray with an error by robust rules, in words: one is enough to look for the cause with.
    first_wrong_ray: Option<String>,
}

/// All that came of it.
struct Report {
    outcomes: Vec<Outcome>,
    /// Of the long walk, where that case was asked for.
    walks: Vec<drift::Walked>,
    /// Where all cases were asked for.
    pipelines: Vec<probe::Row>,
}

pub(crate) fn run(args: &StabilityArgs) -> Result<(), Error> {
    let cases = chosen_cases(&args.cases)?;
    if args.list {
        return print(&table::list(&cases));
    }
    let progress = Progress::new(args.quiet.quiet);
    let report = match &args.output {
        None => all(args, &cases, &progress)?,
        Some(path) => {
            output::refuse_others(path)?;
            let report = TargetFolder::new(path, args.force)?.fill(&[], |folder| {
                let report = all(args, &cases, &progress)?;
                output::write(folder, &report)?;
                Ok(report)
            })?;
            progress.say(format_args!("wrote {} to {}", output::NAMES.join(", "), path.display()));
            report
        }
    };
    progress.finish();
    if !args.quiet.quiet {
        print(&(table::text(&report.outcomes) + &instruments::text(&report)))?;
    }
    judge(&report)
}

/// Those whose names have one of the texts in them.
fn chosen_cases(names: &[String]) -> Result<Vec<&'static Case>, Error> {
    if let Some(unknown) = names.iter().find(|name| !CASES.iter().any(|case| case.name.contains(name.as_str()))) {
        let all: Vec<&str> = CASES.iter().map(|case| case.name).collect();
        return Err(Error::usage(format!(
            "--case {unknown}: no case has this in its name; {}'raystep stability --list' lists them",
            did_you_mean(unknown, &all)
        )));
    }
    let is_chosen = |case: &&Case| names.is_empty() || names.iter().any(|name| case.name.contains(name.as_str()));
    Ok(CASES.iter().filter(is_chosen).collect())
}

/// Where to trace, and how it is called in the report.
fn places(args: &StabilityArgs, progress: &Progress) -> Result<Vec<(Place, Machine)>, Error> {
    if args.device == Devices::Cpu && args.adapter.is_some() {
        return Err(Error::usage("--adapter names a GPU adapter, and --device cpu uses none: leave one of them out"));
    }
    let mut places = Vec::new();
    if args.device != Devices::Cpu {
        progress.stage("looking for a device");
        match device::choose(&DeviceArgs { device: DeviceKind::Gpu, adapter: args.adapter.clone() }) {
            Ok(chosen) => places.push((Place { device: "gpu", adapter: chosen.name() }, chosen)),
            Err(error) if args.device == Devices::Gpu || args.adapter.is_some() => return Err(error),
            Err(error) => progress.say(format_args!("note: {}: the CPU twins only", error.message())),
        }
    }
    if args.device != Devices::Gpu {
        let twins = [("cpu_f32", Device::Cpu(None)), ("cpu_f64", Device::CpuF64(None))];
        places.extend(twins.map(|(name, device)| {
            let reason = "the CPU twins".to_owned();
            (Place { device: name, adapter: String::new() }, Machine { device, reason })
        }));
    }
    Ok(places)
}

fn all(args: &StabilityArgs, cases: &[&'static Case], progress: &Progress) -> Result<Report, Error> {
    let places = places(args, progress)?;
    let mut outcomes = Vec::new();
    for (i, case) in cases.iter().enumerate() {
        progress.stage(&format!("case {} of {}: {}", i + 1, cases.len(), case.name));
        outcomes.push(one(args, case, &places).map_err(|e| Error::failed(format!("{}: {}", case.name, e.message())))?);
    }
    let has_walk = cases.iter().any(|case| case.name == "long-walk") && args.accelerator.contains(&Accelerator::Grid);
    let walks = if has_walk { instruments::walks(args.quick, &places, progress)? } else { Vec::new() };
    let pipelines =
        if args.cases.is_empty() { instruments::pipelines(args.quick, &places, progress)? } else { Vec::new() };
    Ok(Report { outcomes, walks, pipelines })
}

/// Traces a case in every way that was asked for.
fn one(args: &StabilityArgs, case: &'static Case, places: &[(Place, Machine)]) -> Result<Outcome, Error> {
    let rays = if args.quick { (case.rays / 8).max(1) } else { case.rays };
    let workload = (case.make)(rays)?;
    let mut outcome = Outcome { case, rows: Vec::new(), pictures: Vec::new(), first_wrong_ray: None };
    let mut judge = Judge::default();
    for (place, chosen) in places {
        for &accelerator in ACCELERATORS.iter().filter(|a| args.accelerator.contains(a)) {
            for variant in Variant::of(accelerator) {
                // In f64 one kernel, or a contracted one, has nothing to add to the steps.
                if (variant.schedule == ScheduleKind::Fused || variant.contracted) && place.device == "cpu_f64" {
                    continue;
                }
                let running = stability::run(case, &workload, variant, &chosen.device, &mut judge);
                let run = block_on(chosen.gpu(), running)?;
                let row = Row::new(case, workload.scene.triangles.len(), variant, place, &run);
                if let Some(([ox, oy, oz], [dx, dy, dz])) = run.score.first_error
                    && variant.numerics == Numerics::Robust
                {
                    outcome.first_wrong_ray.get_or_insert_with(|| {
                        let name = table::name(&row);
                        format!("{name}: first wrong ray, in traced units: {ox:?},{oy:?},{oz:?},{dx:?},{dy:?},{dz:?}")
                    });
                }
                add_picture(&mut outcome.pictures, &row, &workload, &run.score.verdicts, &judge);
                outcome.rows.push(row);
            }
        }
    }
    Ok(outcome)
}

/// Keeps a picture of what went wrong; ways with the same errors share one.
fn add_picture(pictures: &mut Vec<Picture>, row: &Row, workload: &Workload, verdicts: &[Verdict], judge: &Judge) {
    let size = match &workload.rays {
        RaySource::Camera { width, height, .. } => Some([*width, *height]),
        RaySource::Given(_) => None,
    };
    let Some(mut picture) =
        Picture::of(verdicts, size, || (0..judge.sample().len()).map(|place| judge.ray(place)[1]).collect())
    else {
        return;
    };
    match pictures.iter_mut().find(|p| p.is_same(&picture)) {
        Some(same) => same.ways.push(table::way(row)),
        None => {
            picture.ways.push(table::way(row));
            pictures.push(picture);
        }
    }
}

/// Fails where anything is not as it must be.
fn judge(report: &Report) -> Result<(), Error> {
    let rows = || report.outcomes.iter().flat_map(|o| &o.rows);
    let wrong: Vec<&Row> = rows().filter(|row| !row.is_as_expected()).collect();
    match wrong.first() {
        None => report.walks.iter().find(|walked| !walked.is_as_expected()).map_or(Ok(()), |walked| {
            Err(Error::failed(format!("tMax along a walk is not as expected: {}", instruments::told(walked))))
        }),
        Some(first) => Err(Error::failed(format!(
            "{} of {} runs are not as expected, the first of them {}: expected to {}",
            wrong.len(),
            rows().count(),
            table::name(first),
            first.field("expected")
        ))),
    }
}

impl From<StabilityError> for Error {
    fn from(error: StabilityError) -> Self {
        match error {
            StabilityError::Render(error) => error.into(),
            StabilityError::Plan(error) => error.into(),
            _ => Self::failed(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use raystep_lab::stability::Expected;

    use super::*;

    #[test]
    fn the_command_fails_where_a_row_is_not_as_expected_and_only_there() {
        let row = |expected: Expected, has_errors: bool| {
            let variant = Variant::of(Accelerator::Grid)[0];
            let case = CASES[0].name;
            Row { case, variant, device: "gpu", expected, passed: !has_errors, has_errors, fields: Default::default() }
        };
        let code = |rows: Vec<Row>| {
            let outcome = Outcome { case: &CASES[0], rows, pictures: Vec::new(), first_wrong_ray: None };
            judge(&Report { outcomes: vec![outcome], walks: Vec::new(), pipelines: Vec::new() }).map_err(|e| e.code)
        };
        let right = [row(Expected::Pass, false), row(Expected::Fail, true), row(Expected::Any, true)];
        assert_eq!(code(right.to_vec()), Ok(()));
        for wrong in [row(Expected::Pass, true), row(Expected::Fail, false)] {
            assert_eq!(code([&right[..], &[wrong]].concat()), Err(1));
        }
    }
}
