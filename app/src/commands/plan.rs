//! `raystep plan`

mod measured;

use clap::Args;
use raystep_kernels::export::plan::PlanSummary;
use raystep_kernels::export::{self, structure::Structure};
use raystep_kernels::options::ProgramName;
use raystep_kernels::plan::PlanText;
use serde::Serialize;

use measured::{AboutCosts, Measured};
use raystep_lab::report::left_out::ALONE_SECONDS;

use crate::args::{ProgramArgs, QuietArgs, RunArgs, SceneArgs, ViewArgs, whole};
use crate::error::Error;
use crate::session::Session;
use crate::terminal::{Progress, print};

/// Show what a run needs, what it omits, and why
///
/// Lists kernels with their bindings, and streams and buffers with their sizes. Omitted parts are not compiled, bound,
/// allocated or uploaded.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  raystep plan cornell-box
  raystep plan teapot --accelerator auto --schedule fused
  raystep plan cornell-box --device gpu --measure
  raystep plan terrain --json | jq .bytes")]
pub(crate) struct PlanArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    program: ProgramArgs,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Also measure what each unneeded item would cost: memory and, on a GPU, run time and start-up
    #[arg(long, conflicts_with = "keep_all")]
    measure: bool,
    /// About how long to measure on a GPU; what does not fit is not measured [default: 25]
    #[arg(long, value_name = "N", default_value_t = ALONE_SECONDS, hide_default_value = true, requires = "measure",
          value_parser = whole::<u32>(1, 36_000), allow_negative_numbers = true)]
    seconds: u32,
    /// Count cells visited and triangles tested
    #[arg(long)]
    counters: bool,
    #[command(flatten)]
    quiet: QuietArgs,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    run: RunArgs,
}

pub(crate) fn run(args: &PlanArgs) -> Result<(), Error> {
    let program = args.program.program;
    if args.measure && program == ProgramName::GridBuild {
        return Err(Error::usage(format!(
            "--measure: program {program} omits nothing that a scene does not need; use --program closest-hit"
        )));
    }
    let progress = Progress::new(args.quiet.quiet);
    let session = Session::new(&args.scene, &args.view, &args.run, &progress, |_, options| {
        options.program = program;
        options.counters = args.counters;
    })?;
    let Session { scene, options, chosen, plan, data, .. } = session;
    let asked = options.accelerator;
    let summary = args.json.then(|| export::plan::plan(asked, &plan, &data));
    let text = match plan.program.course {
        _ if args.json => String::new(),
        None => plan.to_string(),
        Some(_) => PlanText(&plan, &Structure::of(asked, &plan, &data)).to_string(),
    };
    let measured = match args.measure {
        true => {
            // Measuring plans anew, and a large scene's structure need not be kept twice.
            drop((plan, data));
            progress.stage("measuring what the scene does not need");
            Some(Measured::of(scene, &options, chosen, args.seconds, &progress)?)
        }
        false => None,
    };
    progress.finish();
    match summary {
        Some(plan) => print(&super::json_text(&AboutPlan { plan, put_back: measured.as_ref().map(Measured::about) })?),
        None => print(&(text + &measured.as_ref().map(Measured::text).unwrap_or_default())),
    }
}

#[derive(Serialize)]
struct AboutPlan<'a> {
    #[serde(flatten)]
    plan: PlanSummary,
    /// With `--measure`.
    #[serde(skip_serializing_if = "Option::is_none")]
    put_back: Option<AboutCosts<'a>>,
}
