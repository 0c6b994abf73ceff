//! The program: the command line, one file per subcommand in `commands`, and the window. A library, so that other hosts can
//! run the same program.

pub mod api;
mod args;
mod cli;
mod commands;
mod debug_adapter;
mod device;
mod drawing;
mod error;
mod interrupt;
mod link;
mod output;
mod process;
mod program_folder;
mod rays_file;
mod scene_file;
mod session;
mod session_file;
mod shard;
mod terminal;
mod threads;
mod usage;
mod window;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::CommandFactory as _;
use raystep_kernels::options::folder::Folder;
use raystep_scenes::Scene;

use cli::{Command, Request};
use error::Error;

/// Runs the program to its end, with the arguments of a command line, beginning with the program's name, and returns the
/// exit code. Call it from the main thread, before there is another one: it installs signal handlers, and may set
/// environment variables.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    #[cfg(target_os = "linux")]
    silence_mesa();
    interrupt::install();
    // What the process ends with after a panic.
    let mut ending = threads::Ending { code: 101 };
    ending.code = match run(arguments) {
        Ok(()) => 0,
        Err(error) => {
            terminal::say_lines(&error.to_string());
            error.code
        }
    };
    ending.code
}

/// Names the folder with the scenes that a host brings along, which open by name: `cornell-box` is `cornell-box.gltf` or
/// `.glb` there, unless there is such a file. The first call counts; without one, it is `scenes` beside the executable, or
/// `../share/raystep/scenes` from there.
pub fn set_scenes(folder: &Path) {
    scene_file::set_folder(folder.to_owned());
}

/// Reads a scene's file, or one that has a name, as the commands do, with their limits: files that it names have to be in
/// its folder or below. Returns also the files that it was read from, its own first.
///
/// # Errors
/// In one line: what is wrong with the file, or with its name.
pub fn read_scene(path: &Path) -> Result<(Scene, Vec<PathBuf>), String> {
    scene_file::read(&scene_file::alone(path)).map(|file| (file.scene, file.files)).map_err(|error| error.message)
}

/// Reads a program's folder or zip file, with the scene that it reads: another one than it names as in `my-program@teapot`.
/// Returns also the files that it was read from.
///
/// # Errors
/// In one line: what is wrong with it.
pub fn read_program(path: &Path) -> Result<(Folder, Scene, Vec<PathBuf>), String> {
    let read = scene_file::read_any(&scene_file::alone(path)).map_err(|error| error.message)?;
    let folder = read.folder.ok_or_else(|| format!("{}: not a program: it has no program.toml", path.display()))?;
    Ok((Folder::clone(&folder), read.scene, read.files))
}

/// The command line's definition, from which the manual pages are made.
#[doc(hidden)]
pub fn definition() -> clap::Command {
    cli::Cli::command()
}

/// Prevents a layer of Mesa from writing "error: XDG_RUNTIME_DIR is invalid" to stderr on machines without a desktop.
/// The layer reorders devices for desktops, but raystep selects its device by rank or name anyway.
#[cfg(target_os = "linux")]
#[allow(unsafe_code)]
fn silence_mesa() {
    use std::env::{set_var, var_os};
    if var_os("XDG_RUNTIME_DIR").is_none() && var_os("MESA_VK_DEVICE_SELECT").is_none() {
        // SAFETY: this is the first action of the program: no other thread can read the environment yet.
        unsafe { set_var("NODEVICE_SELECT", "1") };
    }
}

fn run(arguments: impl IntoIterator<Item = OsString>) -> Result<(), Error> {
    match cli::parse(arguments)? {
        Request::Show(text) => terminal::print(&text),
        Request::Run(command) => match command {
            Command::Inspect(args) => commands::inspect::run(*args),
            Command::Render(args) => commands::render::run(&args),
            Command::Trace(args) => commands::trace::run(*args),
            Command::Dump(args) => commands::dump::run(&args),
            Command::Bench(args) => commands::bench::run(&args),
            Command::Build(args) => commands::build::run(&args),
            Command::Run(args) => commands::run::run(&args),
            Command::Cast(args) => commands::cast::run(&args),
            Command::CheckKernel(args) => commands::check_kernel::run(*args),
            Command::ExportProgram(args) => commands::export_program::run(&args),
            Command::New(args) => commands::new::run(&args),
            Command::Check(args) => commands::check::run(&args),
            Command::Stop(args) => commands::stop::run(&args),
            Command::Cost(args) => commands::cost::run(&args),
            Command::DebugAdapter(args) => commands::debug_adapter::run(&args),
            Command::Course(args) => commands::course::run(&args),
            Command::Grade(args) => commands::grade::run(&args),
            Command::Merge(args) => commands::merge::run(&args),
            Command::Report(args) => commands::report::run(&args),
            Command::Stability(args) => commands::stability::run(&args),
            Command::Sweep(args) => commands::sweep::run(&args),
            Command::Plan(args) => commands::plan::run(&args),
            Command::Paper(args) => commands::paper::run(&args),
            Command::Info(args) => commands::info::run(&args),
            Command::Scene(command) => commands::scene::run(&command),
            Command::Completions(args) => commands::completions::run(&args),
        },
    }
}
