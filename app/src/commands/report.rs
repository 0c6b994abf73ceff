//! `raystep report`

mod bundle;
mod verify;

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::str::FromStr as _;
use std::sync::Arc;
use std::time::Duration;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use raystep_kernels::{Accelerator, GridSize, ScheduleKind};
use raystep_lab::meter::Meter;
use raystep_lab::report::methods::{self, Method};
use raystep_lab::report::{self, About, Only, Report, SECTIONS, Section, Wanted};
use raystep_lab::stiff::{self, Kept, Start};
use raystep_lab::text::visible;
use raystep_lab::{Machine, Size};

use crate::args::{CameraArgs, DeviceArgs, QuietArgs, ReadArgs, SceneArgs, counted, named, parse_size, whole};
use crate::commands::input::Input;
use crate::commands::unfinished::Unfinished;
use crate::commands::{distinct, input};
use crate::device;
use crate::error::Error;
use crate::output::{self, Target, TargetFolder};
use crate::rays_file;
use crate::scene_file::read_file;
use crate::session::run_id;
use crate::terminal::{Progress, print};

/// Report error against run time: CSV files, figures and a page
///
/// Measures how fast rays are resolved, and how many wrongly, by accelerator and schedule; the cost and benefit of each
/// numerical rule; errors far from the origin and at tiny and huge scales; effects of grid resolution and samples per
/// pixel; and what omitting unneeded work saves. Every ray, or a sample of them, is compared with exact hits in f64.
///
/// Each of the 8 sections takes at most about --seconds N per scene: 60, with --quick 20, and in small scenes much less.
/// Slow choices run once or are left out, which the page says. DIR has the page and its files after the first section,
/// which is the answer, and again after each other one.
///
/// DIR/index.html is self-contained; all its numbers are also in CSV files. Each of its figures is there for a paper, too,
/// as PDF and SVG of one column's width (84 mm) and of two columns' (178 mm), such as
/// DIR/cornell-box-choices-precision-one-column.pdf: \includegraphics takes it as it is. DIR/captions.tex has their
/// captions for LaTeX, and says how to use them. The same command on the same machine finds the same errors; times
/// differ. The first sentences of the page are also printed.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  raystep report cornell-box -o report
  raystep report cornell-box teapot --device gpu -o report
  raystep report teapot --section rules,moved --size 256x256 -o report
  raystep report cornell-box --quick -o report
  raystep report terrain --section choices --accelerators grid,bvh --seconds 20 -o report
  raystep report cornell-box -o report --bundle report.zip
  raystep report --verify report.zip")]
pub(crate) struct ReportArgs {
    /// The scenes: files that end in .gltf, .glb, .obj, .ply or .stl; or names, such as cornell-box
    #[arg(required_unless_present = "verify", value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// Output folder: new, or empty
    #[arg(short, long, value_name = "DIR", required_unless_present = "verify")]
    output: Option<PathBuf>,
    /// Also write a ZIP file with the report, its inputs and everything needed to repeat it
    #[arg(long, value_name = "FILE.zip")]
    bundle: Option<PathBuf>,
    /// Make a bundled report again, and compare: everything but times must be the same on the CPU, or on the same
    /// adapter with the same driver
    #[arg(long, value_name = "FILE.zip", conflicts_with_all = ["scenes", "output", "bundle"])]
    verify: Option<PathBuf>,
    /// Replace the report in a folder that is not empty; other files are kept
    #[arg(long)]
    force: bool,
    /// Use fewer rays and repeats
    #[arg(long)]
    quick: bool,
    /// About how long a section may take per scene; stiff takes its own time [default: 60; with --quick 20]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1, 36_000), allow_negative_numbers = true)]
    seconds: Option<u32>,
    /// Seed of rays, orders and samples
    #[arg(long, value_name = "N", default_value_t = report::SEED, allow_negative_numbers = true,
          value_parser = whole::<u32>(0, u64::from(u32::MAX)))]
    seed: u32,
    /// Seeds in sections samples, strategies and photon-maps [default: 10; at least 6 for intervals]
    #[arg(long, value_name = "N", default_value_t = report::SEEDS, hide_default_value = true, allow_negative_numbers = true,
          value_parser = whole::<u32>(1, 1000))]
    seeds: u32,
    /// Also write DIR/rays.csv: every judged ray, with its verdict, error and error bound
    #[arg(long)]
    rays_csv: bool,
    /// CSV file with results of other programs, ranked with raystep's: columns method, ns_per_ray, judged_rays and
    /// wrong_rays; optionally scene, ns_per_ray_low, ns_per_ray_high and undecided
    #[arg(long, value_name = "FILE.csv")]
    methods: Option<PathBuf>,
    /// Write only these sections [default: all but stiff]
    #[arg(long = "section", value_name = "A,B…", value_delimiter = ',',
          value_parser = PossibleValuesParser::new(SECTIONS.iter().map(|s| PossibleValue::new(s.name).help(s.help))))]
    sections: Vec<String>,
    /// Index of the scene in files with several, counted from 0 [default: each file's default scene]
    #[arg(long, value_name = "N", value_parser = counted, allow_negative_numbers = true, help_heading = "Scene and view")]
    scene_index: Option<usize>,
    #[command(flatten)]
    read: ReadArgs,
    /// Width and height of views in pixels [default: 192x192; with --quick 128x128]
    #[arg(long, value_name = "WxH", value_parser = parse_size, help_heading = "Scene and view",
          allow_hyphen_values = true)]
    size: Option<Size>,
    /// Measure only these structures [default: all]
    #[arg(long, value_name = "A,B…", value_delimiter = ',', help_heading = "Tracing",
          value_parser = named(STRUCTURES, Accelerator::name))]
    accelerators: Vec<Accelerator>,
    /// Measure only these schedules, where a section varies them [default: all]
    #[arg(long, value_name = "A,B…", value_delimiter = ',', help_heading = "Tracing",
          value_parser = named(ScheduleKind::ALL, ScheduleKind::name))]
    schedules: Vec<ScheduleKind>,
    /// Number of grid cells in section rules [default: auto]
    #[arg(long, value_name = "auto|N|NX,NY,NZ", default_value = "auto", hide_default_value = true,
          value_parser = GridSize::from_str, allow_hyphen_values = true, help_heading = "Tracing")]
    grid: GridSize,
    /// Rays for section choices, instead of the camera's: .npy, float32, N×6 (origin, direction) or N×8 (origin, t_min,
    /// direction, t_max), or .f32, see 'raystep cast --help'
    #[arg(long, value_name = "F", help_heading = "Rays")]
    rays_file: Option<PathBuf>,
    /// Groups of those rays, judged separately: .npy, N integers
    #[arg(long, value_name = "F", requires = "rays_file", help_heading = "Rays")]
    strata: Option<PathBuf>,
    #[command(flatten)]
    quiet: QuietArgs,
    #[command(flatten)]
    camera: CameraArgs,
    #[command(flatten)]
    pub(super) device: DeviceArgs,
}

/// The structures of a report.
const STRUCTURES: &[Accelerator] = &[Accelerator::Grid, Accelerator::Irregular, Accelerator::Bvh, Accelerator::None];

/// Default pixels per side, for quick and full reports.
const SIDES: [u32; 2] = [128, 192];

impl ReportArgs {
    /// A scene, and how it is read.
    pub(super) fn file(&self, path: &Path) -> SceneArgs {
        SceneArgs { scene: path.to_owned(), scene_index: self.scene_index, read: self.read }
    }

    fn size(&self) -> Size {
        let side = if self.quick { SIDES[0] } else { SIDES[1] };
        self.size.unwrap_or(Size { width: side, height: side })
    }

    fn seconds(&self) -> u32 {
        self.seconds.unwrap_or(report::SECONDS[usize::from(!self.quick)])
    }

    /// The arguments that repeat this report, but for scenes and output: those of the command line, and the device.
    fn repeating(&self, machine: &Machine) -> Vec<String> {
        let mut words = vec!["--seed".to_owned(), self.seed.to_string(), "--size".to_owned(), self.size().to_string()];
        let mut add = |name: &str, value: String| words.extend([name.to_owned(), value]);
        add("--grid", self.grid.to_string());
        add("--device", machine.kind().to_owned());
        if machine.gpu().is_some() {
            add("--adapter", machine.name());
        }
        if !self.sections.is_empty() {
            add("--section", self.sections.join(","));
        }
        let mut add_names = |option: &str, names: Vec<&str>| {
            if !names.is_empty() {
                add(option, names.join(","));
            }
        };
        add_names("--accelerators", self.accelerators.iter().map(|a| a.name()).collect());
        add_names("--schedules", self.schedules.iter().map(|s| s.name()).collect());
        add("--seconds", self.seconds().to_string());
        if let Some(index) = self.scene_index {
            add("--scene-index", index.to_string());
        }
        self.camera.words().into_iter().for_each(|(name, value)| add(name, value));
        let flags = [("--quick", self.quick), ("--rays-csv", self.rays_csv)];
        words.extend(flags.into_iter().filter(|(_, is_set)| *is_set).map(|(name, _)| name.to_owned()));
        words
    }

    /// Input files other than scenes, with the options that name them.
    fn input_files(&self) -> Vec<(&'static str, &Path)> {
        let all = [("--rays-file", &self.rays_file), ("--strata", &self.strata), ("--methods", &self.methods)];
        all.into_iter().filter_map(|(option, path)| Some((option, path.as_deref()?))).collect()
    }

    fn sections(&self) -> Vec<&'static Section> {
        let is_wanted = |s: &&Section| match self.sections.is_empty() {
            true => s.is_default,
            false => self.sections.iter().any(|name| name == s.name),
        };
        SECTIONS.iter().filter(is_wanted).collect()
    }
}

pub(crate) fn run(args: &ReportArgs) -> Result<(), Error> {
    let progress = Progress::new(args.quiet.quiet);
    match &args.verify {
        Some(bundle) => verify::run(bundle, args.read.max_memory, &progress),
        None => {
            let (_, lead) = report(args, &progress)?;
            progress.finish();
            let page = args.output.iter().map(|output| output.join(report::PAGE)).next().unwrap_or_default();
            progress.say(format_args!(
                "wrote {}, its CSV files, and its figures for papers, *-one-column.pdf, *-two-columns.pdf and .svg, \
                 with captions.tex",
                page.display()
            ));
            if args.quiet.quiet { Ok(()) } else { print(&lead.iter().map(|s| format!("{s}\n")).collect::<String>()) }
        }
    }
}

/// Measures and writes everything; returns the machine, and the first sentences of the page.
fn report(args: &ReportArgs, progress: &Progress) -> Result<(Machine, Vec<String>), Error> {
    let Some(output) = &args.output else { return Err(Error::usage("--output is missing")) };
    let bundle = args.bundle.as_deref().map(Target::new).transpose()?;
    let is_long = args.sections().iter().any(|section| section.file == stiff::CSV);
    let unfinished = if is_long { Some(Unfinished::beside(output)?) } else { None };
    let mut page = Page { output, folder: Some(TargetFolder::new(output, args.force)?) };
    let (report, inputs, machine, run_id) = measure(args, unfinished.as_ref(), &mut page, progress)?;
    progress.stage("writing");
    let lead = report.lead();
    let files = page.write(&report, &machine, None)?;
    let contents = bundle::Contents {
        run_id: &run_id,
        seed: args.seed,
        machine: &machine,
        arguments: args.repeating(&machine),
        options: args.input_files(),
    };
    let zip = bundle.is_some().then(|| bundle::zip(contents, &inputs, args.read.max_memory, files)).transpose()?;
    unfinished.iter().for_each(Unfinished::remove);
    if let Some((target, bytes)) = bundle.zip(zip) {
        output::write(vec![(target, bytes)])?;
    }
    Ok((machine, lead))
}

/// The report's folder, which is written again after every section.
struct Page<'a> {
    output: &'a Path,
    /// Before the first time.
    folder: Option<TargetFolder>,
}

impl Page<'_> {
    /// Replaces the folder's report by what there is. `progress` says how much of it, unless it is complete.
    fn write(&mut self, report: &Report, machine: &Machine, progress: Option<String>) -> Result<Files, Error> {
        let mut about = about(machine);
        about.extend(progress.map(|progress| ("unfinished", progress)));
        let files = report.files(&about).map_err(Error::failed)?;
        let folder = self.folder.take().map_or_else(|| TargetFolder::new(self.output, true), Ok)?;
        folder.fill(&report_files(self.output), |folder| {
            files.iter().try_for_each(|(name, bytes)| folder.write(name, |out| out.write_all(bytes)))
        })?;
        Ok(files)
    }
}

/// Files by name.
type Files = Vec<(String, Vec<u8>)>;

/// Reads the scenes and measures; writes `page` whenever a section is ready.
fn measure(
    args: &ReportArgs,
    unfinished: Option<&Unfinished>,
    page: &mut Page<'_>,
    progress: &Progress,
) -> Result<(Report, Vec<Input>, Machine, String), Error> {
    let output = page.output;
    let names = report_files(output);
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    output::refuse_others(output, &names, "a report", report::PAGE, report::is_report)?;
    progress.stage("reading scenes");
    let (mut inputs, mut subjects) = (Vec::new(), Vec::new());
    for path in &distinct(&args.scenes) {
        let (input, subject) = input::read(args.file(path), &args.camera, progress)?;
        page.folder.iter().try_for_each(|folder| folder.refuse_inputs(&input.files, report::is_ours))?;
        inputs.push(input);
        subjects.push(subject);
    }
    if args.rays_file.is_some() && !args.sections().iter().any(|section| section.name == "choices") {
        return Err(Error::usage("--rays-file applies to the section choices: omit it, or add --section choices"));
    }
    let methods = args.methods.as_deref().map(read_methods).transpose()?.unwrap_or_default();
    let rays = args.rays_file.as_deref().map(|path| rays_file::read(path, args.strata.as_deref())).transpose()?;
    progress.stage("looking for a device");
    let meter = Meter::new(device::choose(&args.device)?);
    let run_id = run_id();
    let stiff = stiff::Wanted { seed: args.seed, ..stiff::Wanted::new(run_id.clone(), args.quick) };
    let stiff = match unfinished {
        Some(unfinished) => unfinished.start(stiff, &meter.machine, progress)?,
        None => Start::new(stiff, Kept::default(), |_, _| Ok(())),
    };
    let wanted = Wanted {
        sections: args.sections(),
        size: args.size(),
        grid: args.grid,
        is_quick: args.quick,
        time: Duration::from_secs(args.seconds().into()),
        only: Only { accelerators: distinct(&args.accelerators), schedules: distinct(&args.schedules) },
        seed: args.seed,
        seeds: args.seeds,
        has_rays: args.rays_csv,
        methods,
        rays,
        stiff: Arc::new(stiff),
    };
    let (mut done, all) = (0, wanted.sections.len() * subjects.len());
    let ready = |report: &Report| {
        done += 1;
        page.write(report, &meter.machine, Some(format!("{done} of {all} sections so far"))).map(drop)
    };
    let measuring = report::measure(&wanted, &subjects, run_id.clone(), &meter, progress, ready);
    let report: Report = meter.machine.wait(measuring)?;
    Ok((report, inputs, meter.machine, run_id))
}

/// Most bytes of a file of methods.
const MOST_METHODS: u64 = 16 << 20;

fn read_methods(path: &Path) -> Result<Vec<Method>, Error> {
    let cannot = |reason: &dyn std::fmt::Display| Error::failed(format!("--methods {}: {reason}", path.display()));
    let bytes = read_file(path, MOST_METHODS).map_err(|e| cannot(&e))?;
    methods::read(bytes.as_slice()).map_err(|e| cannot(&e))
}

/// Existing files of an earlier report. They are replaced with it: a new one may have fewer sections and plots.
fn report_files(folder: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    names.filter(|name| report::is_ours(name)).collect()
}

/// The machine and the command.
fn about(machine: &Machine) -> About {
    let command_line = std::env::args_os().skip(1).map(|argument| visible(&argument.to_string_lossy()).into_owned());
    let mut about = vec![
        ("command", std::iter::once("raystep".to_owned()).chain(command_line).collect::<Vec<_>>().join(" ")),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("commit", env!("RAYSTEP_COMMIT").to_owned()),
        ("operating system", std::env::consts::OS.to_owned()),
        ("device", format!("{} ({})", machine.kind(), machine.reason)),
    ];
    about.extend(cpu_model().map(|model| ("CPU", model)));
    match machine.gpu() {
        Some(gpu) => {
            let info = raystep_kernels::export::json::AdapterInfo::from(gpu);
            about.extend([
                ("adapter", format!("{} ({}, {})", info.name, info.kind, info.backend)),
                ("driver", info.driver),
            ]);
        }
        None => {
            let cores = std::thread::available_parallelism().map_or(1, usize::from);
            about.push(("adapter", format!("CPU with {cores} cores")));
        }
    }
    about
}

/// The processor's name, where Linux tells it.
fn cpu_model() -> Option<String> {
    let about = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let model = about.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'))?;
    Some(visible(model.1.trim()).into_owned()).filter(|model| !model.is_empty())
}
