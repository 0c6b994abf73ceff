//! A benchmark whose runs another program orders one by one, so that two builds can be compared run by run.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::measure::{Bench, run_row};
use super::prepare::{Extent, Ready};
use super::runs::RunRow;
use super::{SummaryRow, Wanted, all_groups};
use crate::Error;
use crate::meter::{Ended, Meter};
use crate::reporter::Reporter;
use crate::subject::Subject;

/// Configurations that are ready to run.
pub struct Served<'a> {
    meter: &'a Meter,
    ready: Vec<Ready>,
    /// What was noted while building.
    pub notes: Vec<String>,
}

/// A configuration, as it is announced to the other program. `name` is the configuration in words.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub struct Announced {
    pub name: String,
    pub row: SummaryRow,
}

impl<'a> Served<'a> {
    /// Builds all configurations and runs each once for its hits. If `is_brief`, their work is not counted and their
    /// passes are not timed.
    ///
    /// # Errors
    /// If the device fails, nothing can be built, or not everything fits into memory together.
    pub fn new(
        wanted: &'a Wanted,
        subjects: &[Subject],
        is_brief: bool,
        meter: &'a Meter,
        reporter: &'a dyn Reporter,
    ) -> Result<Self, Error> {
        let extent = if is_brief { Extent::Brief } else { Extent::Full };
        let mut bench = Bench::new(wanted, String::new(), meter, reporter).only_building(extent);
        all_groups(wanted, subjects, &mut bench)?;
        let (ready, notes) = bench.finish_building()?;
        let mut served = Self { meter, ready, notes };
        for place in 0..served.ready.len() {
            served.run(place)?;
            served.ready[place].set_hits(&meter.machine)?;
        }
        Ok(served)
    }

    /// Its configurations, without times.
    #[must_use]
    pub fn announced(&self) -> Vec<Announced> {
        let announce = |ready: &Ready| Announced { name: ready.row.name(), row: ready.row.clone() };
        self.ready.iter().map(announce).collect()
    }

    /// Runs a configuration, given by its place among [`announced`](Self::announced); `None` if there is no such place.
    ///
    /// # Errors
    /// If the device fails.
    pub fn run(&mut self, place: usize) -> Result<Option<RunRow>, Error> {
        let Some(ready) = self.ready.get_mut(place) else { return Ok(None) };
        let fixed_work_ns = self.meter.fixed_work_ns();
        let running = self.meter.run_within(Duration::MAX, &mut ready.renderer);
        match self.meter.machine.wait(running)? {
            Ended::Done(time) => Ok(Some(run_row(&ready.row, 0, 0, 0, time, fixed_work_ns))),
            Ended::GivenUp => Err(Error::GivenUp),
        }
    }
}
