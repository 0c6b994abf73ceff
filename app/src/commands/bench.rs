//! `raystep bench`

mod against;
mod baseline;
mod output;
mod process;
mod programs;
mod protocol;
mod serve;

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use clap::Args;
use raystep_kernels::options::mapping::Mapping;
use raystep_kernels::options::{Integrator, ParseOptionError};
use raystep_kernels::{Accelerator, Numerics, Options, RaySource, ScheduleKind, Traversal};
use raystep_lab::bench;
use raystep_lab::bench::gate::{self, Gate, Verdict};
use raystep_lab::meter::{Meter, Turns};
use raystep_lab::{RayKind, Size, Subject};

use crate::args::choices::{ChoiceArgs, Tuning};
use crate::args::kernel::KernelArgs;
use crate::args::{CameraArgs, DeviceArgs, QuietArgs, ReadArgs, SceneArgs, counted, named, parse_size, whole};
use crate::commands::distinct;
use crate::commands::input::{self, Input};
use crate::device;
use crate::error::Error;
use crate::output::TargetFolder;
use crate::rays_file;
use crate::session::run_id;
use crate::shard::{self, Part, ShardArgs};
use crate::terminal::{Progress, print, say};

/// Benchmark tracing
///
/// Each scene, size and kind of rays forms a group, in which every accelerator is combined with every schedule. Runs
/// are interleaved: run 1 of each configuration, then run 2 of each, and so on, in random order, so that drift affects
/// all equally. Building and compiling are timed separately. DIR/summary.csv has one row per configuration: median time
/// of a run with its interval, rays per second, counters, and the ratio to the fastest of the group; DIR/runs.csv has
/// every timed run; DIR/passes.csv has the passes of one more run of each, made before these, in which every pass is timed; DIR/run.json describes machine and
/// options, DIR/datapackage.json the columns. Hits are measured, and shading is excluded, unless --integrators asks for light:
/// then the image is measured, with shading and with the rays that it casts, which DIR/summary.csv counts by kind.
///
/// Rays: primary, from the camera; bounce, one from each primary hit, cosine-weighted about the normal; shadow, from each
/// primary hit to a light that its visible side faces, or, if the scene has none, to the top centre of its box; random,
/// from anywhere in the scene's box in any direction. They are the same in every run. Bounce and shadow rays start off
/// the surface by the bound of f32's error there.
///
/// With --at-most R, bench is a regression gate: it checks that this build takes at most R times as long as another,
/// with the same hits, tests, cells and passes. --against BINARY runs both builds alternately, in several processes
/// each. --baseline DIR compares with an earlier benchmark, and judges times only if the machine has drifted by less
/// than R. Exit code 0: this build takes at most R times as long; 1: it takes longer, or hits, counts, device or scene
/// differ, or a row is missing; 3: too noisy to tell. The verdict on times holds with 95% confidence for all rows
/// together. DIR/gate.json and DIR/gate.md have the result.
///
/// A folder with program.toml is a program of your own, which is measured as it is: DIR/kernels.csv has the times of its
/// kernels. Programs and scenes are measured apart. A kernel of your own that takes the place of a built-in one (--kernel) is
/// compared with it by a --baseline without --kernel, in configurations that have such a kernel.
///
/// With --shard I/N, only some of the scenes are measured, for N machines or jobs, and 'raystep merge' combines their
/// tables. What is compared within a scene is never divided.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  raystep bench cornell-box -o bench
  raystep bench teapot --accelerators grid,bvh --schedules second,compact,fused -o bench
  raystep bench teapot --size 512x512,1920x1080 --rays primary,bounce,shadow -o bench
  raystep bench cornell-box --integrators local,shadows -o bench
  raystep bench cornell-box --integrators photons --photons 2000 --photon-map bitonic -o bitonic
  raystep bench teapot terrain --shard 1/2 -o bench-1
  raystep bench my-program my-program-before -o programs
  raystep bench cornell-box --schedules second -o built-in
  raystep bench cornell-box --schedules second --kernel my.wgsl --baseline built-in -o own
  raystep bench teapot --repeats 50 -o before
  raystep bench teapot --repeats 50 --baseline before -o after
  raystep bench teapot --repeats 50 --baseline before --at-most 1.5 -o after
  raystep bench teapot --against old/raystep --at-most 1.05 -o gate")]
pub(crate) struct BenchArgs {
    /// The scenes: files that end in .gltf, .glb, .obj, .ply or .stl; or names, such as cornell-box; or programs of your own
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
    /// How kernels are mapped to the GPU: compute, or fragment, with choices that differ from those of the paper, such as
    /// fragment+many+early-z; see 'raystep render --help'. Fragment programs run with schedules first and second
    #[arg(long, value_name = "M,N…", value_delimiter = ',', default_value = "compute", value_parser = parse_mapping,
          help_heading = "What is measured")]
    mappings: Vec<Mapping>,
    /// How rays walk through a uniform grid, with --numerics paper: amanatides-woo, 3d-dda, or both, see 'raystep render
    /// --help'
    #[arg(long, value_name = "T,U…", value_delimiter = ',', default_value = "amanatides-woo",
          value_parser = named(Traversal::ALL, Traversal::name), help_heading = "What is measured")]
    traversals: Vec<Traversal>,
    /// What is measured: hits alone, without shading (local), or the image, with shading and all rays for its light
    /// (shadows, whitted, path, photons; see 'raystep render --help'). For primary rays
    #[arg(long, value_name = "I,J…", value_delimiter = ',', default_value = Integrator::default().name(),
          value_parser = named(Integrator::ALL, Integrator::name), help_heading = "What is measured")]
    integrators: Vec<Integrator>,
    /// Width and height in pixels, of one image or of several
    #[arg(
        long = "size",
        alias = "sizes",
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
          value_parser = named(RayKind::ALL, RayKind::name), conflicts_with = "rays_file", help_heading = "What is measured")]
    rays: Vec<RayKind>,
    /// Measured runs per configuration [default: 10; with --against 40, fewer if the answer is clear earlier]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1, MOST_RUNS), allow_negative_numbers = true,
          help_heading = "What is measured")]
    repeats: Option<u32>,
    /// Warm-up runs per configuration, not counted
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = whole::<u32>(0, MOST_RUNS), allow_negative_numbers = true,
          help_heading = "What is measured")]
    warmups: u32,
    /// Submit exactly the passes that an earlier run needed; otherwise passes are submitted in batches, and the last ones
    /// may find no active ray
    #[arg(long, conflicts_with = "against", help_heading = "What is measured")]
    replay: bool,
    /// Seed of the rays and of the order within rounds
    #[arg(long, value_name = "N", default_value_t = bench::SEED, allow_negative_numbers = true,
          value_parser = whole::<u32>(0, u64::from(u32::MAX)), help_heading = "What is measured")]
    seed: u32,
    /// Folder of an earlier benchmark, to add ratios of the times
    #[arg(long, value_name = "DIR", help_heading = "Comparison")]
    baseline: Option<PathBuf>,
    /// Another build of raystep to compare with: runs of both alternate; requires --at-most
    #[arg(long, value_name = "BINARY", conflicts_with = "baseline", help_heading = "Comparison")]
    against: Option<PathBuf>,
    /// Largest acceptable ratio of times, this build's divided by the other's: exit code 1 if it is exceeded, 3 if times
    /// are too noisy to tell
    #[arg(long, value_name = "R", value_parser = parse_ratio, allow_negative_numbers = true, help_heading = "Comparison")]
    at_most: Option<f64>,
    /// Answers a program that compares two builds, by the protocol of the module `protocol`
    #[arg(long, hide = true)]
    serve: bool,
    /// Output folder: new, or empty
    #[arg(short, long, value_name = "DIR", required_unless_present = "serve")]
    output: Option<PathBuf>,
    /// Replace the benchmark in a folder that is not empty; other files are kept
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    shard: ShardArgs,
    /// Index of the scene in files with several, counted from 0 [default: each file's default scene]
    #[arg(long, value_name = "N", value_parser = counted, allow_negative_numbers = true, help_heading = "Scene and view")]
    scene_index: Option<usize>,
    #[command(flatten)]
    read: ReadArgs,
    /// Rays instead of the camera's: .npy, float32, N×6 (origin, direction) or N×8 (origin, t_min, direction, t_max), or
    /// .f32, see 'raystep cast --help'
    #[arg(long, value_name = "F", help_heading = "What is measured")]
    rays_file: Option<PathBuf>,
    #[command(flatten)]
    quiet: QuietArgs,
    #[command(flatten)]
    camera: CameraArgs,
    #[command(flatten)]
    tuning: ChoiceArgs<Tuning>,
    #[command(flatten)]
    kernels: KernelArgs,
    #[command(flatten)]
    device: DeviceArgs,
}

/// Parses `--mappings`.
fn parse_mapping(text: &str) -> Result<Mapping, ParseOptionError> {
    text.parse()
}

/// Parses `--at-most`.
fn parse_ratio(text: &str) -> Result<f64, String> {
    let ratio = text.parse::<f64>().ok().filter(|ratio| (0.01..=1000.0).contains(ratio));
    ratio.ok_or_else(|| "expected a ratio of times from 0.01 to 1000, such as 1.05".to_owned())
}

impl BenchArgs {
    /// A scene, and how it is read.
    pub(super) fn file(&self, path: &Path) -> SceneArgs {
        SceneArgs { scene: path.to_owned(), scene_index: self.scene_index, read: self.read }
    }

    fn wanted(&self) -> Result<bench::Wanted, Error> {
        let replaced = self.kernels.read()?;
        let tuning = Options { replaced, ..self.tuning.options(RaySource::Given(Vec::new())) };
        Ok(bench::Wanted {
            configurations: bench::combinations(
                &distinct(&self.accelerators),
                &distinct(&self.schedules),
                &distinct(&self.mappings),
                &distinct(&self.traversals),
                &distinct(&self.integrators),
                &tuning,
            ),
            sizes: distinct(&self.sizes),
            rays: distinct(&self.rays),
            file: self.rays_file.as_deref().map(|path| rays_file::read(path, None)).transpose()?.map(Arc::new),
            turns: Turns { seed: u64::from(self.seed), ..Turns::of(self.warmups as usize, self.repeats() as usize) },
            longest_run: Duration::MAX,
            until: None,
            is_counted: |_| true,
            is_replayed: if self.replay { |_| true } else { |_| false },
            seed: self.seed,
            tuning,
        })
    }

    /// Where passes run: fragment programs need a GPU, if only one in software.
    pub(super) fn device(&self) -> DeviceArgs {
        self.device.if_needed(self.mappings.iter().any(|&mapping| mapping != Mapping::Compute))
    }

    fn repeats(&self) -> u32 {
        self.repeats.unwrap_or(if self.against.is_some() { 40 } else { 10 })
    }
}

/// Most runs of a configuration.
const MOST_RUNS: u64 = 100_000;

/// What a benchmark leaves behind beside its files.
struct Done {
    /// For the terminal.
    text: String,
    gate: Option<Gate>,
}

pub(crate) fn run(args: &BenchArgs) -> Result<(), Error> {
    args.tuning.check_for(&args.accelerators, &args.schedules, &args.integrators)?;
    let is_drawn = |schedule: &ScheduleKind| matches!(schedule, ScheduleKind::First | ScheduleKind::Second);
    let draws = args.mappings.iter().any(|&mapping| mapping != Mapping::Compute);
    if draws && !args.schedules.iter().any(is_drawn) {
        return Err(Error::usage(
            "--mappings: fragment programs run with schedules first and second: add --schedules second",
        ));
    }
    let is_walked = args.accelerators.contains(&Accelerator::Grid) && args.tuning.values.numerics == Numerics::Paper;
    if args.traversals.contains(&Traversal::Dda3d) && !is_walked {
        return Err(Error::usage(
            "--traversals: 3d-dda walks through a uniform grid with the paper's rules: add --accelerators grid --numerics \
             paper",
        ));
    }
    if let Some(integrator) = args.integrators.iter().find(|&&integrator| integrator != Integrator::default()) {
        let is_camera = args.rays_file.is_none() && args.rays.iter().all(|&kind| kind == RayKind::Primary);
        if !is_camera {
            return Err(Error::usage(format!(
                "--integrators {integrator}: light is measured in an image, by primary rays: omit --rays and --rays-file, or \
                 measure these rays in another benchmark"
            )));
        }
    }
    if args.serve {
        return serve::run(args);
    }
    let Some(output) = &args.output else { return Err(Error::usage("--output DIR is required")) };
    match (args.at_most, &args.against, &args.baseline) {
        (Some(_), None, None) => {
            return Err(Error::usage(
                "--at-most needs a build to compare with: add --against BINARY or --baseline DIR",
            ));
        }
        (None, Some(_), _) => return Err(Error::usage("--against needs a limit: add --at-most R, such as 1.05")),
        _ => {}
    }
    if let Some(shard) = args.shard.shard {
        let compared = [("--baseline", args.baseline.is_some()), ("--against", args.against.is_some())];
        if let Some((option, _)) = compared.iter().find(|(_, is_given)| *is_given) {
            return Err(Error::usage(format!("--shard cannot be combined with {option}: compare the merged results")));
        }
        shard.range(distinct(&args.scenes).len(), "scenes")?;
    }
    if args.against.is_some() {
        args.kernels.refuse("it replaces a kernel of one build: compare with --baseline")?;
    }
    if programs::are_programs(args)? {
        args.kernels.refuse("a program of your own has no built-in kernels")?;
        let compared = [("--baseline", args.baseline.is_some()), ("--against", args.against.is_some())];
        let with_shards = compared.into_iter().chain([("--shard", args.shard.shard.is_some())]);
        if let Some((option, _)) = with_shards.into_iter().find(|(_, is_given)| *is_given) {
            return Err(Error::usage(format!("{option} is for scenes: omit it to measure programs")));
        }
        let stale = programs::NAMES.map(str::to_owned);
        let done = TargetFolder::new(output, args.force)?.fill(&stale, |folder| programs::fill(args, folder))?;
        return if args.quiet.quiet { Ok(()) } else { print(&done.text) };
    }
    let stale = output::stale(args.at_most.is_some(), args.against.is_some(), args.shard.shard.is_some());
    let done = TargetFolder::new(output, args.force)?.fill(&stale, |folder| match (&args.against, args.at_most) {
        (Some(other), Some(at_most)) => against::fill(args, other, at_most, folder, output),
        _ => fill(args, folder, output),
    })?;
    if !args.quiet.quiet {
        print(&done.text)?;
    }
    done.gate.map_or(Ok(()), |gate| exit(&gate))
}

/// A line for each failure, and the error that determines the exit code.
fn exit(gate: &Gate) -> Result<(), Error> {
    for failure in gate.failures() {
        say(format_args!("fail: {failure}"));
    }
    match gate.verdict {
        Verdict::Pass => Ok(()),
        Verdict::Fail => Err(Error::failed(&gate.because)),
        Verdict::Undecided => Err(Error::undecided(&gate.because)),
    }
}

/// Measures and writes every file.
fn fill(args: &BenchArgs, folder: &TargetFolder, output: &Path) -> Result<Done, Error> {
    output::refuse_others(output)?;
    let progress = Progress::new(args.quiet.quiet);
    // Checks come before slow work.
    let baseline = args.baseline.as_deref().map(baseline::read).transpose()?;
    progress.stage("reading scenes");
    let (mut inputs, mut subjects) = read_scenes(args, Some(folder), &progress)?;
    let names = subjects.iter().map(|s| (s.scene.name.clone(), s.hash.to_string())).collect::<Vec<_>>();
    if let Some(shard) = args.shard.shard {
        let range = shard.range(subjects.len(), "scenes")?;
        inputs = inputs.drain(range.clone()).collect();
        subjects = subjects.drain(range).collect();
    }
    progress.stage("looking for a device");
    let meter = Meter::new(device::choose(&args.device())?);
    let wanted = args.wanted()?;
    let mut measured = bench::measure(&wanted, &subjects, run_id(), &meter, &progress)?;
    if let Some(baseline) = &baseline {
        for note in baseline.compare(&mut measured.rows) {
            progress.say(format_args!("note: {note}"));
            measured.notes.push(note);
        }
    }
    let gate = baseline
        .zip(args.at_most)
        .map(|(baseline, at_most)| baseline.gate(&measured.run_id, &measured.rows, &measured.runs, at_most));
    progress.stage("writing");
    let scenes = inputs.iter().zip(&subjects).map(|(input, subject)| output::AboutScene::new(input, subject)).collect();
    let about = output::About::new(args, &measured.run_id, &measured.notes, scenes);
    if let Some(shard) = args.shard.shard {
        let part = Part::new("bench", shard, names, about.options(), &meter.machine)?;
        let text = part.text()?;
        folder.write(shard::FILE, |out| out.write_all(text.as_bytes()))?;
    }
    output::write(folder, about.on(&meter.machine, &measured), &measured, true, gate.as_ref())?;
    progress.finish();
    progress.say(format_args!("wrote {} to {}", output::written(&gate, true).join(", "), output.display()));
    let file = args.rays_file.as_ref().and_then(|path| path.file_name()).map(|name| name.to_string_lossy());
    let text = bench::text(&measured.rows, file.as_deref());
    let text = gate.as_ref().map_or(text.clone(), |gate| format!("{text}\n{}", gate::text(gate)));
    Ok(Done { text, gate })
}

/// Reads every scene once, and refuses to overwrite any.
fn read_scenes(
    args: &BenchArgs,
    folder: Option<&TargetFolder>,
    progress: &Progress,
) -> Result<(Vec<Input>, Vec<Subject>), Error> {
    let mut all = Vec::new();
    for path in &distinct(&args.scenes) {
        let (input, subject) = input::read(args.file(path), &args.camera, progress)?;
        if let Some(folder) = folder {
            folder.refuse_inputs(&input.files, |name| output::NAMES.contains(&name))?;
        }
        all.push((input, subject));
    }
    Ok(all.into_iter().unzip())
}
