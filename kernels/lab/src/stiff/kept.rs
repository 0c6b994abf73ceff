//! Results of an earlier, interrupted start.

use super::row::{COLUMNS, RUN_COLUMNS};
use super::{Settings, Wanted};
use crate::machine::Machine;
use crate::tidy::Table;

/// Rows that are finished, and need not be measured again.
#[derive(Clone, Debug)]
pub struct Kept {
    pub(super) rows: Table,
    pub(super) runs: Table,
}

/// Why an earlier start cannot be continued.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum KeptError {
    /// Its columns are others.
    #[error("its columns are not those of this version")]
    Columns,
    /// It measured something else.
    #[error("it has {column} {found}, not {wanted}")]
    Settings {
        /// What differs.
        column: &'static str,
        /// There.
        found: String,
        /// Here.
        wanted: String,
    },
}

impl Default for Kept {
    fn default() -> Self {
        Self { rows: Table::new(COLUMNS), runs: Table::new(RUN_COLUMNS) }
    }
}

impl Kept {
    /// Reads the files that a start appended to: rows and runs, as CSV. What was cut off at the end is dropped, and so are
    /// runs whose row is missing.
    ///
    /// # Errors
    /// If they do not belong to the same measurement.
    pub fn read(rows: &[u8], runs: &[u8], wanted: &Wanted, machine: &Machine) -> Result<Self, KeptError> {
        let rows = table(COLUMNS, rows)?;
        let mut runs = table(RUN_COLUMNS, runs)?;
        let Settings(settings) = wanted.settings(machine);
        for row in &rows.rows {
            for (column, wanted) in &settings {
                let found = row.get(column);
                if found != wanted {
                    return Err(KeptError::Settings { column, found: found.to_owned(), wanted: wanted.clone() });
                }
            }
        }
        let key = |row: &crate::tidy::Row| [row.get("run_id").to_owned(), row.get("configuration").to_owned()];
        let finished: std::collections::BTreeSet<_> = rows.rows.iter().map(key).collect();
        runs.rows.retain(|run| finished.contains(&key(run)));
        Ok(Self { rows, runs })
    }

    /// Finished rows.
    #[must_use]
    pub fn count(&self) -> usize {
        self.rows.rows.len()
    }

    /// Both files, rows first, with what was read.
    ///
    /// # Errors
    /// If there is not enough memory.
    pub fn files(&self) -> std::io::Result<[Vec<u8>; 2]> {
        Ok([self.rows.csv()?, self.runs.csv()?])
    }

    pub(super) fn has(&self, configuration: &str) -> bool {
        self.rows.rows.iter().any(|row| row.get("configuration") == configuration)
    }
}

/// An empty file is a table without rows.
fn table(columns: &'static [&'static str], bytes: &[u8]) -> Result<Table, KeptError> {
    let whole = bytes.iter().rposition(|&b| b == b'\n').map_or(0, |end| end + 1);
    match whole {
        0 => Ok(Table::new(columns)),
        _ => Table::read(columns, &bytes[..whole]).ok_or(KeptError::Columns),
    }
}
