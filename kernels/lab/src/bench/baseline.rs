//! An earlier benchmark to compare with.

use super::gate::{Gate, GateRow, LEVEL, Verdict, changed, drift, matched};
use super::{RunRow, SCHEMA_VERSION, SummaryRow};

/// The results of an earlier benchmark.
pub struct Baseline {
    /// Its folder, for display.
    pub folder: String,
    /// Its summary.
    pub rows: Vec<SummaryRow>,
    /// Its runs.
    pub runs: Vec<RunRow>,
}

impl Baseline {
    /// Fills in the rows' ratios. Returns notes on rows without a ratio, whose ratio is not a fair comparison, or whose
    /// hits have changed.
    pub fn compare(&self, rows: &mut [SummaryRow]) -> Vec<String> {
        let at = &self.folder;
        let mut notes = Vec::new();
        let mut note = |text: String| {
            if !notes.contains(&text) {
                notes.push(text);
            }
        };
        for row in rows.iter_mut() {
            let name = row.name();
            let Some(then) = row.in_baseline(&self.rows) else {
                note(format!("{at} has no match for {name}"));
                continue;
            };
            row.baseline_ratio = row.ratio_to(then);
            if row.baseline_ratio.is_none() {
                note(format!("{at} has no time by the same clock for {name}"));
            }
            if then.adapter != row.adapter {
                note(format!("{at} was measured on {}, and this is {}", then.adapter, row.adapter));
            }
            if then.scene_hash != row.scene_hash {
                note(format!("{} has changed since {at} was measured", row.scene));
            }
            if then.rays != row.rays {
                note(format!("{at} has {} rays for {name}, but now there are {}", then.rays, row.rays));
            } else if row.hits.is_some() && then.scene_hash == row.scene_hash && then.hits_hash != row.hits_hash {
                let [hits, before] = [row.hits, then.hits].map(Option::unwrap_or_default);
                note(format!("{name}: other hits than in {at} ({hits} and {before} rays hit something)"));
            }
        }
        let is_gone = |then: &&SummaryRow| !rows.iter().any(|row| row.is_same_configuration(then));
        for then in self.rows.iter().filter(is_gone) {
            note(format!("{at} also has {}, which was not measured now", then.name()));
        }
        notes
    }

    /// Whether the rows are at most `at_most` times as slow, with the same hits and work.
    #[must_use]
    pub fn gate(&self, run_id: &str, rows: &[SummaryRow], runs: &[RunRow], at_most: f64) -> Gate {
        let matched = matched(rows, &self.rows, &self.folder);
        let now: Vec<Vec<RunRow>> = matched.pairs.iter().map(|(row, _)| of(row, runs)).collect();
        let then: Vec<Vec<RunRow>> = matched.pairs.iter().map(|(_, row)| of(row, &self.runs)).collect();
        let both: Vec<drift::Both<'_>> = now.iter().zip(&then).map(|(a, b)| [a.as_slice(), b.as_slice()]).collect();
        let drift = drift::drift(&both);
        let times = drift::judge(&both, at_most, &drift);
        let row = |((row, then), times): (&(&SummaryRow, &SummaryRow), _)| GateRow {
            name: row.name(),
            configuration: row.configuration.clone(),
            median_ns: row.median_ns,
            other_median_ns: then.median_ns,
            changed: changed(row, then),
            times,
        };
        let rows: Vec<GateRow> = matched.pairs.iter().zip(times).map(row).collect();
        Gate {
            schema_version: SCHEMA_VERSION,
            run_id: run_id.to_owned(),
            other: self.folder.clone(),
            verdict: Verdict::Undecided,
            because: String::new(),
            at_most,
            level: LEVEL,
            method: "Two independent medians by order statistics, all rows together at a level of 5% (Bonferroni), \
                     widened by the drift."
                .into(),
            rounds: now.iter().map(Vec::len).max().unwrap_or(0),
            needed_repeats: None,
            drift: Some(drift),
            faults: matched.missing,
            rows,
        }
        .concluded()
    }
}

/// The runs of a row.
fn of(row: &SummaryRow, runs: &[RunRow]) -> Vec<RunRow> {
    runs.iter().filter(|run| run.configuration == row.configuration && run.run_id == row.run_id).cloned().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(ids: &[&str], ns: u64) -> (Vec<SummaryRow>, Vec<RunRow>) {
        let row = |id: &&str| SummaryRow {
            configuration: (*id).into(),
            accelerator: (*id).into(),
            median_ns: Some(ns as f64),
            hits: Some(1),
            hits_hash: "x".into(),
            ..SummaryRow::default()
        };
        let run = |id: &&str, round| RunRow {
            configuration: (*id).into(),
            round,
            time_ns: Some(ns),
            fixed_work_ns: 5,
            ..RunRow::default()
        };
        let runs = ids.iter().flat_map(|id| (0..12).map(move |round| run(id, round)));
        (ids.iter().map(row).collect(), runs.collect())
    }

    #[test]
    fn a_baseline_is_passed_or_names_what_fails() {
        let (then, runs_then) = rows(&["a", "b"], 1000);
        let baseline = Baseline { folder: "before".into(), rows: then, runs: runs_then };
        let gate = |ids: &[&str], ns| {
            let (rows, runs) = rows(ids, ns);
            baseline.gate("id", &rows, &runs, 1.05)
        };
        assert_eq!(gate(&["a", "b"], 1049).verdict, Verdict::Pass);
        let slow = gate(&["a", "b"], 1100);
        assert_eq!((slow.verdict, slow.failures().len()), (Verdict::Fail, 2), "{slow:?}");
        let missing = gate(&["b", "c"], 1000);
        assert_eq!((missing.verdict, missing.failures().len()), (Verdict::Fail, 2), "{missing:?}");
        let (mut changed, runs) = rows(&["a", "b"], 1000);
        changed[1].hits_hash = "y".into();
        let gate = baseline.gate("id", &changed, &runs, 1.05);
        assert_eq!((gate.verdict, gate.failures()[0].contains(", b ")), (Verdict::Fail, true), "{gate:?}");
        let notes = baseline.compare(&mut changed);
        assert!(notes.len() == 1 && notes[0].contains("other hits than in before"), "{notes:?}");
    }
}
