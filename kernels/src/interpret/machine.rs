//! Executes statements.

use naga::{Expression, Function, Handle};

use super::code::{Body, Global, If, NONE, Op, Slot, What};
use super::compile::is_invocation;
use super::recording::{Decision, KNOWN, OUTSIDE, Recording};
use super::{Element, InterpretError, Interpreter, MOST_SITES, MOST_STEPS, Outcomes};
use crate::scene_data::SceneData;
use crate::shader::Printed;
use crate::tables::stream::Texel;

/// How a block is left.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Flow {
    Next,
    Break,
    Continue,
    Return,
}

/// A function's call.
#[derive(Clone, Copy)]
pub(super) struct Frame<'a> {
    pub(super) body: &'a Body,
    pub(super) function: &'a Function,
    /// Where its slots begin.
    pub(super) base: usize,
}

/// The state of an interpretation.
pub(super) struct Machine<'a> {
    pub(super) kernel: &'a Interpreter,
    /// The bytes of each global that has some.
    pub(super) bytes: Vec<&'a [u8]>,
    pub(super) stack: Vec<Slot>,
    pub(super) private: Vec<Slot>,
    /// The element's components in the kernel's streams.
    pub(super) row: Vec<Slot>,
    /// Components that were written.
    pub(super) written: Vec<bool>,
    /// The statements that wrote them.
    pub(super) stored: Vec<u32>,
    /// The components before.
    pub(super) before: Vec<u32>,
    pub(super) element: Element,
    returned: Vec<Slot>,
    steps: u64,
    turns: u32,
    /// The statement that was run last.
    pub(super) at: u32,
    /// The statements with the calls that have not returned.
    pub(super) calls: Vec<u32>,
    /// What the element has printed: of each note the last value, and how often.
    pub(super) noted: Vec<Printed>,
    /// How often each statement ran.
    pub(super) runs: Vec<u64>,
    /// The node of the decision that the current statement was reached by.
    pub(super) control: u32,
    pub(super) recording: Option<Recording>,
    pub(super) outcomes: Outcomes,
}

impl<'a> Machine<'a> {
    pub(super) fn new(kernel: &'a Interpreter, data: &'a SceneData, recording: Option<Recording>) -> Self {
        let program = kernel.kernel.program();
        let bytes = kernel.code.globals.iter().map(|global| match global {
            Global::Bytes(name) => program.buffer(name).map_or(&[][..], |buffer| buffer.contents(data)),
            _ => &[],
        });
        Self {
            kernel,
            bytes: bytes.collect(),
            stack: Vec::new(),
            private: Vec::new(),
            row: Vec::new(),
            written: Vec::new(),
            stored: Vec::new(),
            before: Vec::new(),
            element: Element { texel: [0; 2], size: [0; 2] },
            returned: Vec::new(),
            steps: 0,
            turns: 0,
            at: 0,
            calls: Vec::new(),
            noted: vec![([0; 4], 0); kernel.notes.noted.len()],
            runs: vec![0; kernel.code.statements.len()],
            control: KNOWN,
            recording,
            outcomes: Outcomes::default(),
        }
    }

    pub(super) fn run(&mut self, element: Element, texels: &mut [u32]) -> Result<(), InterpretError> {
        let needed = self.kernel.components();
        if texels.len() != needed {
            return Err(InterpretError::Texels { given: texels.len(), needed });
        }
        (self.element, self.control, self.outcomes) = (element, KNOWN, Outcomes::default());
        (self.steps, self.turns) = (0, 0);
        self.calls.clear();
        self.noted.fill(([0; 4], 0));
        self.private.clear();
        self.private.resize(self.kernel.code.private as usize, Slot::default());
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
        let kernel = self.kernel;
        let entry = &kernel.code.bodies[kernel.code.entry];
        let function = self.function(entry);
        self.reserve(entry.frame as usize);
        for (argument, &(place, width)) in function.arguments.iter().zip(&entry.arguments) {
            let id = if is_invocation(argument) { [element.texel[0], element.texel[1], 0] } else { [0; 3] };
            for (i, bits) in id.into_iter().take(width as usize).enumerate() {
                self.stack[place as usize + i] = Slot { bits, from: KNOWN, wide: 0.0 };
            }
        }
        self.call(entry, 0)?;
        for (texel, slot) in texels.iter_mut().zip(&self.row) {
            *texel = slot.bits;
        }
        Ok(())
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
        if self.stack.len() < slots {
            self.stack.resize(slots.next_power_of_two(), Slot::default());
        }
    }

    /// Runs a function whose arguments are in its frame.
    fn call(&mut self, body: &'a Body, base: usize) -> Result<(), InterpretError> {
        let frame = Frame { body, function: self.function(body), base };
        for local in &body.locals {
            let first = base + local.place as usize;
            for i in 0..local.width {
                let value = if local.init == NONE { Slot::default() } else { self.at(&frame, local.init, i) };
                self.stack[first + i as usize] = value;
            }
        }
        self.returned.clear();
        let before = self.control;
        self.block(&frame, &body.ops)?;
        if self.control != before {
            let control = self.control;
            let mut returned = std::mem::take(&mut self.returned);
            returned.iter_mut().for_each(|slot| slot.from = self.join(slot.from, control));
            self.returned = returned;
        }
        self.control = before;
        Ok(())
    }

    fn block(&mut self, frame: &Frame<'a>, ops: &'a [Op]) -> Result<Flow, InterpretError> {
        for op in ops {
            if let Some(recording) = &mut self.recording {
                recording.ran[op.statement as usize] = true;
            }
            self.runs[op.statement as usize] += 1;
            self.at = op.statement;
            self.steps += 1;
            if self.steps > MOST_STEPS {
                return Err(InterpretError::Steps(MOST_STEPS));
            }
            match self.statement(frame, op)? {
                Flow::Next => {}
                flow => return Ok(flow),
            }
        }
        Ok(Flow::Next)
    }

    fn statement(&mut self, frame: &Frame<'a>, op: &'a Op) -> Result<Flow, InterpretError> {
        match &op.what {
            What::Emit(expressions) => {
                self.steps += expressions.len() as u64;
                for &expression in expressions {
                    self.evaluate(frame, expression)?;
                }
            }
            What::Block(ops) => return self.block(frame, ops),
            What::If(branch) => return self.branch(frame, branch),
            What::Switch { site, selector, cases } => {
                let value = self.get(frame, *selector, 0);
                let is_case = |case: &(Option<u32>, Vec<Op>, bool)| case.0 == Some(value.bits);
                let found = cases.iter().position(is_case);
                let bits = u32::from(found.is_some());
                let node = self.decide(*site, Slot { bits, wide: f64::from(bits), ..value });
                self.control = node;
                let first = found.or_else(|| cases.iter().position(|case| case.0.is_none())).unwrap_or(cases.len());
                for (_, ops, falls_through) in cases.iter().skip(first) {
                    match self.block(frame, ops)? {
                        Flow::Break => break,
                        Flow::Next if *falls_through => {}
                        Flow::Next => break,
                        flow => return Ok(flow),
                    }
                }
            }
            What::Loop { body, continuing, break_if } => {
                return self.repeat(frame, op.statement, (body, continuing), *break_if);
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
                self.stored[component] = op.statement;
            }
            What::Call { function, arguments, result } => self.invoke(frame, *function, arguments, *result)?,
            What::Texel(result) => {
                let place = frame.base + frame.body.cells[result.index()].place as usize;
                for (i, bits) in self.element.texel.into_iter().enumerate() {
                    self.stack[place + i] = Slot { bits, from: KNOWN, wide: 0.0 };
                }
            }
            What::Note(index, value) => {
                let width = frame.body.cells[value.index()].width.min(4);
                let values = std::array::from_fn(|lane| match lane as u32 {
                    lane if lane < width => self.get(frame, *value, lane).bits,
                    _ => 0,
                });
                if let Some((last, count)) = self.noted.get_mut(*index) {
                    (*last, *count) = (values, *count + 1);
                }
            }
            What::Assertion(index, condition) => {
                if self.get(frame, *condition, 0).bits == 0 {
                    let label = self.kernel.notes.asserted.get(*index).cloned().unwrap_or_default();
                    return Err(InterpretError::Assertion(label));
                }
            }
            What::Nothing => {}
            What::Unsupported(what) => {
                return Err(InterpretError::Unsupported { what: (*what).into(), line: self.line() });
            }
        }
        Ok(Flow::Next)
    }

    fn branch(&mut self, frame: &Frame<'a>, branch: &'a If) -> Result<Flow, InterpretError> {
        let condition = self.get(frame, branch.condition, 0);
        let node = self.decide(branch.site, condition);
        let before = std::mem::replace(&mut self.control, node);
        let flow = self.block(frame, if condition.bits != 0 { &branch.accept } else { &branch.reject })?;
        if !branch.has_jump {
            self.control = before;
        }
        if self.recording.is_some() {
            for &(place, width) in &branch.writes {
                for at in frame.base + place as usize..frame.base + (place + width) as usize {
                    self.stack[at].from = self.join(self.stack[at].from, node);
                }
            }
        }
        // In f64 the right side would decide, or would not: the whole may come out differently.
        if let Some(result) = branch.result.filter(|_| (condition.wide != 0.0) != (condition.bits != 0)) {
            let place = frame.base + frame.body.locals[result.index()].place as usize;
            self.stack[place].wide = 1.0 - f64::from(self.stack[place].bits);
        }
        Ok(flow)
    }

    fn repeat(
        &mut self,
        frame: &Frame<'a>,
        statement: u32,
        (body, continuing): (&'a [Op], &'a [Op]),
        break_if: Option<(Handle<Expression>, u32)>,
    ) -> Result<Flow, InterpretError> {
        let before = self.control;
        let flow = loop {
            self.turns += 1;
            if self.turns > self.kernel.turns {
                self.at = statement;
                return Err(InterpretError::Turns(self.kernel.turns));
            }
            match self.block(frame, body)? {
                Flow::Next | Flow::Continue => {}
                Flow::Break => break Flow::Next,
                Flow::Return => break Flow::Return,
            }
            self.block(frame, continuing)?;
            if let Some((condition, site)) = break_if {
                let condition = self.get(frame, condition, 0);
                self.decide(site, condition);
                if condition.bits != 0 {
                    break Flow::Next;
                }
            }
        };
        if flow == Flow::Next {
            self.control = before;
        }
        Ok(flow)
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
        for (&value, &(place, width)) in arguments.iter().zip(&body.arguments) {
            for i in 0..width {
                let slot = self.get(frame, value, i);
                self.stack[base + place as usize + i as usize] = slot;
            }
        }
        // What has failed leaves its calls there.
        self.calls.push(self.at);
        self.call(body, base)?;
        self.calls.pop();
        if let Some(result) = result {
            let cell = frame.body.cells[result.index()];
            let place = frame.base + cell.place as usize;
            let count = (cell.width as usize).min(self.returned.len());
            self.stack[place..place + count].copy_from_slice(&self.returned[..count]);
        }
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
        let control = self.control;
        self.recording.as_mut().map_or(KNOWN, |recording| {
            let site = site as usize;
            recording.decide(Decision { site, is_taken: holds, differs, condition: condition.from, control })
        })
    }

    pub(super) fn join(&mut self, a: u32, b: u32) -> u32 {
        self.recording.as_mut().map_or(KNOWN, |recording| recording.join(a, b))
    }
}
