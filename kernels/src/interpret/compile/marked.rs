//! Calls that only the interpreter gets: stops, and the beginnings of statements.

use naga::{Expression, Handle, Literal};

use super::{Compiler, Frame};
use crate::interpret::code::{StopOp, Watched, What};
use crate::interpret::stopped::MOST_STOPS;
use crate::shader::{Call, watched_by};

/// Most components of a variable whose value is kept.
const MOST_WORDS: u32 = 4;

impl Compiler<'_> {
    pub(super) fn marked(
        &mut self,
        frame: &Frame,
        call: Call,
        arguments: &[Handle<Expression>],
        result: Option<Handle<Expression>>,
    ) -> What {
        if let (Call::Now, Some(result)) = (call, result) {
            return What::Now(result);
        }
        let &[argument] = arguments else { return What::Nothing };
        match (call, &self.function.expressions[argument]) {
            (Call::At, Expression::Literal(Literal::U32(statement))) => What::At(*statement),
            (Call::At | Call::Now, _) => What::Nothing,
            (Call::Stop(index), _) => {
                let mut watched = Vec::new();
                for (&at, name) in &self.function.named_expressions {
                    let Some((_, of)) = watched_by(name).filter(|(stop, _)| *stop == index) else { continue };
                    let cell = frame.cells[at.index()];
                    if at != argument && (1..=MOST_WORDS).contains(&cell.width) && cell.rows == 0 {
                        watched.push((Watched { index: of, kind: cell.kind, words: cell.width }, at));
                    }
                }
                watched.sort_by_key(|(watched, _)| watched.index);
                if self.code.stops.len() <= index.min(MOST_STOPS) {
                    self.code.stops.resize(index.min(MOST_STOPS) + 1, Vec::new());
                }
                self.code.stops[index.min(MOST_STOPS)] = watched.iter().map(|(watched, _)| *watched).collect();
                What::Stop(Box::new(StopOp { index, condition: argument, watched }))
            }
        }
    }
}
