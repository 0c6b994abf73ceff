//! `raystep bench`

mod output;

use std::path::{Path, PathBuf};

use clap::Args;
use raystep_kernels::{Accelerator, RaySource, ScheduleKind};
use raystep_lab::bench::{self, Baseline};
use raystep_lab::meter::Meter;
use raystep_lab::{RayKind, Size, Subject};

use crate::args::{
    CameraArgs, DeviceArgs, QuietArgs, ReadArgs, SceneArgs, TuningArgs, counted, named, parse_size, whole,
};
use crate::commands::distinct;
use crate::commands::input::{self, Input};
use crate::device;
use crate::error::Error;
use crate::output::TargetFolder;
use crate::scene_file::read_file;
use crate::session::run_id;
use crate::terminal::{Progress, print};

/// Benchmark tracing
///
/// Each scene, size and kind of rays forms a group, in which every accelerator is combined with every schedule. Runs
/// are interleaved: run 1 of each configuration, then run 2 of each, and so on, so that drift affects all equally.
/// Building and compiling are timed separately. DIR/summary.csv has one row per configuration: n, median, 5th and 95th
/// percentile of the device time of a run, rays per second, and counters; DIR/passes.csv has the passes of one
/// additional run of each; DIR/run.json describes machine and options. Shading is excluded.
///
/// Rays: primary, from the camera; bounce, one from each primary hit, cosine-weighted about the normal; shadow, from
/// each primary hit to a light, or, if the scene has none, to the top centre of its box; random, from anywhere in the
/// scene's box in any direction. They are the same in every run.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  raystep bench scenes/cornell-box.gltf -o bench
  raystep bench scenes/teapot.glb --accelerators grid,bvh --schedules second,compact,fused -o bench
  raystep bench scenes/teapot.glb --sizes 512x512,1920x1080 --rays primary,bounce,shadow -o bench
  raystep bench scenes/teapot.glb --repeats 50 -o before
  raystep bench scenes/teapot.glb --repeats 50 --baseline before -o after")]
pub(crate) struct BenchArgs {
    /// The scenes: glTF 2.0, .gltf or .glb
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// Acceleration structures, see 'raystep render --help'
    #[arg(long, value_name = "A,B…", value_delimiter = ',', default_value = Accelerator::default().name(),
          value_parser = named(Accelerator::ALL, Accelerator::name), help_heading = "What is measured")]
    accelerators: Vec<Accelerator>,
    /// Schedules, see 'raystep render --help'
    #[arg(long, value_name = "S,T…", value_delimiter = ',', default_value = ScheduleKind::default().name(),
          value_parser = named(ScheduleKind::ALL, ScheduleKind::name), help_heading = "What is measured")]
    schedules: Vec<ScheduleKind>,
    /// Width and height in pixels
    #[arg(
        long,
        value_name = "WxH…",
        value_delimiter = ',',
        default_value = "512x512",
        value_parser = parse_size,
        allow_hyphen_values = true,
        help_heading = "What is measured"
    )]
    sizes: Vec<Size>,
    /// Kinds of rays
    #[arg(long, value_name = "KIND…", value_delimiter = ',', default_value = RayKind::default().name(),
          value_parser = named(RayKind::ALL, RayKind::name), help_heading = "What is measured")]
    rays: Vec<RayKind>,
    /// Measured runs per configuration
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = whole::<u32>(1, MOST_RUNS), allow_negative_numbers = true,
          help_heading = "What is measured")]
    repeats: u32,
    /// Warm-up runs per configuration, not counted
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = whole::<u32>(0, MOST_RUNS), allow_negative_numbers = true,
          help_heading = "What is measured")]
    warmups: u32,
    /// Folder of an earlier benchmark, to add ratios of the times
    #[arg(long, value_name = "DIR")]
    baseline: Option<PathBuf>,
    /// Output folder: new, or empty
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Replace the benchmark in a folder that is not empty; other files are kept
    #[arg(long)]
    force: bool,
    /// Index of the scene in files with several, counted from 0 [default: each file's default scene]
    #[arg(long, value_name = "N", value_parser = counted, allow_negative_numbers = true, help_heading = "Scene and view")]
    scene_index: Option<usize>,
    #[command(flatten)]
    read: ReadArgs,
    #[command(flatten)]
    quiet: QuietArgs,
    #[command(flatten)]
    camera: CameraArgs,
    #[command(flatten)]
    tuning: TuningArgs,
    #[command(flatten)]
    device: DeviceArgs,
}

impl BenchArgs {
    /// A scene, and how it is read.
    fn file(&self, path: &Path) -> SceneArgs {
        SceneArgs { scene: path.to_owned(), scene_index: self.scene_index, read: self.read }
    }

    fn wanted(&self) -> bench::Wanted {
        bench::Wanted {
            accelerators: distinct(&self.accelerators),
            schedules: distinct(&self.schedules),
            sizes: distinct(&self.sizes),
            rays: distinct(&self.rays),
            repeats: self.repeats,
            warmups: self.warmups,
            tuning: self.tuning.options(RaySource::Given(Vec::new())),
        }
    }
}

/// Most runs of a configuration.
const MOST_RUNS: u64 = 100_000;

pub(crate) fn run(args: &BenchArgs) -> Result<(), Error> {
    args.tuning.check(&args.accelerators, &args.schedules)?;
    let table = TargetFolder::new(&args.output, args.force)?.fill(&[], |folder| fill(args, folder))?;
    if args.quiet.quiet { Ok(()) } else { print(&table) }
}

/// Measures and writes every file; returns the table of results.
fn fill(args: &BenchArgs, folder: &TargetFolder) -> Result<String, Error> {
    output::refuse_others(&args.output)?;
    let progress = Progress::new(args.quiet.quiet);
    // Checks come before slow work.
    let baseline = args.baseline.as_deref().map(read_baseline).transpose()?;
    progress.stage("reading scenes");
    let (inputs, subjects) = read_scenes(args, folder, &progress)?;
    progress.stage("looking for a device");
    let meter = Meter::new(device::choose(&args.device)?);
    let wanted = args.wanted();
    let mut measured = bench::measure(&wanted, &subjects, run_id(), &meter, &progress)?;
    if let Some(baseline) = &baseline {
        for note in baseline.compare(&mut measured.rows) {
            progress.say(format_args!("note: {note}"));
            measured.notes.push(note);
        }
    }
    progress.stage("writing");
    output::write(folder, args, &wanted, &meter.machine, &inputs, &subjects, &measured)?;
    progress.finish();
    progress.say(format_args!("wrote {} to {}", output::NAMES.join(", "), args.output.display()));
    Ok(bench::text(&measured.rows))
}

/// Reads every scene once, and refuses to overwrite any.
fn read_scenes(
    args: &BenchArgs,
    folder: &TargetFolder,
    progress: &Progress,
) -> Result<(Vec<Input>, Vec<Subject>), Error> {
    let mut all = Vec::new();
    for path in &distinct(&args.scenes) {
        let (input, subject) = input::read(args.file(path), &args.camera, progress)?;
        folder.refuse_inputs(&input.files, |name| output::NAMES.contains(&name))?;
        all.push((input, subject));
    }
    Ok(all.into_iter().unzip())
}

/// Most bytes of an earlier summary: several million configurations.
const MOST_BYTES: u64 = 1 << 30;

/// Reads the summary from the folder of an earlier benchmark.
fn read_baseline(folder: &Path) -> Result<Baseline, Error> {
    let path = folder.join(output::SUMMARY);
    let cannot = |reason: String| {
        let at = path.display();
        Error::failed(format!("--baseline: {at}: {reason}; expected a folder written by 'raystep bench'"))
    };
    let bytes = read_file(&path, MOST_BYTES).map_err(|e| cannot(e.to_string()))?;
    let rows = bench::read_summary(bytes.as_slice()).map_err(|e| cannot(e.to_string()))?;
    Ok(Baseline { folder: folder.display().to_string(), rows })
}
