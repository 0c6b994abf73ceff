//! `raystep render`

mod bounces;
mod part;

use std::io::Cursor;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clap::Args;
use raystep_kernels::export::{Recorded, exr};
use raystep_kernels::options::mapping::Until;
use raystep_kernels::renderer::Counted;
use raystep_kernels::{Image, Numerics, RayHit};
use raystep_lab::judge::{Report, Traced, check_rays};
use raystep_lab::png;

use super::summary;
use crate::args::choices::{fastest_accelerator, fastest_schedule};
use crate::args::{QuietArgs, RunArgs, SceneArgs, ViewArgs};
use crate::error::Error;
use crate::output::{Target, ending, refuse_inputs, write};
use crate::session::{Running, Session};
use crate::shard::ShardArgs;
use crate::terminal::{Progress, print};
pub(super) use part::{block_file, read_block};

/// Mistakes that `--check` lists; the rest are counted.
const MISTAKES_SHOWN: usize = 8;

/// Render a scene to an image
///
/// PNG is sRGB. EXR is linear, with additional channels for what each ray hit, with --spp each ray of the last sample: Z,
/// Hit.T.V, Hit.Bary.U and .V, Hit.TriId.V, Normal.X, .Y and .Z, Albedo.R, .G and .B; and Samples.V, the number of samples.
///
/// With --shard I/N, the samples of each pixel are divided among N machines or jobs, in blocks of 16. The output is then
/// a folder with the mean of each of this part's blocks, and their image so far, so-far.png. If it is started again, the
/// command traces only the missing blocks. 'raystep merge' combines all parts into one image. If all devices are of the
/// same kind, its pixels are bit-identical to those of the same command without --shard; a merged EXR has colour only.
#[derive(Args, Debug)]
#[command(
    mut_arg("schedule", fastest_schedule),
    mut_arg("accelerator", fastest_accelerator),
    after_help = "\
Examples:
  raystep render cornell-box -o box.png
  raystep render cornell-box -o box.png --spp 64
  raystep render cornell-box -o part-1 --spp 256 --shard 1/4
  raystep render teapot -o teapot.exr --size 1920x1080 --device cpu
  raystep render cornell-box -o box.exr --integrator path --spp 256 --by-bounce
  raystep render cornell-box -o box.png --integrator photons --photons 20000
  raystep render cornell-box -o box.png --numerics paper --check
  raystep render terrain -o t.png --eye 2,1,2 --look-at 0,0,0 --fov 30
  raystep render cornell-box -o box.png --passes-csv passes.csv --summary-json run.json
  raystep render cornell-box -o box.png --trace-json trace.json   # for ui.perfetto.dev"
)]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    /// Output image; its name ends in .png or .exr. With --shard, a folder
    #[arg(short, long, value_name = "OUT.png|OUT.exr")]
    output: PathBuf,
    #[command(flatten)]
    shard: ShardArgs,
    /// Time every pass, and write one row per pass
    #[arg(long, value_name = "F")]
    passes_csv: Option<PathBuf>,
    /// Also count the fragments that each draw runs, where the adapter can, with --mapping fragment and --until count
    #[arg(long, requires = "passes_csv")]
    count_fragments: bool,
    /// Time every pass, and write a trace for Perfetto: passes as slices, rays in each state as counters
    #[arg(long, value_name = "F")]
    trace_json: Option<PathBuf>,
    /// Write a summary of the run
    #[arg(long, value_name = "F")]
    summary_json: Option<PathBuf>,
    /// Count cells visited and triangles tested
    #[arg(long)]
    counters: bool,
    /// Also write the light of paths by their number of bounces, with --integrator path, as layers of an EXR that add up to
    /// its colour: Emitted, Direct, Indirect.2, .3, … Takes another image for each bounce of --max-depth, with fewer bounces
    #[arg(long)]
    by_bounce: bool,
    /// Compare every hit, with --spp those of the last sample, with f64 brute force; with --numerics robust, a difference
    /// is a failure
    #[arg(long)]
    check: bool,
    #[command(flatten)]
    quiet: QuietArgs,
    #[command(flatten)]
    pub(super) view: ViewArgs,
    #[command(flatten)]
    pub(super) run: RunArgs,
}

#[derive(Clone, Copy)]
enum Format {
    Png,
    Exr,
}

pub(crate) fn run(args: &RenderArgs) -> Result<(), Error> {
    if let Some(shard) = args.shard.shard {
        return part::run(args, shard);
    }
    let format = if ending("-o", &args.output, &["png", "exr"])? == "exr" { Format::Exr } else { Format::Png };
    bounces::check(args, format)?;
    let target = Target::new(&args.output)?;
    let optional = |path: &Option<PathBuf>| path.as_deref().map(Target::new).transpose();
    let (passes_target, trace_target) = (optional(&args.passes_csv)?, optional(&args.trace_json)?);
    let summary_target = optional(&args.summary_json)?;
    let targets = [Some(&target), passes_target.as_ref(), trace_target.as_ref(), summary_target.as_ref()];
    refuse_doubles(&targets)?;

    let is_counted = args.run.tracing.values.mapping.fragment().is_some_and(|how| how.until == Until::Count);
    if args.count_fragments && !is_counted {
        return Err(Error::usage(
            "--count-fragments counts in draws, without queries: add --mapping fragment --until count",
        ));
    }
    let progress = Progress::new(args.quiet.quiet);
    let session = Session::new(&args.scene, &args.view, &args.run, &progress, |_, options| {
        options.counters = args.counters;
        options.timings = args.passes_csv.is_some() || args.trace_json.is_some();
        options.keep_passes = options.timings;
        options.count_fragments = args.count_fragments;
    })?;
    refuse_inputs(&targets, &session.inputs)?;
    if let Some(note) = session.chosen.note_on_times().filter(|_| session.options.timings) {
        progress.say(format_args!("note: {note}"));
    }
    let mut running = session.start(&progress)?;
    let counted = trace(&mut running, args.passes_csv.is_some(), &progress)?;
    running.watch.lap("trace");

    progress.stage("reading back");
    let image = running.chosen.wait(running.renderer.image())?;
    let hits = running.chosen.wait(running.renderer.hits())?;
    running.watch.lap("read_back");
    let report = args.check.then(|| check(&mut running, &progress)).transpose()?;
    let bounces = if args.by_bounce { bounces::trace(&running, &progress)? } else { Vec::new() };
    running.watch.lap("by_bounce");

    progress.stage("writing");
    let mut files = vec![(target, encode(format, &image, &hits, &bounces, &running, &args.output)?)];
    if let Some(target) = passes_target {
        let each = counted.as_ref().map_or(&[][..], |counted| &counted.passes);
        files.push((target, running.passes_csv(&running.run_context(), each)?));
    }
    if let Some(target) = trace_target {
        let events = Recorded::of(&running.run_context(), &running.renderer, &[]).trace_events();
        files.push((target, super::json_text(&events)?.into_bytes()));
    }
    running.watch.lap("encode");
    let hits = image.hits(running.renderer.samples());
    let summary = summary::of(&running, hits, counted.map(|counted| counted.sums), report.as_ref());
    if let Some(target) = summary_target {
        files.push((target, super::json_text(&summary)?.into_bytes()));
    }
    write(files)?;
    progress.finish();
    progress.say_lines(&summary::text(&summary, &running));
    report.map_or(Ok(()), |report| judge(&report, &running))
}

fn refuse_doubles(targets: &[Option<&Target>]) -> Result<(), Error> {
    for (i, a) in targets.iter().enumerate() {
        if let Some(a) = a
            && targets[..i].iter().flatten().any(|b| a.is_same(b))
        {
            return Err(Error::usage(format!(
                "{} is used for two outputs: choose different names",
                a.path().display()
            )));
        }
    }
    Ok(())
}

/// Runs to the end, and sums the counters; with `each_pass` also those of every pass.
fn trace(running: &mut Running, each_pass: bool, progress: &Progress) -> Result<Option<Counted>, Error> {
    let Running { chosen, renderer, .. } = running;
    progress.rays(&renderer.progress());
    let show = |now: &raystep_kernels::Progress| {
        progress.rays(now);
        ControlFlow::Continue(())
    };
    Ok(chosen.wait(renderer.run_counting(each_pass, show))?)
}

/// Compares with f64 brute force.
fn check(running: &mut Running, progress: &Progress) -> Result<Report, Error> {
    let Running { chosen, renderer, watch, .. } = running;
    let traced = chosen.wait(Traced::read(renderer))?;
    let show = |done, of| {
        progress.part("comparing with f64", done, of);
        ControlFlow::Continue(())
    };
    let report = check_rays(&traced, show);
    watch.lap("check");
    Ok(report)
}

/// Prints the result of the comparison; errors fail the run, unless the paper's numerics are expected to make them.
fn judge(report: &Report, running: &Running) -> Result<(), Error> {
    let width = running.renderer.plan().width as usize;
    let of = if running.options.samples.count > 1 { "last sample: " } else { "" };
    let mut text = format!("{of}{report}\n");
    for m in report.mistakes.iter().take(MISTAKES_SHOWN) {
        let (x, y) = (m.ray % width, m.ray / width);
        let found = m.found.map_or("nothing".into(), |(triangle, t)| format!("triangle {triangle} at t {t}"));
        let exact = m.exact.map_or("nothing".into(), |(triangle, t)| format!("triangle {triangle} at t {t}"));
        text += &format!("  pixel {x},{y}: {found}, expected {exact} (t in traced units)\n");
    }
    print(&text)?;
    if report.errors() > 0 && running.options.numerics == Numerics::Robust {
        return Err(Error::failed(format!("{} of {} rays have the wrong hit", report.errors(), report.counts.rays())));
    }
    Ok(())
}

fn encode(
    format: Format,
    image: &Image,
    hits: &[Option<RayHit>],
    bounces: &[Image],
    running: &Running,
    path: &Path,
) -> Result<Vec<u8>, Error> {
    match format {
        Format::Png => encode_png(image, path),
        Format::Exr => {
            let mut file = Cursor::new(Vec::new());
            let layers = exr::Layers {
                hits,
                triangles: &running.scene.triangles,
                albedo: &running.renderer.albedo(hits)?,
                samples: running.renderer.samples(),
                bounces,
            };
            exr::write_image(&mut file, image, &layers).map_err(|e| cannot_encode(path, &e))?;
            Ok(file.into_inner())
        }
    }
}

fn cannot_encode(path: &Path, error: &dyn std::fmt::Display) -> Error {
    Error::failed(format!("cannot encode {}: {error}", path.display()))
}

/// An image as PNG.
fn encode_png(image: &Image, path: &Path) -> Result<Vec<u8>, Error> {
    png::encode(image.width, image.height, &image.to_srgb8()).map_err(|e| cannot_encode(path, &e))
}

/// An image without hits, in the format that a name asks for.
pub(super) fn encode_colors(image: &Image, path: &Path, is_exr: bool) -> Result<Vec<u8>, Error> {
    if !is_exr {
        return encode_png(image, path);
    }
    let mut file = Cursor::new(Vec::new());
    exr::write_colors(&mut file, image).map_err(|e| cannot_encode(path, &e))?;
    Ok(file.into_inner())
}
