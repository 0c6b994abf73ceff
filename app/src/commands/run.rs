//! `raystep run`: users' programs, and those of ours that need no scene.

mod result;

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clap::Args;
use raystep_kernels::options::ProgramName;
use raystep_kernels::plan::Plan;
use raystep_kernels::programs::own::OwnResult;
use raystep_kernels::programs::{Alone, registered};
use raystep_kernels::{Options, RaySource, Stream, StreamData};
use raystep_scenes::{Camera, Scene};

use crate::args::choices::{Amount, ChoiceArgs};
use crate::args::{DeviceArgs, QuietArgs, SightArgs};
use crate::device;
use crate::error::Error;
use crate::output::{Target, ending, write};
use crate::program_folder;
use crate::scene_file::{self, SceneFile};
use crate::session::{Session, Stopwatch};
use crate::terminal::{Progress, print};
use crate::usage::did_you_mean;

/// Run a stream program: one of your own, or sort
///
/// A folder with program.toml is a program of your own; 'raystep new NAME' makes one. FOLDER@SCENE names the scene of a
/// program that reads one. sort puts random keys in ascending order. Its passes are a network of comparisons that does not
/// depend on the keys: 136 passes for 65,536 keys. 'raystep inspect FOLDER' and 'raystep inspect cornell-box --program sort'
/// show the passes one by one.
#[derive(Args, Debug)]
#[command(mut_arg("seed", |seed| seed.help("Seed of sort's keys")), mut_arg("elements", |elements| elements.help("How many keys sort has")),
    after_help = "\
Examples:
  raystep run my-program -o result.png
  raystep run my-program --passes-csv passes.csv --device gpu
  raystep run my-tracer@teapot --size 640x480 -o teapot.png
  raystep run sort --elements 65536 --check
  raystep run sort --seed 7 -o keys.npy
  raystep inspect my-program")]
pub(crate) struct RunProgramArgs {
    /// The program: a folder with program.toml, FOLDER@SCENE for a program that reads a scene, or sort
    #[arg(value_name = "FOLDER[@SCENE]|sort")]
    program: PathBuf,
    #[command(flatten)]
    size: ChoiceArgs<Amount>,
    /// Of sort: compare with the same computation on the host, and fail if a result differs; for a folder there is 'raystep
    /// check'
    #[arg(long)]
    check: bool,
    /// Write the result: as a picture (.png), a plot (.svg), a table with a row per element (.csv), or an array (layer, row, column) (.npy)
    #[arg(short, long, value_name = "F")]
    output: Option<PathBuf>,
    /// Time every pass, and write one row per pass
    #[arg(long, value_name = "F")]
    passes_csv: Option<PathBuf>,
    #[command(flatten)]
    sight: SightArgs,
    #[command(flatten)]
    quiet: QuietArgs,
    #[command(flatten)]
    device: DeviceArgs,
}

/// What runs.
struct Runs {
    scene: Scene,
    options: Options,
    /// The stream of the results, if it is known.
    results: Option<Stream>,
    shown: Option<OwnResult>,
    /// Whether results are right, if they are the same on the host.
    are_right: Option<fn(&Options, &StreamData) -> bool>,
    files: Vec<PathBuf>,
}

/// The names of programs that need no scene.
fn alone() -> impl Iterator<Item = (ProgramName, &'static Alone)> {
    ProgramName::ALL.iter().filter_map(|&name| Some((name, registered(name).alone.as_ref()?)))
}

/// A view for programs that look at none.
fn nothing() -> RaySource {
    RaySource::Camera { camera: Camera::framing(&Scene::default().bounds()), width: 1, height: 1 }
}

impl Runs {
    fn of(program: &Path, size: &ChoiceArgs<Amount>, sight: &SightArgs) -> Result<Self, Error> {
        if program_folder::find(program).is_some() {
            let (SceneFile { folder, scene, files, .. }, rays) = scene_file::read_program(program, sight)?;
            let shown = folder.as_ref().map(program_folder::program).transpose()?.and_then(|own| own.result);
            let options = Options { folder, ..size.options(rays) };
            let results = shown.map(|result| result.stream);
            return Ok(Self { scene, options, results, shown, are_right: None, files });
        }
        let scene = Scene { name: "none".into(), ..Scene::default() };
        let name = program.to_string_lossy();
        if let Some((name, alone)) = alone().find(|(of, _)| of.name() == name) {
            let options = Options { program: name, ..size.options(nothing()) };
            let are_right = Some(alone.are_right);
            return Ok(Self {
                scene,
                options,
                results: Some(alone.results),
                shown: None,
                are_right,
                files: Vec::new(),
            });
        }
        let names: Vec<&str> = alone().map(|(name, _)| name.name()).collect();
        let hint = did_you_mean(&name, &names);
        Err(Error::usage(format!(
            "{name}: neither a folder with program.toml nor a program that needs no scene; {hint}'raystep new NAME' makes a folder"
        )))
    }
}

pub(crate) fn run(args: &RunProgramArgs) -> Result<(), Error> {
    if let Some(path) = &args.output {
        ending("-o", path, &["png", "svg", "csv", "npy"])?;
    }
    let output = args.output.as_deref().map(Target::new).transpose()?;
    let passes = args.passes_csv.as_deref().map(Target::new).transpose()?;
    let runs = Runs::of(&args.program, &args.size, &args.sight)?;
    crate::output::refuse_inputs(&[output.as_ref(), passes.as_ref()], &crate::scene_file::canonical(&runs.files))?;
    if args.check && runs.are_right.is_none() {
        return Err(Error::usage("--check: 'raystep check FOLDER' checks a program of your own"));
    }
    if output.is_some() && runs.results.is_none() {
        return Err(Error::usage(
            "-o: program.toml names no result; [result] needs stream = \"NAME\", and 'raystep dump' writes all streams",
        ));
    }
    let progress = Progress::new(args.quiet.quiet);
    let mut watch = Stopwatch::start();
    let is_own = runs.options.folder.is_some();
    let chosen = device::choose(&if is_own { args.device.for_users() } else { args.device.clone() })?;
    watch.lap("device");
    let options = Options { timings: passes.is_some(), ..runs.options };
    let scene = runs.scene;
    let (plan, data) = chosen.wait(Plan::on(&scene, &options, &chosen.device))?;
    watch.lap("plan");
    let session = Session { scene_path: PathBuf::new(), scene, inputs: Vec::new(), options, chosen, plan, data, watch };
    let mut running = session.start(&progress)?;
    let show = |now: &raystep_kernels::Progress| {
        progress.rays(now);
        ControlFlow::Continue(())
    };
    running.chosen.wait(running.renderer.run(show))?;
    // With a scene, the program may have more streams than before.
    let here = |stream: Stream| running.renderer.plan().program.stream(stream.name());
    let shown = runs.shown.and_then(|shown| Some(OwnResult { stream: here(shown.stream)?, ..shown }));
    let results = match runs.results.and_then(here) {
        Some(stream) => Some(running.chosen.wait(running.renderer.values(stream))?),
        None => None,
    };
    let mut files = Vec::new();
    if let Some(target) = passes {
        files.push((target, running.passes_csv(&running.run_context(), &[])?));
    }
    if let Some((target, results)) = output.zip(results.as_ref()) {
        let elements = running.renderer.size(results.stream.info().elements).map_or(0, |size| size.count);
        let bytes =
            result::file(target.path(), results, elements, shown.as_ref(), running.renderer.plan().program.states)?;
        files.push((target, bytes));
    }
    write(files)?;
    progress.finish();

    let renderer = &running.renderer;
    let is_right = args.check.then(|| {
        runs.are_right.zip(results.as_ref()).is_some_and(|(are_right, results)| are_right(&running.options, results))
    });
    let device = running.chosen.gpu().map_or("CPU".into(), |gpu| gpu.info.name.clone());
    let main = renderer.plan().program.elements[0];
    let mut lines = vec![
        ("device", format!("{device}: {}", running.chosen.reason)),
        (main.name, renderer.plan().rays.to_string()),
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
