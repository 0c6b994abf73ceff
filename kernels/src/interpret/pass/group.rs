//! What the threads of a workgroup share: its memory, and the streams, each thread with what it has stored itself.

use std::collections::HashMap;
use std::ops::Range;

use naga::{AtomicFunction, Expression, Handle, ScalarKind, TypeInner};

use super::columns::Columns;
use crate::interpret::InterpretError;
use crate::interpret::code::{NONE, Slot};
use crate::interpret::machine::{Frame, Machine};
use crate::interpret::memory::{Place, Root};
use crate::interpret::recording::{KNOWN, OUTSIDE};
use crate::tables::stream::Stream;

/// A component that a thread has stored.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stored {
    pub(super) component: usize,
    pub(super) lane: u32,
    pub(super) slot: Slot,
    pub(super) statement: u32,
}

/// Which threads have accessed a word of the workgroup's memory between two barriers, without atomics.
#[derive(Clone, Copy)]
struct Touch {
    phase: u64,
    writer: u32,
    statement: u32,
    /// Two different ones, if there are as many.
    readers: [u32; 2],
}

impl Touch {
    const NOBODY: Self = Self { phase: 0, writer: NONE, statement: NONE, readers: [NONE; 2] };
}

/// Two threads that have accessed a word of the workgroup's memory between two barriers, one of them by a store.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clash {
    pub(super) lanes: [u32; 2],
    pub(super) word: usize,
    /// The statement that stores.
    pub(super) statement: u32,
}

/// A workgroup that is run.
pub(in crate::interpret) struct Group<'a> {
    pub(super) columns: &'a Columns<'a>,
    memory: Vec<Slot>,
    touches: Vec<Touch>,
    /// Between two barriers.
    phase: u64,
    pub(super) first_thread: u32,
    /// The thread that runs.
    pub(super) lane: u32,
    /// What it has stored, and so have the others.
    pub(super) stored: Vec<Stored>,
    /// What a thread of the workgroup sees of streams that are updated in place: what it has stored itself, and what others
    /// have before the last `textureBarrier`.
    own: Vec<HashMap<usize, Slot>>,
    seen: HashMap<usize, Slot>,
    /// The first.
    pub(super) clash: Option<Clash>,
}

impl<'a> Group<'a> {
    pub(super) fn new(columns: &'a Columns<'a>, threads: u32, words: u32) -> Self {
        Self {
            columns,
            memory: vec![Slot::default(); words as usize],
            touches: vec![Touch::NOBODY; words as usize],
            phase: 0,
            first_thread: 0,
            lane: 0,
            stored: Vec::new(),
            own: vec![HashMap::new(); threads as usize],
            seen: HashMap::new(),
            clash: None,
        }
    }

    /// Forgets the workgroup before.
    pub(super) fn begin(&mut self, first_thread: u32) {
        self.first_thread = first_thread;
        self.memory.fill(Slot::default());
        self.phase += 1;
        self.stored.clear();
        self.own.iter_mut().for_each(HashMap::clear);
        self.seen.clear();
        self.clash = None;
    }

    /// All threads have come to a barrier, which orders accesses of the workgroup's memory, or of textures, or of neither.
    pub(super) fn synchronise(&mut self, memory: bool, textures: bool) {
        self.phase += u64::from(memory);
        if textures {
            for own in &mut self.own {
                self.seen.extend(own.drain());
            }
        }
    }

    /// The workgroup's memory.
    pub(in crate::interpret) fn memory(&self) -> &[Slot] {
        &self.memory
    }

    /// Columns and rows of a stream.
    pub(in crate::interpret) fn size(&self, stream: Stream) -> [u32; 2] {
        self.columns.size(stream)
    }

    /// The component of a layer that a kernel has.
    pub(in crate::interpret) fn component(
        &self,
        stream: Stream,
        layer: u32,
        texel: [u32; 2],
    ) -> Result<usize, InterpretError> {
        let size = self.columns.size(stream);
        for (index, size, what) in [(texel[0], size[0], "columns"), (texel[1], size[1], "rows")] {
            if index >= size {
                let what = format!("the {size} {what} of {}", stream.name());
                return Err(InterpretError::OutOfBounds { index: index.into(), what });
            }
        }
        Ok(self.columns.component(stream, layer, texel))
    }

    pub(in crate::interpret) fn load(&mut self, component: usize, stream: Stream, is_float: bool) -> Slot {
        if self.columns.is_in_place(stream) {
            let own = self.own[self.lane as usize].get(&component).or_else(|| self.seen.get(&component));
            if let Some(slot) = own {
                return *slot;
            }
            self.columns.note_load(component, stream, self.first_thread + self.lane);
        }
        self.columns.load(component, stream, is_float)
    }

    pub(in crate::interpret) fn store(&mut self, component: usize, stream: Stream, slot: Slot, statement: u32) {
        self.stored.push(Stored { component, lane: self.lane, slot, statement });
        if self.columns.is_in_place(stream) {
            self.own[self.lane as usize].insert(component, slot);
        }
    }

    /// What a thread has stored last among these components, and to which of them.
    pub(super) fn stored_by(&self, lane: u32, components: &Range<usize>) -> Option<(usize, u32)> {
        let mut of_thread = self.stored.iter().rev().filter(|stored| stored.lane == lane);
        of_thread
            .find(|stored| components.contains(&stored.component))
            .map(|stored| (stored.component, stored.slot.bits))
    }

    /// Notes an access without atomics.
    fn touch(&mut self, word: usize, is_store: bool, statement: u32) {
        let lane = self.lane;
        let touch = &mut self.touches[word];
        if touch.phase != self.phase {
            *touch = Touch { phase: self.phase, ..Touch::NOBODY };
        }
        let is_other = |other: &u32| *other != NONE && *other != lane;
        let others = [touch.writer, touch.readers[0], touch.readers[1]];
        let other = others[..if is_store { 3 } else { 1 }].iter().copied().find(is_other);
        if let (Some(other), None) = (other, &self.clash) {
            let statement = if is_store { statement } else { touch.statement };
            self.clash = Some(Clash { lanes: [other, lane], word, statement });
        }
        if is_store {
            (touch.writer, touch.statement) = (lane, statement);
        } else if touch.readers[0] == NONE {
            touch.readers[0] = lane;
        } else if touch.readers[0] != lane {
            touch.readers[1] = lane;
        }
    }
}

impl<'a> Machine<'a> {
    pub(in crate::interpret) fn load_shared(&mut self, word: usize, is_atomic: bool) -> Slot {
        let (statement, is_recorded) = (self.thread.at, self.thread.recording.is_some());
        let Some(group) = &mut self.group else { return Slot::default() };
        if !is_atomic {
            group.touch(word, false, statement);
        }
        let slot = group.memory[word];
        // Another thread may have found it.
        Slot { from: if slot.from == KNOWN && is_recorded { OUTSIDE } else { slot.from }, ..slot }
    }

    pub(in crate::interpret) fn store_shared(&mut self, word: usize, slot: Slot, is_atomic: bool) {
        let statement = self.thread.at;
        let Some(group) = &mut self.group else { return };
        if !is_atomic {
            group.touch(word, true, statement);
        }
        group.memory[word] = slot;
    }

    pub(in crate::interpret) fn atomic(
        &mut self,
        frame: &Frame<'a>,
        pointer: Handle<Expression>,
        fun: AtomicFunction,
        value: Handle<Expression>,
        result: Option<Handle<Expression>>,
    ) -> Result<(), InterpretError> {
        let Place { root, inner, from } = self.place(frame, pointer)?;
        let (Root::Workgroup(word), TypeInner::Atomic(scalar)) = (root, inner.get()) else {
            return Err(self.unsupported(frame, pointer, "an atomic operation outside of the workgroup's memory"));
        };
        let kind = scalar.kind;
        if kind == ScalarKind::Float {
            return Err(self.unsupported(frame, pointer, "an atomic operation on floats"));
        }
        let is_signed = kind == ScalarKind::Sint;
        let old = self.load_shared(word, true);
        let given = self.get(frame, value, 0);
        let pick = |is_first: bool| if is_first { old.bits } else { given.bits };
        let is_less = if is_signed { old.bits.cast_signed() < given.bits.cast_signed() } else { old.bits < given.bits };
        let mut has_exchanged = false;
        let bits = match fun {
            AtomicFunction::Add => old.bits.wrapping_add(given.bits),
            AtomicFunction::Subtract => old.bits.wrapping_sub(given.bits),
            AtomicFunction::And => old.bits & given.bits,
            AtomicFunction::ExclusiveOr => old.bits ^ given.bits,
            AtomicFunction::InclusiveOr => old.bits | given.bits,
            AtomicFunction::Min => pick(is_less),
            AtomicFunction::Max => pick(!is_less),
            AtomicFunction::Exchange { compare: None } => given.bits,
            AtomicFunction::Exchange { compare: Some(compare) } => {
                has_exchanged = self.get(frame, compare, 0).bits == old.bits;
                pick(!has_exchanged)
            }
        };
        let from = self.join(old.from, from);
        let stored = self.join(given.from, self.thread.control);
        let both = self.join(from, stored);
        self.store_shared(word, Slot { bits, from: both, wide: 0.0 }, true);
        if let Some(result) = result {
            let cell = frame.body.cells[result.index()];
            let to = frame.base + cell.place as usize;
            self.thread.stack[to] = Slot { from, ..old };
            // Whether it was exchanged is the second member of a structure.
            if cell.width > 1 {
                let wide = f64::from(u8::from(has_exchanged));
                self.thread.stack[to + 1] = Slot { bits: has_exchanged.into(), from, wide };
            }
        }
        Ok(())
    }

    /// Loads what all threads of the workgroup see, behind the barrier that they wait at.
    pub(super) fn load_uniform(
        &mut self,
        pointer: Handle<Expression>,
        result: Handle<Expression>,
    ) -> Result<(), InterpretError> {
        let Some(frame) = self.thread.frame else { return Ok(()) };
        let to = frame.base + frame.body.cells[result.index()].place as usize;
        self.load(&frame, pointer, to)
    }
}
