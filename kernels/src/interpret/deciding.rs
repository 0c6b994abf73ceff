//! Which decision made the element's new state.
//!
//! Of all decisions that the written state depends on (a backward slice, Weiser 1984), and of those only the ones that
//! depend on more than what the ray had found before this pass, it is
//!
//! - the last that compares two floats, neither of them a constant: where the ray meets an edge, a box or a face; else
//! - the last that compares floats, or was taken.
//!
//! A test of the old state does not count: it decides whether the kernel works on the ray at all. If nothing else is
//! left, it is the last branch taken, or reached, of those that anything written depends on.

use std::collections::BTreeSet;

use super::code::{Site, SiteKind};
use super::recording::{Comparison, Node, OUTSIDE, Recording};

/// The decision, for the nodes of the state and of everything that was written.
pub(super) fn deciding(recording: &Recording, sites: &[Site], state: &[u32], all: &[u32]) -> Option<usize> {
    let is_whole = |index: &usize| is_site(recording, sites, *index, |kind| kind != SiteKind::ShortCircuit);
    let is_taken = |index: &usize| recording.decisions.get(*index).is_some_and(|decision| decision.is_taken);
    let is_found = |index: &usize| {
        let condition = recording.decisions.get(*index).map(|decision| decision.condition);
        condition.is_some_and(|condition| is_outside(recording, condition))
    };
    let compares = |index: &usize, is_so: &dyn Fn(&Comparison) -> bool| {
        let found = comparisons(recording, sites, *index);
        found.iter().filter_map(|&i| recording.comparisons.get(i)).any(|c| c.values[0].kind.is_float() && is_so(c))
    };
    let own: Vec<usize> = slice(recording, state).into_iter().filter(is_whole).collect();
    let everything: Vec<usize> = slice(recording, all).into_iter().filter(is_whole).collect();
    let last = |of: &[usize], is_so: &dyn Fn(&usize) -> bool| of.iter().rev().find(|index| is_so(index)).copied();
    let two_floats = |index: &usize| compares(index, &|c| !c.has_constant) && is_found(index);
    last(&own, &two_floats)
        .or_else(|| last(&own, &|index| (is_taken(index) || compares(index, &|_| true)) && is_found(index)))
        .or_else(|| last(&everything, &is_taken))
        .or_else(|| everything.last().copied())
        .or_else(|| (0..recording.decisions.len()).rev().find(is_whole))
}

fn is_site(recording: &Recording, sites: &[Site], index: usize, is_so: impl Fn(SiteKind) -> bool) -> bool {
    recording.decisions.get(index).and_then(|decision| sites.get(decision.site)).is_some_and(|site| is_so(site.kind))
}

/// All decisions that nodes depend on.
fn slice(recording: &Recording, nodes: &[u32]) -> BTreeSet<usize> {
    let mut found = BTreeSet::new();
    walk(recording, nodes, |node| match node {
        Node::Both(a, b) => vec![a, b],
        Node::Comparison(_, from) => vec![from],
        Node::Operation(index) => vec![recording.operations[index].from],
        Node::Decision(index) => {
            found.insert(index);
            recording.decisions.get(index).map_or_else(Vec::new, |d| vec![d.condition, d.control])
        }
    });
    found
}

/// Whether a value depends on anything that was not known before the pass.
fn is_outside(recording: &Recording, node: u32) -> bool {
    let mut is_outside = node == OUTSIDE;
    walk(recording, &[node], |node| {
        let next = match node {
            Node::Both(a, b) => vec![a, b],
            Node::Comparison(_, from) => vec![from],
            Node::Operation(index) => vec![recording.operations[index].from],
            Node::Decision(index) => recording.decisions.get(index).map_or_else(Vec::new, |d| vec![d.condition]),
        };
        is_outside |= next.contains(&OUTSIDE);
        if is_outside { Vec::new() } else { next }
    });
    is_outside
}

impl Recording {
    /// The comparisons that a decision's condition consists of, in the order of their evaluation.
    #[must_use]
    pub fn comparisons(&self, code: &super::Interpreter, decision: usize) -> Vec<&Comparison> {
        let found = comparisons(self, &code.code.sites, decision);
        found.into_iter().filter_map(|index| self.comparisons.get(index)).collect()
    }

    /// The decision that chose a decision's condition, if that is a value decided before.
    #[must_use]
    pub fn because(&self, code: &super::Interpreter, decision: usize) -> Option<usize> {
        because(self, &code.code.sites, decision)
    }
}

/// The comparisons of a condition: those that its value is made of, but not what a decision before it compared.
fn comparisons(recording: &Recording, sites: &[Site], decision: usize) -> BTreeSet<usize> {
    let mut found = BTreeSet::new();
    let Some(condition) = recording.decisions.get(decision).map(|decision| decision.condition) else { return found };
    walk(recording, &[condition], |node| match node {
        Node::Both(a, b) => vec![a, b],
        Node::Comparison(index, _) => {
            found.insert(index);
            Vec::new()
        }
        Node::Decision(index) if is_site(recording, sites, index, |kind| kind == SiteKind::ShortCircuit) => {
            vec![recording.decisions[index].condition]
        }
        Node::Operation(index) => vec![recording.operations[index].from],
        Node::Decision(_) => Vec::new(),
    });
    found
}

/// The last decision that a condition's value was chosen by.
fn because(recording: &Recording, sites: &[Site], decision: usize) -> Option<usize> {
    let mut found = None;
    let condition = recording.decisions.get(decision)?.condition;
    walk(recording, &[condition], |node| match node {
        Node::Both(a, b) => vec![a, b],
        Node::Comparison(..) => Vec::new(),
        Node::Operation(index) => vec![recording.operations[index].from],
        Node::Decision(index) if is_site(recording, sites, index, |kind| kind == SiteKind::ShortCircuit) => {
            vec![recording.decisions[index].condition]
        }
        Node::Decision(index) => {
            found = found.max(Some(index));
            Vec::new()
        }
    });
    found
}

/// Visits nodes once each; `visit` returns where to go on.
fn walk(recording: &Recording, from: &[u32], mut visit: impl FnMut(Node) -> Vec<u32>) {
    let mut seen = BTreeSet::new();
    let mut waiting = from.to_vec();
    while let Some(at) = waiting.pop() {
        if let Some(node) = recording.node(at).filter(|_| seen.insert(at)) {
            waiting.extend(visit(node));
        }
    }
}
