//! `raystep stability`

use std::io::Write as _;
use std::path::PathBuf;
use std::sync::Arc;

use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};
use raystep_kernels::{Accelerator, Device};
use raystep_lab::Machine;
use raystep_lab::machine::now_ns;
use raystep_lab::stability::{self, ACCELERATORS, CASES, Case, DeviceName, FILES, Report, Wanted};
use raystep_lab::stiff::{self, FAMILIES, Family, Kept, Start};
use serde_json::json;

use crate::args::{DeviceArgs, DeviceKind, QuietArgs, named};
use crate::commands::unfinished::Unfinished;
use crate::device;
use crate::error::Error;
use crate::output::{self, TargetFolder};
use crate::session::run_id;
use crate::shard::{self, Part, Shard, ShardArgs};
use crate::terminal::{Progress, print};
use crate::usage::did_you_mean;

/// Trace extreme cases, and compare every ray with f64 brute force
///
/// Each case has a scene and rays that are hard for ray tracers: rays along axes, in faces, at edges and corners,
/// slivers, and scenes that are far away, huge, tiny, flat or crowded. They are traced with robust and with the paper's
/// numerics, with each structure and with none, on a GPU and on the CPU in f32 and f64. Robust numerics must make no
/// error; the paper's must fail where theory predicts it. Otherwise the exit code is 1.
///
/// The error of tMax (where a ray leaves its cell) along a walk of 3,000 cells is measured for each way to compute it,
/// and pairs of rays and triangles are tested by every pipeline that includes the triangle test.
///
/// With --cost, families of stiff scenes are traced, too: scenes in which a structure gets slower as one parameter
/// grows, such as a small object in an ever larger room, slivers or coincident layers. For every structure, with all
/// rules and without each, this measures time, cells and tests per ray, building and memory, and wrong rays. In some
/// families light gets harder instead: near or grazing lights, many, or very unequal ones. There, rays to lights are traced,
/// too, each is compared with f64, and so is the light of every ray. It takes up to 27 minutes. If it is interrupted, the same command continues from DIR.stiff.csv.part.
///
/// DIR/stability.csv has one row per case and configuration, DIR/tmax.csv one per sample of the walk, DIR/pipelines.csv
/// one per pipeline, DIR/stiff.csv one per point of a family and configuration, DIR/runs.csv one per timed run;
/// DIR/datapackage.json describes their columns; DIR/stability.html shows all of it, and where the errors are.
///
/// With --shard I/N, only some of the cases and families are traced, for N machines or jobs, and 'raystep merge' puts their
/// tables together.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  raystep stability -o stability
  raystep stability --cost -o stability
  raystep stability --cost --family room,slivers --quick --device cpu -o stability
  raystep stability --case axis --case cell-faces
  raystep stability --quick --device cpu --accelerator grid
  raystep stability --case axis --shard 1/2 -o stability-1
  raystep stability --list")]
pub(crate) struct StabilityArgs {
    /// Output folder: new, or empty
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Replace the report in a folder that is not empty; other files are kept
    #[arg(long, requires = "output")]
    force: bool,
    /// Only cases with this text in their names; can be repeated
    #[arg(long = "case", value_name = "NAME")]
    cases: Vec<String>,
    /// List the cases and the expected results
    #[arg(long)]
    list: bool,
    /// Acceleration structures
    #[arg(long, value_name = "A,B…", value_delimiter = ',', default_value = "grid,irregular,bvh,none",
          value_parser = named(ACCELERATORS, Accelerator::name))]
    accelerator: Vec<Accelerator>,
    /// Use an eighth of the rays
    #[arg(long)]
    quick: bool,
    /// Also measure what stiff scenes cost, on the GPU, or with --device cpu on the CPU
    #[arg(long)]
    pub(super) cost: bool,
    /// Only these families of stiff scenes
    #[arg(long = "family", value_name = "A,B…", value_delimiter = ',', requires = "cost",
          value_parser = PossibleValuesParser::new(FAMILIES.iter().map(|f| f.name)))]
    families: Vec<String>,
    #[command(flatten)]
    shard: ShardArgs,
    #[command(flatten)]
    quiet: QuietArgs,
    /// Where to trace
    #[arg(long, value_enum, default_value_t = Devices::Auto, help_heading = "Device")]
    device: Devices,
    /// Name of the GPU adapter, or part of it; see 'raystep info'
    #[arg(long, value_name = "NAME", help_heading = "Device")]
    adapter: Option<String>,
}

impl StabilityArgs {
    /// Whether it traces on a GPU, if there is one.
    pub(super) fn uses_gpu(&self) -> bool {
        self.device != Devices::Cpu
    }
}

/// `--device`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Devices {
    /// The best adapter, even if it is software, and the CPU
    Auto,
    /// The best adapter, even if it is software
    Gpu,
    /// The CPU in f32 and in f64
    Cpu,
}

pub(crate) fn run(args: &StabilityArgs) -> Result<(), Error> {
    let cases = chosen_cases(&args.cases)?;
    if args.list {
        return print(&stability::list(&cases));
    }
    let progress = Progress::new(args.quiet.quiet);
    let report = match &args.output {
        None => all(args, cases, &devices(args, &progress)?, None, &progress)?,
        Some(path) => {
            let [csv, ..] = FILES;
            // Also of earlier versions.
            let has_our_column = |line: &[u8]| line.split(|&b| b == b',').any(|name| name == b"undecided_ceiling");
            let is_ours = |bytes: &[u8]| bytes.split(|&b| b == b'\r').next().is_some_and(has_our_column);
            output::refuse_others(path, &FILES, "a stability report", csv, is_ours)?;
            let stale: Vec<String> = FILES.into_iter().chain([shard::FILE]).map(str::to_owned).collect();
            let unfinished = Unfinished::beside(path)?;
            let (report, names) = TargetFolder::new(path, args.force)?.fill(&stale, |folder| {
                let devices = devices(args, &progress)?;
                let report = all(args, cases, &devices, Some(&unfinished), &progress)?;
                if let Some(shard) = args.shard.shard {
                    let text = describe(args, shard, &devices)?.text()?;
                    folder.write(shard::FILE, |out| out.write_all(text.as_bytes()))?;
                }
                let files = report.files()?;
                files.iter().try_for_each(|(name, bytes)| folder.write(name, |out| out.write_all(bytes)))?;
                Ok((report, files.iter().map(|(name, _)| *name).collect::<Vec<_>>()))
            })?;
            if args.cost {
                unfinished.remove();
            }
            progress.say(format_args!("wrote {} to {}", names.join(", "), path.display()));
            report
        }
    };
    progress.finish();
    if !args.quiet.quiet {
        print(&(stability::text(&report.outcomes) + &stability::text_beside(&report)))?;
        if let Some(cost) = &report.cost {
            let lines: Vec<String> = cost.sentences().into_iter().chain(cost.notes.clone()).collect();
            print(&lines.iter().map(|line| format!("{line}\n")).collect::<String>())?;
        }
    }
    // A gate: unexpected results fail the command.
    report.unexpected().map_or(Ok(()), |line| Err(Error::failed(line)))
}

/// Cases whose names contain one of the texts.
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

/// Where to trace, and its name in the report.
fn devices(args: &StabilityArgs, progress: &Progress) -> Result<Vec<(DeviceName, Machine)>, Error> {
    if args.device == Devices::Cpu && args.adapter.is_some() {
        return Err(Error::usage("--adapter names a GPU adapter, but --device cpu uses none: omit one of them"));
    }
    let mut devices = Vec::new();
    if args.device != Devices::Cpu {
        progress.stage("looking for a device");
        match device::choose(&DeviceArgs { device: DeviceKind::Gpu, adapter: args.adapter.clone() }) {
            Ok(chosen) => devices.push((DeviceName { kind: "gpu", adapter: chosen.name() }, chosen)),
            Err(error) if args.device == Devices::Gpu || args.adapter.is_some() => return Err(error),
            Err(error) => progress.say(format_args!("note: {}; using the CPU only", error.message())),
        }
    }
    if args.device != Devices::Gpu {
        let twins = [("cpu_f32", Device::Cpu(Some(now_ns))), ("cpu_f64", Device::CpuF64(None))];
        devices.extend(twins.map(|(name, device)| {
            let reason = "CPU".to_owned();
            (DeviceName { kind: name, adapter: "cpu".into() }, Machine { device, reason })
        }));
    }
    Ok(devices)
}

/// What is traced.
struct Chosen {
    cases: Vec<&'static Case>,
    pipelines: bool,
    families: Vec<&'static Family>,
}

/// All that the options ask for, or one part of it.
fn chosen(args: &StabilityArgs, cases: Vec<&'static Case>) -> Result<Chosen, Error> {
    let is_wanted = |f: &&Family| args.families.is_empty() || args.families.iter().any(|name| name == f.name);
    let families: Vec<_> = FAMILIES.iter().filter(is_wanted).filter(|_| args.cost).collect();
    let pipelines = args.cases.is_empty();
    let Some(shard) = args.shard.shard else { return Ok(Chosen { cases, pipelines, families }) };
    // Cases, then the comparison of pipelines, then families.
    let after_cases = cases.len() + usize::from(pipelines);
    let range = shard.range(after_cases + families.len(), "cases and families")?;
    let of = |begin: usize, end: usize| range.start.clamp(begin, end) - begin..range.end.clamp(begin, end) - begin;
    Ok(Chosen {
        pipelines: pipelines && range.contains(&cases.len()),
        families: families[of(after_cases, after_cases + families.len())].to_vec(),
        cases: cases[of(0, cases.len())].to_vec(),
    })
}

/// What the part's folder says of it.
fn describe(args: &StabilityArgs, shard: Shard, devices: &[(DeviceName, Machine)]) -> Result<Part, Error> {
    let device = args.device.to_possible_value().map(|value| value.get_name().to_owned());
    let accelerators: Vec<_> = args.accelerator.iter().map(|a| a.name()).collect();
    let options = json!({
        "accelerator": accelerators, "case": args.cases, "cost": args.cost, "device": device, "family": args.families,
        "quick": args.quick,
    });
    match devices.first() {
        Some((_, machine)) => Part::new("stability", shard, Vec::new(), &options, machine),
        None => Err(Error::failed("there is no device")),
    }
}

fn all(
    args: &StabilityArgs,
    cases: Vec<&'static Case>,
    devices: &[(DeviceName, Machine)],
    unfinished: Option<&Unfinished>,
    progress: &Progress,
) -> Result<Report, Error> {
    let accelerators = args.accelerator.clone();
    let Chosen { cases, pipelines, families } = chosen(args, cases)?;
    let run_id = run_id();
    let cost = match devices.first() {
        Some((_, machine)) if !families.is_empty() => {
            let accelerators = accelerators.clone();
            let wanted = stiff::Wanted { families, accelerators, ..stiff::Wanted::new(run_id.clone(), args.quick) };
            Some(Arc::new(match unfinished {
                Some(unfinished) => unfinished.start(wanted, machine, progress)?,
                None => Start::new(wanted, Kept::default(), |_, _| Ok(())),
            }))
        }
        _ => None,
    };
    let wanted = Wanted { cases, accelerators, is_quick: args.quick, pipelines, cost, run_id };
    Ok(stability::measure(&wanted, devices, progress)?)
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::*;

    #[derive(clap::Parser)]
    struct Only {
        #[command(flatten)]
        args: StabilityArgs,
    }

    /// What is traced with these options: names of cases, whether pipelines are compared, names of families.
    fn names(options: &str) -> (Vec<&'static str>, bool, Vec<&'static str>) {
        let only = Only::try_parse_from(format!("stability -o out {options}").split_whitespace()).expect(options);
        let cases = chosen_cases(&only.args.cases).expect("cases");
        let Chosen { cases, pipelines, families } = chosen(&only.args, cases).expect("enough of them");
        (cases.iter().map(|case| case.name).collect(), pipelines, families.iter().map(|family| family.name).collect())
    }

    #[test]
    fn parts_have_every_case_family_and_comparison_once() {
        for options in ["", "--cost", "--case axis", "--cost --family room,slivers"] {
            let whole = names(options);
            for of in [1, 2, 5] {
                let (mut cases, mut pipelines, mut families) = (Vec::new(), 0, Vec::new());
                for index in 1..=of {
                    let part = names(&format!("{options} --shard {index}/{of}"));
                    cases.extend(part.0);
                    pipelines += usize::from(part.1);
                    families.extend(part.2);
                }
                assert_eq!((cases, pipelines, families), (whole.0.clone(), usize::from(whole.1), whole.2.clone()));
            }
        }
    }
}
