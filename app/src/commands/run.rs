//! `raystep run`: programs that need no scene.

use std::ops::ControlFlow;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use raystep_kernels::export::npy;
use raystep_kernels::options::ProgramName;
use raystep_kernels::plan::Plan;
use raystep_kernels::programs::sort::{KEY, random_keys};
use raystep_kernels::{Options, RaySource, StreamData};
use raystep_scenes::{Camera, Scene};

use crate::args::{DeviceArgs, ElementsArgs, QuietArgs};
use crate::device;
use crate::error::Error;
use crate::output::{Target, write};
use crate::session::{Session, Stopwatch};
use crate::terminal::{Progress, print};

/// A program that needs no scene.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Name {
    /// Sorts random keys by Batcher's bitonic sort, every pass of which can be watched
    Sort,
}

/// Run a stream program that needs no scene
///
/// sort puts random keys in ascending order. Its passes are a network of comparisons that does not depend on the keys:
/// 136 passes for 65,536 keys. 'raystep inspect cornell-box --program sort' shows them one by one.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  raystep run sort --elements 65536 --check
  raystep run sort --elements 1000000 --device gpu --passes-csv passes.csv
  raystep run sort --seed 7 -o keys.npy
  raystep inspect cornell-box --program sort --elements 1024")]
pub(crate) struct RunProgramArgs {
    /// The program
    program: Name,
    #[command(flatten)]
    elements: ElementsArgs,
    /// Seed of the keys
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u32,
    /// Compare with a sort on the host, and fail if a key differs
    #[arg(long)]
    check: bool,
    /// Write the sorted keys, and the element that each came from, as an npy array (layer, row, column) of uint32
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
    let Name::Sort = args.program;
    let output = args.output.as_deref().map(Target::new).transpose()?;
    let passes = args.passes_csv.as_deref().map(Target::new).transpose()?;
    let progress = Progress::new(args.quiet.quiet);
    let mut watch = Stopwatch::start();
    let chosen = device::choose(&args.device)?;
    watch.lap("device");
    let scene = Scene { name: "none".into(), ..Scene::default() };
    let rays = RaySource::Camera { camera: Camera::framing(&scene.bounds()), width: 1, height: 1 };
    let mut options = Options { program: ProgramName::Sort, timings: passes.is_some(), ..Options::new(rays) };
    (options.elements, options.samples.seed) = (args.elements.elements, args.seed);
    let (plan, data) = chosen.wait(Plan::on(&scene, &options, &chosen.device))?;
    watch.lap("plan");
    let session = Session { scene_path: PathBuf::new(), scene, inputs: Vec::new(), options, chosen, plan, data, watch };
    let mut running = session.start(&progress)?;
    let show = |now: &raystep_kernels::Progress| {
        progress.rays(now);
        ControlFlow::Continue(())
    };
    running.chosen.wait(running.renderer.run(show))?;
    let sorted = running.chosen.wait(running.renderer.values(KEY))?;
    let mut files = Vec::new();
    if let Some(target) = passes {
        files.push((target, running.passes_csv(&running.run_context(), &[])?));
    }
    if let Some(target) = output {
        let mut bytes = Vec::new();
        npy::write_stream(&mut bytes, &sorted).map_err(|error| Error::failed(error.to_string()))?;
        files.push((target, bytes));
    }
    write(files)?;
    progress.finish();

    let (renderer, keys) = (&running.renderer, args.elements.elements);
    let is_right = args.check.then(|| is_sorted(&sorted, keys, args.seed));
    let device = running.chosen.gpu().map_or("CPU".into(), |gpu| gpu.info.name.clone());
    let mut lines = vec![
        ("device", format!("{device}: {}", running.chosen.reason)),
        ("keys", keys.to_string()),
        ("passes", renderer.pass_count().to_string()),
    ];
    let ns = renderer.device_ns().filter(|&ns| ns > 0).or(renderer.host_ns());
    lines.extend(ns.map(|ns| ("time", format!("{:.3} ms", ns as f64 / 1e6))));
    lines.extend(is_right.map(|right| ("check", if right { "as the host sorts them" } else { "wrong" }.into())));
    let text: String = lines.into_iter().map(|(name, value)| format!("{name:<10}{value}\n")).collect();
    print(&text)?;
    match is_right {
        Some(false) => Err(Error::failed("the keys are not sorted: a defect of raystep")),
        _ => Ok(()),
    }
}

/// Whether these are the keys of the seed, as the host sorts them.
fn is_sorted(sorted: &StreamData, keys: u32, seed: u32) -> bool {
    let mut expected: Vec<(u32, u32)> = random_keys(keys, seed).into_iter().zip(0..).collect();
    expected.sort_unstable();
    let found = sorted.layer(0).iter().copied().zip(sorted.layer(1).iter().copied());
    found.take(keys as usize).eq(expected)
}
