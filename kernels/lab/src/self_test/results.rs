//! All findings, as one row a check.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{Check, Finding, Group, Outcome, Step, Verdict, checks};

/// What is known of a step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Done {
    group: Group,
    name: String,
    #[serde(skip)]
    checks: Vec<&'static str>,
    /// How long it took; `null` if it was not run.
    seconds: Option<f64>,
    /// Why it was not run.
    not_run: Option<String>,
}

/// The table, as it grows.
#[derive(Clone, Debug)]
pub struct Results {
    checks: Vec<Check>,
    steps: Vec<Done>,
    findings: Vec<Finding>,
    files: BTreeMap<String, String>,
}

/// A row of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The part of the table.
    pub group: Group,
    /// The check's name.
    pub name: &'static str,
    /// What it shows.
    pub shows: &'static str,
    /// What was found.
    pub verdict: Verdict,
    /// The same in words.
    pub says: String,
    /// How much was looked at.
    pub counts: BTreeMap<String, u64>,
    /// Everything that is wrong or differs.
    pub details: Vec<String>,
    /// Time of the steps that are only for this check; `null` if they are for others, too.
    pub seconds: Option<f64>,
}

/// Numbers of checks by verdict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Totals {
    /// All.
    pub checks: usize,
    /// As they must be.
    pub right: usize,
    /// Not as they must be.
    pub wrong: usize,
    /// Properties of the driver.
    pub information: usize,
    /// Without anything to check.
    pub not_applicable: usize,
    /// Not, or not completely, run.
    pub not_run: usize,
}

impl Results {
    /// Nothing is known yet.
    #[must_use]
    pub fn new(steps: &[Step]) -> Self {
        let waiting = |step: &Step| Done {
            group: step.group,
            name: step.name.clone(),
            checks: step.checks.clone(),
            seconds: None,
            not_run: None,
        };
        let (checks, steps) = (checks(), steps.iter().map(waiting).collect());
        Self { checks, steps, findings: Vec::new(), files: BTreeMap::new() }
    }

    /// Adds what a step has found.
    pub fn add(&mut self, step: usize, outcome: Outcome) {
        if let Some(step) = self.steps.get_mut(step) {
            step.seconds = Some(outcome.seconds);
        }
        self.findings.extend(outcome.findings);
        for (name, part) in outcome.files {
            match self.files.get_mut(&name) {
                // Its first line is there already.
                Some(file) => file.extend(part.split_inclusive('\n').skip(1)),
                None => _ = self.files.insert(name, part),
            }
        }
    }

    /// Says why a step was not run.
    pub fn skip(&mut self, step: usize, why: &str) {
        if let Some(step) = self.steps.get_mut(step) {
            step.not_run = Some(why.to_owned());
        }
    }

    /// Adds a finding that no step made.
    pub fn note(&mut self, group: Group, check: &str, verdict: Verdict, says: String) {
        let details = if verdict == Verdict::Wrong { vec![says.clone()] } else { Vec::new() };
        self.findings.push(Finding { details, ..Finding::new(group, check, verdict, says) });
    }

    /// Steps and their times.
    #[must_use]
    pub fn steps(&self) -> &[Done] {
        &self.steps
    }

    /// CSV files by name.
    #[must_use]
    pub fn files(&self) -> &BTreeMap<String, String> {
        &self.files
    }

    /// Mean time of the steps of a group that were run; `None` if there are none.
    #[must_use]
    pub fn usual_seconds(&self, group: Group) -> Option<f64> {
        let all: Vec<f64> =
            self.steps.iter().filter(|step| step.group == group).filter_map(|step| step.seconds).collect();
        (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64)
    }

    /// Time of a group's steps.
    #[must_use]
    pub fn seconds(&self, group: Group) -> f64 {
        // A sum of nothing would be -0.
        self.steps.iter().filter(|step| step.group == group).filter_map(|step| step.seconds).fold(0.0, |a, b| a + b)
    }

    /// Every check with what is known of it.
    #[must_use]
    pub fn rows(&self) -> Vec<Row> {
        self.checks.iter().map(|check| self.row(check)).collect()
    }

    fn row(&self, check: &Check) -> Row {
        let needed = || self.steps.iter().filter(|step| step.group == check.group && step.checks.contains(&check.name));
        let found: Vec<&Finding> =
            self.findings.iter().filter(|f| f.group == check.group && f.check == check.name).collect();
        let mut counts: BTreeMap<String, u64> = BTreeMap::new();
        for (name, count) in found.iter().flat_map(|finding| &finding.counts) {
            *counts.entry(name.clone()).or_default() += count;
        }
        let worst = found.iter().map(|finding| finding.verdict).max();
        let said =
            found.iter().filter(|finding| Some(finding.verdict) == worst).find(|finding| !finding.says.is_empty());
        let mut says = said.map(|finding| finding.says.clone()).unwrap_or_default();
        let mut verdict = worst.unwrap_or(Verdict::NotRun);
        let missing: Vec<&Done> = needed().filter(|step| step.seconds.is_none()).collect();
        if let Some(first) = missing.first().filter(|_| verdict != Verdict::Wrong) {
            let why = first.not_run.as_deref().unwrap_or("not begun");
            verdict = Verdict::NotRun;
            says = match needed().count() {
                1 => why.to_owned(),
                all => format!("{} of {all} runs are left out: {why}", missing.len()),
            };
        } else if found.is_empty() {
            says = self.why_not_reached(check.group);
        }
        let is_alone = needed().all(|step| step.checks.len() == 1) && needed().next().is_some();
        Row {
            group: check.group,
            name: check.name,
            shows: check.shows,
            verdict,
            says,
            counts,
            details: found.iter().flat_map(|finding| &finding.details).cloned().collect(),
            seconds: is_alone.then(|| needed().filter_map(|step| step.seconds).sum()),
        }
    }

    /// Why a check that needs no step in particular has no finding.
    fn why_not_reached(&self, group: Group) -> String {
        let left_out = self.steps.iter().filter(|step| step.group == group).find_map(|step| step.not_run.as_deref());
        left_out.unwrap_or("no run that ended has reached it").to_owned()
    }

    /// Checks by verdict.
    #[must_use]
    pub fn totals(&self) -> Totals {
        let rows = self.rows();
        let of = |verdict| rows.iter().filter(|row| row.verdict == verdict).count();
        Totals {
            checks: rows.len(),
            right: of(Verdict::Right),
            wrong: of(Verdict::Wrong),
            information: of(Verdict::Information),
            not_applicable: of(Verdict::NotApplicable),
            not_run: of(Verdict::NotRun),
        }
    }
}
