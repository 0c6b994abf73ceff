//! A gate: checks, row by row, that this build takes at most a given factor longer than another one, and traces the same
//! hits with the same work.
//!
//! Two builds in one run are compared run by run ([`paired`]). An earlier benchmark was measured at another time, so
//! times are judged only if the limit exceeds the drift of the machine ([`drift`]).

pub mod drift;
mod markdown;
pub mod paired;

use serde::Serialize;

use super::SummaryRow;
pub use markdown::{markdown, text};

/// The probability of failing, for all rows together, although no row is slower than the limit; and that of passing
/// although one is.
pub const LEVEL: f64 = 0.05;

/// A gate's answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Every upper bound is within the limit.
    Pass,
    /// A lower bound exceeds the limit, or something changed that must not.
    Fail,
    /// Too noisy to tell.
    Undecided,
}

/// What is known about the ratio of a row's times.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Times {
    /// Median ratio, this build's time divided by the other's: above 1 is slower.
    pub time_ratio: Option<f64>,
    /// Lower bound at the level that decides on failing.
    pub time_ratio_low: Option<f64>,
    /// Upper bound at the level that decides on passing.
    pub time_ratio_high: Option<f64>,
    /// Probability of such times if this build is not slower than the limit, adjusted for the number of rows (Holm).
    pub p_slower: Option<f64>,
    /// Probability of such times if it is.
    pub p_within: Option<f64>,
    /// The answer for this row.
    pub verdict: Verdict,
    /// Repeats that would probably decide, at the level of the last look; `None` if none would, or it is decided.
    pub needed_repeats: Option<u64>,
}

impl Times {
    pub(crate) fn unknown() -> Self {
        Self {
            time_ratio: None,
            time_ratio_low: None,
            time_ratio_high: None,
            p_slower: None,
            p_within: None,
            verdict: Verdict::Undecided,
            needed_repeats: None,
        }
    }
}

/// A row that both have.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GateRow {
    /// The configuration in words.
    pub name: String,
    /// Its id in `summary.csv`.
    pub configuration: String,
    /// Median time of this build.
    pub median_ns: Option<f64>,
    /// Median time of the other.
    pub other_median_ns: Option<f64>,
    /// What changed that must not; empty if nothing did.
    pub changed: Vec<String>,
    /// The times.
    #[serde(flatten)]
    pub times: Times,
}

/// A gate's result, as it is written to `gate.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gate {
    /// [`super::SCHEMA_VERSION`].
    pub schema_version: u32,
    /// As in the other files.
    pub run_id: String,
    /// What this build is compared with.
    pub other: String,
    /// The answer.
    pub verdict: Verdict,
    /// The answer in words.
    pub because: String,
    /// Largest acceptable ratio.
    pub at_most: f64,
    /// [`LEVEL`].
    pub level: f64,
    /// The statistics in a sentence.
    pub method: String,
    /// Counted rounds.
    pub rounds: usize,
    /// Repeats that would probably decide; `None` if none would, or it is decided.
    pub needed_repeats: Option<u64>,
    /// Ratios of times of the same build, where they were seen.
    pub drift: Option<drift::Drift>,
    /// What is wrong with the comparison as a whole: missing rows, other devices.
    pub faults: Vec<String>,
    /// The rows.
    pub rows: Vec<GateRow>,
}

/// Rows of two builds.
#[derive(Debug)]
pub struct Matched<'a> {
    /// This build's row and the other's, by configuration.
    pub pairs: Vec<(&'a SummaryRow, &'a SummaryRow)>,
    /// A line for every row that only one of them has.
    pub missing: Vec<String>,
}

/// Matches rows by configuration; `other` names the other side.
#[must_use]
pub fn matched<'a>(now: &'a [SummaryRow], then: &'a [SummaryRow], other: &str) -> Matched<'a> {
    let mut matched = Matched { pairs: Vec::new(), missing: Vec::new() };
    for row in now {
        match row.in_baseline(then) {
            Some(then) => matched.pairs.push((row, then)),
            None => matched.missing.push(format!("{}: {other} has no such row", row.name())),
        }
    }
    for row in then.iter().filter(|then| !now.iter().any(|row| row.is_same_configuration(then))) {
        matched.missing.push(format!("{}: only {other} has this row", row.name()));
    }
    matched
}

/// What differs between two rows of the same configuration that must not: device, scene, rays, hits and work.
#[must_use]
pub fn changed(now: &SummaryRow, then: &SummaryRow) -> Vec<String> {
    let mut changed = Vec::new();
    if now.adapter != then.adapter {
        changed.push(format!("measured on {}, before on {}", now.adapter, then.adapter));
    }
    if now.clock != then.clock {
        changed.push(format!("timed by {}, before by {}", now.clock, then.clock));
    }
    if now.scene_hash != then.scene_hash {
        changed.push(format!("another scene: {}, before {}", now.scene_hash, then.scene_hash));
    }
    if now.rays != then.rays {
        changed.push(format!("{} rays, before {}", now.rays, then.rays));
    }
    fn known<T: ToString>(count: Option<T>) -> String {
        count.map_or_else(|| "unknown".to_owned(), |count| count.to_string())
    }
    if now.hits_hash != then.hits_hash {
        let [hits, before] = [now.hits, then.hits].map(known);
        changed.push(match now.hits == then.hits {
            true => format!("other hits, of as many rays ({hits})"),
            false => format!("other hits: of {hits} rays, before of {before}"),
        });
    }
    if now.passes != then.passes {
        changed.push(format!("{} passes, before {}", now.passes, then.passes));
    }
    for (name, now, then) in
        [("secondary", now.secondary_rays, then.secondary_rays), ("shadow", now.shadow_rays, then.shadow_rays)]
    {
        if now != then {
            changed.push(format!("{} {name} rays, before {}", known(now), known(then)));
        }
    }
    for (name, now, then) in
        [("tests", now.tests_per_ray, then.tests_per_ray), ("cells", now.cells_per_ray, then.cells_per_ray)]
    {
        if now != then {
            changed.push(format!("{name} a ray {}, before {}", known(now), known(then)));
        }
    }
    changed
}

impl Gate {
    /// The answer for all rows: one that fails is enough to fail, and all must pass.
    #[must_use]
    pub fn concluded(mut self) -> Self {
        let count = |wanted: Verdict| self.rows.iter().filter(|row| row.times.verdict == wanted).count();
        let (slower, within, all) = (count(Verdict::Fail), count(Verdict::Pass), self.rows.len());
        let changed = self.rows.iter().filter(|row| !row.changed.is_empty()).count() + self.faults.len();
        let limit = format!("{} times as slow as {}", self.at_most, self.other);
        (self.verdict, self.because) = if changed > 0 || slower > 0 {
            let slow = format!("{slower} of {} more than {limit}", rows_are(all));
            let differ = format!("{changed} with changed results or without a counterpart");
            let because = [(slower, slow), (changed, differ)].into_iter().filter(|(n, _)| *n > 0).map(|(_, text)| text);
            (Verdict::Fail, because.collect::<Vec<_>>().join(", "))
        } else if within == all && all > 0 {
            (Verdict::Pass, format!("at most {limit} ({})", rows_are(all)))
        } else {
            self.needed_repeats = needed_repeats(self.at_most, self.rows.iter().map(|row| &row.times));
            let how = self.what_would_decide();
            (Verdict::Undecided, format!("too noisy for {} of {}; {how}", all - within, rows_are(all)))
        };
        self
    }

    /// How to get an answer where there is none.
    fn what_would_decide(&self) -> String {
        match (self.needed_repeats, &self.drift) {
            (Some(repeats), _) if repeats > MOST_REPEATS => {
                format!("more than {MOST_REPEATS} repeats would be needed, as the ratio is too near the limit")
            }
            (Some(repeats), _) => format!("--repeats {repeats} would probably decide"),
            (None, Some(drift)) if self.at_most <= drift.seen => "use --against, or a larger --at-most".into(),
            (None, Some(_)) => "more repeats would not decide".into(),
            (None, None) => "no number of repeats would decide, as the ratio is at the limit".into(),
        }
    }

    /// A line for everything that fails, in the order of the rows.
    #[must_use]
    pub fn failures(&self) -> Vec<String> {
        let mut lines = self.faults.clone();
        for row in &self.rows {
            lines.extend(row.changed.iter().map(|what| format!("{}: {what}", row.name)));
            if row.times.verdict == Verdict::Fail {
                let [ratio, low] = [row.times.time_ratio, row.times.time_ratio_low].map(|r| r.unwrap_or(f64::NAN));
                lines.push(format!("{}: {ratio:.3} times as slow, at least {low:.3}", row.name));
            }
        }
        lines
    }
}

/// Most repeats that anyone would wait for; it is also the most that the command line takes.
const MOST_REPEATS: u64 = 100_000;

/// Repeats that would probably decide. One row that fails is enough: if the ratios of some rows lie above the limit, the
/// fewest that one of them needs; otherwise the most that any undecided row needs. `None` if no number would do.
pub(crate) fn needed_repeats<'a>(at_most: f64, rows: impl Iterator<Item = &'a Times>) -> Option<u64> {
    let open: Vec<&Times> = rows.filter(|row| row.verdict == Verdict::Undecided).collect();
    let above = open.iter().filter(|row| row.time_ratio.is_some_and(|ratio| ratio > at_most));
    let fewest = above.filter_map(|row| row.needed_repeats).min();
    fewest.or_else(|| open.iter().map(|row| row.needed_repeats).collect::<Option<Vec<_>>>()?.into_iter().max())
}

fn rows_are(count: usize) -> String {
    crate::text::counted(count, "row")
}

#[cfg(test)]
mod simulation;

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn gate(rows: &[(Verdict, Option<u64>)]) -> Gate {
        let row = |&(verdict, needed_repeats): &(Verdict, Option<u64>)| GateRow {
            name: "box 8x8 primary, grid fused robust".into(),
            configuration: "0".into(),
            median_ns: Some(1.2e6),
            other_median_ns: Some(1e6),
            changed: Vec::new(),
            times: Times {
                time_ratio: Some(1.2),
                time_ratio_low: Some(1.1),
                verdict,
                needed_repeats,
                ..Times::unknown()
            },
        };
        Gate {
            schema_version: super::super::SCHEMA_VERSION,
            run_id: "a".into(),
            other: "old".into(),
            verdict: Verdict::Undecided,
            because: String::new(),
            at_most: 1.05,
            level: LEVEL,
            method: "signs".into(),
            rounds: 40,
            needed_repeats: None,
            drift: None,
            faults: Vec::new(),
            rows: rows.iter().map(row).collect(),
        }
        .concluded()
    }

    #[test]
    fn one_slow_row_fails_and_all_must_pass() {
        use Verdict::{Fail, Pass, Undecided};
        let verdict = |rows: &[(Verdict, Option<u64>)]| gate(rows).verdict;
        assert_eq!(verdict(&[(Pass, None), (Fail, None), (Undecided, Some(9))]), Fail);
        assert_eq!(verdict(&[(Pass, None), (Pass, None)]), Pass);
        assert_eq!(gate(&[(Pass, None)]).because, "at most 1.05 times as slow as old (1 row)");
        assert_eq!(verdict(&[]), Undecided);
        let open = |first, second| gate(&[(Pass, None), (Undecided, first), (Undecided, second)]);
        // Both ratios lie above the limit.
        assert_eq!((open(Some(9), Some(70)).verdict, open(Some(9), Some(70)).needed_repeats), (Undecided, Some(9)));
        assert_eq!((open(Some(9), None).needed_repeats, open(None, None).needed_repeats), (Some(9), None));
        let below = |needed_repeats| Times { time_ratio: Some(1.0), needed_repeats, ..Times::unknown() };
        assert_eq!(needed_repeats(1.05, [below(Some(9)), below(Some(70))].iter()), Some(70));
        assert_eq!(needed_repeats(1.05, [below(Some(9)), below(None)].iter()), None);
        let failed = gate(&[(Pass, None), (Fail, None)]);
        assert_eq!(failed.because, "1 of 2 rows more than 1.05 times as slow as old");
        assert_eq!(failed.failures(), ["box 8x8 primary, grid fused robust: 1.200 times as slow, at least 1.100"]);
        let mut missing = gate(&[(Pass, None)]);
        missing.faults.push("x: old has no such row".into());
        let missing = missing.concluded();
        assert_eq!((missing.verdict, missing.failures().len()), (Fail, 1));
    }

    #[test]
    fn every_change_is_named() {
        let now = SummaryRow {
            adapter: "cpu".into(),
            hits: Some(0),
            hits_hash: "a".into(),
            rays: 9,
            ..SummaryRow::default()
        };
        assert_eq!(changed(&now, &now), Vec::<String>::new());
        let then = SummaryRow {
            adapter: "x".into(),
            clock: "host".into(),
            scene_hash: "s".into(),
            rays: 8,
            hits: Some(3),
            hits_hash: "b".into(),
            passes: 2,
            tests_per_ray: Some(1.5),
            cells_per_ray: Some(0.5),
            shadow_rays: Some(7),
            ..now.clone()
        };
        let all = changed(&now, &then);
        assert_eq!(all.len(), 9, "{all:?}");
        assert_eq!(
            changed(&now, &SummaryRow { hits_hash: "b".into(), ..now.clone() }),
            ["other hits, of as many rays (0)"]
        );
        let other = SummaryRow { schedule: "fused".into(), ..now.clone() };
        let matched = matched(std::slice::from_ref(&now), std::slice::from_ref(&other), "old");
        assert_eq!((matched.pairs.len(), matched.missing.len()), (0, 2), "{matched:?}");
    }
}
