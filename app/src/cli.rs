//! The command line; each subcommand's options are in its own file.

use std::ffi::OsString;
use std::path::Path;

use clap::{CommandFactory as _, Parser, Subcommand};
use raystep_scenes::ENDINGS;

use crate::commands::{
    bench, build, cast, check, check_kernel, completions, cost, course, debug_adapter, dump, export_program, extension,
    grade, info, inspect, merge, new, paper, plan, render, report, run, scene, stability, stop, sweep, trace,
};
use crate::error::Error;
use crate::scene_file::is_known;
use crate::{program_folder, usage, window};

/// A ray tracer for inspecting every pass and every stream
///
/// Small kernels process per-ray streams on any GPU or on the CPU. Exit codes: 0 success, 1 failure, 2 wrong usage,
/// 3 undecided (bench --at-most); 129, 130 and 143 after SIGHUP, SIGINT and SIGTERM.
#[derive(Parser, Debug)]
#[command(
    name = "raystep",
    version,
    max_term_width = 100,
    disable_help_subcommand = true,
    after_help = "\
Examples:
  raystep cornell-box   # opens the inspector
  raystep render cornell-box -o box.png
  raystep plan cornell-box
  raystep trace cornell-box --pixel 256,256
  raystep dump cornell-box --pass last --stream hit -o hits
  raystep bench cornell-box --accelerators grid,bvh -o bench
  raystep build teapot --check
  raystep run sort --elements 65536 --check
  raystep cast cornell-box --rays-file rays.npy -o hits.npy
  raystep check-kernel my.wgsl --for intersect cornell-box
  raystep new my-program
  raystep run my-program -o result.png
  raystep check my-program
  raystep export-program cornell-box --schedule second -o my-tracer
  raystep stop my-program --at generation.wgsl:20 --when 'neighbours > 5u'
  raystep cost my-program --for generation --pass 1
  raystep course my-course
  raystep report cornell-box -o report
  raystep stability -o stability
  raystep paper -o paper
  raystep sweep sweep.toml -o sweep
  raystep info
A scene is a file, or a name: cornell-box is in the program; others, such as teapot and terrain, come with the wheel and
the archive, and open in a checkout of raystep.
'raystep COMMAND --help' says more about each."
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

#[derive(Subcommand, Debug)]
pub(crate) enum Command {
    Inspect(Box<inspect::InspectArgs>),
    Render(Box<render::RenderArgs>),
    Trace(Box<trace::TraceArgs>),
    Dump(Box<dump::DumpArgs>),
    Bench(Box<bench::BenchArgs>),
    Build(Box<build::BuildArgs>),
    Run(Box<run::RunProgramArgs>),
    Cast(Box<cast::CastArgs>),
    CheckKernel(Box<check_kernel::CheckKernelArgs>),
    New(new::NewArgs),
    Check(Box<check::CheckArgs>),
    ExportProgram(Box<export_program::ExportArgs>),
    Stop(Box<stop::StopArgs>),
    Cost(Box<cost::CostArgs>),
    DebugAdapter(debug_adapter::DebugAdapterArgs),
    Course(course::CourseArgs),
    Grade(grade::GradeArgs),
    Merge(merge::MergeArgs),
    Report(Box<report::ReportArgs>),
    Stability(Box<stability::StabilityArgs>),
    Sweep(sweep::SweepArgs),
    Plan(Box<plan::PlanArgs>),
    Paper(paper::PaperArgs),
    Info(info::InfoArgs),
    #[command(subcommand)]
    Scene(scene::SceneCommand),
    Completions(completions::CompletionsArgs),
}

/// A parsed command line.
pub(crate) enum Request {
    /// A command.
    Run(Command),
    /// Help or version.
    Show(String),
}

/// Parses the command line.
pub(crate) fn parse(arguments: impl IntoIterator<Item = OsString>) -> Result<Request, Error> {
    let arguments: Vec<_> = arguments.into_iter().collect();
    // A scene alone opens the inspector; so does no argument, if there is a display.
    let mut arguments = arguments;
    if arguments.get(1).is_some_and(is_scene) || arguments.len() < 2 && window::has_display() {
        arguments.insert(1, "inspect".into());
    }
    match Cli::try_parse_from(&arguments) {
        Ok(Cli { command: Some(command) }) => Ok(Request::Run(command)),
        Ok(Cli { command: None }) => Ok(Request::Show(Cli::command().render_help().to_string())),
        Err(error) if !error.use_stderr() => Ok(Request::Show(error.render().to_string())),
        Err(error) => Err(Error::usage(usage::message(&error, &arguments))),
    }
}

/// Whether an argument looks like the file of a scene or session, or is the name of a scene and of no command.
fn is_scene(argument: &OsString) -> bool {
    let path = Path::new(argument);
    let ending = extension(path);
    let is_command = || Cli::command().find_subcommand(argument).is_some();
    ENDINGS.contains(&ending.as_str())
        || program_folder::find(path).is_some() && !is_command()
        || ending == "raystep-session"
        || is_known(path) && !is_command()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_option_that_another_names_is_there() {
        Cli::command().debug_assert();
    }
}
