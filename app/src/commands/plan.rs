//! `raystep plan`

use clap::Args;
use raystep_kernels::export::{self, structure::Structure};
use raystep_kernels::plan::PlanText;

use crate::args::{ProgramArgs, QuietArgs, RunArgs, SceneArgs, ViewArgs};
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
  raystep plan scenes/cornell-box.gltf
  raystep plan scenes/teapot.glb --accelerator auto --schedule fused
  raystep plan scenes/terrain.glb --json | jq .bytes")]
pub(crate) struct PlanArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    program: ProgramArgs,
    /// Print JSON
    #[arg(long)]
    json: bool,
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
    let progress = Progress::new(args.quiet.quiet);
    let session = Session::new(&args.scene, &args.view, &args.run, &progress, |options| {
        options.program = args.program.program;
        options.counters = args.counters;
    })?;
    progress.finish();
    if args.json {
        return print(&super::json_text(&export::plan::plan(
            session.options.accelerator,
            &session.plan,
            &session.data,
        ))?);
    }
    if session.plan.program.course.is_none() {
        return print(&session.plan.to_string());
    }
    let structure = Structure::of(session.options.accelerator, &session.plan, &session.data);
    print(&PlanText(&session.plan, &structure).to_string())
}
