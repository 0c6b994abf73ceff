//! Whether every thread of a workgroup reaches a kernel's barriers.

use naga::{Block, Function, Module, Span, Statement};

/// A barrier that some threads of a workgroup may not reach: inside of a branch or loop, or after a `return` of one. Stricter
/// than WGSL, which allows it where the condition is the same for all threads.
pub(super) fn astray(module: &Module, entry: &Function) -> Option<Span> {
    // A function comes before those that call it.
    let mut barriers = Barriers(Vec::new());
    for (_, function) in module.functions.iter() {
        barriers.0.push(barriers.are_in(&function.body));
    }
    let functions = module.functions.iter().map(|(_, function)| function);
    std::iter::once(entry).chain(functions).find_map(|function| barriers.astray(&function.body, false, &mut false))
}

/// For each function of a module, whether it or one that it calls has a barrier.
struct Barriers(Vec<bool>);

impl Barriers {
    fn is_one(&self, statement: &Statement) -> bool {
        match statement {
            Statement::ControlBarrier(_) | Statement::WorkGroupUniformLoad { .. } => true,
            Statement::Call { function, .. } => self.0.get(function.index()).copied().unwrap_or_default(),
            _ => false,
        }
    }

    fn are_in(&self, block: &Block) -> bool {
        block.iter().any(|statement| match statement {
            Statement::Block(block) => self.are_in(block),
            Statement::If { accept, reject, .. } => self.are_in(accept) || self.are_in(reject),
            Statement::Switch { cases, .. } => cases.iter().any(|case| self.are_in(&case.body)),
            Statement::Loop { body, continuing, .. } => self.are_in(body) || self.are_in(continuing),
            other => self.is_one(other),
        })
    }

    /// `has_left` becomes true where a thread may have returned.
    fn astray(&self, block: &Block, is_nested: bool, has_left: &mut bool) -> Option<Span> {
        for (statement, &span) in block.span_iter() {
            if (is_nested || *has_left) && self.is_one(statement) {
                return Some(span);
            }
            let mut inner = |block: &Block| self.astray(block, true, has_left);
            let found = match statement {
                Statement::Block(block) => self.astray(block, is_nested, has_left),
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
}
