//! `raystep stop`

mod result;

use std::path::PathBuf;

use clap::Args;
use raystep_kernels::shader::{Sourced, Stop};
use raystep_lab::stops::{Outcome, PASSES, Told, find};
use raystep_lab::text::counted;

use super::source_line::{SourceLine, code, no_pass, of_stops};
use crate::args::choices::{ChoiceArgs, What};
use crate::args::{QuietArgs, RunArgs, SCENE_OR_PROGRAM, SceneArgs, ViewArgs, whole};
use crate::error::Error;
use crate::output::{Target, ending, refuse_inputs, write};
use crate::session::Session;
use crate::terminal::{Progress, print};

/// Find the elements that come to a line of a kernel, or for which a condition holds there
///
/// All elements of a pass are interpreted, from the streams before it: those of the first pass of the kernel in which the
/// condition holds for one, or those of --pass. Prints how many elements come to the line, for how many the condition holds,
/// and the first of them with the values of its variables. The line is one of the kernel's own file, of a file that it
/// imports, or of one of yours, and the condition is any expression of WGSL that has a value of type bool before the first
/// statement of the line. Exit code 0 if there is such an element, 1 if there is none.
#[derive(Args, Debug)]
#[command(mut_arg("scene", |scene| scene.help(SCENE_OR_PROGRAM)), after_help = "\
Examples:
  raystep stop cornell-box --at intersect:57 --when 'candidate.is_hit && candidate.t < 3.0' -o mask.png
  raystep stop cornell-box --at triangle.wgsl:40 -o rays.csv
  raystep stop my-program --at generation.wgsl:20 --when 'neighbours > 5u'
  raystep stop cornell-box --kernel my-intersect.wgsl --at my-intersect.wgsl:57")]
pub(crate) struct StopArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    program: ChoiceArgs<What>,
    /// The line: a kernel or a file of WGSL, and the line's number
    #[arg(long, value_name = "NAME:LINE")]
    at: SourceLine,
    /// The condition, an expression of WGSL; without one, every element that comes to the line counts
    #[arg(long, value_name = "EXPRESSION", allow_hyphen_values = true)]
    when: Option<String>,
    /// The kernel, if several have the file
    #[arg(long = "for", value_name = "KERNEL")]
    kernel: Option<String>,
    /// The pass, counted from 0 over all kernels [default: the first in which an element stops]
    #[arg(long, value_name = "N", value_parser = whole::<usize>(0, u64::MAX))]
    pass: Option<usize>,
    /// Look at the first N passes of the kernel at most
    #[arg(long, value_name = "N", default_value_t = PASSES, value_parser = whole::<usize>(1, u64::MAX), conflicts_with = "pass")]
    passes: usize,
    /// Write which elements: a mask (.png, white where the condition holds, gray where the line is only reached), a list with
    /// the values (.csv), or an array (times reached and times held, row, column) (.npy)
    #[arg(short, long, value_name = "F")]
    output: Option<PathBuf>,
    #[command(flatten)]
    quiet: QuietArgs,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    run: RunArgs,
}

pub(crate) fn run(args: &StopArgs) -> Result<(), Error> {
    if let Some(path) = &args.output {
        ending("-o", path, &["png", "csv", "npy"])?;
    }
    let target = args.output.as_deref().map(Target::new).transpose()?;
    let progress = Progress::new(args.quiet.quiet);
    let session = Session::stepped(&args.scene, &args.program, &args.view, &args.run, &progress)?;
    refuse_inputs(&[target.as_ref()], &session.inputs)?;
    let (of, at, statement) = args.at.find(&session.plan, args.kernel.as_deref())?;
    let stops = [Stop { statement, when: args.when.clone() }];
    let stopping = of.stopping(&stops, false).map_err(|error| {
        let mut wrong = Error::usage(format!("--when, column {}: {}", error.column, error.message));
        let when = args.when.as_deref().unwrap_or_default();
        wrong.excerpt = Some(format!("    {when}\n    {}^", " ".repeat(error.column.saturating_sub(1))));
        wrong
    })?;
    let code = code(&session.plan, &of, &stopping.variant)?;
    let mut running = session.start(&progress)?;
    progress.stage("looking for elements that stop");
    let told = |passes: usize| {
        progress.stage(&format!("looking for elements that stop, pass {passes}"));
        true
    };
    let outcome = running.chosen.wait(find(&mut running.renderer, &code, args.pass, args.passes, told));
    progress.finish();
    let found = match outcome.map_err(|error| of_stops(&of, error))? {
        Outcome::Stopped(found) => found,
        Outcome::Never { passes, of: all, reached, is_cut } => {
            return Err(never(&of, args, [passes, all], reached, is_cut));
        }
        other => return Err(no_pass(&of, args.pass, &other)),
    };
    let names = stopping.watched.first().map_or(&[][..], Vec::as_slice);
    let told =
        Told { found: &found, of: &of, at, when: args.when.as_deref(), names, watched: code.interpreter().watched(0) };
    if let Some(target) = target {
        let bytes = result::file(&told, target.path())?;
        write(vec![(target, bytes)])?;
    }
    print(&result::words(&told))?;
    match found.held().next() {
        Some(_) => Ok(()),
        None => Err(Error::failed(format!("no element stops in pass {}", found.pass))),
    }
}

fn never(of: &Sourced, args: &StopArgs, [passes, all]: [usize; 2], reached: u64, is_cut: bool) -> Error {
    let kernel = of.variant.kernel.name();
    let where_ = match is_cut {
        true => format!("in the first {} of {kernel}; --passes looks at more", counted(passes, "pass")),
        false => format!("in {} of {kernel}, of {all} passes of the run", counted(passes, "pass")),
    };
    let why = match (reached, &args.when) {
        (0, _) => "no element comes to this line".to_owned(),
        (_, Some(when)) => format!("{when} holds for none of the {reached} elements that come to this line"),
        (_, None) => "no element stops".to_owned(),
    };
    Error::failed(format!("{why}, {where_}"))
}
