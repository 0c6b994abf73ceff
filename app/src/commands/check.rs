//! `raystep check`: a user's program on a device beside the interpreter.

use std::path::PathBuf;

use clap::Args;
use raystep_kernels::Options;
use raystep_kernels::plan::Plan;
use raystep_lab::check_program::{CheckError, Difference, Outcome, PASSES, TOLERANCE, Wanted, check};

use crate::args::{DeviceArgs, QuietArgs, SightArgs, whole};
use crate::device;
use crate::error::Error;
use crate::program_folder;
use crate::scene_file::{self, SceneFile};
use crate::terminal::{Progress, print};

/// Check a program of your own: its files, and its values on the GPU beside those of the interpreter
///
/// The interpreter starts every pass from the device's streams, so a difference is that of one pass. It also finds what a
/// GPU does not report: indices that are out of range, elements that two threads write, barriers that some threads do not
/// reach. Interpreting takes long: for a program that reads a scene, choose a small --size.
/// Exit code 0 if no mistake is found, 1 if one is.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  raystep check my-program
  raystep check my-program --passes 100
  raystep check my-tracer@teapot --size 64x48
  raystep check my-program --device gpu --json")]
pub(crate) struct CheckArgs {
    /// The folder with program.toml, or FOLDER@SCENE
    #[arg(value_name = "FOLDER[@SCENE]")]
    folder: PathBuf,
    /// Compare the first N passes of each kernel
    #[arg(long, value_name = "N", default_value_t = PASSES, value_parser = whole::<usize>(1, u64::MAX))]
    passes: usize,
    /// How far floats may be apart, in parts of the largest magnitude in their layer
    #[arg(long, value_name = "R", default_value_t = TOLERANCE, value_parser = tolerance)]
    tolerance: f32,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    sight: SightArgs,
    #[command(flatten)]
    quiet: QuietArgs,
    #[command(flatten)]
    device: DeviceArgs,
}

fn tolerance(text: &str) -> Result<f32, &'static str> {
    text.parse().ok().filter(|value| (0.0..=1.0).contains(value)).ok_or("expected a number from 0 to 1")
}

pub(crate) fn run(args: &CheckArgs) -> Result<(), Error> {
    if program_folder::find(&args.folder).is_none() {
        let message = format!("{}: no folder with program.toml; 'raystep new NAME' makes one", args.folder.display());
        return Err(Error::usage(message));
    }
    let (SceneFile { folder, scene, .. }, rays) = scene_file::read_program(&args.folder, &args.sight)?;
    let progress = Progress::new(args.quiet.quiet);
    let chosen = device::choose(&args.device.for_users())?;
    let options = Options { folder, ..Options::new(rays) };
    let planned = chosen.wait(Plan::on(&scene, &options, &chosen.device))?;
    let program = planned.0.program;
    let wanted = Wanted { passes: args.passes, tolerance: args.tolerance };
    let told = |passes: usize| {
        progress.stage(&format!("comparing, pass {passes}"));
        true
    };
    let outcome = chosen.wait(check(&chosen.device, planned, &options, wanted, told));
    progress.finish();
    let outcome = outcome.map_err(|error| match error {
        CheckError::Render(error) => Error::from(error),
        CheckError::Cpu(error) => Error::failed(error),
    })?;
    if args.json {
        print(&super::json_text(&outcome)?)?;
    } else {
        print(&words(program.name, &chosen.name(), &outcome))?;
    }
    match outcome {
        Outcome::Same { .. } => Ok(()),
        Outcome::Differs(_) => Err(Error::failed(format!("{} has other values than the interpreter", program.name))),
        Outcome::Fails { .. } => Err(Error::failed(format!("check found a mistake in {}", program.name))),
    }
}

fn words(name: &str, device: &str, outcome: &Outcome) -> String {
    match outcome {
        Outcome::Same { passes, of, values, apart } => {
            let apart = if *apart > 0.0 {
                format!(", floats at most {apart:.1e} of their layer's largest apart")
            } else {
                String::new()
            };
            format!(
                "{name}: {values} values after {passes} of {of} passes are those of the interpreter, on {device}{apart}\n"
            )
        }
        Outcome::Differs(difference) => {
            let Difference { pass, kernel, element, of, stream, layer, value, expected, values } = &**difference;
            let element: Vec<String> = element.iter().map(u32::to_string).collect();
            let others = match values {
                0 | 1 => String::new(),
                more => format!(", and {} other values", more - 1),
            };
            format!(
                "{name}, on {device}: pass {pass}, {kernel}, leaves {stream}.{layer} = {value} in element {} of {of}, where the interpreter has {expected}{others}\n",
                element.join(",")
            )
        }
        Outcome::Fails { pass, message } => format!("{name}, interpreted: pass {pass} fails: {message}\n"),
    }
}
