//! What calls what, and where blocks are left.

use std::collections::BTreeSet;

use naga::valid::{GlobalUse, ModuleInfo};
use naga::{Block, Function, Handle, Module, Statement};

use crate::interpret::code::{Op, What};
use crate::shader::{Binding, Resource, Variant};

/// Functions that find a thread's element in a list.
const TEXEL_OF: [&str; 2] = ["listed_texel", "tiled_texel"];
/// Functions that tell the host and other passes what became of the element.
const BOOKS: [&str; 2] = ["send", "book"];

/// The functions that are not interpreted: those above. In a whole pass a thread finds its element as on a device, and a
/// function is one that books if it writes what is for the host: another may have the same name.
pub(super) fn skipped(
    variant: &Variant,
    module: &Module,
    info: &ModuleInfo,
    is_whole: bool,
) -> BTreeSet<Handle<Function>> {
    let is_live = |name: &str| {
        let live = |binding: &&Binding| matches!(binding.resource, Resource::Live { .. });
        variant.bindings.iter().filter(live).any(|binding| binding.name == name)
    };
    let books = |handle: Handle<Function>| {
        module.global_variables.iter().any(|(global, variable)| {
            let name = variable.name.as_deref().map(|name| variant.kernel.bound(name));
            info[handle][global].contains(GlobalUse::WRITE) && name.is_some_and(is_live)
        })
    };
    let is_skipped = |handle: Handle<Function>, name: &str| match is_whole {
        true => BOOKS.contains(&name) && books(handle),
        false => BOOKS.contains(&name) || TEXEL_OF.contains(&name),
    };
    let functions = module.functions.iter();
    let named = functions.map(|(handle, function)| (handle, function.name.as_deref().unwrap_or_default()));
    named.filter(|&(handle, name)| is_skipped(handle, name)).map(|(handle, _)| handle).collect()
}

/// Whether a function of ours says which element a thread has.
pub(in crate::interpret) fn finds_elements(module: &Module) -> bool {
    let mut names = module.functions.iter().filter_map(|(_, function)| function.name.as_deref());
    names.any(|name| TEXEL_OF.contains(&name))
}

/// The functions that a function calls, except those that are not interpreted.
pub(super) fn called(
    module: &Module,
    from: &Function,
    is_skipped: &dyn Fn(Handle<Function>) -> bool,
) -> BTreeSet<Handle<Function>> {
    fn visit(
        module: &Module,
        block: &Block,
        is_skipped: &dyn Fn(Handle<Function>) -> bool,
        found: &mut BTreeSet<Handle<Function>>,
    ) {
        let visit = |block: &Block, found: &mut _| visit(module, block, is_skipped, found);
        for statement in block {
            match statement {
                Statement::Call { function, .. } if !is_skipped(*function) && found.insert(*function) => {
                    visit(&module.functions[*function].body, found);
                }
                Statement::Block(block) => visit(block, found),
                Statement::If { accept, reject, .. } => [accept, reject].iter().for_each(|b| visit(b, found)),
                Statement::Switch { cases, .. } => cases.iter().for_each(|case| visit(&case.body, found)),
                Statement::Loop { body, continuing, .. } => {
                    [body, continuing].iter().for_each(|b| visit(b, found));
                }
                _ => {}
            }
        }
    }
    let mut found = BTreeSet::new();
    visit(module, &from.body, is_skipped, &mut found);
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
