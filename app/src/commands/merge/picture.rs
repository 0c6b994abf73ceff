//! Pictures: the mean of all blocks of samples.

use raystep_kernels::Samples;
use raystep_kernels::renderer::image::Merge;

use super::{MergeArgs, Placed};
use crate::commands::render::{block_file, encode_colors, read_block};
use crate::error::Error;
use crate::output::{Target, ending, write};
use crate::shard::Picture;
use crate::terminal::Progress;

/// Most bytes of the picture in memory, twice: larger ones are not what a part's folder holds.
const MOST_PIXELS: u64 = 1 << 30;

/// Writes the picture.
pub(super) fn merge(args: &MergeArgs, parts: &[Placed], picture: Picture, progress: &Progress) -> Result<(), Error> {
    let is_exr = ending("-o", &args.output, &["png", "exr"])? == "exr";
    let target = Target::new(&args.output)?;
    let Picture { width, height, samples } = picture;
    let pixels = u64::from(width) * u64::from(height);
    if !(1..=MOST_PIXELS).contains(&pixels) || !(1..=Samples::MOST).contains(&samples) {
        let at = parts[0].folder.display();
        return Err(Error::failed(format!(
            "{at}: shard.json describes an invalid image: {width}x{height} pixels, {samples} samples"
        )));
    }
    let whole = Samples { count: samples, ..Samples::default() };
    let (blocks, mut merge) = (whole.blocks(), Merge::new(width, height));
    for Placed { folder, part } in parts {
        for block in part.shard.range(blocks as usize, "blocks of 16 samples")? {
            let block = block as u32;
            progress.part("merging blocks", u64::from(block), u64::from(blocks));
            let Some(image) = read_block(folder, block, picture)? else {
                if args.so_far {
                    continue;
                }
                let (at, name) = (folder.display(), block_file(block));
                return Err(Error::failed(format!(
                    "{at}: {name} is missing, so the part is incomplete: run its command again to continue"
                )));
            };
            let count = whole.part(block).map_or(0, |part| part.count);
            merge.add(image, count);
        }
    }
    let Some(image) = merge.image() else { return Err(Error::failed("there are no blocks to merge")) };
    write(vec![(target, encode_colors(&image, &args.output, is_exr)?)])?;
    progress.finish();
    progress.say(format_args!(
        "wrote {}: {width}x{height}, {} of {samples} samples per pixel, from {} of {} parts",
        args.output.display(),
        merge.samples(),
        parts.len(),
        parts[0].part.shard.of
    ));
    Ok(())
}
