//! Breakpoints: lines of files, some with a condition.

use std::collections::BTreeSet;

use raystep_kernels::shader::{FileLine, Stop};
use serde_json::{Value, json};

use super::reply::{text, whole};
use super::target::Target;

/// Most breakpoints of a kernel.
const MOST: usize = 200;

/// A breakpoint that can be hit.
#[derive(Clone, Debug)]
struct Breakpoint {
    file: usize,
    stop: Stop,
}

/// All breakpoints.
#[derive(Debug, Default)]
pub(super) struct Breakpoints(Vec<Breakpoint>);

impl Breakpoints {
    /// Replaces those of a file. Returns what became of each.
    pub(super) fn set(&mut self, target: &Target, arguments: &Value) -> Vec<Value> {
        let wanted = arguments.get("breakpoints").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
        let file = arguments.get("source").and_then(|source| target.file(source));
        let Some(file) = file else {
            let kernel = target.of.variant.kernel.name();
            let message = format!("{kernel} has nothing from this file");
            return wanted.iter().map(|_| json!({ "verified": false, "message": message })).collect();
        };
        self.0.retain(|other| other.file != file);
        let lines = target.of.statement_lines(file);
        wanted.iter().map(|one| self.add(target, file, &lines, one)).collect()
    }

    fn add(&mut self, target: &Target, file: usize, lines: &[usize], one: &Value) -> Value {
        let refused = |message: String| json!({ "verified": false, "message": message });
        let line = whole(one, "line").unwrap_or(0);
        let Some(&line) = lines.iter().find(|&&own| own >= line) else {
            return refused("no statement of the kernel is here or below".into());
        };
        let Some(statement) = target.of.statement(FileLine { file, line }) else {
            return refused("no statement of the kernel begins here".into());
        };
        if self.0.len() >= MOST {
            return refused(format!("more than {MOST} breakpoints"));
        }
        let when = text(one, "condition").filter(|condition| !condition.trim().is_empty()).map(str::to_owned);
        let stop = Stop { statement, when };
        if stop.when.is_some()
            && let Some(fault) = target.fault(&stop)
        {
            return refused(format!("column {}: {}", fault.column, fault.message));
        }
        self.0.push(Breakpoint { file, stop });
        json!({ "verified": true, "line": line, "id": self.0.len() })
    }

    /// The statements that stop always.
    pub(super) fn always(&self) -> BTreeSet<u32> {
        let plain = self.0.iter().filter(|one| one.stop.when.is_none());
        plain.filter_map(|one| u32::try_from(one.stop.statement).ok()).collect()
    }

    /// Those with a condition.
    pub(super) fn conditional(&self) -> Vec<Stop> {
        self.0.iter().filter(|one| one.stop.when.is_some()).map(|one| one.stop.clone()).collect()
    }
}
