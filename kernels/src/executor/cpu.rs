//! Runs the twins (CPU reference kernels) on all cores, over the same streams as the GPU executor, stored as one row of
//! texels per element.

mod columns;
mod elements;
mod guest;
mod interpreted;
mod rows;

use std::sync::Arc;

use crate::executor::PassResult;
use crate::executor::sizes::{Sizes, TooMany};
use crate::numbers::parallel::for_chunks;
use crate::plan::Plan;
use crate::program::kernel::Precision;
use crate::program::schedule::Call;
use crate::program::{Course, Twin};
use crate::scene_data::SceneData;
use crate::tables::elements::{Elements, Size};
use crate::tables::state::StateCounts;
use crate::tables::stream::{Region, STATE_TAG, Stream, StreamData};
use crate::tables::texels::{Layout, MOST_STREAMS};
pub use guest::Failed;
pub(crate) use guest::{Interpreted, OnElement};
pub use interpreted::RaceFound;
#[cfg(test)]
pub(crate) use interpreted::tests::agree;
pub use rows::OutOfMemory;
use rows::{Rows, count_tags};
pub(crate) use rows::{from_stream_bits, to_stream_bits};

/// Runs twins over the elements of a plan.
#[derive(Clone, Debug)]
pub struct CpuExecutor<R: Precision> {
    plan: Arc<Plan>,
    sizes: Sizes,
    /// One per set of elements, in the program's order.
    rows: Vec<Rows<R>>,
    /// The set of each stream, by the stream's index.
    set_of: [usize; MOST_STREAMS],
    /// Elements in each state, for each course and every block of [`ELEMENTS_PER_TASK`] of its elements: a pass skips tasks
    /// without elements in the kernel's states.
    counts: Vec<Vec<StateCounts>>,
    clock: Option<fn() -> u64>,
    /// The kernels that are users'.
    interpreted: Arc<[Interpreted]>,
    /// The first race that one of them has shown.
    race: Option<RaceFound>,
}

/// Why twins cannot run.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CpuError {
    /// The streams do not fit in memory.
    #[error(transparent)]
    Memory(#[from] OutOfMemory),
    /// The run has found more elements than fit.
    #[error(transparent)]
    TooMany(#[from] TooMany),
    /// A user's kernel failed.
    #[error(transparent)]
    Failed(#[from] Failed),
}

/// Elements per task: enough work to be worth scheduling, few enough to balance the load.
const ELEMENTS_PER_TASK: usize = 512;

/// A task's first element, its texels, and its counts if its elements have states.
type Task<'a, T> = (usize, &'a mut [T], Option<&'a mut StateCounts>);

impl<R: Precision> CpuExecutor<R> {
    /// Allocates the plan's streams. `clock`, in nanoseconds, times the passes if there is one.
    ///
    /// # Errors
    /// If the system does not have that much memory.
    pub fn new(plan: &Arc<Plan>, clock: Option<fn() -> u64>) -> Result<Self, OutOfMemory> {
        let sizes = Sizes::new(plan);
        let mut rows = Vec::new();
        for elements in plan.program.elements {
            let own = plan.streams.iter().map(|s| s.what).filter(|s| s.info().elements.name == elements.name);
            let mut own = Rows { layout: Layout::of(plan.program.streams, own), size: None, texels: Vec::new() };
            own.resize(sizes.of(plan.program, elements))?;
            rows.push(own);
        }
        let mut set_of = [0; MOST_STREAMS];
        for stream in plan.program.streams() {
            let set = plan.program.elements.iter().position(|e| e.name == stream.info().elements.name);
            set_of[stream.index()] = set.unwrap_or(0);
        }
        let interpreted = Interpreted::of(plan).into();
        let mut executor =
            Self { plan: plan.clone(), sizes, rows, set_of, counts: Vec::new(), clock, interpreted, race: None };
        executor.clear();
        Ok(executor)
    }

    /// Resets every stream to its unwritten value, and forgets the sizes of all sets that the run has counted.
    pub fn clear(&mut self) {
        // Cannot fail: it never needs more memory than before.
        let _: Result<(), OutOfMemory> = self.resize(Sizes::new(&self.plan));
        self.race = None;
        let streams: Vec<Stream> = self.plan.streams.iter().map(|s| s.what).collect();
        self.rows.iter_mut().for_each(|rows| rows.clear(&streams));
        self.count();
    }

    /// The current size of each set.
    pub(crate) fn sizes(&self) -> Sizes {
        self.sizes.clone()
    }

    /// Resizes the sets of elements.
    pub(crate) fn resize(&mut self, sizes: Sizes) -> Result<(), OutOfMemory> {
        let streams: Vec<Stream> = self.plan.streams.iter().map(|s| s.what).collect();
        let mut is_other = false;
        for (rows, elements) in self.rows.iter_mut().zip(self.plan.program.elements) {
            let size = sizes.of(self.plan.program, elements);
            if rows.size != size {
                is_other = true;
                rows.resize(size)?;
                rows.clear(&streams);
            }
        }
        self.sizes = sizes;
        if is_other {
            self.count();
        }
        Ok(())
    }

    /// The size of a set and its layout in the streams; `None` while it is unknown.
    #[must_use]
    pub fn size(&self, elements: &Elements) -> Option<Size> {
        self.sizes.of(self.plan.program, elements)
    }

    /// Whether a stream belongs to this run's program.
    fn is_known(&self, stream: Stream) -> bool {
        self.plan.program.streams.get(stream.index()).is_some_and(|info| Stream::of(info) == stream)
    }

    /// The rows of the set that a stream belongs to, and the stream's offset in a row; `None` if the plan left the
    /// stream out.
    fn rows_of(&self, stream: Stream) -> Option<(&Rows<R>, usize)> {
        self.is_known(stream).then_some(())?;
        let rows = &self.rows[self.set_of[stream.index()]];
        rows.layout.first[stream.index()].map(|first| (rows, first))
    }

    fn rows_of_mut(&mut self, stream: Stream) -> Option<(&mut Rows<R>, usize)> {
        self.is_known(stream).then_some(())?;
        let rows = &mut self.rows[self.set_of[stream.index()]];
        rows.layout.first[stream.index()].map(|first| (rows, first))
    }

    /// The rows of one stream.
    fn rows_alone(&self, stream: Stream) -> Vec<R::Bits> {
        let Some((rows, first)) = self.rows_of(stream) else { return Vec::new() };
        let own = first..first + stream.layers();
        rows.texels.chunks_exact(rows.layout.stride.max(1)).flat_map(|row| &row[own.clone()]).copied().collect()
    }

    fn put_rows(&mut self, stream: Stream, own: &[R::Bits]) {
        let Some((rows, first)) = self.rows_of_mut(stream) else { return };
        let stride = rows.layout.stride.max(1);
        for (row, own) in rows.texels.chunks_exact_mut(stride).zip(own.chunks_exact(stream.layers())) {
            row[first..first + own.len()].copy_from_slice(own);
        }
    }

    /// Runs one pass over every element that the kernel works on.
    ///
    /// # Errors
    /// If the run has found more elements than fit.
    pub fn run(&mut self, call: Call, scene: &SceneData) -> Result<PassResult, CpuError> {
        let kernel = call.kernel;
        let scene = &*kernel.reads(scene);
        let mut sizes = self.sizes.clone();
        sizes.renew(self.plan.program, kernel);
        let adopted = sizes.adopt(self.plan.program, kernel)?;
        while let Some(unknown) = sizes.unknown(&self.plan, kernel) {
            let count = |(rows, first): (&Rows<R>, usize)| rows.texels.get(first + unknown.layer).copied();
            let count = self.rows_of(unknown.stream).and_then(count);
            sizes.found(self.plan.program, unknown, count.map_or(0, R::bits_to_u32))?;
        }
        let adopted: Vec<_> = adopted.into_iter().map(|(to, from)| (to, self.rows_alone(from))).collect();
        self.resize(sizes)?;
        adopted.into_iter().for_each(|(stream, rows)| self.put_rows(stream, &rows));
        let copied = kernel.instance().copies.iter().map(|&(to, from)| (to, self.rows_alone(from)));
        let copied: Vec<_> = copied.collect();
        copied.into_iter().for_each(|(stream, rows)| self.put_rows(stream, &rows));
        let begin_ns = self.clock.map(|now| now());
        let threads_launched = match kernel.info().twin {
            Twin::Element { .. } => self.run_elements(kernel, scene)?,
            Twin::Pass(_) if Interpreted::find(&self.interpreted, kernel).is_some() => {
                self.run_interpreted(call, scene)?
            }
            Twin::Pass(twin) => {
                twin(&mut columns::All(self, call), scene);
                if kernel.course().is_some() {
                    self.count();
                }
                u64::from(self.size(kernel.instance().over).map_or(0, |size| size.count))
            }
            Twin::Interpreted => self.run_interpreted(call, scene)?,
        };
        let duration_ns = begin_ns.zip(self.clock).map(|(begin, now)| now().saturating_sub(begin));
        let elements = self.size(kernel.instance().over).map_or(0, |size| size.count);
        let (counts, sizes, rounding) = (self.counts(), self.sizes.counts(), None);
        let (counts, is_active, encode_ns, draws) = (Some(counts), None, None, Vec::new());
        Ok(PassResult {
            kernel,
            counts,
            sizes,
            is_active,
            elements,
            threads_launched,
            encode_ns,
            begin_ns,
            duration_ns,
            rounding,
            draws,
        })
    }

    /// Where the tag is in a row of a course's elements; `None` if the plan left the states out.
    fn tag(&self, course: &Course) -> Option<usize> {
        self.rows_of(course.stream).map(|(_, first)| first + STATE_TAG)
    }

    /// Recounts the elements in each state, after streams were replaced.
    fn count(&mut self) {
        let program = self.plan.program;
        let count = |course: &Course| {
            let (Some((rows, _)), Some(tag)) = (self.rows_of(course.stream), self.tag(course)) else {
                return Vec::new();
            };
            let stride = rows.layout.stride.max(1);
            let tasks = rows.texels.chunks(ELEMENTS_PER_TASK * stride);
            tasks.map(|texels| count_tags::<R>(texels, stride, tag, program.states)).collect()
        };
        self.counts = program.courses.iter().map(count).collect();
    }

    /// Number of elements in each state.
    #[must_use]
    pub fn counts(&self) -> StateCounts {
        let mut sum = StateCounts::none(self.plan.program.states);
        for counts in self.counts.iter().flatten() {
            sum.iter_mut().zip(counts).for_each(|(s, n)| *s += n);
        }
        sum
    }

    /// The values of a stream; f64 is rounded to f32. `None` if the plan left it out.
    #[must_use]
    pub fn read(&self, stream: Stream) -> Option<StreamData> {
        let Size { width, height, .. } = self.rows_of(stream)?.0.size?;
        self.read_region(stream, Region { x: 0, y: 0, width, height })
    }

    /// A region of a stream; `None` if the plan left the stream out or the region lies outside of it.
    #[must_use]
    pub fn read_region(&self, stream: Stream, region: Region) -> Option<StreamData> {
        let (rows, first) = self.rows_of(stream)?;
        let size = rows.size.filter(|size| region.is_in(size.width, size.height))?;
        let Region { x, y, width, height } = region;
        let stride = rows.layout.stride;
        let row_words = size.width as usize * stride;
        let (begin, end) = (x as usize * stride, (x + width) as usize * stride);
        let mut bits = Vec::with_capacity(width as usize * height as usize * stream.layers());
        for layer in 0..stream.layers() {
            // A row at a time: its length is known, and none of its texels is checked for room.
            for row in rows.texels.chunks_exact(row_words).skip(y as usize).take(height as usize) {
                let texels = row[begin..end].chunks_exact(stride);
                bits.extend(texels.map(|texel| to_stream_bits::<R>(stream, layer, texel[first + layer])));
            }
        }
        Some(StreamData { stream, width, height, bits })
    }

    /// One element's texels in several streams; `None` if the plan left one of them out or there is no such texel.
    #[must_use]
    pub fn read_texels(&self, streams: &[Stream], x: u32, y: u32) -> Option<Vec<Vec<u32>>> {
        let read = |&stream: &Stream| self.read_region(stream, Region { x, y, width: 1, height: 1 }).map(|d| d.bits);
        streams.iter().map(read).collect()
    }

    /// A float component of an element in the executor's own precision.
    #[must_use]
    pub fn component(&self, stream: Stream, layer: usize, element: usize) -> Option<R> {
        let (rows, first) = self.rows_of(stream)?;
        rows.texels.get(element * rows.layout.stride + first + layer).map(|&bits| R::from_bits(bits))
    }

    /// A copy of all streams, for [`Self::restore`].
    pub(crate) fn snapshot(&self) -> Result<Self, OutOfMemory> {
        let bytes = self.bytes();
        let copy = |rows: &Rows<R>| {
            let mut texels = Vec::new();
            texels.try_reserve_exact(rows.texels.len()).map_err(|_| OutOfMemory { bytes })?;
            texels.extend_from_slice(&rows.texels);
            Ok(Rows { layout: rows.layout, size: rows.size, texels })
        };
        let rows = self.rows.iter().map(copy).collect::<Result<_, _>>()?;
        let (plan, sizes, counts) = (self.plan.clone(), self.sizes.clone(), self.counts.clone());
        let (interpreted, race) = (self.interpreted.clone(), self.race.clone());
        Ok(Self { plan, sizes, rows, set_of: self.set_of, counts, clock: self.clock, interpreted, race })
    }

    /// Restores a copy made by an executor of the same plan.
    pub(crate) fn restore(&mut self, snapshot: &Self) -> Result<(), OutOfMemory> {
        self.resize(snapshot.sizes.clone())?;
        for (rows, kept) in self.rows.iter_mut().zip(&snapshot.rows) {
            rows.texels.copy_from_slice(&kept.texels);
        }
        self.counts.clone_from(&snapshot.counts);
        Ok(())
    }

    /// Bytes of all streams.
    pub(crate) fn bytes(&self) -> u64 {
        self.rows.iter().map(|rows| size_of_val(rows.texels.as_slice()) as u64).sum()
    }

    /// Replaces one component of one element. Returns false if the plan left the stream out or it has no such texel.
    pub(crate) fn write_component(&mut self, stream: Stream, layer: usize, x: u32, y: u32, bits: u32) -> bool {
        let Some((rows, first)) = self.rows_of_mut(stream) else { return false };
        let Some(size) = rows.size.filter(|s| x < s.width && y < s.height && layer < stream.layers()) else {
            return false;
        };
        let element = y as usize * size.width as usize + x as usize;
        rows.texels[element * rows.layout.stride + first + layer] = from_stream_bits::<R>(stream, layer, bits);
        if self.plan.program.has_states(stream) && layer == STATE_TAG {
            self.count();
        }
        true
    }

    /// Replaces a stream. Returns false if the plan left it out or the size differs.
    pub fn write(&mut self, data: &StreamData) -> bool {
        let stream = data.stream;
        let Some((rows, first)) = self.rows_of_mut(stream) else { return false };
        let is_same = |size: &Size| {
            (data.width, data.height) == (size.width, size.height)
                && data.bits.len() as u64 == size.texels() * stream.layers() as u64
        };
        if !rows.size.as_ref().is_some_and(is_same) {
            return false;
        }
        let layers: Vec<&[u32]> = (0..stream.layers()).map(|layer| data.layer(layer)).collect();
        let stride = rows.layout.stride;
        for_chunks(&mut rows.texels, ELEMENTS_PER_TASK * stride, |begin, texels| {
            for (row, element) in texels.chunks_exact_mut(stride).zip(begin / stride..) {
                for (layer, bits) in layers.iter().enumerate() {
                    row[first + layer] = from_stream_bits::<R>(stream, layer, bits[element]);
                }
            }
        });
        if self.plan.program.has_states(stream) {
            self.count();
        }
        true
    }
}

#[cfg(test)]
mod tests;
