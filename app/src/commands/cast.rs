//! `raystep cast`

mod hits;
mod pipeline;

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use indicatif::HumanCount;
use raystep_kernels::{Caster, Numerics, Options, Order, RaySource};
use raystep_lab::outside::MISSES_OUTSIDE;
use raystep_lab::rays::file::{BadRays, RaysFormat, RaysReader};

use crate::args::choices::{self, Casting, ChoiceArgs, fastest_accelerator, fastest_schedule};
use crate::args::{DeviceArgs, QuietArgs, SceneArgs, named, whole};
use crate::commands::extension;
use crate::commands::summary::way;
use crate::device;
use crate::error::{Error, reason};
use crate::output::{self, Target, refuse_inputs};
use crate::scene_file::{self, SceneFile, canonical};
use crate::terminal::{Progress, print, say};
use hits::{HitsFormat, HitsWriter};
use pipeline::{Counts, Pipeline};

/// Cast rays of another program: read them from a file or a pipe, and write what each ray hits
///
/// Rays are an npy array of float32 or float64, N×6 (origin, direction) or N×8 (origin, t_min, direction, t_max; t_max
/// may be infinite), or raw float32, eight per ray (.f32: origin, unused, direction, unused). Origins are in the
/// coordinates of the scene's file; for a scene far from its origin (see 'raystep info'), use float64. t is in multiples
/// of the direction vector, whose length must not be 0: where f32 cannot hold t, it is f32's largest number, or
/// rounded up to the next number above 0. A hit counts if t_min < t < t_max; with N×6 and .f32, if t > 0. With --order
/// exact, t, u and v are the exact values, each rounded once to float32.
///
/// The result has one element per ray: t (infinite without a hit), u, v (weights of the triangle's vertices 1 and 2),
/// triangle and material (4294967295 without a hit). --output-format selects an npy array of records of 20 bytes with the
/// dtype [('t', '<f4'), ('u', '<f4'), ('v', '<f4'), ('triangle', '<u4'), ('material', '<u4')] (structured); an npy array of
/// '<f8' with those five columns and -1 for no triangle, for programs that read no records, such as MATLAB's and Julia's
/// readers (plain); or one npy array for each, in a zip file (npz). In Python, numpy.save('rays.npy',
/// numpy.hstack([origins, directions])) writes rays, and hits = numpy.load('hits.npy') reads hits: hits['t'],
/// hits['triangle'].
///
/// With --all-hits, the result has one element per hit instead, ray after ray, and each ray's in the order of exact t; a field
/// ray before the others ('<u8') is the ray's number, from 0. Every surface that a ray crosses is a hit, once, also at edges and
/// corners: a ray is taken to start an infinitesimal beside its origin, so that it enters a closed surface as often as it
/// leaves it. t is 0 where a ray starts on a surface and leaves it.
///
/// Rays are read, traced and written in batches at the same time, so any number of them takes the same memory.
#[derive(Args, Debug)]
#[command(
    mut_arg("schedule", fastest_schedule),
    mut_arg("accelerator", fastest_accelerator),
    after_help = "\
Examples:
  raystep cast cornell-box --rays-file rays.npy -o hits.npy
  raystep cast teapot --rays-file shadow.npy --any-hit -o shadow-hits.npy
  raystep cast teapot --rays-file rays.npy --all-hits -o all.npy
  raystep cast teapot --rays-file primary.f32 --device cpu -o hits.npy
  raystep cast teapot --rays-file rays.npy --output-format plain -o hits.npy
  python make_rays.py | raystep cast terrain --rays-file - -o - | python use_hits.py"
)]
pub(crate) struct CastArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Rays; - for standard input
    #[arg(long, value_name = "F")]
    rays_file: PathBuf,
    /// Hits, .npy or .npz; - for standard output
    #[arg(short, long, value_name = "F")]
    output: PathBuf,
    /// Format of the hits [default: structured, or npz if the output's name ends in it]
    #[arg(long, value_parser = named(HitsFormat::ALL, HitsFormat::name))]
    output_format: Option<HitsFormat>,
    /// What to do with a ray that cannot be traced because a number is not finite or its direction is 0: stop, or count
    /// it as a miss
    #[arg(long, default_value = "error", value_parser = named(BadRays::ALL, BadRays::name))]
    bad_rays: BadRays,
    /// Format of the rays [default: from the file extension; npy for standard input]
    #[arg(long, value_parser = named(RaysFormat::ALL, RaysFormat::name))]
    format: Option<RaysFormat>,
    /// Number of rays; needed only if f32 rays come from a pipe and hits go to a pipe
    #[arg(long, value_name = "N", value_parser = whole::<u64>(0, u64::MAX), allow_negative_numbers = true)]
    count: Option<u64>,
    /// Report whichever hit is found first, not the closest
    #[arg(long)]
    any_hit: bool,
    /// Report every surface that a ray crosses, in the order of exact t
    #[arg(long)]
    all_hits: bool,
    /// Maximum rays per batch, fewer if the device cannot hold that many [default: 65536 on the CPU, 1048576 on a GPU]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1, 1 << 26), allow_negative_numbers = true)]
    batch: Option<u32>,
    #[command(flatten)]
    quiet: QuietArgs,
    #[command(flatten)]
    tracing: ChoiceArgs<Casting>,
    #[command(flatten)]
    device: DeviceArgs,
}

/// Standard input or output instead of a file.
fn is_standard(path: &Path) -> bool {
    path == Path::new("-")
}

pub(crate) fn run(args: &CastArgs) -> Result<(), Error> {
    choices::check(&args.tracing.values, |name| args.tracing.has(name))?;
    if args.any_hit && args.tracing.values.numerics == Numerics::Paper {
        return Err(Error::usage("--any-hit: the paper's rules find closest hits only; use --numerics robust"));
    }
    check_all_hits(args)?;
    let output_format = output_format(args);
    let target = target(args, output_format)?;
    let format = format(args)?;
    let progress = Progress::new(args.quiet.quiet);
    progress.stage("reading the scene");
    let SceneFile { scene, mut inputs, .. } = scene_file::read(&args.scene)?;
    for note in &scene.notes {
        progress.say(format_args!("note: {}", note.0));
    }
    inputs.extend(canonical(std::slice::from_ref(&args.rays_file)));
    refuse_inputs(&[target.as_ref()], &inputs)?;
    let (input, count) = open(args, format)?;

    progress.stage("building");
    let chosen = device::choose(&args.device)?;
    let rays = RaySource::Given(Vec::new());
    let options = Options { any_hit: args.any_hit, all_hits: args.all_hits, ..args.tracing.options(rays) };
    let offset = scene.offset;
    let mut caster = chosen.wait(Caster::new(scene, &options, &chosen.device))?;
    let way = way(&options, caster.plan());
    if let Some(batch) = args.batch {
        caster.set_batch(batch.into());
    }

    progress.stage("waiting for rays");
    let name = shown(&args.rays_file);
    let from = |error| Error::failed(format!("{name}: {error}"));
    let reader = RaysReader::new(input, format, count).map_err(from)?.with_bad_rays(args.bad_rays);
    let count = reader.total().filter(|_| !args.all_hits);
    let writer = HitsWriter::new(output::Stream::new(target)?, output_format, count, args.all_hits)?;
    if args.all_hits && writer.needs_total() {
        return Err(Error::usage(
            "--all-hits: the output starts with the number of hits, which is known only at the end: write to a file, or add \
             --output-format npz",
        ));
    }
    if count.is_none() && writer.needs_total() {
        return Err(Error::usage(
            "the output starts with the number of rays, which f32 from a pipe does not give: add --count N, use npy, or \
             write to a file",
        ));
    }
    let begin = Instant::now();
    let pipeline = Pipeline {
        caster,
        chosen: &chosen,
        bad_rays: args.bad_rays,
        is_all: args.all_hits,
        offset,
        name: &name,
        progress: &progress,
    };
    let Some(counts) = pipeline.run(reader, writer)? else { return Ok(()) };
    progress.finish();
    if counts.bad > 0 {
        let [some, all] = [counts.bad, counts.rays].map(HumanCount);
        progress.say(format_args!(
            "note: {some} of {all} rays cannot be traced (a number is not finite, the direction is 0, or the origin is too \
             far away): they count as misses"
        ));
    }
    if counts.outside > 0 {
        let [some, all] = [counts.outside, counts.rays].map(HumanCount);
        progress
            .say(format_args!("note: {MISSES_OUTSIDE}; here {some} of {all} rays start there; use --numerics robust"));
    }
    if !args.quiet.quiet {
        let device = chosen.gpu().map_or("CPU", |gpu| gpu.info.name.as_str());
        let line = summary(args, &counts, begin.elapsed().as_secs_f64(), device, &way);
        if is_standard(&args.output) { say(line.trim_end()) } else { print(&line)? }
    }
    Ok(())
}

/// Refuses what does not go together with `--all-hits`.
fn check_all_hits(args: &CastArgs) -> Result<(), Error> {
    let has_rounded = args.tracing.has("order") && args.tracing.values.order == Order::Rounded;
    let why = match () {
        () if !args.all_hits => return Ok(()),
        () if args.any_hit => "it excludes --any-hit: omit one of them",
        () if args.tracing.values.numerics == Numerics::Paper => {
            "the paper's rules find closest hits only; use --numerics robust"
        }
        () if has_rounded => "hits are in the order of exact t: omit --order, or use --order exact",
        () => return Ok(()),
    };
    Err(Error::usage(format!("--all-hits: {why}")))
}

/// The file's name in messages.
fn shown(path: &Path) -> String {
    if is_standard(path) { "standard input".into() } else { path.display().to_string() }
}

/// One line about all rays.
fn summary(args: &CastArgs, counts: &Counts, seconds: f64, device: &str, way: &str) -> String {
    let Counts { rays, hits, unfinished, .. } = *counts;
    let mut line = format!("{} rays, {} hit", HumanCount(rays), HumanCount(hits));
    if args.all_hits {
        line += &format!("s, at most {} of a ray", HumanCount(counts.most));
    } else if rays > 0 {
        line += &format!(" ({:.1}%)", 100.0 * hits as f64 / rays as f64);
    }
    line += &format!(
        "; {seconds:.3} s, {} rays/s on {device}; {way}",
        HumanCount((rays as f64 / seconds.max(1e-9)) as u64)
    );
    if unfinished > 0 {
        line += &format!("; {} not resolved within the limit of passes", HumanCount(unfinished));
    }
    line + "\n"
}

/// The format of hits, from the option or the output's name.
fn output_format(args: &CastArgs) -> HitsFormat {
    let by_name = if extension(&args.output) == "npz" { HitsFormat::Npz } else { HitsFormat::Structured };
    args.output_format.unwrap_or(by_name)
}

/// The output; `None` for standard output.
fn target(args: &CastArgs, format: HitsFormat) -> Result<Option<Target>, Error> {
    let path = args.output.as_path();
    if is_standard(path) {
        return Ok(None);
    }
    let is_special = fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir());
    if !is_special {
        let endings: &[&str] = match (args.output_format, format) {
            (None, _) => &["npy", "npz"],
            (Some(_), HitsFormat::Npz) => &["npz"],
            (Some(_), _) => &["npy"],
        };
        output::ending("--output", path, endings)?;
    }
    Target::new(path).map(Some)
}

fn format(args: &CastArgs) -> Result<RaysFormat, Error> {
    let format = told_format(args)?;
    match args.count {
        Some(count) if format == RaysFormat::Npy => {
            Err(Error::usage(format!("--count {count}: an npy file contains the number of its rays; omit the option")))
        }
        _ => Ok(format),
    }
}

/// The format, from the option or the name.
fn told_format(args: &CastArgs) -> Result<RaysFormat, Error> {
    let path = &args.rays_file;
    match (args.format, extension(path).as_str()) {
        (Some(format), _) => Ok(format),
        (None, _) if is_standard(path) => Ok(RaysFormat::Npy),
        (None, "npy") => Ok(RaysFormat::Npy),
        (None, "f32") => Ok(RaysFormat::F32),
        (None, _) => {
            let at = path.display();
            Err(Error::usage(format!(
                "--rays-file {at}: expected a name that ends in .npy or .f32, or --format; rays as text are not read"
            )))
        }
    }
}

/// Opens the rays. Also returns their number if the format does not contain it, but the file's size tells it.
fn open(args: &CastArgs, format: RaysFormat) -> Result<(Box<dyn Read + Send>, Option<u64>), Error> {
    if is_standard(&args.rays_file) {
        return Ok((Box::new(io::stdin()), args.count));
    }
    let at = args.rays_file.display();
    let failed = |problem: &str| Error::failed(format!("{at}: {problem}"));
    let opened = File::open(&args.rays_file).and_then(|file| file.metadata().map(|found| (file, found)));
    let (file, found) = opened.map_err(|e| failed(&reason(&e)))?;
    if found.is_dir() {
        return Err(failed("it is a folder; expected a file"));
    }
    let mut count = args.count;
    if found.is_file() && format == RaysFormat::F32 && count.is_none() {
        if found.len() % 32 != 0 {
            return Err(failed(&format!("{} bytes is not a whole number of rays (32 bytes each)", found.len())));
        }
        count = Some(found.len() / 32);
    }
    Ok((Box::new(file), count))
}
