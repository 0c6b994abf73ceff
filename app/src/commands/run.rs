//! `raystep run`: programs that need no scene.

use std::ops::ControlFlow;
use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser as _};
use raystep_kernels::export::npy;
use raystep_kernels::options::ProgramName;
use raystep_kernels::plan::Plan;
use raystep_kernels::programs::{Alone, registered};
use raystep_kernels::{Options, RaySource};
use raystep_scenes::{Camera, Scene};

use crate::args::choices::{Amount, ChoiceArgs};
use crate::args::{DeviceArgs, QuietArgs};
use crate::device;
use crate::error::Error;
use crate::output::{Target, write};
use crate::session::{Session, Stopwatch};
use crate::terminal::{Progress, print};

/// Run a stream program that needs no scene
///
/// sort puts random keys in ascending order. Its passes are a network of comparisons that does not depend on the keys:
/// 136 passes for 65,536 keys. 'raystep inspect cornell-box --program sort' shows them one by one.
#[derive(Args, Debug)]
#[command(mut_arg("seed", |seed| seed.help("Seed of the keys")), after_help = "\
Examples:
  raystep run sort --elements 65536 --check
  raystep run sort --elements 1000000 --device gpu --passes-csv passes.csv
  raystep run sort --seed 7 -o keys.npy
  raystep inspect cornell-box --program sort --elements 1024")]
pub(crate) struct RunProgramArgs {
    /// The program
    #[arg(value_parser = PossibleValuesParser::new(alone().map(named)).try_map(|name| parse(&name)))]
    program: Runs,
    #[command(flatten)]
    size: ChoiceArgs<Amount>,
    /// Compare with the same computation on the host, and fail if a result differs
    #[arg(long)]
    check: bool,
    /// Write the results as an npy array (layer, row, column) of uint32: of sort, the keys, and the element that each came
    /// from
    #[arg(short, long, value_name = "F")]
    output: Option<PathBuf>,
    /// Time every pass, and write one row per pass
    #[arg(long, value_name = "F")]
    passes_csv: Option<PathBuf>,
    #[command(flatten)]
    quiet: QuietArgs,
    #[command(flatten)]
    device: DeviceArgs,
}

pub(crate) fn run(args: &RunProgramArgs) -> Result<(), Error> {
    let Runs { name, alone } = args.program;
    let output = args.output.as_deref().map(Target::new).transpose()?;
    let passes = args.passes_csv.as_deref().map(Target::new).transpose()?;
    let progress = Progress::new(args.quiet.quiet);
    let mut watch = Stopwatch::start();
    let chosen = device::choose(&args.device)?;
    watch.lap("device");
    let scene = Scene { name: "none".into(), ..Scene::default() };
    let rays = RaySource::Camera { camera: Camera::framing(&scene.bounds()), width: 1, height: 1 };
    let options = Options { program: name, timings: passes.is_some(), ..args.size.options(rays) };
    let (plan, data) = chosen.wait(Plan::on(&scene, &options, &chosen.device))?;
    watch.lap("plan");
    let session = Session { scene_path: PathBuf::new(), scene, inputs: Vec::new(), options, chosen, plan, data, watch };
    let mut running = session.start(&progress)?;
    let show = |now: &raystep_kernels::Progress| {
        progress.rays(now);
        ControlFlow::Continue(())
    };
    running.chosen.wait(running.renderer.run(show))?;
    let results = running.chosen.wait(running.renderer.values(alone.results))?;
    let mut files = Vec::new();
    if let Some(target) = passes {
        files.push((target, running.passes_csv(&running.run_context(), &[])?));
    }
    if let Some(target) = output {
        let mut bytes = Vec::new();
        npy::write_stream(&mut bytes, &results).map_err(|error| Error::failed(error.to_string()))?;
        files.push((target, bytes));
    }
    write(files)?;
    progress.finish();

    let renderer = &running.renderer;
    let is_right = args.check.then(|| (alone.are_right)(&running.options, &results));
    let device = running.chosen.gpu().map_or("CPU".into(), |gpu| gpu.info.name.clone());
    let mut lines = vec![
        ("device", format!("{device}: {}", running.chosen.reason)),
        (renderer.plan().program.elements[0].name, running.options.elements.to_string()),
        ("passes", renderer.pass_count().to_string()),
    ];
    let ns = renderer.device_ns().filter(|&ns| ns > 0).or(renderer.host_ns());
    lines.extend(ns.map(|ns| ("time", format!("{:.3} ms", ns as f64 / 1e6))));
    lines.extend(is_right.map(|right| ("check", if right { "as on the host" } else { "wrong" }.into())));
    let text: String = lines.into_iter().map(|(name, value)| format!("{name:<10}{value}\n")).collect();
    print(&text)?;
    match is_right {
        Some(false) => Err(Error::failed("the results are not those of the host: a defect of raystep")),
        _ => Ok(()),
    }
}

/// A program that needs no scene.
#[derive(Clone, Copy, Debug)]
struct Runs {
    name: ProgramName,
    alone: &'static Alone,
}

/// All of them.
fn alone() -> impl Iterator<Item = Runs> {
    ProgramName::ALL.iter().filter_map(|&name| Some(Runs { name, alone: registered(name).alone.as_ref()? }))
}

fn named(runs: Runs) -> PossibleValue {
    PossibleValue::new(runs.name.name()).help(registered(runs.name).program().summary)
}

fn parse(name: &str) -> Result<Runs, &'static str> {
    alone().find(|runs| runs.name.name() == name).ok_or("expected a program that needs no scene")
}
