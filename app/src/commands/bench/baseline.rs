//! Reads an earlier benchmark, to compare with.

use std::path::Path;

use raystep_lab::bench::{self, Baseline};

use super::output;
use crate::error::Error;
use crate::scene_file::read_file;

/// Most bytes of an earlier summary: several million configurations.
const MOST_BYTES: u64 = 1 << 30;

/// Reads the folder of an earlier benchmark. One that compared two builds has rows of both; those of the other are left
/// out.
pub(super) fn read(folder: &Path) -> Result<Baseline, Error> {
    let read = |name: &str| {
        let path = folder.join(name);
        read_file(&path, MOST_BYTES).map_err(|e| cannot(&path, &e.to_string()))
    };
    let rows = bench::read_summary(read(output::SUMMARY)?.as_slice());
    let mut rows = rows.map_err(|e| cannot(&folder.join(output::SUMMARY), &e.to_string()))?;
    rows.retain(|row| row.build == bench::summary::THIS);
    let runs = bench::read_runs(read(output::RUNS)?.as_slice());
    let runs = runs.map_err(|e| cannot(&folder.join(output::RUNS), &e.to_string()))?;
    Ok(Baseline { folder: folder.display().to_string(), rows, runs })
}

fn cannot(path: &Path, reason: &str) -> Error {
    Error::failed(format!("--baseline: {}: {reason}; expected a folder written by 'raystep bench'", path.display()))
}
