//! Builds configurations and times them in interleaved runs.

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use raystep_kernels::{RaySource, RenderError};

use super::prepare::{Builder, Extent, Group, Ready, options};
use super::runs::{RunRow, pairs};
use super::{Measured, SCHEMA_VERSION, SummaryRow, Wanted, in_words};
use crate::configuration::Configuration;
use crate::meter::{Ended, Meter, Time, Turns, in_turn};
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
        let base = options(self.wanted, configurations, rays, group.ends_early);
        let mut of_group = Vec::new();
        for configuration in configurations {
            let what = format!("{}, {}", group.name, in_words(configuration));
            let (reporter, mut notes) = (self.reporter, Vec::new());
            let builder = Builder { wanted: self.wanted, meter: self.meter, extent: self.extent };
            let ids = [self.measured.run_id.clone(), self.configurations.to_string()];
            let stage = |name: &str| reporter.stage(&format!("{what}: {name}"));
            let built = match self.time_left() {
                Some(Duration::ZERO) => Err(Error::TimeOver),
                _ => builder.build(ids, &group, configuration, &base, stage, |note| notes.push(note.to_owned())),
            };
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

    /// The time until everything is to end; `None` without a limit.
    fn time_left(&self) -> Option<Duration> {
        self.wanted.until.map(|until| until.saturating_duration_since(Instant::now()))
    }

    /// Times everything that is built, interleaved, and drops it.
    fn measure(&mut self) -> Result<(), Error> {
        let mut batch: Vec<(Ready, Vec<u64>)> =
            std::mem::take(&mut self.batch).into_iter().map(|ready| (ready, Vec::new())).collect();
        let longest = self.wanted.longest_run;
        let limits = [self.wanted.turns.all, self.time_left()];
        let turns = Turns { all: limits.into_iter().flatten().min(), ..self.wanted.turns };
        let most = turns.warmups + turns.repeats;
        let (mut done, mut of) = (0, (most * batch.len()) as u64);
        let times = in_turn(&mut batch, turns, |(ready, fixed_work)| {
            self.reporter.part("measuring", done, of);
            done += 1;
            fixed_work.push(self.meter.fixed_work_ns());
            let ended = self.machine().wait(self.meter.run_within(longest, &mut ready.renderer))?;
            if ended == Ended::GivenUp {
                // It runs no more.
                of -= most.saturating_sub(fixed_work.len()) as u64;
            }
            Ok::<_, RenderError>(ended)
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
            if times.is_given_up {
                let runs = runs.len();
                self.note(format!("{}: stopped after {runs} timed runs: too slow, or endless", ready.row.name()));
            } else {
                ready.set_hits(self.machine())?;
            }
            self.check(&ready.row);
            groups.push(ready.group);
            self.measured.details.push(ready.details);
            self.measured.rows.push(ready.row);
            self.measured.runs.extend(runs);
        }
        set_ratios(&mut self.measured.rows[first..], &groups, &self.measured.runs, self.wanted.seed);
        Ok(())
    }

    /// Notes what is odd about a measured row: invalid times, or other hits than those of the same rays by the same
    /// rules. The paper's may miss what robust ones hit, and a run that was stopped has no hits.
    fn check(&mut self, row: &SummaryRow) {
        let name = row.name();
        if row.invalid_runs > 0 {
            let (invalid, runs) = (row.invalid_runs, row.runs + row.invalid_runs);
            self.note(format!("{name}: {invalid} of {runs} times were invalid and do not count"));
        }
        fn rays_of(r: &SummaryRow) -> ([&str; 4], Option<Size>) {
            ([&r.scene_hash, &r.rays_kind, &r.numerics, &r.integrator], r.size())
        }
        let is_comparable = |other: &&SummaryRow| rays_of(other) == rays_of(row) && other.hits.is_some();
        let other = self.measured.rows.iter().find(is_comparable);
        if let Some((hits, other)) = row.hits.zip(other).filter(|(_, other)| other.hits_hash != row.hits_hash) {
            let (others, other) = (other.hits.unwrap_or_default(), other.name());
            self.note(format!("{name} and {other} have different hits ({hits} and {others} rays hit something)"));
        }
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
