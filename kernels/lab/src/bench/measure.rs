//! Builds configurations and times them in interleaved runs.

use std::collections::BTreeMap;

use raystep_kernels::RaySource;

use super::prepare::{Builder, Extent, Group, Ready, options};
use super::runs::{RunRow, pairs};
use super::{Measured, SCHEMA_VERSION, SummaryRow, Wanted, in_words};
use crate::configuration::Configuration;
use crate::meter::{Meter, Time, in_turn};
use crate::reporter::Reporter;
use crate::subject::Size;
use crate::{Error, Machine};

/// Maximum size of the configurations that are measured together, chosen to fit on most devices. A larger configuration
/// is measured alone.
const BATCH_BYTES: u64 = 2 << 30;

/// A benchmark in progress.
pub(super) struct Bench<'a> {
    wanted: &'a Wanted,
    meter: &'a Meter,
    reporter: &'a dyn Reporter,
    extent: Extent,
    /// Whether all configurations stay built, and are not timed here.
    keeps_all: bool,
    batch: Vec<Ready>,
    configurations: usize,
    first_failure: Option<Error>,
    measured: Measured,
}

impl<'a> Bench<'a> {
    pub(super) fn new(wanted: &'a Wanted, run_id: String, meter: &'a Meter, reporter: &'a dyn Reporter) -> Self {
        let measured = Measured { run_id, rows: Vec::new(), runs: Vec::new(), details: Vec::new(), notes: Vec::new() };
        let (extent, keeps_all) = (Extent::Full, false);
        Self {
            wanted,
            meter,
            reporter,
            extent,
            keeps_all,
            batch: Vec::new(),
            configurations: 0,
            first_failure: None,
            measured,
        }
    }

    /// One that only builds, and keeps everything that it has built.
    pub(super) fn only_building(self, extent: Extent) -> Self {
        Self { extent, keeps_all: true, ..self }
    }

    pub(super) fn machine(&self) -> &'a Machine {
        &self.meter.machine
    }

    pub(super) fn stage(&self, name: &str) {
        self.reporter.stage(name);
    }

    /// Adds a note.
    pub(super) fn note(&mut self, text: impl Into<String>) {
        let text = text.into();
        // A note that applies to every configuration appears once.
        if !self.measured.notes.contains(&text) {
            self.reporter.note(&text);
            self.measured.notes.push(text);
        }
    }

    /// Notes that something is not measured.
    pub(super) fn skip(&mut self, text: String) {
        self.note(format!("omitted: {text}"));
    }

    /// Notes an error. The rest can still be measured, unless the device itself has failed.
    pub(super) fn failed(&mut self, what: &str, error: Error) -> Result<(), Error> {
        self.machine().health()?;
        self.skip(format!("{what}: {}", self.reporter.explain(&error)));
        self.first_failure.get_or_insert(error);
        Ok(())
    }

    /// Builds every configuration of a group. Measures what is built so far when memory is full.
    pub(super) fn group(
        &mut self,
        group: Group<'_>,
        rays: RaySource,
        configurations: &[Configuration],
    ) -> Result<(), Error> {
        let mut options = options(self.wanted, configurations, rays, group.ends_early);
        let mut of_group = Vec::new();
        for configuration in configurations {
            let what = format!("{}, {}", group.name, in_words(configuration));
            configuration.apply(&mut options);
            let (reporter, mut notes) = (self.reporter, Vec::new());
            let builder = Builder { wanted: self.wanted, meter: self.meter, extent: self.extent };
            let ids = [self.measured.run_id.clone(), self.configurations.to_string()];
            let stage = |name: &str| reporter.stage(&format!("{what}: {name}"));
            let built = builder.build(ids, &group, &mut options, stage, |note| notes.push(note.to_owned()));
            notes.into_iter().for_each(|note| self.note(note));
            match built {
                Ok(ready) => of_group.push(ready),
                Err(error) => self.failed(&what, error)?,
            }
            self.configurations += 1;
            // Keep the group together if it fits; split it only if it is too large by itself.
            let (before, now) = (bytes(&self.batch), bytes(&of_group));
            if self.keeps_all {
                if before + now > BATCH_BYTES && self.batch.len() + of_group.len() > 1 {
                    return Err(Error::TooLargeTogether { most: BATCH_BYTES });
                }
                continue;
            }
            if before + now > BATCH_BYTES && !self.batch.is_empty() {
                self.measure()?;
            }
            if now > BATCH_BYTES && configurations.len() > 1 {
                self.note(format!(
                    "{}: its configurations do not fit together, so not all of them are interleaved",
                    group.name
                ));
                self.batch.append(&mut of_group);
                self.measure()?;
            }
        }
        self.batch.append(&mut of_group);
        Ok(())
    }

    /// Times everything that is built, interleaved, and drops it.
    fn measure(&mut self) -> Result<(), Error> {
        let mut batch: Vec<(Ready, Vec<u64>)> =
            std::mem::take(&mut self.batch).into_iter().map(|ready| (ready, Vec::new())).collect();
        let (turns, longest) = (self.wanted.turns, self.wanted.longest_run);
        let of = ((turns.warmups + turns.repeats) * batch.len()) as u64;
        let mut done = 0;
        let times = in_turn(&mut batch, turns, |(ready, fixed_work)| {
            self.reporter.part("measuring", done, of);
            done += 1;
            fixed_work.push(self.meter.fixed_work_ns());
            self.machine().wait(self.meter.run_within(longest, &mut ready.renderer))
        })?;
        let first = self.measured.rows.len();
        let mut groups = Vec::new();
        for ((mut ready, fixed_work), times) in batch.into_iter().zip(times) {
            let fixed_work = fixed_work.into_iter().skip(turns.warmups);
            let row = |(run, fixed_work_ns): (&crate::meter::Run, u64)| {
                run_row(&ready.row, 0, run.round, run.place, run.time, fixed_work_ns)
            };
            let runs: Vec<RunRow> = times.runs.iter().zip(fixed_work).map(row).collect();
            ready.row.set_times(&runs, u64::from(self.wanted.seed));
            ready.set_hits(self.machine())?;
            groups.push(ready.group.clone());
            self.finish_one(ready);
            self.measured.runs.extend(runs);
        }
        set_ratios(&mut self.measured.rows[first..], &groups, &self.measured.runs, self.wanted.seed);
        Ok(())
    }

    /// Adds the row of a measured configuration, and compares its hits with its group's.
    fn finish_one(&mut self, ready: Ready) {
        let Ready { group, row, details, .. } = ready;
        let name = |row: &SummaryRow| format!("{} {} {} {}", row.accelerator, row.schedule, row.mapping, row.traversal);
        if row.invalid_runs > 0 {
            let (invalid, repeats) = (row.invalid_runs, self.wanted.turns.repeats);
            self.note(format!("{group}, {}: {invalid} of {repeats} times were invalid and do not count", name(&row)));
        }
        fn rays_of(r: &SummaryRow) -> (&str, &str, Option<Size>) {
            (&r.scene_hash, &r.rays_kind, r.size())
        }
        let same_rays = |other: &&SummaryRow| rays_of(other) == rays_of(&row);
        let other = self.measured.rows.iter().find(same_rays).filter(|r| r.hits_hash != row.hits_hash);
        if let Some(other) = other {
            let (one, two, hits, others) = (name(&row), name(other), row.hits, other.hits);
            self.note(format!("{group}: {one} and {two} have different hits ({hits} and {others} rays hit something)"));
        }
        self.measured.details.push(details);
        self.measured.rows.push(row);
    }

    /// Measures what remains.
    pub(super) fn finish(mut self) -> Result<Measured, Error> {
        self.measure()?;
        match self.first_failure {
            Some(error) if self.measured.rows.is_empty() => Err(error),
            _ if self.measured.rows.is_empty() => Err(Error::NoRays),
            _ => Ok(self.measured),
        }
    }

    /// Everything that was built, with the notes.
    pub(super) fn finish_building(self) -> Result<(Vec<Ready>, Vec<String>), Error> {
        match self.first_failure {
            Some(error) if self.batch.is_empty() => Err(error),
            _ if self.batch.is_empty() => Err(Error::NoRays),
            _ => Ok((self.batch, self.measured.notes)),
        }
    }
}

/// The row of a timed run.
pub(super) fn run_row(
    of: &SummaryRow,
    sitting: usize,
    round: usize,
    place: usize,
    time: Time,
    fixed_work_ns: u64,
) -> RunRow {
    let (run_id, configuration, clock) = (of.run_id.clone(), of.configuration.clone(), of.clock.clone());
    let row = RunRow {
        schema_version: SCHEMA_VERSION,
        run_id,
        configuration,
        sitting,
        round,
        place,
        clock,
        fixed_work_ns,
        ..RunRow::default()
    };
    row.timed(time)
}

/// Fills in the ratios to the fastest of each group. Only rows that were measured in the same rounds have any.
fn set_ratios(rows: &mut [SummaryRow], groups: &[String], runs: &[RunRow], seed: u32) {
    let of: BTreeMap<&str, &[RunRow]> = runs
        .chunk_by(|a, b| a.configuration == b.configuration)
        .map(|runs| (runs[0].configuration.as_str(), runs))
        .collect();
    let of = |row: &SummaryRow| of.get(row.configuration.as_str()).copied().unwrap_or_default();
    for place in 0..rows.len() {
        let same = (0..rows.len()).filter(|&other| groups[other] == groups[place]);
        let time = |row: usize| rows[row].median_ns.unwrap_or(f64::MAX);
        let Some(fastest) = same.min_by(|&a, &b| time(a).total_cmp(&time(b))) else { continue };
        let to = rows[fastest].configuration.clone();
        let pairs = pairs(of(&rows[place]), of(&rows[fastest]));
        rows[place].set_ratio(&to, &pairs, u64::from(seed));
    }
}

fn bytes(batch: &[Ready]) -> u64 {
    batch.iter().map(|ready| ready.bytes).sum()
}
