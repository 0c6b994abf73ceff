//! `raystep inspect`

mod lesson;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::{Args, Parser};
use raystep_inspector::command::{COMMANDS, Command};
use raystep_inspector::link::{Link, LinkRay, Shown};
use raystep_inspector::session_file::BUILT_IN;
use raystep_inspector::settings::Settings;
use raystep_inspector::ui::Arrival;
use raystep_kernels::AdapterChoice;
use raystep_kernels::Choices;
use raystep_kernels::programs::chosen;
use raystep_lab::text::visible;

use super::trace::Pixel;
use crate::args::choices::{ChoiceArgs, What, with_linked};
use crate::args::{DeviceArgs, RunArgs, SceneArgs, ViewArgs, whole};
use crate::device;
use crate::error::Error;
use crate::link::{LinkArgs, Wanted, link_of};
use crate::output::{Target, ending, write};
use crate::scene_file;
use crate::session_file;
use crate::terminal::{Progress, print};
use crate::usage::did_you_mean;
use crate::window::{self, SceneChoice, Start};

/// Open the inspector: step through passes, view streams, follow rays
///
/// Same as 'raystep SCENE'. With --screenshot, draws the window without a display, and exits.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  raystep inspect cornell-box
  raystep inspect teapot --accelerator bvh --pixel 200,260 --pass 40
  raystep inspect teapot.raystep-session
  raystep inspect --link \"raystep:1?scene=teapot&pixel=200,260&pass=41&stream=tmax.x\"
  raystep inspect cornell-box --screenshot box.png --window 1600x1000 --do \"Ray layout\"
  raystep inspect --lesson one-ray
  raystep inspect --lesson my-lesson.md --check")]
pub(crate) struct InspectArgs {
    #[command(flatten)]
    link: LinkArgs,
    /// Pixel of the ray to select, from the top left
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    pixel: Option<Pixel>,
    /// Start after this many passes
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<usize>(0, u64::MAX))]
    pass: Option<usize>,
    /// Begin a lesson by its name (one-ray, grid-2004, fragment-2004, crack, leaping, tie), or a Markdown file with a text
    /// and commands for each step
    ///
    /// In a file, scenes are named relative to the lesson, and have to be in its folder or below, unless --allow-outside is used.
    #[arg(
        long,
        value_name = "NAME|F.md",
        conflicts_with_all = with_linked(&[
            "scene", "scene_index", "link", "pixel", "pass", "program", "size", "camera", "eye", "look_at", "up", "fov",
        ])
    )]
    lesson: Option<PathBuf>,
    /// Begin at this step of the lesson, counted from 1
    #[arg(long, value_name = "N", requires = "lesson", value_parser = whole::<usize>(1, u64::MAX),
          allow_negative_numbers = true)]
    step: Option<usize>,
    /// Set up every step of the lesson without a display, and check that everything it refers to is visible
    #[arg(long, requires = "lesson", conflicts_with_all = ["screenshot", "step"])]
    check: bool,
    /// Draw the window to a PNG without a display, and exit
    #[arg(long, value_name = "F.png")]
    screenshot: Option<PathBuf>,
    /// Size of the window in points
    #[arg(long, value_name = "WxH", default_value = "1280x800", allow_hyphen_values = true)]
    window: Size,
    /// Pixels per point in a screenshot
    #[arg(long, value_name = "S", default_value_t = 1.0, requires = "screenshot", value_parser = parse_scale,
          allow_negative_numbers = true)]
    scale: f32,
    /// Perform this command before the screenshot, see --list; can be repeated
    #[arg(long = "do", value_name = "COMMAND", requires = "screenshot", value_parser = parse_command)]
    commands: Vec<Command>,
    /// Measure how long the window takes to respond to clicks and keys, print a table, and exit
    #[arg(long, conflicts_with_all = ["screenshot", "list"])]
    latency: bool,
    /// List all commands for --do
    #[arg(long)]
    list: bool,
    #[command(flatten)]
    program: ChoiceArgs<What>,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    run: RunArgs,
}

/// `--window`
#[derive(Clone, Copy, Debug, PartialEq)]
struct Size([f32; 2]);

impl FromStr for Size {
    type Err = &'static str;

    fn from_str(value: &str) -> Result<Self, Self::Err> {
        const WRONG: &str = "expected two integers from 16 to 16384 separated by x, such as 1280x800";
        let (width, height) = value.split_once(['x', 'X']).ok_or(WRONG)?;
        let side =
            |text: &str| text.parse::<u16>().ok().filter(|n| (16..=16384).contains(n)).map(f32::from).ok_or(WRONG);
        Ok(Self([side(width)?, side(height)?]))
    }
}

fn parse_scale(text: &str) -> Result<f32, &'static str> {
    text.parse().ok().filter(|scale| (0.25..=8.0).contains(scale)).ok_or("expected a number from 0.25 to 8")
}

fn parse_command(name: &str) -> Result<Command, String> {
    Command::named(name).ok_or_else(|| {
        let names: Vec<&str> = COMMANDS.iter().map(|info| info.name).collect();
        format!("no such command; {}'raystep inspect --list' lists them", did_you_mean(name, &names))
    })
}

pub(crate) fn run(args: InspectArgs) -> Result<(), Error> {
    // The clock starts with its first use.
    let _ = raystep_lab::machine::now_ns();
    if args.list {
        return print(&COMMANDS.iter().map(|info| info.name.to_owned() + "\n").collect::<String>());
    }
    if let Some(path) = &args.screenshot {
        ending("--screenshot", path, &["png"])?;
    }
    let is_check = args.check;
    let session = args.link.scene.clone().filter(|path| session_file::is_session(path));
    let (args, mut start) = match (&args.lesson, &session) {
        (Some(file), _) => lesson::start(file, &args)?,
        (None, Some(path)) => of_session(args, path)?,
        (None, None) => start(args)?,
    };
    if let Some(scene) = &start.scene {
        scene_file::expect_scene(&scene.path)?;
    }
    if is_check {
        return lesson::check(&device::open(&adapter(&args.device))?, start);
    }
    let is_measured = start.measured_from.is_some();
    if is_measured && start.scene.is_none() {
        return Err(Error::usage("--latency needs a scene"));
    }
    if args.screenshot.is_none() && !is_measured && !window::has_display() {
        return Err(Error::failed(
            "no display to open a window on; use --screenshot F.png to draw the window to a file, or 'raystep \
             render' for an image",
        ));
    }
    let target = args.screenshot.as_deref().map(Target::new).transpose()?;
    if let Some(target) = &target {
        let inputs: Vec<PathBuf> = start.scene.iter().map(|scene| scene.path.clone()).chain(session).collect();
        crate::output::refuse_inputs(&[Some(target)], &scene_file::canonical(&inputs))?;
    }
    if target.is_none() {
        start.begin_reading();
    }
    let gpu = device::open(&adapter(&args.device))?;
    let progress = Progress::new(false);
    if is_measured && !window::has_display() {
        progress.stage("measuring how fast the window responds");
        let table = window::latency(&gpu, start)?;
        progress.finish();
        return print(&table);
    }
    let Some(target) = target else { return window::open(gpu, start) };
    progress.stage("drawing the window");
    let picture = window::screenshot(&gpu, start, args.scale, &args.commands)?;
    let mut png = Vec::new();
    picture
        .write_with_encoder(image::codecs::png::PngEncoder::new(&mut png))
        .map_err(|e| Error::failed(format!("cannot write as PNG: {e}")))?;
    let (name, [width, height]) =
        (visible(&target.path().to_string_lossy()).into_owned(), [picture.width(), picture.height()]);
    write(vec![(target, png)])?;
    progress.finish();
    print(&format!("{name}: {width} x {height}, drawn on {}\n", gpu.info.name))
}

fn adapter(args: &DeviceArgs) -> AdapterChoice {
    args.adapter.clone().map_or(AdapterChoice::Best, AdapterChoice::Named)
}

/// The options of the window.
struct WindowArgs {
    screenshot: Option<PathBuf>,
    scale: f32,
    commands: Vec<Command>,
    device: DeviceArgs,
}

/// The request of a session's file, which has all options of the run.
fn of_session(args: InspectArgs, path: &Path) -> Result<(WindowArgs, Start), Error> {
    let at = path.display();
    let own = InspectArgs::of(path)?;
    let of_run = |args: &InspectArgs| {
        let InspectArgs { link, pixel, pass, program, view, run, .. } = args;
        let run = format!("{:?} {:?}", run.tracing, run.device.device);
        format!("{:?} {pixel:?} {pass:?} {program:?} {view:?} {run}", link.scene_index)
    };
    if of_run(&args) != of_run(&own) {
        return Err(Error::usage(format!(
            "{at} has its own options: omit all but those of the window, --adapter, and limits for reading"
        )));
    }
    let session = session_file::read(path)?;
    let link = &session.here.link;
    let scene = link.scene.as_deref().filter(|scene| !scene.starts_with(BUILT_IN));
    let scene = scene.map(|scene| SceneChoice { path: session_file::beside(path, scene), index: link.scene_index });
    let InspectArgs { link, screenshot, window, scale, commands, run, .. } = args;
    let start =
        Start { scene, session: Some((path.to_owned(), session)), read: link.read, size: window.0, ..Start::default() };
    Ok((WindowArgs { screenshot, scale, commands, device: run.device }, start))
}

impl InspectArgs {
    /// The options for a file when no others are given.
    fn of(path: &Path) -> Result<Self, Error> {
        /// The options alone.
        #[derive(Parser)]
        struct Alone {
            #[command(flatten)]
            args: InspectArgs,
        }
        let arguments = [OsStr::new("inspect"), OsStr::new("--"), path.as_os_str()];
        let alone = Alone::try_parse_from(arguments).map_err(|e| Error::failed(e.to_string()))?;
        Ok(alone.args)
    }
}

/// The request, from options or from a link.
fn start(args: InspectArgs) -> Result<(WindowArgs, Start), Error> {
    let InspectArgs { link, pixel, pass, screenshot, window, scale, commands, latency, mut program, view, run, .. } =
        args;
    let measured_from = latency.then(raystep_lab::machine::now_ns);
    let mut arrival = Arrival { pixel: pixel.map(|p| [p.x, p.y]), place: pass, ..Arrival::default() };
    if let Some(text) = &link.link {
        let link: Link = text.parse().map_err(|e| Error::usage(format!("--link: {e}")))?;
        if link.pass.is_some() && pass.is_some() {
            return Err(Error::usage("--link has a number of passes, and so does --pass: omit one of them"));
        }
        if !program.has("program") {
            program = ChoiceArgs::of(link.choices);
        }
        arrival.place = arrival.place.or(link.pass);
        arrival.shown = Shown::of(&link);
        arrival.scene_hash = link.scene_hash;
    }
    arrival.place = arrival.place.or(Arrival::picture().place);
    let is_empty = link.scene.is_none() && link.link.is_none();
    let wanted = if is_empty {
        let scene = SceneArgs { scene: PathBuf::new(), scene_index: None, read: link.read };
        Wanted { scene, view, run, ray: None, scene_hash: None }
    } else {
        link.wanted(view, run)?
    };
    let run = &wanted.run;
    run.check(&wanted.view)?;
    if !run.tracing.values.schedule.is_stepped() {
        return Err(Error::usage(
            "--schedule fused traces a ray in one pass, so it cannot be stepped; use first, second or compact",
        ));
    }
    if wanted.view.camera.eye.is_some() {
        // The same checks as elsewhere; they do not depend on the scene for a custom camera.
        scene_file::camera(&wanted.view.camera, &raystep_scenes::Scene::default())?;
    }
    let linked = link_of(&wanted)?;
    if let Some(LinkRay::Pixel(pixel)) = linked.ray {
        if arrival.pixel.is_some() {
            return Err(Error::usage("--link has a pixel, and so does --pixel: omit one of them"));
        }
        arrival.pixel = Some(pixel);
    }
    if matches!(linked.ray, Some(LinkRay::Given(_))) && linked.choices.samples.count > 1 {
        return Err(Error::usage("--link has a single ray, to which --spp does not apply"));
    }
    let [width, height] = linked.size;
    if let Some([x, y]) = arrival.pixel
        && (x >= width || y >= height)
    {
        let (right, bottom) = (width - 1, height - 1);
        return Err(Error::usage(format!(
            "--pixel {x},{y}: the image has pixels 0,0 to {right},{bottom}; --size enlarges it"
        )));
    }
    let mut settings = Settings { replaced: wanted.run.kernels.read()?, ..Settings::from(&linked) };
    let Choices { program, elements, .. } = program.values;
    settings.choices = Choices { program, elements, ..settings.choices };
    let Wanted { scene, run, .. } = wanted;
    let read = scene.read;
    let scene = match (is_empty, chosen(&settings.choices).alone.is_some()) {
        (false, _) => Some(SceneChoice { path: scene.scene, index: scene.scene_index }),
        // Any scene will do.
        (true, true) => Some(SceneChoice { path: PathBuf::from(format!("{BUILT_IN}cornell-box")), index: None }),
        (true, false) => None,
    };
    let start = Start { scene, read, settings, arrival, size: window.0, measured_from, ..Start::default() };
    Ok((WindowArgs { screenshot, scale, commands, device: run.device }, start))
}
