//! `raystep report`

use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::PossibleValuesParser;
use raystep_kernels::GridSize;
use raystep_lab::meter::Meter;
use raystep_lab::report::{self, About, SECTIONS, Section, Wanted};
use raystep_lab::text::visible;
use raystep_lab::{Machine, Size};

use crate::args::{CameraArgs, DeviceArgs, QuietArgs, ReadArgs, SceneArgs, counted, parse_grid, parse_size, whole};
use crate::commands::{distinct, input};
use crate::device;
use crate::error::Error;
use crate::output::{self, TargetFolder};
use crate::session::run_id;
use crate::terminal::Progress;

/// Report error against run time: CSV files, plots and a page
///
/// Measures how fast rays are resolved, and how many wrongly, by accelerator and schedule; the cost and benefit of each
/// numerical rule; errors far from the origin and at tiny and huge scales; effects of grid resolution and samples per
/// pixel; and what omitting unneeded work saves. Every ray, or in large scenes a sample of them, is compared with f64
/// brute force.
///
/// DIR/index.html is self-contained; all its numbers are also in CSV files, and all its plots are also SVG files. The
/// same command on the same machine finds the same errors; times differ.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  raystep report scenes/cornell-box.gltf -o report
  raystep report scenes/cornell-box.gltf scenes/teapot.glb --device gpu -o report
  raystep report scenes/teapot.glb --section factors,moved --size 256x256 -o report
  raystep report scenes/cornell-box.gltf --quick -o report")]
pub(crate) struct ReportArgs {
    /// The scenes: glTF 2.0, .gltf or .glb
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// Output folder: new, or empty
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Replace the report in a folder that is not empty; other files are kept
    #[arg(long)]
    force: bool,
    /// Use fewer rays and repeats
    #[arg(long)]
    quick: bool,
    /// Seed of rays, orders and samples
    #[arg(long, value_name = "N", default_value_t = report::SEED, allow_negative_numbers = true,
          value_parser = whole::<u32>(0, u64::from(u32::MAX)))]
    seed: u32,
    /// Number of seeds where samples per pixel are measured; below 6 there are no intervals
    #[arg(long, value_name = "N", default_value_t = report::SEEDS, allow_negative_numbers = true,
          value_parser = whole::<u32>(1, 1000))]
    seeds: u32,
    /// Also write DIR/rays.csv: every judged ray, with its verdict, error and error bound
    #[arg(long)]
    rays_csv: bool,
    /// Write only these sections
    #[arg(long = "section", value_name = "A,B…", value_delimiter = ',',
          value_parser = PossibleValuesParser::new(SECTIONS.iter().map(|s| s.name).collect::<Vec<_>>()))]
    sections: Vec<String>,
    /// Index of the scene in files with several, counted from 0 [default: each file's default scene]
    #[arg(long, value_name = "N", value_parser = counted, allow_negative_numbers = true, help_heading = "Scene and view")]
    scene_index: Option<usize>,
    #[command(flatten)]
    read: ReadArgs,
    /// Width and height of views in pixels [default: 192x192; with --quick 64x64]
    #[arg(long, value_name = "WxH", value_parser = parse_size, help_heading = "Scene and view",
          allow_hyphen_values = true)]
    size: Option<Size>,
    /// Number of grid cells in the section factors [default: auto, finer than elsewhere]
    #[arg(long, value_name = "auto|N|NX,NY,NZ", default_value = "auto", hide_default_value = true,
          value_parser = parse_grid, allow_hyphen_values = true, help_heading = "Tracing")]
    grid: GridSize,
    #[command(flatten)]
    quiet: QuietArgs,
    #[command(flatten)]
    camera: CameraArgs,
    #[command(flatten)]
    device: DeviceArgs,
}

/// Default pixels per side, for quick and full reports.
const SIDES: [u32; 2] = [64, 192];

impl ReportArgs {
    /// A scene, and how it is read.
    fn file(&self, path: &Path) -> SceneArgs {
        SceneArgs { scene: path.to_owned(), scene_index: self.scene_index, read: self.read }
    }

    fn size(&self) -> Size {
        let side = if self.quick { SIDES[0] } else { SIDES[1] };
        self.size.unwrap_or(Size { width: side, height: side })
    }

    fn sections(&self) -> Vec<&'static Section> {
        let is_wanted = |s: &&Section| self.sections.is_empty() || self.sections.iter().any(|name| name == s.name);
        SECTIONS.iter().filter(is_wanted).collect()
    }
}

pub(crate) fn run(args: &ReportArgs) -> Result<(), Error> {
    let progress = Progress::new(args.quiet.quiet);
    let stale = report_files(&args.output);
    TargetFolder::new(&args.output, args.force)?.fill(&stale, |folder| fill(args, folder, &progress))?;
    progress.finish();
    progress.say(format_args!("wrote {} with its CSV files and plots", args.output.join(report::PAGE).display()));
    Ok(())
}

/// Measures and writes every file.
fn fill(args: &ReportArgs, folder: &TargetFolder, progress: &Progress) -> Result<(), Error> {
    let names = report_files(&args.output);
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    output::refuse_others(&args.output, &names, "a report", report::PAGE, report::is_report)?;
    progress.stage("reading scenes");
    let mut subjects = Vec::new();
    for path in &distinct(&args.scenes) {
        let (input, subject) = input::read(args.file(path), &args.camera, progress)?;
        folder.refuse_inputs(&input.files, report::is_ours)?;
        subjects.push(subject);
    }
    progress.stage("looking for a device");
    let meter = Meter::new(device::choose(&args.device)?);
    let wanted = Wanted {
        sections: args.sections(),
        size: args.size(),
        grid: args.grid,
        is_quick: args.quick,
        seed: args.seed,
        seeds: args.seeds,
        has_rays: args.rays_csv,
    };
    let report = report::measure(&wanted, &subjects, run_id(), &meter, progress)?;
    progress.stage("writing");
    let files = report.files(&about(&meter.machine)).map_err(Error::failed)?;
    files.iter().try_for_each(|(name, bytes)| folder.write(name, |out| out.write_all(bytes)))
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
        ("device", format!("{} ({})", machine.kind(), machine.reason)),
    ];
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
