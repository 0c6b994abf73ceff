//! Copies of blocks of statements with some of them replaced.

use naga::{Block, Span, Statement};

/// Calls `visit` for each statement of a block, and of the blocks inside it, that has no blocks of its own.
///
/// # Errors
/// If `visit` fails.
pub(super) fn visit<E>(block: &Block, visit: &mut dyn FnMut(&Statement) -> Result<(), E>) -> Result<(), E> {
    rewritten(block, &mut |_, statement, _| visit(statement)).map(drop)
}

/// A copy of a block, the blocks inside it too, in which `put` appends each other statement, or what stands for it.
///
/// # Errors
/// If `put` fails.
pub(crate) fn rewritten<E>(
    block: &Block,
    put: &mut dyn FnMut(&mut Block, &Statement, Span) -> Result<(), E>,
) -> Result<Block, E> {
    let mut all = Block::with_capacity(block.len());
    for (statement, &span) in block.span_iter() {
        let mut inner = |block: &Block| rewritten(block, put);
        let statement = match statement {
            Statement::Block(block) => Statement::Block(inner(block)?),
            Statement::If { condition, accept, reject } => {
                Statement::If { condition: *condition, accept: inner(accept)?, reject: inner(reject)? }
            }
            Statement::Switch { selector, cases } => {
                let mut cases = cases.clone();
                for case in &mut cases {
                    case.body = inner(&case.body)?;
                }
                Statement::Switch { selector: *selector, cases }
            }
            Statement::Loop { body, continuing, break_if } => {
                Statement::Loop { body: inner(body)?, continuing: inner(continuing)?, break_if: *break_if }
            }
            other => {
                put(&mut all, other, span)?;
                continue;
            }
        };
        all.push(statement, span);
    }
    Ok(all)
}
