//! Programs: the kernels of each, with their rows, streams and schedules.

pub mod closest_hit;
pub mod grid_build;
pub mod sort;

use crate::options::ProgramName;
use crate::program::Program;
use crate::tables::stream::Stream;

/// All programs.
pub static ALL: [&Program; 3] = [&closest_hit::PROGRAM, &grid_build::PROGRAM, &sort::PROGRAM];

/// The program with this name.
#[must_use]
pub fn named(name: ProgramName) -> &'static Program {
    match name {
        ProgramName::ClosestHit => &closest_hit::PROGRAM,
        ProgramName::GridBuild => &grid_build::PROGRAM,
        ProgramName::Sort => &sort::PROGRAM,
    }
}

/// The stream with this name, of any program: names are unique.
#[must_use]
pub fn stream(name: &str) -> Option<Stream> {
    ALL.into_iter().find_map(|program| program.stream(name))
}

/// Whether a stream holds the costs of rays, of any program.
#[must_use]
pub fn are_counters(stream: Stream) -> bool {
    ALL.into_iter().any(|program| program.results.is_some_and(|results| results.counters == stream))
}

#[cfg(test)]
mod tests;
