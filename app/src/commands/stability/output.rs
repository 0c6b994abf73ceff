//! The files of a report.

use std::io::Write as _;
use std::path::Path;

use raystep_kernels::stability::{COLUMNS, Row, write_rows};

use super::{Outcome, page};
use crate::error::Error;
use crate::output::TargetFolder;
use crate::scene_file::read_file;

/// One row a case and way.
const CSV: &str = "stability.csv";
/// The same with pictures.
const PAGE: &str = "stability.html";
/// All of them.
pub(super) const NAMES: [&str; 2] = [CSV, PAGE];

/// Refuses a folder whose files of our names are not a report's.
pub(super) fn refuse_others(folder: &Path) -> Result<(), Error> {
    const MOST_BYTES: u64 = 1 << 28;
    let Some(name) = NAMES.iter().find(|name| folder.join(name).exists()) else { return Ok(()) };
    let csv = read_file(&folder.join(CSV), MOST_BYTES).ok();
    if csv.is_some_and(|bytes| bytes.starts_with(COLUMNS.join(",").as_bytes())) {
        return Ok(());
    }
    Err(Error::failed(format!("{} has a {name} that is no such report: name another folder", folder.display())))
}

/// Writes every file.
pub(super) fn write(folder: &TargetFolder, outcomes: &[Outcome]) -> Result<(), Error> {
    let rows: Vec<Row> = outcomes.iter().flat_map(|o| &o.rows).cloned().collect();
    folder.write(CSV, |out| write_rows(out, &rows))?;
    let page = page::html(outcomes)?;
    folder.write(PAGE, |out| out.write_all(page.as_bytes()))
}
