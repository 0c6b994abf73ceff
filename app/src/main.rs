//! The program as a command.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(raystep_app::main(std::env::args_os()))
}
