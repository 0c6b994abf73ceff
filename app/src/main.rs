//! The program as a command.

use std::process::ExitCode;

fn main() -> ExitCode {
    raystep_app::main(std::env::args_os())
}
