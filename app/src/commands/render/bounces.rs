//! `raystep render --by-bounce`: the light of paths by their number of bounces.

use std::ops::ControlFlow;

use raystep_kernels::options::Integrator;
use raystep_kernels::plan::Plan;
use raystep_kernels::{Image, Options, Renderer};

use super::{Format, RenderArgs};
use crate::error::Error;
use crate::session::Running;
use crate::terminal::Progress;

/// Refuses it where there are no bounces, or no layers to write.
pub(super) fn check(args: &RenderArgs, format: Format) -> Result<(), Error> {
    if !args.by_bounce {
        return Ok(());
    }
    if args.run.tracing.values.integrator != Integrator::Path {
        return Err(Error::usage("--by-bounce divides the light of paths: add --integrator path"));
    }
    match format {
        Format::Exr => Ok(()),
        Format::Png => {
            Err(Error::usage("--by-bounce writes layers, which a PNG does not have: use a name that ends in .exr"))
        }
    }
}

/// The images of paths with at most 0, 1, 2… bounces, up to one fewer than the run's.
///
/// What decides a path at a depth does not depend on how many bounces it may have. A path of such an image is therefore the
/// beginning of the run's, and two images differ by the light of exactly so many bounces.
pub(super) fn trace(running: &Running, progress: &Progress) -> Result<Vec<Image>, Error> {
    let Running { chosen, options, scene, .. } = running;
    let (count, samples) = (options.max_depth, options.samples.count);
    let mut images = Vec::new();
    for max_depth in 0..count {
        let options = Options { max_depth, counters: false, timings: false, keep_passes: false, ..options.clone() };
        let (plan, data) = chosen.wait(Plan::on(scene, &options, &chosen.device))?;
        let mut renderer = chosen.wait(Renderer::from_plan(plan, data, &options, &chosen.device))?;
        let show = |now: &raystep_kernels::Progress| {
            let done = u64::from(max_depth) * u64::from(samples) + u64::from(now.samples);
            progress.part("light by bounce: samples", done, u64::from(count) * u64::from(samples));
            ControlFlow::Continue(())
        };
        chosen.wait(renderer.run(show))?;
        images.push(chosen.wait(renderer.image())?);
    }
    Ok(images)
}
