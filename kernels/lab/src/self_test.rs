//! Whether raystep works on a GPU: every kernel against its CPU reference, and what the kernels rely on, in a minute.
//!
//! [`checks`] are the rows of the resulting table; [`steps`] are what is run for them, the most important first. A step
//! may serve several checks (a run of a program compares many kernels), and a check may need several steps.
//! [`Step::run`] never fails: an error in a step is a [`Finding`]. [`Results`] makes the table of all findings, which
//! also says what was not run.
//!
//! | module | contents |
//! |---|---|
//! | `adapter` | limits, loops, clock, timestamps |
//! | `arithmetic`, `operations`, `probe` | operations of WGSL, judged against exact values |
//! | `shader` | a compute shader that runs once |
//! | `storage` | bits on their way through textures and buffers |
//! | `passes` | every kernel of every program against its CPU reference |
//! | `hits` | structures and schedules against each other and against f64 brute force |
//! | `extremes` | the cases of [`stability`](crate::stability), and pipelines compiled from one source |
//! | `results`, `table` | all findings as rows, and as text |
//!
//! Nothing here writes a file or ends a driver that hangs: a caller that wants to go on runs the steps in a process of
//! its own.

mod adapter;
mod arithmetic;
mod extremes;
mod hits;
mod operations;
mod passes;
pub mod probe;
mod results;
mod shader;
mod storage;
mod table;

use std::sync::Arc;

use raystep_kernels::{Device, Gpu, Plan, named};
use serde::{Deserialize, Serialize};
use web_time::Instant;

use crate::stability::probe::{Bits, Comparison};
use crate::{Error, Machine};
pub use results::{Done, Results, Row, Totals};
pub use table::{details, text};

/// What a check is about; the parts of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Group {
    /// The adapter and its driver.
    Adapter,
    /// Operations of WGSL.
    Arithmetic,
    /// Kernels of `closest-hit` as compute shaders.
    Tracing,
    /// Hits of all structures and schedules.
    Hits,
    /// Kernels of `grid-build`.
    Building,
    /// Extreme cases.
    Extremes,
    /// Kernels of `closest-hit` as fragment programs.
    Drawing,
    /// Pipelines compiled from one source.
    Pipelines,
}

named!(
    Group,
    Adapter "The adapter",
    Arithmetic "Arithmetic",
    Tracing "Kernels that trace rays, against their CPU references",
    Hits "Hits of all structures and schedules",
    Building "Kernels that build grids, against their CPU references",
    Extremes "Extreme cases, against f64 brute force",
    Drawing "Kernels as fragment programs, against their CPU references",
    Pipelines "Pipelines compiled from one source"
);

/// What is known of a check. The later of two outweighs the earlier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The adapter has nothing to check.
    NotApplicable,
    /// A property of the driver, with which raystep works.
    Information,
    /// As it must be.
    Right,
    /// Not, or not completely, checked.
    NotRun,
    /// Not as it must be.
    Wrong,
}

named!(Verdict, NotApplicable "n/a", Information "info", Right "right", NotRun "not run", Wrong "WRONG");

/// Something that is right, wrong or a property of an adapter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Check {
    /// The part of the table.
    pub group: Group,
    /// Its name: that of a kernel where it is about one.
    pub name: &'static str,
    /// What it shows, in one sentence.
    pub shows: &'static str,
}

/// What a step has found out about a check.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finding {
    /// The check's part of the table.
    pub group: Group,
    /// The check's name.
    pub check: String,
    /// What was found.
    pub verdict: Verdict,
    /// The same in words; empty if the counts say all.
    pub says: String,
    /// How much was looked at: names and numbers, which add up over steps.
    pub counts: Vec<(String, u64)>,
    /// Everything that is wrong or differs, a line each.
    pub details: Vec<String>,
}

impl Finding {
    /// A finding without counts.
    fn new(group: Group, check: &str, verdict: Verdict, says: impl Into<String>) -> Self {
        let (check, says) = (check.to_owned(), says.into());
        Self { group, check, verdict, says, counts: Vec::new(), details: Vec::new() }
    }

    fn counting(mut self, counts: &[(&str, u64)]) -> Self {
        self.counts = counts.iter().map(|&(name, count)| (name.to_owned(), count)).collect();
        self
    }

    /// The same, wrong if there are details, of which the first is said.
    fn wrong_by(mut self, details: Vec<String>) -> Self {
        if let Some(first) = details.first() {
            self.verdict = Verdict::Wrong;
            self.says.clone_from(first);
        }
        self.details = details;
        self
    }
}

/// A file that a step has written a part of; the parts of later steps have the same first line.
pub type File = (String, String);

/// What a step has found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// About checks.
    pub findings: Vec<Finding>,
    /// Parts of CSV files.
    pub files: Vec<File>,
    /// How long it took.
    pub seconds: f64,
    /// Whether the device does not work any more: what follows needs another.
    pub is_device_lost: bool,
}

impl Outcome {
    /// What is known of a step that did not come to its end: its first check is wrong.
    #[must_use]
    pub fn failed(step: &Step, why: &str, seconds: f64) -> Self {
        let findings = vec![step.failure(why)];
        Self { findings, seconds, is_device_lost: true, ..Self::default() }
    }
}

type Found = Result<(Vec<Finding>, Vec<File>), Error>;
type Run = Box<dyn Fn(&mut Bench) -> Found + Send + Sync>;

/// Something that is done on the device.
pub struct Step {
    /// Part of the table that it is for.
    pub group: Group,
    /// What is done.
    pub name: String,
    /// The checks of its group that are not complete without it. A failure of the step itself is one of the first.
    pub checks: Vec<&'static str>,
    run: Run,
}

impl Step {
    fn new(
        group: Group,
        name: impl Into<String>,
        checks: &[&'static str],
        run: impl Fn(&mut Bench) -> Found + Send + Sync + 'static,
    ) -> Self {
        Self { group, name: name.into(), checks: checks.to_vec(), run: Box::new(run) }
    }

    /// That it failed, as a finding.
    fn failure(&self, why: &str) -> Finding {
        let says = format!("{}: {why}", self.name);
        Finding::new(self.group, self.checks.first().copied().unwrap_or_default(), Verdict::Wrong, "")
            .wrong_by(vec![says])
    }

    /// Does it. Blocks while it waits for the device.
    pub fn run(&self, bench: &mut Bench) -> Outcome {
        let begin = Instant::now();
        let (mut findings, files) = (self.run)(bench).unwrap_or_else(|error| {
            let why = error.to_string();
            (vec![self.failure(&why)], Vec::new())
        });
        let health = bench.gpu.health();
        if let Err(error) = &health {
            let says = format!("after {}: {error}", self.name);
            findings.push(Finding::new(Group::Adapter, adapter::STAYS, Verdict::Wrong, "").wrong_by(vec![says]));
        }
        Outcome { findings, files, seconds: begin.elapsed().as_secs_f64(), is_device_lost: health.is_err() }
    }
}

/// Changes of what runs, for tests: a self-test that cannot fail shows nothing.
#[derive(Clone)]
pub struct Faults {
    /// Of the plan of every comparison of kernels.
    pub plan: Arc<dyn Fn(&mut Plan) + Send + Sync>,
    /// Of the WGSL that computes the operations.
    pub operations: Arc<dyn Fn(String) -> String + Send + Sync>,
}

impl Default for Faults {
    fn default() -> Self {
        Self { plan: Arc::new(|_| {}), operations: Arc::new(|source| source) }
    }
}

/// A device under test, and what steps share.
pub struct Bench {
    gpu: Arc<Gpu>,
    machine: Machine,
    run_id: String,
    faults: Faults,
    pipelines: Option<Comparison>,
    /// The hits that all others of a scene must have.
    hits: Vec<Option<Bits>>,
}

impl Bench {
    /// Tests this device; the run's id is for files.
    #[must_use]
    pub fn new(gpu: Arc<Gpu>, run_id: String, faults: Faults) -> Self {
        let machine = Machine { device: Device::Gpu(gpu.clone()), reason: "self-test".into() };
        Self { gpu, machine, run_id, faults, pipelines: None, hits: Vec::new() }
    }
}

/// Every check, in the order of the table.
#[must_use]
pub fn checks() -> Vec<Check> {
    [
        adapter::checks(),
        arithmetic::checks(),
        passes::checks_of_tracing(),
        hits::checks(),
        passes::checks_of_building(),
        extremes::checks_of_cases(),
        passes::checks_of_drawing(),
        extremes::checks_of_pipelines(),
    ]
    .concat()
}

/// Every step, in order.
#[must_use]
pub fn steps() -> Vec<Step> {
    let mut all = adapter::steps();
    all.extend(arithmetic::steps());
    all.extend(passes::tracing());
    all.extend(hits::steps());
    all.extend(passes::building());
    all.extend(extremes::cases());
    all.extend(passes::drawing());
    all.extend(extremes::pipelines());
    all
}

/// The check of [`Group::Adapter`] that is wrong if no device can be opened.
pub const LIMITS: &str = adapter::LIMITS;

/// The check of [`Group::Adapter`] that is wrong if a device is lost, or cannot be opened again.
pub const STAYS: &str = adapter::STAYS;

#[cfg(test)]
mod tests;
