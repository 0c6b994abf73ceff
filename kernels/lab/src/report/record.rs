//! What the sections of a report share beyond their own rows: every timed run, and on request every judged ray.

use std::sync::{Mutex, PoisonError};

use crate::Hash;
use crate::tidy::{KEYS, Row, Table, count, joined};

/// File of all timed runs.
pub(super) const RUNS: &str = "runs.csv";

const RUN_GROUPS: &[&[&str]] = &[KEYS, columns![section round place time_ns wall_ns clock]];

pub(super) const RUN_COLUMNS: &[&str] = &joined::<{ count(RUN_GROUPS) }>(RUN_GROUPS);

/// File of all judged rays.
pub(super) const RAYS: &str = "rays.csv";

const RAY_GROUPS: &[&[&str]] =
    &[KEYS, columns![section ray stratum verdict found_triangle found_t exact_triangle exact_t t_error t_bound]];

pub(super) const RAY_COLUMNS: &[&str] = &joined::<{ count(RAY_GROUPS) }>(RAY_GROUPS);

/// Tables that grow while sections run.
#[derive(Debug)]
pub(super) struct Record {
    /// Identifies this report.
    pub(super) run_id: String,
    /// Seed of rays, orders and bootstraps.
    pub(super) seed: u32,
    runs: Mutex<Table>,
    rays: Option<Mutex<Table>>,
}

fn add(table: &Mutex<Table>, rows: impl IntoIterator<Item = Row>) {
    table.lock().unwrap_or_else(PoisonError::into_inner).rows.extend(rows);
}

impl Record {
    pub(super) fn new(run_id: String, seed: u32, has_rays: bool) -> Self {
        let rays = has_rays.then(|| Mutex::new(Table::new(RAY_COLUMNS)));
        Self { run_id, seed, runs: Mutex::new(Table::new(RUN_COLUMNS)), rays }
    }

    /// An empty row with the columns that identify report, scene and adapter.
    pub(super) fn row(&self, columns: &'static [&'static str], scene: &str, hash: Hash, adapter: &str) -> Row {
        let row = Row::new(columns).set("run_id", &*self.run_id).set("scene", scene).set("adapter", adapter);
        row.set("scene_hash", hash)
    }

    /// Adds timed runs.
    pub(super) fn add_runs(&self, rows: impl IntoIterator<Item = Row>) {
        add(&self.runs, rows);
    }

    /// Whether single rays are recorded.
    pub(super) fn has_rays(&self) -> bool {
        self.rays.is_some()
    }

    /// Adds judged rays, if they are recorded.
    pub(super) fn add_rays(&self, rows: impl IntoIterator<Item = Row>) {
        if let Some(rays) = &self.rays {
            add(rays, rows);
        }
    }

    /// The files so far, with what their rows are.
    pub(super) fn tables(&self) -> Vec<(&'static str, &'static str, Table)> {
        let of = |table: &Mutex<Table>| table.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let rays = self.rays.as_ref().map(|rays| (RAYS, "a ray judged in one configuration", of(rays)));
        [(RUNS, "a timed run", of(&self.runs))].into_iter().chain(rays).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::ABOUT_COLUMNS;
    use super::*;
    use crate::tidy::columns::column;

    #[test]
    fn columns_beside_those_of_sections_are_described() {
        let all = [RUN_COLUMNS, RAY_COLUMNS, ABOUT_COLUMNS].concat();
        let unknown: Vec<_> = all.into_iter().filter(|name| column(name).is_none()).collect();
        assert!(unknown.is_empty(), "{unknown:?}");
    }
}
