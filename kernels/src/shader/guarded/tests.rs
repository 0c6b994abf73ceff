//! Users' loops end, and nothing else changes.

use std::sync::Arc;

use naga::{Block, Expression, Function, Literal, Statement};

use super::super::parsed::Parsed;
use super::super::{Binding, Resource, Variant};
use super::{find, guarded};
use crate::options::features::Features;
use crate::options::replacement::Replacement;
use crate::programs::closest_hit::kernels::{FUSED, GENERATE, INTERSECT};

/// Loops of every kind, and names that the guard's own would be.
const LOOPS: &str = "@group(2) @binding(3) var<storage, read_write> tally: array<atomic<u32>>;

var<private> turns_left: u32 = 7u;

fn turn_is_over(line: u32) -> bool {
    return line > turns_left;
}

fn looped(n: u32) -> u32 {
    var m = n;
    while (m < 9u) {
        m += 2u;
    }
    for (var i = 0u; i < m; i++) {
        for (var j = i; j < m; j++) {
            if (turn_is_over(j)) {
                continue;
            }
            m -= 1u;
        }
    }
    return m;
}

@compute @workgroup_size(8)
fn main(@builtin(local_invocation_index) lane: u32) {
    var n = looped(lane);
    switch (n) {
        case 1u: {
            loop {
                n += 1u;
                if (n > 20u) {
                    break;
                }
                continuing {
                    n += 2u;
                }
            }
        }
        default: {
            loop {
                n += 1u;
                continuing {
                    break if n > 30u;
                }
            }
        }
    }
    atomicStore(&tally[0], n);
}
";

fn counters(index: u32) -> Binding {
    let resource = Resource::Live { writable: true };
    Binding { group: 2, index, name: "sent".into(), resource, reads: false, writes: true }
}

/// Of each loop of a function, outer ones first: how many exits it has, and the lines that it gives to the guard.
fn loops(function: &Function, block: &Block, guard: naga::Handle<Function>, found: &mut Vec<(usize, Vec<u32>)>) {
    for statement in block {
        match statement {
            Statement::Loop { body, continuing, break_if } => {
                let mut lines = Vec::new();
                for statement in body {
                    if let Statement::Call { function: callee, arguments, .. } = statement
                        && *callee == guard
                        && let Expression::Literal(Literal::U32(line)) = function.expressions[arguments[0]]
                    {
                        lines.push(line);
                    }
                }
                found.push((breaks(body) + usize::from(break_if.is_some()), lines));
                loops(function, body, guard, found);
                loops(function, continuing, guard, found);
            }
            Statement::Block(block) => loops(function, block, guard, found),
            Statement::If { accept, reject, .. } => {
                loops(function, accept, guard, found);
                loops(function, reject, guard, found);
            }
            Statement::Switch { cases, .. } => cases.iter().for_each(|case| loops(function, &case.body, guard, found)),
            _ => {}
        }
    }
}

/// Ways out of the loop that a block belongs to.
fn breaks(block: &Block) -> usize {
    let of = |statement: &Statement| match statement {
        Statement::Break => 1,
        Statement::Block(block) => breaks(block),
        Statement::If { accept, reject, .. } => breaks(accept) + breaks(reject),
        _ => 0,
    };
    block.iter().map(of).sum()
}

fn with_guards(source: &str, counters: &Binding, turns: u32) -> String {
    let name = find(&Parsed::new(source).expect("valid WGSL"), counters).map(|(_, name)| name);
    guarded(source, name, counters, turns).expect("valid WGSL")
}

#[test]
fn every_loop_counts_its_turns_and_has_no_exit_more_than_it_needs() {
    let text = with_guards(LOOPS, &counters(3), 100);
    let parsed = Parsed::new(&text).expect("valid WGSL");
    // The source has functions of these names, which are left alone.
    let guard = parsed.function("turn_is_overx").expect("the guard");
    let mut found = Vec::new();
    for (function, _) in parsed.functions() {
        loops(function, &function.body, guard, &mut found);
    }
    // The `while` and `for` end by their conditions alone; a `loop` may end in its body too.
    assert_eq!(found, [(1, vec![11]), (1, vec![14]), (1, vec![15]), (2, vec![30]), (2, vec![41])]);
    assert!(text.contains("turns_leftx: u32 = 100u"), "{text}");
    assert!(text.contains("turns_left: u32 = 7u"), "{text}");
    // The counters are those that the source declares; their last word is that of the line.
    assert!(text.contains("var<storage, read_write> tally: array<atomic<u32>, 64>;"), "{text}");
    assert!(text.contains("last_counterx: u32 = 63u"), "{text}");
    assert_eq!(text.matches("@group(2)").count(), 1, "{text}");
}

#[test]
fn counters_are_declared_where_there_are_none() {
    let source =
        "@compute @workgroup_size(1)\nfn main() {\n    var n = 0u;\n    while (n < 9u) {\n        n++;\n    }\n}\n";
    let text = with_guards(source, &counters(5), 10);
    assert!(text.contains("@group(2) @binding(5)"), "{text}");
    let parsed = Parsed::new(&text).expect("valid WGSL");
    let (mut found, guard) = (Vec::new(), parsed.function("turn_is_over").expect("the guard"));
    parsed.functions().for_each(|(function, _)| loops(function, &function.body, guard, &mut found));
    assert_eq!(found, [(1, vec![4])]);
}

/// A kernel of ours, given back by a user with a change.
fn of_user(kernel: crate::Kernel, from: &str, to: &str) -> Variant {
    let features = Features { robust: true, watertight: true, grid: true, ..Features::default() };
    assert!(kernel.info().wgsl.contains(from));
    let source = kernel.info().wgsl.replacen(from, to, 1);
    let by = Replacement { kernel: kernel.name().into(), file: "my.wgsl".into(), source };
    Variant::replaced(kernel, &features, &[], &Arc::new(by)).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn only_users_kernels_with_loops_are_guarded() {
    let list = "let list = list_of(cell);";
    let without = of_user(GENERATE, "fn ", "fn ");
    assert!(without.guarded(100).expect("valid WGSL").is_none(), "it has no loop");
    let with_loop = of_user(INTERSECT, list, "let list = list_of(cell);\n    while (item > 1000000u) { item -= 1u; }");
    let guarded = with_loop.guarded(100).expect("valid WGSL").expect("it has a loop");
    // It counts rays already, so it has the counters.
    assert_eq!(guarded.bindings, with_loop.bindings);
    assert!(guarded.source.contains("turn_is_over("));
    let ours = Variant { replaced: None, ..with_loop };
    assert!(ours.guarded(100).expect("valid WGSL").is_none(), "it is ours");
}

#[test]
fn a_kernel_that_counts_no_rays_gets_the_counters() {
    let fused = of_user(FUSED, "fn ", "fn ");
    assert!(!fused.bindings.iter().any(|binding| binding.name == "sent"));
    let guarded = fused.guarded(100).expect("valid WGSL").expect("it has loops");
    let added: Vec<_> = guarded.bindings.iter().filter(|binding| !fused.bindings.contains(binding)).collect();
    let [added] = added[..] else { panic!("{added:?}") };
    assert_eq!((&*added.name, added.group, &added.resource), ("sent", 2, &Resource::Live { writable: true }));
    let declaration = format!("@group(2) @binding({})", added.index);
    assert_eq!((fused.source.matches(&declaration).count(), guarded.source.matches(&declaration).count()), (0, 1));
    assert!(guarded.bindings.is_sorted_by_key(|binding| (binding.group, binding.index)));
}
