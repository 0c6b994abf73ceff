//! Measures how fast raystep traces, and generates tables of `docs/performance.md`, `docs/performance-notes.md` and
//! `docs/paper-tables.md` from the results.
//!
//! `measure` writes `machine.json` and one CSV per section: see [`measure::SECTIONS`]. It reads no files except the
//! meshes, so that the binary can be copied to another machine. `page` reads such folders and rewrites the marked parts
//! of those pages and the plots beside the tables.

mod bytes;
mod measure;
mod page;
mod probe;
mod sections;
mod subjects;
mod tdelta;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, ValueEnum};
use subjects::Mesh;

#[derive(Parser)]
enum Command {
    /// Measures sections, in the order in which they run: the largest scenes last
    Measure(MeasureArgs),
    /// Rewrites the pages from the folders that measure has written
    Page {
        #[arg(required = true, value_name = "DIR")]
        folders: Vec<PathBuf>,
    },
}

/// Kind of device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Adapter {
    /// A real GPU
    Gpu,
    /// Mesa's software Vulkan
    Software,
    /// The CPU reference kernels
    Cpu,
}

#[derive(Args, Clone, Debug)]
pub(crate) struct MeasureArgs {
    #[arg(long)]
    pub(crate) adapter: Adapter,
    /// Output folder
    #[arg(short)]
    pub(crate) output: PathBuf,
    /// A mesh as glTF, GLB, OBJ, PLY or STL: points are X,Y,Z, the vertical field of view is in degrees. Without a view,
    /// its first camera, or one that frames it
    #[arg(long = "mesh", value_name = "NAME=FILE[:EYE:LOOK_AT:FOV]", value_parser = subjects::mesh)]
    pub(crate) meshes: Vec<Mesh>,
    /// Only these sections
    #[arg(long, value_delimiter = ',', value_parser = measure::SECTIONS)]
    pub(crate) only: Vec<String>,
    /// Small images and three repeats, to try it out
    #[arg(long)]
    pub(crate) quick: bool,
}

fn main() -> ExitCode {
    let result = match Command::parse() {
        Command::Measure(args) => measure::measure(&args),
        Command::Page { folders } => page::write(&folders),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}
