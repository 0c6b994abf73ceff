//! The files of a report.

use std::io::Write as _;
use std::path::Path;

use raystep_lab::stability::{COLUMNS, drift, probe, write_rows};

use super::{Report, page};
use crate::error::Error;
use crate::output::{self, TargetFolder};

/// One row a case and way.
const CSV: &str = "stability.csv";
/// How far tMax is off along a walk.
const DRIFT: &str = "tmax.csv";
/// How pipelines differ.
const PROBE: &str = "pipelines.csv";
/// The same with pictures.
const PAGE: &str = "stability.html";
/// All of them.
pub(super) const NAMES: [&str; 4] = [CSV, DRIFT, PROBE, PAGE];

/// Refuses a folder whose files of our names are not a report's.
pub(super) fn refuse_others(folder: &Path) -> Result<(), Error> {
    let is_ours = |bytes: &[u8]| bytes.starts_with(COLUMNS.join(",").as_bytes());
    output::refuse_others(folder, &NAMES, "such report", CSV, is_ours)
}

/// Writes every file.
pub(super) fn write(folder: &TargetFolder, report: &Report) -> Result<(), Error> {
    folder.write(CSV, |out| write_rows(out, report.outcomes.iter().flat_map(|o| &o.rows)))?;
    folder.write(DRIFT, |out| drift::write_rows(out, &report.walks))?;
    folder.write(PROBE, |out| probe::write_rows(out, &report.pipelines))?;
    let page = page::html(report)?;
    folder.write(PAGE, |out| out.write_all(page.as_bytes()))
}
