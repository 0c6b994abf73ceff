//! Groups of rays from a file, which are judged separately.

use std::collections::BTreeSet;

use super::{COLUMNS, Measured};
use crate::report::judge::Judge;
use crate::report::work::{Work, id};
use crate::tidy::Row;
use crate::tidy::fill::{Drawn, verdicts};

/// The name of all strata together.
pub(super) const ALL: &str = "all";

/// Groups of rays.
pub(super) struct Strata<'a> {
    /// The group of each ray.
    of_rays: Option<&'a [u32]>,
    /// The groups that there are, ascending, with their names.
    names: Vec<(u32, String)>,
}

impl<'a> Strata<'a> {
    pub(super) fn new(work: &Work<'a>) -> Self {
        let of_rays = work.rays.and_then(|file| file.strata.as_deref());
        let numbers: BTreeSet<u32> = of_rays.into_iter().flatten().copied().collect();
        // As many as a page can show; single rays are in rays.csv.
        let names = numbers.into_iter().take(MOST_STRATA).map(|n| (n, n.to_string())).collect();
        Self { of_rays, names }
    }

    fn number(&self, ray: usize) -> Option<u32> {
        self.of_rays?.get(ray).copied()
    }

    pub(super) fn of(&self, ray: usize) -> &str {
        let name = |number| self.names.iter().find(|(n, _)| *n == number).map(|(_, name)| name.as_str());
        self.number(ray).and_then(name).unwrap_or("view")
    }

    /// One row for each group: verdicts only.
    pub(super) fn rows(&self, work: &Work<'_>, judge: &Judge, m: &Measured) -> Vec<Row> {
        let row = |(number, name): &(u32, String)| {
            let counts = m.judged.counts_of(judge, |ray| self.number(ray) == Some(*number));
            let rays = self.of_rays.map(|all| all.iter().filter(|n| *n == number).count());
            let row = work
                .row(COLUMNS)
                .set("configuration", id(work, &m.configuration))
                .configured(&m.configuration)
                .set("stratum", &**name)
                .set("rays", rays);
            verdicts(row, &counts, Drawn::AtRandom)
        };
        self.names.iter().map(row).collect()
    }
}

/// Most strata with rows of their own.
const MOST_STRATA: usize = 64;
