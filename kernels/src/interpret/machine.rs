//! Executes statements.

use naga::{Expression, Function, Handle};

use super::code::{Body, Global, Holds, NONE, Op, Slot, What};
use super::flow::{After, Flow, Todo};
use super::invocation::{Invocation, enter};
use super::pass::Group;
use super::recording::{Decision, KNOWN, OUTSIDE, Recording};
use super::stopped::Stopped;
use super::trace::Trace;
use super::{Element, InterpretError, Interpreter, MOST_SITES, Outcomes};
use crate::scene_data::SceneData;
use crate::shader::Printed;
use crate::tables::stream::Texel;

/// A function's call.
#[derive(Clone, Copy)]
pub(super) struct Frame<'a> {
    pub(super) body: &'a Body,
    pub(super) function: &'a Function,
    /// Where its slots begin.
    pub(super) base: usize,
}

/// What belongs to one thread while it runs.
#[derive(Default)]
pub(super) struct Thread<'a> {
    pub(super) stack: Vec<Slot>,
    pub(super) private: Vec<Slot>,
    /// The blocks that it is in, innermost last.
    pub(super) todo: Vec<Todo<'a>>,
    /// The function that it is in; `None` before the first.
    pub(super) frame: Option<Frame<'a>>,
    pub(super) steps: u64,
    pub(super) turns: u32,
    /// The statement that was run last.
    pub(super) at: u32,
    /// The statements with the calls that have not returned.
    pub(super) calls: Vec<u32>,
    /// What the element has printed: of each note the last value, and how often.
    pub(super) noted: Vec<Printed>,
    /// The state that it has told for its element, and the statement that did.
    pub(super) booked: Option<(u32, u32)>,
    /// What it did at the kernel's stops.
    pub(super) stopped: Vec<Stopped>,
    /// Its steps, if they are followed.
    pub(super) trace: Option<Box<Trace>>,
    /// The node of the decision that the current statement was reached by.
    pub(super) control: u32,
    pub(super) recording: Option<Recording>,
}

/// The state of an interpretation.
pub(super) struct Machine<'a> {
    pub(super) kernel: &'a Interpreter,
    /// The bytes of each global that has some.
    pub(super) bytes: Vec<&'a [u8]>,
    pub(super) thread: Thread<'a>,
    /// The workgroup, in a whole pass.
    pub(super) group: Option<Box<Group<'a>>>,
    /// The element's components in the kernel's streams.
    pub(super) row: Vec<Slot>,
    /// Components that were written.
    pub(super) written: Vec<bool>,
    /// The statements that wrote them.
    pub(super) stored: Vec<u32>,
    /// The components before.
    pub(super) before: Vec<u32>,
    pub(super) element: Element,
    pub(super) returned: Vec<Slot>,
    /// How often each statement ran.
    pub(super) runs: Vec<u64>,
    pub(super) outcomes: Outcomes,
}

impl<'a> Machine<'a> {
    pub(super) fn new(kernel: &'a Interpreter, data: &'a SceneData, recording: Option<Recording>) -> Self {
        let program = kernel.kernel.program();
        let bytes = kernel.code.globals.iter().map(|global| match global {
            Global::Bytes(name) => program.buffer(name).map_or(&[][..], |buffer| buffer.contents(data)),
            _ => &[],
        });
        let noted = vec![([0; 4], 0); kernel.notes.noted.len()];
        Self {
            kernel,
            bytes: bytes.collect(),
            thread: Thread { noted, recording, ..Thread::default() },
            group: None,
            row: Vec::new(),
            written: Vec::new(),
            stored: Vec::new(),
            before: Vec::new(),
            element: Element { texel: [0; 2], size: [0; 2] },
            returned: Vec::new(),
            runs: vec![0; kernel.code.statements.len()],
            outcomes: Outcomes::default(),
        }
    }

    pub(super) fn run(&mut self, element: Element, texels: &mut [u32]) -> Result<(), InterpretError> {
        if self.kernel.is_whole {
            return Err(InterpretError::NotAlone(self.kernel.kernel.name()));
        }
        let needed = self.kernel.components();
        if texels.len() != needed {
            return Err(InterpretError::Texels { given: texels.len(), needed });
        }
        (self.element, self.outcomes) = (element, Outcomes::default());
        self.row.clear();
        self.written.clear();
        self.written.resize(needed, false);
        self.stored.clear();
        self.stored.resize(needed, NONE);
        self.before.clear();
        self.before.extend_from_slice(texels);
        for &stream in &self.kernel.streams {
            let is_kept = stream.info().texel == Texel::U32 && self.kernel.kept.contains(&stream);
            let from = if is_kept { KNOWN } else { OUTSIDE };
            let is_float = stream.info().texel == Texel::F32;
            for _ in 0..stream.layers() {
                let bits = texels[self.row.len()];
                let wide = if is_float { f64::from(f32::from_bits(bits)) } else { 0.0 };
                self.row.push(Slot { bits, from, wide });
            }
        }
        let [x, y] = element.texel;
        self.begin(&Invocation { global: [x, y, 0], ..Invocation::default() });
        self.go_on()?;
        if self.kernel.is_to_book()
            && let Some(tag) = self.kernel.tag()
        {
            let after = self.row.get(tag).map(|slot| slot.bits);
            let states = self.before.get(tag).copied().zip(after).map(|(before, after)| [before, after]);
            self.check_booked(states)?;
        }
        for (texel, slot) in texels.iter_mut().zip(&self.row) {
            *texel = slot.bits;
        }
        Ok(())
    }

    /// Before the first statement of a thread.
    pub(super) fn begin(&mut self, of: &Invocation) {
        let kernel = self.kernel;
        let thread = &mut self.thread;
        (thread.steps, thread.turns, thread.control, thread.booked) = (0, 0, KNOWN, None);
        thread.calls.clear();
        thread.todo.clear();
        thread.noted.clear();
        thread.stopped.clear();
        thread.noted.resize(kernel.notes.noted.len(), ([0; 4], 0));
        thread.private.clone_from(&kernel.code.private);
        let entry = &kernel.code.bodies[kernel.code.entry];
        let function = self.function(entry);
        self.reserve(entry.frame as usize);
        enter(of, kernel, function, entry, &mut self.thread.stack);
        self.call(entry, 0);
        self.thread.todo.push(Todo { ops: &entry.ops, next: 0, after: After::Block });
    }

    fn function(&self, body: &Body) -> &'a Function {
        let kernel = self.kernel;
        match body.handle {
            Some(handle) => &kernel.module.functions[handle],
            None => {
                let is_entry = |point: &&naga::EntryPoint| point.name == kernel.kernel.info().name;
                kernel
                    .module
                    .entry_points
                    .iter()
                    .find(is_entry)
                    .map_or(&kernel.module.entry_points[0].function, |point| &point.function)
            }
        }
    }

    fn reserve(&mut self, slots: usize) {
        if self.thread.stack.len() < slots {
            self.thread.stack.resize(slots.next_power_of_two(), Slot::default());
        }
    }

    /// Enters a function whose arguments are in its frame.
    fn call(&mut self, body: &'a Body, base: usize) {
        let frame = Frame { body, function: self.function(body), base };
        for local in &body.locals {
            let first = base + local.place as usize;
            for i in 0..local.width {
                let value = if local.init == NONE { Slot::default() } else { self.at(&frame, local.init, i) };
                self.thread.stack[first + i as usize] = value;
            }
        }
        self.returned.clear();
        self.thread.frame = Some(frame);
    }

    /// Runs a statement, or begins one that has others inside of it.
    pub(super) fn statement(&mut self, frame: &Frame<'a>, op: &'a Op) -> Result<Flow, InterpretError> {
        match &op.what {
            What::Emit(expressions) => {
                self.thread.steps += expressions.len() as u64;
                for &expression in expressions {
                    self.evaluate(frame, expression)?;
                }
            }
            What::Block(ops) => self.thread.todo.push(Todo { ops, next: 0, after: After::Block }),
            What::If(branch) => self.branch(frame, branch),
            What::Switch { site, selector, cases } => {
                let value = self.get(frame, *selector, 0);
                let is_case = |case: &(Option<u32>, Vec<Op>, bool)| case.0 == Some(value.bits);
                let found = cases.iter().position(is_case);
                let bits = u32::from(found.is_some());
                let node = self.decide(*site, Slot { bits, wide: f64::from(bits), ..value });
                self.thread.control = node;
                let first = found.or_else(|| cases.iter().position(|case| case.0.is_none())).unwrap_or(cases.len());
                if let Some((_, ops, _)) = cases.get(first) {
                    self.thread.todo.push(Todo { ops, next: 0, after: After::Case { cases, index: first } });
                }
            }
            What::Loop { body, continuing, break_if } => {
                let before = self.thread.control;
                let looped =
                    super::flow::Loop { statement: op.statement, body, continuing, break_if: *break_if, before };
                self.turn(looped, 0)?;
            }
            What::Break => return Ok(Flow::Break),
            What::Continue => return Ok(Flow::Continue),
            What::Return(value) => {
                self.returned.clear();
                if let Some(value) = *value {
                    let width = frame.body.cells[value.index()].width;
                    for i in 0..width {
                        let slot = self.get(frame, value, i);
                        self.returned.push(slot);
                    }
                }
                return Ok(Flow::Return);
            }
            What::Store { pointer, value } => self.store(frame, *pointer, *value)?,
            What::ImageStore { image, texel, layer, value } => {
                let component = self.image_store(frame, *image, *texel, *layer, *value)?;
                if let Some(stored) = self.stored.get_mut(component) {
                    *stored = op.statement;
                    if let Some(recording) = &mut self.thread.recording {
                        recording.calls.insert(component, self.thread.calls.clone());
                    }
                }
            }
            What::Call { function, arguments, result } => self.invoke(frame, *function, arguments, *result)?,
            What::Atomic { pointer, fun, value, result } => self.atomic(frame, *pointer, *fun, *value, *result)?,
            What::Barrier(_) | What::UniformLoad { .. } => return Ok(Flow::Wait),
            What::Texel(result) => {
                let place = frame.base + frame.body.cells[result.index()].place as usize;
                for (i, bits) in self.element.texel.into_iter().enumerate() {
                    self.thread.stack[place + i] = Slot { bits, from: KNOWN, wide: 0.0 };
                }
            }
            What::Note(index, value) => {
                let width = frame.body.cells[value.index()].width.min(4);
                let values = std::array::from_fn(|lane| match lane as u32 {
                    lane if lane < width => self.get(frame, *value, lane).bits,
                    _ => 0,
                });
                if let Some((last, count)) = self.thread.noted.get_mut(*index) {
                    (*last, *count) = (values, *count + 1);
                }
            }
            What::Assertion(index, condition) => {
                if self.get(frame, *condition, 0).bits == 0 {
                    let label = self.kernel.notes.asserted.get(*index).cloned().unwrap_or_default();
                    return Err(InterpretError::Assertion(label));
                }
            }
            What::Stop(stop) => {
                self.stop(frame, stop);
                if let Some(trace) = &mut self.thread.trace {
                    trace.stop(stop.index, self.thread.stopped.get(stop.index).map_or(0, |stopped| stopped.held));
                }
            }
            What::Now(result) => {
                let is_now = self.thread.trace.as_ref().is_some_and(|trace| trace.is_next());
                let bits = u32::from(is_now);
                let place = frame.base + frame.body.cells[result.index()].place as usize;
                self.thread.stack[place] = Slot { bits, from: KNOWN, wide: f64::from(bits) };
            }
            What::At(statement) => {
                let depth = self.thread.calls.len() as u32;
                if let Some(trace) = &mut self.thread.trace
                    && trace.step(*statement, depth)
                {
                    return Ok(Flow::Pause);
                }
            }
            What::Book(tag) => self.thread.booked = Some((self.get(frame, *tag, 0).bits, op.statement)),
            What::Nothing => {}
            What::Unsupported(what) => {
                return Err(InterpretError::Unsupported { what: (*what).into(), line: self.line() });
            }
        }
        Ok(Flow::Next)
    }

    fn invoke(
        &mut self,
        frame: &Frame<'a>,
        function: usize,
        arguments: &[Handle<Expression>],
        result: Option<Handle<Expression>>,
    ) -> Result<(), InterpretError> {
        let kernel = self.kernel;
        let body = &kernel.code.bodies[function];
        let base = frame.base + frame.body.frame as usize;
        self.reserve(base + body.frame as usize);
        for (&value, argument) in arguments.iter().zip(&body.arguments) {
            let place = base + argument.place as usize;
            match argument.holds {
                Holds::Value => {
                    for i in 0..argument.width {
                        let slot = self.get(frame, value, i);
                        self.thread.stack[place + i as usize] = slot;
                    }
                }
                Holds::Pointer => self.thread.stack[place] = self.pointer(frame, value)?,
                Holds::Texture => {
                    let bits = self.texture(frame, value).unwrap_or(NONE);
                    self.thread.stack[place] = Slot { bits, ..Slot::default() };
                }
            }
        }
        // What has failed leaves its calls there.
        self.thread.calls.push(self.thread.at);
        let after = After::Call { before: self.thread.control, caller: *frame, result };
        self.call(body, base);
        self.thread.todo.push(Todo { ops: &body.ops, next: 0, after });
        Ok(())
    }

    /// Notes how a condition came out, and returns the decision's node.
    pub(super) fn decide(&mut self, site: u32, condition: Slot) -> u32 {
        let holds = condition.bits != 0;
        let differs = (condition.wide != 0.0) != holds;
        let bit = if (site as usize) < MOST_SITES { 1u128 << site } else { 0 };
        self.outcomes.reached |= bit;
        self.outcomes.taken |= if holds { bit } else { 0 };
        self.outcomes.differs |= if differs { bit } else { 0 };
        let control = self.thread.control;
        self.thread.recording.as_mut().map_or(KNOWN, |recording| {
            let site = site as usize;
            recording.decide(Decision { site, is_taken: holds, differs, condition: condition.from, control })
        })
    }

    pub(super) fn join(&mut self, a: u32, b: u32) -> u32 {
        self.thread.recording.as_mut().map_or(KNOWN, |recording| recording.join(a, b))
    }
}
