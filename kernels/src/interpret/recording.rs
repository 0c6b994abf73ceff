//! What happened to one element in one pass: statements, decisions, comparisons, and what depends on what.
//!
//! Every scalar names a *node*: 0 if it is constant or what the element had found before this pass, 1 if it was read
//! from anywhere else, or one of the nodes below. A value depends on its operands; on the decisions that chose it; and,
//! if it was written in a branch, or could have been, on that branch's condition.

use std::collections::BTreeMap;

use super::code::{Code, Kind};
use crate::shader::Printed;
use crate::tables::stream::Stream;

/// A constant, or found in an earlier pass.
pub(super) const KNOWN: u32 = 0;
/// Read from the scene, the camera, or the ray.
pub(super) const OUTSIDE: u32 = 1;
const FIRST: u32 = 2;
/// Nodes to keep; after that, a value depends on one of its operands only.
const MOST_NODES: usize = 1 << 22;
/// Decisions, comparisons and operations to keep, of each the first so many.
const MOST_KEPT: usize = 1 << 18;

#[derive(Clone, Copy, Debug)]
pub(super) enum Node {
    /// Depends on two others.
    Both(u32, u32),
    /// The result of a comparison, and what its sides depend on.
    Comparison(usize, u32),
    /// Chosen by a decision.
    Decision(usize),
    /// The result of an operation that is not finite.
    Operation(usize),
}

/// A scalar with its shadow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Value {
    /// Its bits.
    pub bits: u32,
    /// Its type.
    pub kind: Kind,
    /// A float's shadow.
    pub wide: f64,
}

/// A comparison of two scalars, or of one component of two vectors.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Its sides, as a reader would name them.
    pub sides: [String; 2],
    /// The component, of vectors.
    pub component: Option<usize>,
    /// As in WGSL.
    pub operator: &'static str,
    /// Its sides.
    pub values: [Value; 2],
    /// Whether it is true.
    pub holds: bool,
    /// Whether it is true for the shadows.
    pub holds_wide: bool,
    /// Whether one of its sides is a constant.
    pub has_constant: bool,
}

/// A condition at the time when it was reached.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// Which condition: an index into the interpreter's sites.
    pub site: usize,
    /// How it came out.
    pub is_taken: bool,
    /// Whether one of its comparisons comes out differently for the shadows.
    pub differs: bool,
    /// The node of its condition.
    pub(super) condition: u32,
    /// The node of the decision that it was reached by.
    pub(super) control: u32,
}

/// An operation whose result is not finite.
#[derive(Clone, Debug, PartialEq)]
pub struct Operation {
    /// Its line in the composed source, from 0.
    pub line: usize,
    /// As in the source.
    pub text: String,
    /// Its operands, as a reader would name them.
    pub operands: Vec<(String, f32)>,
    /// Its result.
    pub result: f32,
    /// The node of an operand that is not finite either.
    pub(super) operand: u32,
    /// What it depends on.
    pub(super) from: u32,
}

/// A component of an element that is no longer finite.
#[derive(Clone, Debug, PartialEq)]
pub struct NonFinite {
    /// Its stream.
    pub stream: Stream,
    /// Its layer.
    pub layer: usize,
    /// Its value.
    pub value: f32,
    /// The line that stored it in the composed source, from 0.
    pub line: usize,
    /// What made it; `None` if it was read as it is.
    pub operation: Option<Operation>,
}

/// What happened.
#[derive(Debug)]
pub struct Recording {
    /// For every statement, whether it ran.
    pub ran: Vec<bool>,
    /// In order.
    pub decisions: Vec<Decision>,
    pub(super) comparisons: Vec<Comparison>,
    /// Those whose results are not finite.
    pub(super) operations: Vec<Operation>,
    pub(super) nodes: Vec<Node>,
    /// How often each condition was true, and false.
    pub counts: Vec<[u64; 2]>,
    /// For each condition, the decision at which it was reached last.
    pub last: Vec<Option<usize>>,
    /// The decision that the element's new state is due to, see the module `deciding`.
    pub deciding: Option<usize>,
    /// For every component of the element, the line of the composed source that stored it last, from 0.
    pub stored: Vec<Option<usize>>,
    /// And the lines of the calls that led there, the innermost first.
    pub callers: Vec<Vec<usize>>,
    /// The calls that led to what a component was stored by last: their statements, the outermost first.
    pub(super) calls: BTreeMap<usize, Vec<u32>>,
    /// What it has printed, in the order of [`Interpreter::notes`](super::Interpreter::notes): the last value of each, and how
    /// often it was printed.
    pub noted: Vec<Printed>,
    /// The first component of the element that has become infinite or not a number.
    pub non_finite: Option<NonFinite>,
}

impl Recording {
    pub(super) fn new(code: &Code) -> Self {
        Self {
            ran: vec![false; code.statements.len()],
            decisions: Vec::new(),
            comparisons: Vec::new(),
            operations: Vec::new(),
            nodes: Vec::new(),
            counts: vec![[0; 2]; code.sites.len()],
            last: vec![None; code.sites.len()],
            deciding: None,
            stored: Vec::new(),
            callers: Vec::new(),
            calls: BTreeMap::new(),
            noted: Vec::new(),
            non_finite: None,
        }
    }

    pub(super) fn node(&self, node: u32) -> Option<Node> {
        node.checked_sub(FIRST).and_then(|at| self.nodes.get(at as usize)).copied()
    }

    fn add(&mut self, node: Node) -> Option<u32> {
        if self.nodes.len() >= MOST_NODES {
            return None;
        }
        self.nodes.push(node);
        Some(self.nodes.len() as u32 - 1 + FIRST)
    }

    /// What depends on both.
    pub(super) fn join(&mut self, a: u32, b: u32) -> u32 {
        match (a, b) {
            _ if a == b => a,
            (0, other) | (other, 0) => other,
            _ => self.add(Node::Both(a, b)).unwrap_or(a.max(b)),
        }
    }

    pub(super) fn compare(&mut self, comparison: Comparison, from: u32) -> u32 {
        if self.comparisons.len() >= MOST_KEPT {
            return from;
        }
        self.comparisons.push(comparison);
        self.add(Node::Comparison(self.comparisons.len() - 1, from)).unwrap_or(from)
    }

    /// Whether there is room for more operations.
    pub(super) fn takes_operations(&self) -> bool {
        self.operations.len() < MOST_KEPT
    }

    /// Records an operation whose result is not finite, and returns its node.
    pub(super) fn compute(&mut self, operation: Operation) -> u32 {
        let from = operation.from;
        self.operations.push(operation);
        self.add(Node::Operation(self.operations.len() - 1)).unwrap_or(from)
    }

    /// Records a decision, and returns its node.
    pub(super) fn decide(&mut self, decision: Decision) -> u32 {
        let (site, condition) = (decision.site, decision.condition);
        if let Some(counts) = self.counts.get_mut(site) {
            counts[usize::from(!decision.is_taken)] += 1;
        }
        // The last of a long loop matters more than those in its middle, but it takes all to say what depends on what.
        if self.decisions.len() >= MOST_KEPT {
            return condition;
        }
        self.decisions.push(decision);
        let index = self.decisions.len() - 1;
        if let Some(last) = self.last.get_mut(site) {
            *last = Some(index);
        }
        self.add(Node::Decision(index)).unwrap_or(condition)
    }
}
