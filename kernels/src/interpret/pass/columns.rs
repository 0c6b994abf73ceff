//! The streams of a pass, before it and after it.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

use super::group::Stored;
use crate::interpret::code::{NONE, Slot};
use crate::interpret::streams::read;
use crate::interpret::{InterpretError, Interpreter};
use crate::tables::stream::{Stream, StreamData};
use crate::tables::texels::MOST_STREAMS;

/// The streams before a pass. All of their components have consecutive numbers.
pub(in crate::interpret) struct Columns<'a> {
    streams: &'a [StreamData],
    /// The number of each stream's first component.
    first: Vec<usize>,
    /// Where a stream is among them, by its index in the program.
    place: [usize; MOST_STREAMS],
    /// Of streams that are updated in place, the first thread and the last that has loaded a component which it had not
    /// stored itself.
    readers: Vec<Vec<[AtomicU32; 2]>>,
    in_place: Vec<bool>,
}

/// Memory for so many values, if there is as much.
pub(super) fn filled<T: Clone>(value: T, count: usize) -> Result<Vec<T>, InterpretError> {
    let mut all = Vec::new();
    let bytes = (count as u64).saturating_mul(size_of::<T>() as u64);
    all.try_reserve_exact(count).map_err(|_| InterpretError::Memory(bytes))?;
    all.resize(count, value);
    Ok(all)
}

impl<'a> Columns<'a> {
    /// `notes_loads`: to tell later who has loaded what another has stored.
    pub(super) fn new(
        kernel: &Interpreter,
        streams: &'a [StreamData],
        notes_loads: bool,
    ) -> Result<Self, InterpretError> {
        let is_whole = |data: &StreamData| {
            let texels = (data.width as usize).checked_mul(data.height as usize);
            texels.and_then(|texels| texels.checked_mul(data.stream.layers())) == Some(data.bits.len())
        };
        let is_complete = streams.iter().map(|data| data.stream).eq(kernel.streams.iter().copied());
        if !is_complete || !streams.iter().all(is_whole) {
            let given = streams.iter().map(|data| data.stream.layers()).sum();
            return Err(InterpretError::Texels { given, needed: kernel.components() });
        }
        let (mut first, mut place, mut readers, mut in_place) = (vec![0], [0; MOST_STREAMS], Vec::new(), Vec::new());
        for (index, data) in streams.iter().enumerate() {
            place[data.stream.index()] = index;
            first.push(first[index] + data.bits.len());
            let is_kept = kernel.kept.contains(&data.stream);
            in_place.push(is_kept);
            let noted = if is_kept && notes_loads { data.bits.len() } else { 0 };
            let mut of_stream = Vec::new();
            let bytes = 8 * noted as u64;
            of_stream.try_reserve_exact(noted).map_err(|_| InterpretError::Memory(bytes))?;
            of_stream.resize_with(noted, || [AtomicU32::new(NONE), AtomicU32::new(0)]);
            readers.push(of_stream);
        }
        Ok(Self { streams, first, place, readers, in_place })
    }

    fn data(&self, stream: Stream) -> (usize, &'a StreamData) {
        let place = self.place[stream.index()];
        (place, &self.streams[place])
    }

    pub(super) fn size(&self, stream: Stream) -> [u32; 2] {
        let (_, data) = self.data(stream);
        [data.width, data.height]
    }

    pub(super) fn is_in_place(&self, stream: Stream) -> bool {
        self.in_place[self.place[stream.index()]]
    }

    /// The number of a component of a texel, which the stream has.
    pub(super) fn component(&self, stream: Stream, layer: u32, [x, y]: [u32; 2]) -> usize {
        let (place, data) = self.data(stream);
        let (width, height) = (data.width as usize, data.height as usize);
        self.first[place] + (layer as usize * height + y as usize) * width + x as usize
    }

    /// The numbers of the components of a layer.
    pub(super) fn layer(&self, stream: Stream, layer: u32) -> Range<usize> {
        let (_, data) = self.data(stream);
        let first = self.component(stream, layer, [0, 0]);
        first..first + data.width as usize * data.height as usize
    }

    pub(super) fn load(&self, component: usize, stream: Stream, is_float: bool) -> Slot {
        let (place, data) = self.data(stream);
        read(data.bits[component - self.first[place]], is_float)
    }

    pub(super) fn note_load(&self, component: usize, stream: Stream, thread: u32) {
        let place = self.place[stream.index()];
        if let Some([first, last]) = self.readers[place].get(component - self.first[place]) {
            first.fetch_min(thread, Ordering::Relaxed);
            last.fetch_max(thread, Ordering::Relaxed);
        }
    }
}

/// Two threads that have stored different values to a component, or one has loaded what the other has stored.
#[derive(Clone, Copy, Debug)]
pub(super) struct Conflict {
    pub(super) threads: [u32; 2],
    pub(super) stream: Stream,
    pub(super) layer: usize,
    pub(super) texel: [u32; 2],
    /// The statement that stores.
    pub(super) statement: u32,
    pub(super) is_load: bool,
}

/// The thread that wrote a component first, and its value; the thread and the statement that wrote it last.
#[derive(Clone, Copy)]
struct Written {
    first: u32,
    value: u32,
    last: u32,
    statement: u32,
}

impl Written {
    const NOT: Self = Self { first: NONE, value: 0, last: NONE, statement: NONE };
}

/// The streams after a pass.
pub(super) struct After<'a> {
    columns: &'a Columns<'a>,
    /// Those that the kernel writes, each with who wrote its components.
    streams: Vec<Option<(StreamData, Vec<Written>)>>,
    /// The first.
    conflict: Option<Conflict>,
}

impl<'a> After<'a> {
    pub(super) fn new(columns: &'a Columns<'a>, written: &[Stream]) -> Result<Self, InterpretError> {
        let copy = |data: &StreamData| {
            if !written.contains(&data.stream) {
                return Ok(None);
            }
            let mut bits = filled(0, data.bits.len())?;
            bits.copy_from_slice(&data.bits);
            let StreamData { stream, width, height, .. } = *data;
            Ok(Some((StreamData { stream, width, height, bits }, filled(Written::NOT, data.bits.len())?)))
        };
        let streams = columns.streams.iter().map(copy).collect::<Result<_, InterpretError>>()?;
        Ok(Self { columns, streams, conflict: None })
    }

    /// Applies what the threads of a workgroup have stored, in their order.
    pub(super) fn apply(&mut self, first_thread: u32, stored: &[Stored]) {
        for one in stored {
            let place = self.columns.first.partition_point(|&first| first <= one.component) - 1;
            let at = one.component - self.columns.first[place];
            let Some(Some((data, by))) = self.streams.get_mut(place) else { continue };
            let thread = first_thread + one.lane;
            let (value, written) = (one.slot.bits, &mut by[at]);
            if written.first == NONE || written.first == thread {
                (written.first, written.value) = (thread, value);
            } else if written.value != value {
                let conflict = conflict(data, at, [written.first, thread], one.statement, false);
                keep(&mut self.conflict, conflict);
            }
            data.bits[at] = value;
            (written.last, written.statement) = (thread, one.statement);
        }
    }

    /// The streams that were written, and the first conflict.
    pub(super) fn end(mut self) -> (Vec<StreamData>, Option<Conflict>) {
        for (place, after) in self.streams.iter().enumerate() {
            let Some((data, by)) = after else { continue };
            let before = &self.columns.streams[place].bits;
            for (at, readers) in self.columns.readers[place].iter().enumerate() {
                let [first, last] = readers.each_ref().map(|thread| thread.load(Ordering::Relaxed));
                let Written { last: writer, statement, .. } = by[at];
                if first == NONE || writer == NONE || before[at] == data.bits[at] || [first, last] == [writer; 2] {
                    continue;
                }
                let reader = if first == writer { last } else { first };
                keep(&mut self.conflict, conflict(data, at, [reader, writer], statement, true));
            }
        }
        (self.streams.into_iter().flatten().map(|(data, _)| data).collect(), self.conflict)
    }
}

fn conflict(data: &StreamData, at: usize, threads: [u32; 2], statement: u32, is_load: bool) -> Conflict {
    let width = (data.width as usize).max(1);
    let texels = (width * data.height as usize).max(1);
    let (layer, at) = (at / texels, at % texels);
    let texel = [(at % width) as u32, (at / width) as u32];
    Conflict { threads, stream: data.stream, layer, texel, statement, is_load }
}

fn keep(first: &mut Option<Conflict>, found: Conflict) {
    let order = |conflict: &Conflict| {
        let [a, b] = conflict.threads;
        [a.min(b), a.max(b)]
    };
    if first.as_ref().is_none_or(|first| order(&found) < order(first)) {
        *first = Some(found);
    }
}
