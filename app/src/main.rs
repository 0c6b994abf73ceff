//! raystep on the command line: one file a subcommand, in `commands`.

mod args;
mod cli;
mod commands;
mod device;
mod error;
mod interrupt;
mod output;
mod scene_file;
mod session;
mod terminal;

use std::process::ExitCode;

use cli::{Command, Request};
use error::Error;

fn main() -> ExitCode {
    interrupt::install();
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            terminal::say(&error);
            ExitCode::from(error.code)
        }
    }
}

fn run() -> Result<(), Error> {
    match cli::parse(std::env::args_os())? {
        Request::Show(text) => terminal::print(&text),
        Request::Run(command) => match command {
            Command::Render(args) => commands::render::run(&args),
            Command::Trace(args) => commands::trace::run(&args),
            Command::Dump(args) => commands::dump::run(&args),
            Command::Plan(args) => commands::plan::run(&args),
            Command::Info(args) => commands::info::run(&args),
            Command::Scene(command) => commands::scene::run(&command),
            Command::Completions(args) => commands::completions::run(&args),
        },
    }
}
