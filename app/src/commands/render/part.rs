//! `raystep render --shard`: some blocks of a picture's samples.

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;

use raystep_kernels::export::npy;
use raystep_kernels::options::Integrator;
use raystep_kernels::renderer::image::Merge;
use raystep_kernels::{Image, RaySource, Samples};
use raystep_lab::Hash;
use serde_json::json;

use super::{RenderArgs, encode_png};
use crate::error::Error;
use crate::output::{Folder, Target, write};
use crate::scene_file::{hashed, read_file};
use crate::session::{Running, Session};
use crate::shard::{self, Part, Picture, Shard};
use crate::terminal::Progress;

/// The picture that the blocks so far give.
const SO_FAR: &str = "so-far.png";

/// The file of a block, counted from 0.
pub(in crate::commands) fn block_file(block: u32) -> String {
    format!("block-{block:04}.npy")
}

/// Reads a block of a picture from a part's folder; `None` if it is not there.
pub(in crate::commands) fn read_block(folder: &Path, block: u32, of: Picture) -> Result<Option<Image>, Error> {
    let path = folder.join(block_file(block));
    if !path.exists() {
        return Ok(None);
    }
    let most = npy::HEADER_BYTES + 16 * u64::from(of.width) * u64::from(of.height);
    let failed = |problem: &dyn std::fmt::Display| Error::failed(format!("{}: {problem}", path.display()));
    let bytes = read_file(&path, most).map_err(|e| failed(&e))?;
    let image = npy::read_image(&bytes, of.width, of.height);
    image.map(Some).ok_or_else(|| failed(&"it is not a block of this image: delete it, and run its part again"))
}

/// Traces the blocks of a part that its folder does not have yet.
pub(super) fn run(args: &RenderArgs, shard: Shard) -> Result<(), Error> {
    refuse_other_outputs(args)?;
    refuse_what_goes_on(args)?;
    let progress = Progress::new(args.quiet.quiet);
    let whole = args.view.samples.values.samples;
    let range = shard.range(whole.blocks() as usize, "blocks of 16 samples")?;
    let blocks: Vec<(u32, Samples)> =
        range.filter_map(|block| Some((block as u32, whole.part(block as u32)?))).collect();
    let first = blocks.first().map_or(whole, |(_, samples)| *samples);
    let session = Session::new(&args.scene, &args.view, &args.run, &progress, |_, options| options.samples = first)?;
    let hash = hashed(Hash::default(), &session.inputs, args.scene.read.max_memory)?;
    let mut running = session.start(&progress)?;
    let plan = running.renderer.plan();
    let picture = Picture { width: plan.width, height: plan.height, samples: whole.count };
    open(&args.output, &describe(&running, hash, shard, whole, picture)?)?;

    let mut merge = Merge::new(picture.width, picture.height);
    let mut traced = 0;
    for &(block, samples) in &blocks {
        let image = match read_block(&args.output, block, picture)? {
            Some(image) => image,
            None => {
                traced += 1;
                let image = trace(&mut running, samples, &progress)?;
                let mut bytes = Vec::new();
                npy::write_image(&mut bytes, &image);
                write(vec![(Target::new(&args.output.join(block_file(block)))?, bytes)])?;
                image
            }
        };
        merge.add(image, samples.count);
        let path = args.output.join(SO_FAR);
        if let Some(image) = merge.image() {
            write(vec![(Target::new(&path)?, encode_png(&image, &path)?)])?;
        }
    }
    progress.finish();
    let (at, count, parts) = (args.output.display(), blocks.len(), shard.of);
    progress.say(format_args!(
        "traced {traced} of {count} blocks of samples, all are in {at}; 'raystep merge' combines the {parts} parts into an image"
    ));
    Ok(())
}

/// What only one run of all samples has.
fn refuse_other_outputs(args: &RenderArgs) -> Result<(), Error> {
    let all = [
        ("--passes-csv", args.passes_csv.is_some()),
        ("--trace-json", args.trace_json.is_some()),
        ("--summary-json", args.summary_json.is_some()),
        ("--counters", args.counters),
        ("--check", args.check),
        ("--by-bounce", args.by_bounce),
    ];
    match all.iter().find(|(_, is_given)| *is_given) {
        Some((option, _)) => Err(Error::usage(format!("--shard cannot be combined with {option}: omit one of them"))),
        None => Ok(()),
    }
}

/// Refuses light whose samples are no independent ones: with photons, each gathers within a radius that those before it
/// leave.
fn refuse_what_goes_on(args: &RenderArgs) -> Result<(), Error> {
    let integrator = args.run.tracing.values.integrator;
    if integrator == Integrator::Photons {
        return Err(Error::usage(format!(
            "--shard divides samples, and with --integrator {integrator} each depends on those before it: omit one of them"
        )));
    }
    Ok(())
}

/// The mean of a block's samples.
fn trace(running: &mut Running, samples: Samples, progress: &Progress) -> Result<Image, Error> {
    let Running { chosen, renderer, .. } = running;
    // A single sample in the centre is the only block of its picture.
    if samples.are_spread() {
        renderer.take_samples(samples);
    }
    let show = |now: &raystep_kernels::Progress| {
        progress.rays(&raystep_kernels::Progress { samples: now.samples + samples.first, ..*now });
        ControlFlow::Continue(())
    };
    chosen.wait(renderer.run(show))?;
    Ok(chosen.wait(renderer.image())?)
}

fn describe(running: &Running, hash: Hash, shard: Shard, whole: Samples, picture: Picture) -> Result<Part, Error> {
    let mut options = serde_json::to_value(running.run_options()).unwrap_or_default();
    if let (Some(options), RaySource::Camera { camera, .. }) = (options.as_object_mut(), &running.options.rays) {
        // What `auto` chose has to be the same in all parts.
        options.insert("structure".into(), running.renderer.plan().accelerator.name().into());
        // Where a scene lies differs between machines; its contents are in the hash.
        options.remove("scene_path");
        options.insert("spp".into(), whole.count.into());
        options.insert("sampler".into(), whole.sampler.name().into());
        options.insert("seed".into(), whole.seed.into());
        let vectors = [camera.eye, camera.forward, camera.right, camera.up].map(|v| v.to_array());
        options.insert("camera".into(), json!([vectors, format!("{:?}", camera.projection)]));
    }
    let scene = (running.scene.name.clone(), hash.to_string());
    Ok(Part::new("render", shard, vec![scene], &options, &running.chosen)?.of_picture(picture))
}

/// Makes the part's folder, or continues in one of the same part.
fn open(folder: &Path, part: &Part) -> Result<(), Error> {
    let at = folder.display();
    let text = part.text()?;
    if let Some(earlier) = Part::read(folder)? {
        let part = &Part::parse(text.as_bytes()).map_err(Error::failed)?;
        let is_other = || (earlier.shard.index != part.shard.index).then(|| "number of the part".to_owned());
        return match earlier.difference(part, false).or_else(is_other) {
            Some(difference) => {
                Err(Error::failed(format!("{at} has a part that differs in {difference}: choose another folder")))
            }
            None => Ok(()),
        };
    }
    match Folder::find(folder)? {
        Folder::Full => return Err(Error::failed(format!("{at} is not empty: choose another folder"))),
        Folder::Empty => {}
        Folder::Missing => fs::create_dir(folder).map_err(|e| Error::cannot_write(folder, &e))?,
    }
    write(vec![(Target::new(&folder.join(shard::FILE))?, text.into_bytes())])
}
