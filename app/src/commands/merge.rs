//! `raystep merge`

mod picture;
mod tables;

use std::path::PathBuf;

use clap::Args;

use crate::args::QuietArgs;
use crate::error::Error;
use crate::shard::{FILE, Part};
use crate::terminal::Progress;

/// Merge the parts of a run that was split with --shard
///
/// The parts are folders of 'raystep render', 'bench' or 'stability' with --shard I/N, in any order. The command fails
/// if parts come from different scenes, options or versions, if a part is missing (unless --so-far is used) or given
/// twice, or if devices or drivers differ (unless --mixed is used).
///
/// Parts of an image are combined into one image. If all devices are of the same kind, its pixels are bit-identical to
/// those of a single run with all samples; an EXR has colour only, without the layers of 'raystep render'. Parts
/// of 'bench' and 'stability' are combined into one folder with the tables of a single run; HTML pages are copied, one
/// per part.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  raystep render cornell-box -o part-1 --spp 256 --shard 1/2
  raystep render cornell-box -o part-2 --spp 256 --shard 2/2
  raystep merge part-1 part-2 -o box.png")]
pub(crate) struct MergeArgs {
    /// The parts' folders
    #[arg(required = true, value_name = "DIR")]
    parts: Vec<PathBuf>,
    /// Output: for an image, a file whose name ends in .png or .exr; for tables, a folder, new or empty
    #[arg(short, long, value_name = "OUT.png|OUT.exr|DIR")]
    output: PathBuf,
    /// Also merge results of different devices: each row names its device; pixels may differ in the last bits
    #[arg(long)]
    mixed: bool,
    /// Write an image of the samples so far, even if parts are missing or incomplete
    #[arg(long)]
    so_far: bool,
    /// Replace the tables in a folder that is not empty; other files are kept
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    quiet: QuietArgs,
}

impl MergeArgs {
    /// All parts of an image, without a word.
    pub(super) fn complete(parts: Vec<PathBuf>, output: PathBuf) -> Self {
        let quiet = QuietArgs { quiet: true };
        Self { parts, output, mixed: false, so_far: false, force: false, quiet }
    }

    /// Those that there are, of whatever devices.
    pub(super) fn so_far(parts: Vec<PathBuf>, output: PathBuf) -> Self {
        Self { mixed: true, so_far: true, ..Self::complete(parts, output) }
    }
}

/// Most missing parts that a message names.
const MOST_NAMED: usize = 8;

/// A part and where it is.
struct Placed {
    folder: PathBuf,
    part: Part,
}

pub(crate) fn run(args: &MergeArgs) -> Result<(), Error> {
    let progress = Progress::new(args.quiet.quiet);
    let parts = read(args)?;
    match parts[0].part.picture {
        Some(picture) => picture::merge(args, &parts, picture, &progress),
        None if args.so_far => Err(Error::usage("--so-far is for parts of an image: omit it")),
        None => tables::merge(args, &parts, &progress),
    }
}

/// Every part of one whole, in order: at least one.
fn read(args: &MergeArgs) -> Result<Vec<Placed>, Error> {
    let mut parts = Vec::new();
    for folder in &args.parts {
        let part = Part::read(folder)?.ok_or_else(|| {
            let at = folder.display();
            let problem = if folder.is_dir() { format!("it has no {FILE}") } else { "there is no such folder".into() };
            Error::failed(format!("{at}: {problem}; expected the output folder of a command run with --shard"))
        })?;
        parts.push(Placed { folder: folder.clone(), part });
    }
    let Some((first, others)) = parts.split_first() else { return Err(Error::usage("name the parts to merge")) };
    for other in others {
        if let Some(difference) = first.part.difference(&other.part, args.mixed) {
            let (a, b) = (first.folder.display(), other.folder.display());
            let mixed = if difference.starts_with("device") { "; --mixed allows it" } else { "" };
            return Err(Error::failed(format!(
                "{a} and {b} do not belong together: they differ in {difference}{mixed}"
            )));
        }
    }
    let of = first.part.shard.of;
    parts.sort_by_key(|placed| placed.part.shard.index);
    if let Some(pair) = parts.windows(2).find(|pair| pair[0].part.shard == pair[1].part.shard) {
        let (a, b) = (pair[0].folder.display(), pair[1].folder.display());
        return Err(Error::failed(format!("{a} and {b} are the same part, {}: give each once", pair[0].part.shard)));
    }
    let missing: Vec<String> = (1..=of)
        .filter(|index| !parts.iter().any(|placed| placed.part.shard.index == *index))
        .map(|index| format!("{index}/{of}"))
        .collect();
    let names = match missing.as_slice() {
        _ if args.so_far => return Ok(parts),
        [] => return Ok(parts),
        [part] => format!("part {part} is"),
        [first @ .., last] if missing.len() <= MOST_NAMED => format!("parts {} and {last} are", first.join(", ")),
        [first, ..] => format!("part {first} and {} others are", missing.len() - 1),
    };
    Err(Error::failed(format!("{names} missing: name the folders of all {of} parts")))
}
