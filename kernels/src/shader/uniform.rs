//! Whether every thread of a workgroup reaches a kernel's barriers.

use naga::{Block, Function, Module, Span, Statement};

/// A barrier that some threads of a workgroup may not reach: inside of a branch or loop, or after a `return` of one. Stricter
/// than WGSL, which allows it where the condition is the same for all threads.
pub(super) fn astray(module: &Module, entry: &Function) -> Option<Span> {
    let all = || std::iter::once(entry).chain(module.functions.iter().map(|(_, function)| function));
    all().find_map(|function| in_block(module, &function.body, false, &mut false))
}

/// `has_left` becomes true where a thread may have returned.
fn in_block(module: &Module, block: &Block, is_nested: bool, has_left: &mut bool) -> Option<Span> {
    for (statement, &span) in block.span_iter() {
        if (is_nested || *has_left) && is_barrier(module, statement) {
            return Some(span);
        }
        let mut inner = |block: &Block| in_block(module, block, true, has_left);
        let found = match statement {
            Statement::Block(block) => in_block(module, block, is_nested, has_left),
            Statement::If { accept, reject, .. } => inner(accept).or_else(|| inner(reject)),
            Statement::Switch { cases, .. } => cases.iter().find_map(|case| inner(&case.body)),
            Statement::Loop { body, continuing, .. } => inner(body).or_else(|| inner(continuing)),
            Statement::Return { .. } => {
                *has_left |= is_nested;
                None
            }
            _ => None,
        };
        if found.is_some() {
            return found;
        }
    }
    None
}

fn is_barrier(module: &Module, statement: &Statement) -> bool {
    match statement {
        Statement::ControlBarrier(_) | Statement::WorkGroupUniformLoad { .. } => true,
        Statement::Call { function, .. } => has_barrier(module, &module.functions[*function].body),
        _ => false,
    }
}

fn has_barrier(module: &Module, block: &Block) -> bool {
    block.iter().any(|statement| match statement {
        Statement::Block(block) => has_barrier(module, block),
        Statement::If { accept, reject, .. } => has_barrier(module, accept) || has_barrier(module, reject),
        Statement::Switch { cases, .. } => cases.iter().any(|case| has_barrier(module, &case.body)),
        Statement::Loop { body, continuing, .. } => has_barrier(module, body) || has_barrier(module, continuing),
        other => is_barrier(module, other),
    })
}
