//! `raystep check`: a user's program on a device beside the interpreter.

use std::path::{Path, PathBuf};

use clap::Args;
use raystep_kernels::plan::Plan;
use raystep_kernels::programs::own::array;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::{Options, Renderer, Stream};
use raystep_lab::Machine;
use raystep_lab::check_program::{
    CheckError, Difference, Outcome, PASSES, TOLERANCE, Wanted, check, check_on, check_result,
};

use crate::args::{DeviceArgs, DeviceKind, QuietArgs, SightArgs, whole};
use crate::device;
use crate::error::{Error, reason};
use crate::program_folder;
use crate::scene_file::{self, SceneFile};
use crate::terminal::{Progress, print};

/// Check a program of your own: its files, and its values on the GPU beside those of the interpreter, or of another witness
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
  raystep check my-program --device gpu --json
  raystep check my-program --against llvmpipe
  raystep check my-program --reference cell=expected.npy")]
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
    /// Compare with this GPU adapter instead of the interpreter: part of its name. Each goes on from its own values
    #[arg(long, value_name = "ADAPTER")]
    against: Option<String>,
    /// Compare a stream at the end of the run with an array of NumPy's instead
    #[arg(long, value_name = "STREAM=FILE", value_parser = reference, conflicts_with = "against")]
    reference: Option<(String, PathBuf)>,
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

fn reference(text: &str) -> Result<(String, PathBuf), &'static str> {
    let (stream, file) = text.split_once('=').ok_or("expected a stream and a file, such as cell=expected.npy")?;
    Ok((stream.to_owned(), file.into()))
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
    let (outcome, witness) = match (&args.against, &args.reference) {
        (Some(name), _) => {
            let other = device::choose(&DeviceArgs { device: DeviceKind::Gpu, adapter: Some(name.clone()) })?;
            let theirs = other.wait(Plan::on(&scene, &options, &other.device))?;
            let both = [(&chosen, planned), (&other, theirs)];
            (check_on(both, &options, wanted, told).map_err(Error::from), other.name())
        }
        (None, Some((stream, file))) => {
            let outcome = at_end(&chosen, planned, &options, (stream, file), (args.tolerance, told));
            (outcome, file.display().to_string())
        }
        (None, None) => {
            let outcome = chosen.wait(check(&chosen.device, planned, &options, wanted, told));
            let outcome = outcome.map_err(|error| match error {
                CheckError::Render(error) => Error::from(error),
                CheckError::Cpu(error) => Error::failed(error),
            });
            (outcome, "the interpreter".to_owned())
        }
    };
    progress.finish();
    let outcome = outcome?;
    if args.json {
        print(&super::json_text(&outcome)?)?;
    } else {
        print(&words(program.name, &chosen.name(), &witness, &outcome))?;
    }
    match outcome {
        Outcome::Same { .. } => Ok(()),
        Outcome::Differs(_) => Err(Error::failed(format!("{} has other values than {witness}", program.name))),
        Outcome::Fails { .. } => Err(Error::failed(format!("check found a mistake in {}", program.name))),
    }
}

/// Compares a stream at the end of the run with a file.
fn at_end(
    chosen: &Machine,
    (plan, data): (Plan, SceneData),
    options: &Options,
    (name, file): (&str, &Path),
    (tolerance, told): (f32, impl FnMut(usize) -> bool),
) -> Result<Outcome, Error> {
    let streams: Vec<Stream> = plan.streams.iter().map(|planned| planned.what).collect();
    let stream = streams.iter().copied().find(|stream| stream.name() == name).ok_or_else(|| {
        let names: Vec<&str> = streams.iter().map(|stream| stream.name()).collect();
        Error::usage(format!("--reference: no stream is named {name}; the streams are {}", names.join(", ")))
    })?;
    let bytes = std::fs::read(file).map_err(|error| Error::at(file, reason(&error)))?;
    let renderer = chosen.wait(Renderer::from_plan(plan, data, options, &chosen.device))?;
    let read = |size| array(stream, size, &bytes);
    let outcome = chosen.wait(check_result(renderer, stream, tolerance, read, told))?;
    outcome.map_err(|why| Error::at(file, why))
}

fn words(name: &str, device: &str, witness: &str, outcome: &Outcome) -> String {
    match outcome {
        Outcome::Same { passes, of, values, apart } => {
            let apart = if *apart > 0.0 {
                format!(", floats at most {apart:.1e} of their layer's largest apart")
            } else {
                String::new()
            };
            format!(
                "{name}: {values} values after {passes} of {of} passes are those of {witness}, on {device}{apart}\n"
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
                "{name}, on {device}: pass {pass}, {kernel}, leaves {stream}.{layer} = {value} in element {} of {of}, where {witness} has {expected}{others}\n",
                element.join(",")
            )
        }
        Outcome::Fails { pass, message } => format!("{name}, beside {witness}: pass {pass} fails: {message}\n"),
    }
}
