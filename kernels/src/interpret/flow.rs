//! Where a thread is: the blocks that it is in, so that it can wait at a barrier and go on later.

use naga::{Expression, Handle};

use super::code::{Case, If, Op, Slot, What};
use super::machine::{Frame, Machine};
use super::{InterpretError, MOST_STEPS};

/// How a statement or a block is left.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Flow {
    Next,
    Break,
    Continue,
    Return,
    /// The statement is not done: it waits for other threads.
    Wait,
    /// The thread is where it was to be run to.
    Pause,
}

/// Whether a thread has come to its end.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Stop {
    Ended,
    /// It is at a barrier.
    Waits,
    /// It is where it was to be run to.
    Paused,
}

/// A block that has begun.
pub(super) struct Todo<'a> {
    pub(super) ops: &'a [Op],
    /// The next of its statements.
    pub(super) next: usize,
    pub(super) after: After<'a>,
}

/// What comes after a block.
pub(super) enum After<'a> {
    /// What comes after the statement that it is in.
    Block,
    If {
        branch: &'a If,
        condition: Slot,
        node: u32,
        /// The decision that the statement was reached by.
        before: u32,
    },
    Case {
        cases: &'a [Case],
        index: usize,
    },
    Body(Loop<'a>, u32),
    Continuing(Loop<'a>, u32),
    Call {
        before: u32,
        caller: Frame<'a>,
        result: Option<Handle<Expression>>,
    },
}

/// A loop; the number of its turn is beside it.
#[derive(Clone, Copy)]
pub(super) struct Loop<'a> {
    pub(super) statement: u32,
    pub(super) body: &'a [Op],
    pub(super) continuing: &'a [Op],
    pub(super) break_if: Option<(Handle<Expression>, u32)>,
    /// The decision that the statement was reached by.
    pub(super) before: u32,
}

impl<'a> Machine<'a> {
    /// Runs the thread to its end, or to the next barrier.
    pub(super) fn go_on(&mut self) -> Result<Stop, InterpretError> {
        while let (Some(top), Some(frame)) = (self.thread.todo.last_mut(), self.thread.frame) {
            let ops = top.ops;
            let Some(op) = ops.get(top.next) else {
                self.leave(Flow::Next)?;
                continue;
            };
            top.next += 1;
            if let Some(recording) = &mut self.thread.recording {
                recording.ran[op.statement as usize] = true;
            }
            self.runs[op.statement as usize] += 1;
            self.thread.at = op.statement;
            self.thread.steps += 1;
            if self.thread.steps > MOST_STEPS {
                return Err(InterpretError::Steps(MOST_STEPS));
            }
            match self.statement(&frame, op)? {
                Flow::Next => {}
                Flow::Wait => return Ok(Stop::Waits),
                Flow::Pause => return Ok(Stop::Paused),
                flow => self.leave(flow)?,
            }
        }
        Ok(Stop::Ended)
    }

    /// The statement that the thread waits at.
    pub(super) fn waiting(&self) -> Option<&'a What> {
        let top = self.thread.todo.last()?;
        Some(&top.ops.get(top.next.checked_sub(1)?)?.what)
    }

    /// Where it waits: the statement, those that call it, and the turns of the loops around it.
    pub(super) fn place_of_wait(&self, place: &mut Vec<u32>) {
        place.clear();
        place.push(self.thread.at);
        place.extend_from_slice(&self.thread.calls);
        place.extend(self.thread.todo.iter().filter_map(|todo| match todo.after {
            After::Body(_, turn) | After::Continuing(_, turn) => Some(turn),
            _ => None,
        }));
    }

    /// Leaves the innermost block, and those around it that end with it.
    fn leave(&mut self, mut flow: Flow) -> Result<(), InterpretError> {
        while let Some(left) = self.thread.todo.pop() {
            match left.after {
                After::Block => {}
                After::If { branch, condition, node, before } => self.end_branch(branch, condition, node, before),
                After::Case { cases, index } => match (flow, cases.get(index + 1)) {
                    (Flow::Break, _) => flow = Flow::Next,
                    (Flow::Next, Some((_, ops, _))) if cases[index].2 => {
                        self.thread.todo.push(Todo { ops, next: 0, after: After::Case { cases, index: index + 1 } });
                    }
                    _ => {}
                },
                After::Body(looped, turn) => match flow {
                    Flow::Break => {
                        self.thread.control = looped.before;
                        flow = Flow::Next;
                    }
                    Flow::Return => {}
                    _ => {
                        let after = After::Continuing(looped, turn);
                        self.thread.todo.push(Todo { ops: looped.continuing, next: 0, after });
                        return Ok(());
                    }
                },
                After::Continuing(looped, turn) => {
                    flow = Flow::Next;
                    if self.breaks(&looped) {
                        self.thread.control = looped.before;
                    } else {
                        return self.turn(looped, turn.wrapping_add(1));
                    }
                }
                After::Call { before, caller, result } => {
                    self.end_call(before, &caller, result);
                    flow = Flow::Next;
                }
            }
            if flow == Flow::Next {
                return Ok(());
            }
        }
        Ok(())
    }

    pub(super) fn branch(&mut self, frame: &Frame<'a>, branch: &'a If) {
        let condition = self.get(frame, branch.condition, 0);
        let node = self.decide(branch.site, condition);
        let before = std::mem::replace(&mut self.thread.control, node);
        let ops = if condition.bits != 0 { &branch.accept } else { &branch.reject };
        match ops.is_empty() {
            true => self.end_branch(branch, condition, node, before),
            false => self.thread.todo.push(Todo { ops, next: 0, after: After::If { branch, condition, node, before } }),
        }
    }

    fn end_branch(&mut self, branch: &'a If, condition: Slot, node: u32, before: u32) {
        let Some(frame) = self.thread.frame else { return };
        if !branch.has_jump {
            self.thread.control = before;
        }
        if self.thread.recording.is_some() {
            for &(place, width) in &branch.writes {
                for at in frame.base + place as usize..frame.base + (place + width) as usize {
                    self.thread.stack[at].from = self.join(self.thread.stack[at].from, node);
                }
            }
        }
        // In f64 the right side would decide, or would not: the whole may come out differently.
        if let Some(result) = branch.result.filter(|_| (condition.wide != 0.0) != (condition.bits != 0)) {
            let place = frame.base + frame.body.locals[result.index()].place as usize;
            self.thread.stack[place].wide = 1.0 - f64::from(self.thread.stack[place].bits);
        }
    }

    /// Begins a turn of a loop.
    pub(super) fn turn(&mut self, looped: Loop<'a>, turn: u32) -> Result<(), InterpretError> {
        self.thread.turns = self.thread.turns.saturating_add(1);
        if self.thread.turns > self.kernel.turns {
            self.thread.at = looped.statement;
            return Err(InterpretError::Turns(self.kernel.turns));
        }
        self.thread.todo.push(Todo { ops: looped.body, next: 0, after: After::Body(looped, turn) });
        Ok(())
    }

    /// Whether a loop ends after its continuing statements.
    fn breaks(&mut self, looped: &Loop<'a>) -> bool {
        let (Some((condition, site)), Some(frame)) = (looped.break_if, self.thread.frame) else { return false };
        let condition = self.get(&frame, condition, 0);
        self.decide(site, condition);
        condition.bits != 0
    }

    fn end_call(&mut self, before: u32, caller: &Frame<'a>, result: Option<Handle<Expression>>) {
        if self.thread.control != before {
            let control = self.thread.control;
            let mut returned = std::mem::take(&mut self.returned);
            returned.iter_mut().for_each(|slot| slot.from = self.join(slot.from, control));
            self.returned = returned;
        }
        self.thread.control = before;
        self.thread.calls.pop();
        self.thread.frame = Some(*caller);
        if let Some(result) = result {
            let cell = caller.body.cells[result.index()];
            let place = caller.base + cell.place as usize;
            let count = (cell.width as usize).min(self.returned.len());
            self.thread.stack[place..place + count].copy_from_slice(&self.returned[..count]);
        }
    }
}
