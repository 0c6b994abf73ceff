//! `raystep export-program`

use std::path::PathBuf;

use clap::Args;
use raystep_kernels::export::program::program;
use raystep_lab::text::counted;

use crate::args::choices::{ChoiceArgs, What};
use crate::args::{QuietArgs, RunArgs, SceneArgs, ViewArgs};
use crate::error::Error;
use crate::output::TargetFolder;
use crate::scene_file;
use crate::session::Session;
use crate::terminal::Progress;

/// Write the program of a run as a folder, to change and run it as a program of your own
///
/// The folder has the run's kernels as WGSL files, and program.toml with its streams, states and schedule. 'raystep run FOLDER'
/// gives the same bits as the run with the same scene, view and options; 'raystep inspect FOLDER' shows its passes.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  raystep export-program cornell-box --schedule second -o my-tracer
  raystep export-program cornell-box --integrator shadows --schedule second -o my-shadows
  raystep export-program cornell-box --program sort --elements 1000 -o my-sort
  raystep run my-tracer -o image.png")]
pub(crate) struct ExportArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    program: ChoiceArgs<What>,
    /// Output folder: new, or empty
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Replace files in a folder that is not empty
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    quiet: QuietArgs,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    run: RunArgs,
}

pub(crate) fn run(args: &ExportArgs) -> Result<(), Error> {
    let progress = Progress::new(args.quiet.quiet);
    let folder = TargetFolder::new(&args.output, args.force)?;
    let session = Session::stepped(&args.scene, &args.program, &args.view, &args.run, &progress)?;
    // A scene with a name is found from anywhere.
    let named = Some(&args.scene.scene).filter(|path| scene_file::is_known(path) && path.extension().is_none());
    let named = named.and_then(|path| path.to_str());
    let files = program(&session.plan, &session.data, &session.options, named).map_err(Error::failed)?;
    folder.refuse_inputs(&session.inputs, |_| false)?;
    folder.fill(&[], |folder| {
        for (path, bytes) in &files {
            folder.write(path, |out| std::io::Write::write_all(out, bytes))?;
        }
        Ok(())
    })?;
    let how = match named {
        Some(_) => args.output.display().to_string(),
        None => format!("{}@{}", args.output.display(), args.scene.scene.display()),
    };
    progress.say(format_args!(
        "wrote {} to {}; 'raystep run {how}' runs the program",
        counted(files.len(), "file"),
        args.output.display()
    ));
    Ok(())
}
