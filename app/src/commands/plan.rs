//! `raystep plan`

mod measured;

use std::path::PathBuf;

use clap::Args;
use raystep_kernels::Choices;
use raystep_kernels::export::plan::PlanSummary;
use raystep_kernels::export::{self, structure::Structure};
use raystep_kernels::options::ProgramName;
use raystep_kernels::plan::PlanText;
use raystep_lab::block_on;
use raystep_lab::intensity::{Intensity, KernelMeans, intensity};
use serde::Serialize;

use measured::{AboutCosts, Measured};
use raystep_lab::report::left_out::ALONE_SECONDS;

use crate::args::choices::{ChoiceArgs, What};
use crate::args::{QuietArgs, RunArgs, SCENE_OR_PROGRAM, SceneArgs, ViewArgs, whole};
use crate::error::Error;
use crate::output::{Target, refuse_inputs, write};
use crate::session::Session;
use crate::terminal::{Progress, print};

/// Show what a run needs, what it omits, and why
///
/// Lists kernels with their bindings, and streams and buffers with their sizes. Omitted parts are not compiled, bound,
/// allocated or uploaded.
#[derive(Args, Debug)]
#[command(mut_arg("scene", |scene| scene.help(SCENE_OR_PROGRAM)), after_help = "\
Examples:
  raystep plan cornell-box
  raystep plan teapot --accelerator auto --schedule fused
  raystep plan cornell-box --device gpu --measure
  raystep plan teapot --schedule second --intensity
  raystep plan terrain --json | jq .bytes
  raystep plan my-program")]
pub(crate) struct PlanArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    program: ChoiceArgs<What>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Also measure what each item that the scene does not need would cost: memory and, on a GPU, run time and start-up
    #[arg(long, conflicts_with = "keep-all")]
    measure: bool,
    /// About how long to measure on a GPU; what does not fit is not measured [default: 25]
    #[arg(long, value_name = "N", default_value_t = ALONE_SECONDS, hide_default_value = true, requires = "measure",
          value_parser = whole::<u32>(1, 36_000), allow_negative_numbers = true)]
    seconds: u32,
    /// Also count the operations and bytes of each kernel, for each ray that it works on: its arithmetic intensity. The
    /// final WGSL is interpreted for this view, in an image of at most 4096 rays
    #[arg(long)]
    intensity: bool,
    /// Write these counts as CSV, one row per kernel
    #[arg(long, value_name = "F")]
    intensity_csv: Option<PathBuf>,
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
    let Choices { program, elements, .. } = args.program.values;
    if args.measure && program != ProgramName::ClosestHit {
        return Err(Error::usage(format!(
            "--measure: program {program} omits nothing that a scene does not need; use --program closest-hit"
        )));
    }
    let counts = args.intensity || args.intensity_csv.is_some();
    if counts && program != ProgramName::ClosestHit {
        return Err(Error::usage(format!(
            "--intensity: elements of program {program} read each other, and are not counted one by one; use --program \
             closest-hit"
        )));
    }
    let target = args.intensity_csv.as_deref().map(Target::new).transpose()?;
    let progress = Progress::new(args.quiet.quiet);
    let session = Session::of_any(&args.scene, &args.view, &args.run, &progress, |_, options| {
        (options.program, options.elements) = (program, elements);
        options.counters = args.counters;
    })?;
    refuse_inputs(&[target.as_ref()], &session.inputs)?;
    let Session { scene, options, chosen, plan, data, .. } = session;
    let asked = options.accelerator;
    let summary = args.json.then(|| export::plan::plan(asked, &plan, &data));
    let text = match plan.traces_rays() {
        _ if args.json => String::new(),
        false => plan.to_string(),
        true => PlanText(&plan, &Structure::of(asked, &plan, &data)).to_string(),
    };
    // What follows plans anew, and a large scene's structure need not be kept twice.
    drop((plan, data));
    let intensity = match counts {
        true => Some(block_on(None, intensity(&scene, &options, &progress))?),
        false => None,
    };
    if let (Some(target), Some(intensity)) = (target, &intensity) {
        write(vec![(target, intensity.csv()?)])?;
    }
    let measured = match args.measure {
        true => {
            progress.stage("measuring what the scene does not need");
            Some(Measured::of(scene, &options, chosen, args.seconds, &progress)?)
        }
        false => None,
    };
    progress.finish();
    match summary {
        Some(plan) => {
            let (intensity, put_back) =
                (intensity.as_ref().map(Intensity::kernels), measured.as_ref().map(Measured::about));
            print(&super::json_text(&AboutPlan { plan, intensity, put_back })?)
        }
        None => {
            let counted = intensity.as_ref().map(|counted| format!("\n{}", counted.text())).unwrap_or_default();
            print(&(text + &counted + &measured.as_ref().map(Measured::text).unwrap_or_default()))
        }
    }
}

#[derive(Serialize)]
struct AboutPlan<'a> {
    #[serde(flatten)]
    plan: PlanSummary,
    /// With `--intensity`: the columns of its CSV, by kernel.
    #[serde(skip_serializing_if = "Option::is_none")]
    intensity: Option<Vec<KernelMeans>>,
    /// With `--measure`.
    #[serde(skip_serializing_if = "Option::is_none")]
    put_back: Option<AboutCosts<'a>>,
}
