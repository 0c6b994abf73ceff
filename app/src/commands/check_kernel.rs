//! `raystep check-kernel`

use std::path::PathBuf;

use clap::Args;
use raystep_kernels::{Device, Options, RaySource};
use raystep_lab::Machine;
use raystep_lab::check_kernel::{Decided, Difference, Line, Outcome, check_kernel, mistake};
use serde::Serialize;

use crate::args::kernel::{KernelArgs, KernelFile};
use crate::args::{CameraArgs, DeviceArgs, DeviceKind, QuietArgs, RunArgs, SceneArgs, parse_size};
use crate::device;
use crate::error::Error;
use crate::scene_file::{self, SceneFile};
use crate::terminal::{Progress, print};

/// Compare a kernel of your own with the one that it replaces
///
/// Both start every pass from the same streams. Prints the first ray that your kernel treats otherwise: pass, pixel, stream,
/// what it left there and what was expected, the line that stored it and the condition that decided. First your kernel is
/// interpreted, then it runs on the GPU, if there is one. Exit code 0: no difference; 1: a difference, a mistake in the file,
/// or a loop that does not end.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  raystep check-kernel my-intersect.wgsl --for intersect cornell-box
  raystep check-kernel my-setup.wgsl teapot --size 32x32 --json
  raystep check-kernel walk.wgsl terrain --schedule compact --steps-per-pass 8")]
pub(crate) struct CheckKernelArgs {
    /// The file with your kernel
    file: PathBuf,
    /// The kernel that it replaces [default: the one that its @compute function is named after]
    #[arg(long = "for", value_name = "NAME")]
    name: Option<String>,
    #[command(flatten)]
    scene: SceneArgs,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "64x64", value_parser = parse_size, allow_hyphen_values = true,
          help_heading = "Scene and view")]
    size: raystep_lab::Size,
    #[command(flatten)]
    camera: CameraArgs,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    quiet: QuietArgs,
    #[command(flatten)]
    run: RunArgs,
}

/// The result as JSON.
#[derive(Serialize)]
struct Report<'a> {
    file: &'a str,
    kernel: &'a str,
    /// "interpreted", or the adapter that it ran on.
    device: &'a str,
    #[serde(flatten)]
    outcome: &'a Outcome,
}

/// A mistake as JSON.
#[derive(Serialize)]
struct Invalid<'a> {
    file: &'a str,
    kernel: &'a str,
    verdict: &'static str,
    line: usize,
    column: usize,
    message: &'a str,
}

pub(crate) fn run(args: CheckKernelArgs) -> Result<(), Error> {
    let CheckKernelArgs { file, name, scene, size, camera, json, quiet, run } = args;
    run.kernels.refuse("check-kernel compares one kernel, that of FILE, with built-in kernels around it")?;
    let file = KernelFile::new(name, file);
    let by = file.read()?;
    let run = RunArgs { kernels: KernelArgs { kernels: vec![file] }, ..run };
    let choices = run.values();
    crate::args::choices::check(&choices, |name| run.tracing.has(name))?;
    let progress = Progress::new(quiet.quiet);
    progress.stage("reading the scene");
    let SceneFile { scene, .. } = scene_file::read(&scene)?;
    let (camera, _) = scene_file::camera(&camera, &scene)?;
    let rays = RaySource::Camera { camera, width: size.width, height: size.height };
    let options = Options { replaced: vec![by.clone()], ..Options::new(rays).chosen(&choices) };

    let machines = machines(&run.device())?;
    let mut checked = Vec::new();
    for machine in &machines {
        let name = machine.as_ref().map_or_else(|| INTERPRETED.to_owned(), Machine::name);
        progress.stage(&format!("comparing {}, {}", by.kernel, ran(&name)));
        let device = machine.as_ref().map_or(Device::Cpu(None), |machine| machine.device.clone());
        let found = match machine {
            Some(machine) => machine.wait(check_kernel(&scene, &options, &device)),
            None => raystep_lab::block_on(None, check_kernel(&scene, &options, &device)),
        };
        let outcome = match found {
            Ok(outcome) => outcome,
            Err(error) => {
                progress.finish();
                let Some(mistake) = mistake(&error) else { return Err(Error::failed(error)) };
                if json {
                    let (line, column) = (mistake.place.line, mistake.place.column);
                    let (file, kernel, message) = (&*by.file, &*by.kernel, &*mistake.message);
                    let verdict = "invalid";
                    print(&super::json_text(&[Invalid { file, kernel, verdict, line, column, message }])?)?;
                }
                return Err(Error::from(mistake));
            }
        };
        let is_same = matches!(outcome, Outcome::Same { .. });
        checked.push((name, outcome));
        if !is_same {
            break;
        }
    }
    progress.finish();
    if json {
        let all: Vec<_> = checked
            .iter()
            .map(|(device, outcome)| Report { file: &by.file, kernel: &by.kernel, device, outcome })
            .collect();
        print(&super::json_text(&all)?)?;
    } else {
        checked.iter().try_for_each(|(device, outcome)| print(&told(&by.file, &by.kernel, device, outcome)))?;
    }
    match checked.last() {
        Some((_, Outcome::Same { .. })) => Ok(()),
        Some((_, Outcome::Idle)) => Err(Error::failed(format!("{} was not compared with {}", by.file, by.kernel))),
        _ => Err(Error::failed(format!("{} does not do what {} does", by.file, by.kernel))),
    }
}

/// What a user's kernel runs on, for these options: the interpreter, which is none, and then a GPU. The interpreter alone sees
/// every index that is out of range.
pub(super) fn machines(args: &DeviceArgs) -> Result<Vec<Option<Machine>>, Error> {
    let mut machines = Vec::new();
    if args.device != DeviceKind::Gpu && args.adapter.is_none() {
        machines.push(None);
    }
    if args.device != DeviceKind::Cpu {
        machines.extend(Some(device::choose(args)?).filter(|machine| machine.gpu().is_some()).map(Some));
    }
    Ok(machines)
}

/// The name of what runs a kernel without a device.
pub(super) const INTERPRETED: &str = "interpreted";

/// Where it ran.
pub(super) fn ran(device: &str) -> String {
    if device == INTERPRETED { device.to_owned() } else { format!("on {device}") }
}

/// An outcome in words.
fn told(file: &str, kernel: &str, device: &str, outcome: &Outcome) -> String {
    let ran = ran(device);
    match outcome {
        Outcome::Same { passes, rays } => {
            format!("{file} does what {kernel} does, {ran}: {rays} rays in {passes} passes have the same values\n")
        }
        Outcome::Differs(difference) => differs(file, kernel, &ran, difference),
        Outcome::Miscounts { pass, states } => miscounts(file, kernel, &ran, *pass, states),
        Outcome::Fails { message } => format!("{file} fails, {ran}: {message}\n"),
        Outcome::Idle => format!("{file} never ran, {ran}: no ray of this view waits for {kernel}\n"),
    }
}

pub(super) fn miscounts(file: &str, kernel: &str, ran: &str, pass: usize, states: &[(&str, u32, u32)]) -> String {
    let mut text = format!(
        "{file} counts rays otherwise than {kernel}, {ran}, first in pass {pass}: every thread must call send, with the tag \
         that it stored\n"
    );
    for (name, counted, found) in states {
        text += &format!("  {name}: {counted} counted, {found} found\n");
    }
    text
}

pub(super) fn differs(file: &str, kernel: &str, ran: &str, difference: &Difference) -> String {
    let Difference { pass, pixel: [x, y], rays, stream, layer, value, expected, .. } = difference;
    let Difference { cells, stored, decided, notes, fails, .. } = difference;
    let others = match rays {
        0 | 1 => String::new(),
        2 => " and another ray".into(),
        3..20 => format!(" and {} other rays", rays - 1),
        _ => " and many other rays".into(),
    };
    let mut text = format!(
        "{file} differs from {kernel}, {ran}, first in pass {pass}, for the ray of pixel {x},{y}{others}\n  \
         {stream}.{layer} is {value}, expected {expected}\n"
    );
    if let Some([[x, y, z], [to_x, to_y, to_z]]) = cells {
        text += &format!("  {value} is cell ({x}, {y}, {z}), and {expected} is cell ({to_x}, {to_y}, {to_z})\n");
    }
    let place = |line: &Line| match line.line {
        0 => line.file.clone(),
        number => format!("{}:{number}", line.file),
    };
    match stored {
        // A line of ours that nothing of the user's has called.
        Some(line) if line.text.is_empty() => {}
        Some(line) => text += &format!("  stored by {}: {}\n", place(line), line.text),
        None => match fails {
            Some(why) => text += &format!("  interpreted, this ray fails: {why}; --device cpu says where\n"),
            None => text += "  no line stored it\n",
        },
    }
    notes.iter().for_each(|note| text += &format!("  noted: {note}\n"));
    if let Some(Decided { at, how }) = decided {
        text += &format!("  decided by {}: {}\n", place(at), at.text);
        how.iter().for_each(|line| text += &format!("    {line}\n"));
    }
    text
}
