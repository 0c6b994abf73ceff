//! `raystep cost`

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use raystep_kernels::interpret::LineWork;
use raystep_kernels::shader::Sourced;
use raystep_lab::line_cost::{LineCosts, line_costs, per_byte};
use raystep_lab::text::{aligned, counted};

use super::source_line::{code, kernel_of, no_pass, of_stops, sourced};
use crate::args::choices::{ChoiceArgs, What};
use crate::args::{QuietArgs, RunArgs, SCENE_OR_PROGRAM, SceneArgs, ViewArgs, whole};
use crate::error::Error;
use crate::output::{Target, refuse_inputs, write};
use crate::session::Session;
use crate::terminal::{Progress, print};

/// Count what each line of a kernel takes: runs, operations, bytes, and operations per byte
///
/// The kernel is interpreted for all elements of its passes, or of --pass, from the streams before each. 'read' and 'written'
/// are bytes of streams, 'buffer' those of scene data and 'uniform' those of uniforms, which a device keeps close by and which do
/// not count in the ratio. What a cache or a compiler would save is counted. 'raystep plan --intensity' has the sums of
/// all kernels.
#[derive(Args, Debug)]
#[command(mut_arg("scene", |scene| scene.help(SCENE_OR_PROGRAM)), after_help = "\
Examples:
  raystep cost cornell-box --for intersect --size 64x64
  raystep cost cornell-box --for traverse_grid --size 64x64 --pass 9 --csv lines.csv
  raystep cost my-program --for generation --pass 1")]
pub(crate) struct CostArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    program: ChoiceArgs<What>,
    /// The kernel
    #[arg(long = "for", value_name = "KERNEL")]
    kernel: String,
    /// The pass, counted from 0 over all kernels [default: all passes of the kernel]
    #[arg(long, value_name = "N", value_parser = whole::<usize>(0, u64::MAX))]
    pass: Option<usize>,
    /// Write a row per line, with means per element
    #[arg(long, value_name = "F")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    quiet: QuietArgs,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    run: RunArgs,
}

pub(crate) fn run(args: &CostArgs) -> Result<(), Error> {
    let target = args.csv.as_deref().map(Target::new).transpose()?;
    let progress = Progress::new(args.quiet.quiet);
    let session = Session::stepped(&args.scene, &args.program, &args.view, &args.run, &progress)?;
    refuse_inputs(&[target.as_ref()], &session.inputs)?;
    let kernel = kernel_of(&session.plan, &args.kernel)?;
    let of = sourced(&session.plan, kernel)?;
    let code = code(&session.plan, &of, &of.variant)?;
    let mut running = session.start(&progress)?;
    let told = |passes: usize| {
        progress.stage(&format!("counting, pass {passes}"));
        true
    };
    let counted = running.chosen.wait(line_costs(&mut running.renderer, &of, &code, args.pass, told));
    progress.finish();
    let costs = match counted.map_err(|error| of_stops(&of, error))? {
        Ok(costs) => costs,
        Err(outcome) => return Err(no_pass(&of, args.pass, &outcome)),
    };
    if let Some(target) = target {
        let bytes = costs.csv(&of).map_err(Error::failed)?;
        write(vec![(target, bytes)])?;
    }
    print(&words(&of, &costs, args.pass))
}

const HEADS: [&str; 10] =
    ["line", "runs", "float", "integer", "compare", "read", "written", "buffer", "uniform", "op/B"];

fn words(of: &Sourced, costs: &LineCosts, pass: Option<usize>) -> String {
    let LineCosts { passes, elements, lines } = costs;
    let passes = match (pass, passes) {
        (Some(pass), _) => format!("pass {pass}"),
        (None, 1) => "its pass".to_owned(),
        (None, passes) => format!("all of its {passes} passes"),
    };
    let mut text = format!("{} in {passes}: {}\n", of.variant.kernel.name(), counted(*elements, "element"));
    let row = |name: String, line: &LineWork| {
        let number = |n: u64| if n == 0 { "-".to_owned() } else { n.to_string() };
        let mut row = vec![name, line.runs.to_string()];
        row.extend(line.work.each().map(number));
        row.push(per_byte(&line.work).map_or_else(|| "-".to_owned(), |ratio| format!("{ratio:.2}")));
        row
    };
    let mut rows = vec![HEADS.map(str::to_owned).to_vec()];
    for (at, line) in lines {
        let name = format!("{}:{}", of.files[at.file].name, at.line);
        rows.push(row(name, line));
    }
    let total = LineWork { runs: *elements, work: costs.total() };
    rows.push(row("all".into(), &total));
    let sources = lines.iter().map(|(at, _)| of.text_of(*at).trim());
    let sources = std::iter::once("").chain(sources).chain(std::iter::once(""));
    for (line, source) in aligned(&rows, 1).iter().zip(sources) {
        let _ = writeln!(text, "{}", format!("{}  {source}", line.trim_end()).trim_end());
    }
    text
}
