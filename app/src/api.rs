//! What other hosts of the program call besides [`main`](crate::main): devices and the options of runs, in the command
//! line's words, with its errors.

use std::ffi::OsString;

use clap::{Args, CommandFactory as _, FromArgMatches as _, Parser};
use raystep_kernels::{Options, RaySource, RenderError};
use raystep_lab::Machine;
use raystep_scenes::Scene;

use crate::args::{DeviceArgs, RunArgs, ViewArgs};
use crate::error::{self, Error};
use crate::session;
use crate::{device, scene_file, threads, usage};

/// Why something cannot be had: one line, as after `error: ` on the command line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Failure {
    /// An option is wrong, or does not go with the others.
    Usage(String),
    /// The work failed.
    Failed(String),
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        if error.code == error::USAGE { Self::Usage(error.message) } else { Self::Failed(error.message) }
    }
}

impl From<&RenderError> for Failure {
    fn from(error: &RenderError) -> Self {
        Error::from(error).into()
    }
}

/// The options of a run of all rays of a camera.
#[derive(Args)]
struct RunWords {
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    run: RunArgs,
    /// Count cells visited and triangles tested
    #[arg(long)]
    counters: bool,
    /// Time every pass
    #[arg(long)]
    timings: bool,
}

/// Options without a command.
#[derive(Parser)]
struct Words<A: Args> {
    #[command(flatten)]
    args: A,
}

/// Parses options, without the program's name before them.
fn parse<A: Args>(words: &[OsString]) -> Result<A, Error> {
    let words: Vec<OsString> = std::iter::once("raystep".into()).chain(words.iter().cloned()).collect();
    let wrong = |e: clap::Error| Error::usage(usage::message(&e, &words));
    let matches = Words::<A>::command().try_get_matches_from(&words).map_err(wrong)?;
    Words::from_arg_matches(&matches).map(|words: Words<A>| words.args).map_err(wrong)
}

/// Opens a device: `--device` and `--adapter`.
///
/// # Errors
/// If an option is wrong, or there is no such device.
pub fn open(words: &[OsString]) -> Result<Machine, Failure> {
    Ok(device::choose(&parse::<DeviceArgs>(words)?)?)
}

/// Ends the threads that call devices, before the process ends: a driver may crash if they call it while its exit handlers
/// run. No device works afterwards.
pub fn end() {
    // If one does not end in time, the host still decides how its process ends.
    let _ = threads::end();
}

/// The options of a run of a scene, and notes about them: those of `raystep render` for view, samples and tracing, except
/// `--adapter`; `--device` tells which kind of device there is.
///
/// # Errors
/// If an option is wrong, or does not go with the others or with the scene.
pub fn run_options(scene: &Scene, words: &[OsString]) -> Result<(Options, Vec<String>), Failure> {
    let RunWords { view, run, counters, timings } = parse(words)?;
    run.check(&view)?;
    let (camera, note) = scene_file::camera(&view.camera, scene)?;
    let rays = RaySource::Camera { camera, width: view.size.width, height: view.size.height };
    let options =
        Options { counters, timings, replaced: run.kernels.read()?, ..Options::new(rays).chosen(&run.choices(&view)) };
    Ok((options, note.into_iter().collect()))
}

/// An id for the rows of a run.
#[must_use]
pub fn run_id() -> String {
    session::run_id()
}

#[cfg(test)]
mod tests {
    use raystep_kernels::{Accelerator, ScheduleKind};
    use raystep_scenes::generate;

    use super::*;

    fn options(words: &[&str]) -> Result<(Options, Vec<String>), Failure> {
        let words: Vec<OsString> = words.iter().map(OsString::from).collect();
        run_options(&generate::cornell_box(), &words)
    }

    #[test]
    fn options_are_those_of_the_command_line() {
        let (found, notes) = options(&["--accelerator=bvh", "--size=64x48", "--spp=4", "--counters"]).expect("options");
        let RaySource::Camera { width, height, .. } = found.rays else { panic!("a camera") };
        assert_eq!((width, height, found.samples.count, found.counters, found.timings), (64, 48, 4, true, false));
        assert_eq!((found.accelerator, found.schedule), (Accelerator::Bvh, ScheduleKind::Compact));
        assert!(notes.is_empty());
        let (_, notes) = options(&["--eye=0,9,0", "--look-at=0,0,0"]).expect("options");
        assert!(notes[0].starts_with("the view is parallel to up"), "{notes:?}");
    }

    #[test]
    fn what_is_wrong_is_said_in_one_line() {
        for (words, wanted) in [
            (&["--accelerator=tree"][..], "--accelerator tree: expected auto, grid, irregular, bvh or none"),
            (&["--size=0x1"], "--size 0x1: expected 1 to 32768 pixels per side"),
            (&["--camera=7"], "--camera 7: the scene has one camera, number 0"),
            (&["--seed=7"], "--seed requires several samples per pixel: omit it, or add --spp N"),
            (&["--accelerator=bvh", "--grid=8"], "--grid applies to a uniform grid"),
            (&["--mapping=fragment", "--spp=2"], "--mapping fragment takes one sample per pixel"),
            (&["--mapping=fragment", "--device=cpu"], "--mapping fragment draws on a GPU"),
        ] {
            match options(words) {
                Err(Failure::Usage(line)) => assert!(line.starts_with(wanted), "{line}"),
                other => panic!("{words:?}: {other:?}"),
            }
        }
        assert_eq!(
            open(&["--device=tpu".into()]).err(),
            Some(Failure::Usage("--device tpu: expected auto, gpu or cpu".into()))
        );
    }
}
