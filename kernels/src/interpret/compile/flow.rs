//! What calls what, and where blocks are left.

use std::collections::BTreeSet;

use naga::{Block, Function, Handle, Module, Statement};

use crate::interpret::code::{Op, What};

/// Functions that find a thread's element in a list.
pub(super) const TEXEL_OF: [&str; 2] = ["listed_texel", "tiled_texel"];
/// Functions that tell the host and other passes what became of the element.
pub(super) const BOOKS: [&str; 2] = ["send", "book"];

/// The functions that a function calls, except those that are not interpreted.
pub(in crate::interpret) fn called(module: &Module, from: &Function) -> BTreeSet<Handle<Function>> {
    fn visit(module: &Module, block: &Block, found: &mut BTreeSet<Handle<Function>>) {
        for statement in block {
            match statement {
                Statement::Call { function, .. } => {
                    let name = module.functions[*function].name.as_deref().unwrap_or_default();
                    if !TEXEL_OF.contains(&name) && !BOOKS.contains(&name) && found.insert(*function) {
                        visit(module, &module.functions[*function].body, found);
                    }
                }
                Statement::Block(block) => visit(module, block, found),
                Statement::If { accept, reject, .. } => [accept, reject].iter().for_each(|b| visit(module, b, found)),
                Statement::Switch { cases, .. } => cases.iter().for_each(|case| visit(module, &case.body, found)),
                Statement::Loop { body, continuing, .. } => {
                    [body, continuing].iter().for_each(|b| visit(module, b, found));
                }
                _ => {}
            }
        }
    }
    let mut found = BTreeSet::new();
    visit(module, &from.body, &mut found);
    found
}

/// Whether statements may leave the block that they are in; jumps inside of a loop stay there.
pub(in crate::interpret) fn has_jump(ops: &[Op], is_in_loop: bool) -> bool {
    ops.iter().any(|op| match &op.what {
        What::Return(_) => true,
        What::Break | What::Continue => !is_in_loop,
        What::Block(ops) => has_jump(ops, is_in_loop),
        What::If(branch) => has_jump(&branch.accept, is_in_loop) || has_jump(&branch.reject, is_in_loop),
        What::Switch { cases, .. } => cases.iter().any(|(_, ops, _)| has_jump(ops, true)),
        What::Loop { body, continuing, .. } => has_jump(body, true) || has_jump(continuing, true),
        _ => false,
    })
}
