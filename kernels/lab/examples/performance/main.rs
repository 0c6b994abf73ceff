//! Measures how fast raystep traces, and generates tables of `docs/performance.md`, `docs/performance-notes.md` and
//! `docs/paper-tables.md` from the results.
//!
//! ```text
//! performance measure --adapter gpu|software|cpu -o DIR [--mesh NAME=FILE[:EYE:LOOK_AT:FOV]]… [--only SECTION,…] [--quick]
//! performance page DIR…
//! ```
//!
//! `measure` writes `machine.json` and one CSV per section: see [`sections`]. Points are X,Y,Z; the vertical field of
//! view is in degrees. It reads no files except the meshes, so that the binary can be copied to another machine.
//! `page` reads such folders and rewrites the marked parts of those pages and the plots beside the tables.

mod args;
mod csvs;
mod fit;
mod machine;
mod meter;
mod page;
mod probe;
mod row;
mod scenes;
mod sections;

use std::process::ExitCode;

use args::Command;

fn main() -> ExitCode {
    let result = match Command::parse(std::env::args().skip(1)) {
        Ok(Command::Measure(args)) => sections::measure(&args),
        Ok(Command::Page(folders)) => page::write(&folders),
        Err(message) => {
            eprintln!("{message}\n\n{}", args::USAGE);
            return ExitCode::from(2);
        }
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}
