//! What a statement takes each time that it runs.

use naga::{AddressSpace, Expression, Handle, MathFunction};

use super::{Compiler, Frame};
use crate::interpret::Work;
use crate::interpret::code::{Kind, What};

/// Bytes of a component of a stream, and of a word of a buffer.
const WORD: u64 = 4;

impl Compiler<'_> {
    /// Notes what a statement takes, and its expressions.
    pub(super) fn cost(&mut self, frame: &Frame, what: &What, statement: u32) {
        let mut own = Work::default();
        match what {
            What::Emit(expressions) => {
                for &at in expressions {
                    let cost = self.cost_of(frame, at);
                    if cost != Work::default() {
                        let first = self.span(at).start;
                        self.code.parts.push((statement, first, cost));
                    }
                }
            }
            What::ImageStore { .. } => own.stream_bytes_written = WORD,
            _ => {}
        }
        self.code.costs.push(own);
    }

    fn cost_of(&self, frame: &Frame, at: Handle<Expression>) -> Work {
        let of = |at: Handle<Expression>| frame.cells[at.index()];
        let (kind, width) = (of(at).kind, u64::from(of(at).width));
        match self.function.expressions[at] {
            // The result of a comparison is a boolean, whatever it compares.
            Expression::Binary { .. } | Expression::Unary { .. } => operations(kind, width),
            Expression::Select { .. } => operations(Kind::Bool, width),
            Expression::Math { fun, .. } => {
                let each = if matches!(fun, MathFunction::Fma | MathFunction::Clamp) { 2 } else { 1 };
                operations(kind, each * width)
            }
            Expression::Relational { argument, .. } => {
                operations(Kind::Bool, u64::from(of(argument).width).saturating_sub(1))
            }
            Expression::As { expr, convert: Some(_), .. } if of(expr).kind != kind => operations(Kind::U32, width),
            Expression::ImageLoad { .. } => Work { stream_bytes_read: WORD, ..Work::default() },
            Expression::Load { pointer } => match self.space(pointer) {
                Some(AddressSpace::Uniform) => Work { uniform_bytes_read: WORD * width, ..Work::default() },
                Some(AddressSpace::Storage { .. }) => Work { buffer_bytes_read: WORD * width, ..Work::default() },
                _ => Work::default(),
            },
            _ => Work::default(),
        }
    }

    /// Where the global variable is that a pointer is to; `None` for a local one.
    fn space(&self, pointer: Handle<Expression>) -> Option<AddressSpace> {
        match self.function.expressions[pointer] {
            Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => self.space(base),
            Expression::GlobalVariable(global) => Some(self.module.global_variables[global].space),
            _ => None,
        }
    }
}

/// So many operations on a type; of booleans, and of those that make one, comparisons.
fn operations(kind: Kind, count: u64) -> Work {
    match kind {
        Kind::F32 => Work { float_operations: count, ..Work::default() },
        Kind::U32 | Kind::I32 => Work { integer_operations: count, ..Work::default() },
        Kind::Bool => Work { comparisons: count, ..Work::default() },
    }
}
