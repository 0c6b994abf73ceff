//! The twins, on all cores: the same streams as the GPU executor, one row of texels a ray.

use crate::executor::PassResult;
use crate::numbers::parallel::for_chunks;
use crate::numbers::real::Real;
use crate::plan::{Bytes, Plan};
use crate::programs::closest_hit::kernels::Kernel;
use crate::scene_data::SceneData;
use crate::tables::kernel::Role;
use crate::tables::state::{self, StateCounts};
use crate::tables::stream::{Region, STATE_TAG, STREAMS, Stream, StreamData};
use crate::tables::texels::{Layout, Texels};

/// Runs twins over the rays of a plan.
#[derive(Clone, Debug)]
pub struct CpuExecutor<R: Real> {
    width: u32,
    height: u32,
    layout: Layout,
    texels: Vec<R::Bits>,
    /// Rays in each state, for every [`RAYS_PER_TASK`] rays: a pass leaves out those that have none for it.
    counts: Vec<StateCounts>,
    clock: Option<fn() -> u64>,
}

/// The streams do not fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not enough memory: the streams need {}; use a smaller image", Bytes(*bytes))]
pub struct OutOfMemory {
    /// What they need.
    pub bytes: u64,
}

/// Rays a task: enough work to be worth a hand-over, few enough to balance.
const RAYS_PER_TASK: usize = 512;

impl<R: Real> CpuExecutor<R> {
    /// Takes the memory for the plan's streams; `clock`, in nanoseconds, times passes if there is one.
    ///
    /// # Errors
    /// Where the system has not that much memory.
    pub fn new(plan: &Plan, clock: Option<fn() -> u64>) -> Result<Self, OutOfMemory> {
        let layout = Layout::of(plan.streams.iter().map(|stream| stream.what));
        let rays = plan.width as usize * plan.height as usize;
        let (count, mut texels) = (rays * layout.stride, Vec::new());
        let bytes = (count * size_of::<R::Bits>()) as u64;
        texels.try_reserve_exact(count).map_err(|_| OutOfMemory { bytes })?;
        texels.resize(count, R::Bits::default());
        let counts = vec![StateCounts::default(); rays.div_ceil(RAYS_PER_TASK)];
        let mut executor = Self { width: plan.width, height: plan.height, layout, texels, counts, clock };
        executor.clear();
        Ok(executor)
    }

    /// Every stream to its unwritten value.
    pub fn clear(&mut self) {
        let mut row = vec![R::Bits::default(); self.layout.stride];
        for info in &STREAMS {
            let Some(first) = self.layout.first[info.stream as usize] else { continue };
            for (layer, &bits) in info.unwritten.iter().enumerate() {
                row[first + layer] = Self::from_stream_bits(info.stream, layer, bits);
            }
        }
        let stride = self.layout.stride.max(1);
        for_chunks(&mut self.texels, RAYS_PER_TASK * stride, |_, texels| {
            texels.chunks_exact_mut(stride).for_each(|texel| texel.copy_from_slice(&row));
        });
        self.count();
    }

    fn from_stream_bits(stream: Stream, layer: usize, bits: u32) -> R::Bits {
        if stream.is_float_layer(layer) { R::from_f32(f32::from_bits(bits)).to_bits() } else { R::bits_from_u32(bits) }
    }

    fn to_stream_bits(stream: Stream, layer: usize, bits: R::Bits) -> u32 {
        if stream.is_float_layer(layer) { (R::from_bits(bits).to_f64() as f32).to_bits() } else { R::bits_to_u32(bits) }
    }

    /// Runs one pass over every ray that the kernel works on.
    pub fn run(&mut self, kernel: Kernel, scene: &SceneData) -> PassResult {
        let begin_ns = self.clock.map(|now| now());
        let (twin, layout, stride) = (kernel.twin::<R>(), self.layout, self.layout.stride.max(1));
        let width = self.width as usize;
        let is_first = scene.features.eye_rays && kernel.role() == Role::Whole;
        let tag = self.tag();
        let mut tasks: Vec<(usize, &mut [R::Bits], &mut StateCounts)> = self
            .texels
            .chunks_mut(RAYS_PER_TASK * stride)
            .zip(&mut self.counts)
            .enumerate()
            .filter(|(_, (_, counts))| is_first || kernel.live(counts) > 0)
            .map(|(task, (texels, counts))| (task * RAYS_PER_TASK, texels, counts))
            .collect();
        let threads_launched = tasks.iter().map(|(_, texels, _)| (texels.len() / stride) as u64).sum();
        for_chunks(&mut tasks, 1, |_, tasks| {
            for (first, texels, counts) in tasks {
                **counts = StateCounts::default();
                for (i, row) in texels.chunks_exact_mut(stride).enumerate() {
                    let ray = *first + i;
                    let (x, y) = ((ray % width) as u32, (ray / width) as u32);
                    twin(&mut Texels::new(row, &layout, x, y), scene);
                    if let Some(tag) = tag {
                        counts[(R::bits_to_u32(row[tag]) as usize).min(state::COUNT - 1)] += 1;
                    }
                }
            }
        });
        let duration_ns = begin_ns.zip(self.clock).map(|(begin, now)| now().saturating_sub(begin));
        PassResult { kernel, counts: self.counts(), threads_launched, begin_ns, duration_ns }
    }

    fn tag(&self) -> Option<usize> {
        self.layout.first[Stream::State as usize].map(|first| first + STATE_TAG)
    }

    /// Counts anew, after streams were replaced.
    fn count(&mut self) {
        let (stride, Some(tag)) = (self.layout.stride.max(1), self.tag()) else { return };
        for (texels, counts) in self.texels.chunks(RAYS_PER_TASK * stride).zip(&mut self.counts) {
            *counts = StateCounts::default();
            for row in texels.chunks_exact(stride) {
                counts[(R::bits_to_u32(row[tag]) as usize).min(state::COUNT - 1)] += 1;
            }
        }
    }

    /// How many rays are in each state.
    #[must_use]
    pub fn counts(&self) -> StateCounts {
        let mut sum = StateCounts::default();
        for counts in &self.counts {
            sum.iter_mut().zip(counts).for_each(|(s, n)| *s += n);
        }
        sum
    }

    /// The values of a stream; f64 is rounded to f32. `None` where the plan left it out.
    #[must_use]
    pub fn read(&self, stream: Stream) -> Option<StreamData> {
        self.read_region(stream, Region { x: 0, y: 0, width: self.width, height: self.height })
    }

    /// A part of a stream; `None` where the plan left the stream out or the image has no such part.
    #[must_use]
    pub fn read_region(&self, stream: Stream, region: Region) -> Option<StreamData> {
        let first = self.layout.first[stream as usize].filter(|_| region.is_in(self.width, self.height))?;
        let Region { x, y, width, height } = region;
        let row_words = self.width as usize * self.layout.stride;
        let (begin, end) = (x as usize * self.layout.stride, (x + width) as usize * self.layout.stride);
        let mut bits = Vec::with_capacity(width as usize * height as usize * stream.layers());
        for layer in 0..stream.layers() {
            let rows = self.texels.chunks_exact(row_words).skip(y as usize).take(height as usize);
            let texels = rows.flat_map(|row| row[begin..end].chunks_exact(self.layout.stride));
            bits.extend(texels.map(|texel| Self::to_stream_bits(stream, layer, texel[first + layer])));
        }
        Some(StreamData { stream, width, height, bits })
    }

    /// One ray's texels in some streams; `None` where the plan left one of them out or the image has no such pixel.
    #[must_use]
    pub fn read_texels(&self, streams: &[Stream], x: u32, y: u32) -> Option<Vec<Vec<u32>>> {
        let read = |&stream: &Stream| self.read_region(stream, Region { x, y, width: 1, height: 1 }).map(|d| d.bits);
        streams.iter().map(read).collect()
    }

    /// A float component of a ray at the executor's own precision.
    #[must_use]
    pub fn component(&self, stream: Stream, layer: usize, ray: usize) -> Option<R> {
        let first = self.layout.first[stream as usize]?;
        self.texels.get(ray * self.layout.stride + first + layer).map(|&bits| R::from_bits(bits))
    }

    /// A copy, to come back to.
    pub(crate) fn snapshot(&self) -> Result<Self, OutOfMemory> {
        let mut texels = Vec::new();
        let bytes = self.bytes();
        texels.try_reserve_exact(self.texels.len()).map_err(|_| OutOfMemory { bytes })?;
        texels.extend_from_slice(&self.texels);
        let Self { width, height, layout, texels: _, ref counts, clock } = *self;
        Ok(Self { width, height, layout, texels, counts: counts.clone(), clock })
    }

    /// Back to a copy of an executor of the same plan.
    pub(crate) fn restore(&mut self, snapshot: &Self) {
        self.texels.copy_from_slice(&snapshot.texels);
        self.counts.copy_from_slice(&snapshot.counts);
    }

    /// What the streams take.
    pub(crate) fn bytes(&self) -> u64 {
        size_of_val(self.texels.as_slice()) as u64
    }

    /// Replaces one component of one ray. False where the plan left the stream out or the image has no such pixel.
    pub(crate) fn write_component(&mut self, stream: Stream, layer: usize, x: u32, y: u32, bits: u32) -> bool {
        let is_there = x < self.width && y < self.height && layer < stream.layers();
        let Some(first) = self.layout.first[stream as usize].filter(|_| is_there) else { return false };
        let ray = y as usize * self.width as usize + x as usize;
        self.texels[ray * self.layout.stride + first + layer] = Self::from_stream_bits(stream, layer, bits);
        if stream == Stream::State && layer == STATE_TAG {
            self.count();
        }
        true
    }

    /// Replaces a stream. False where the plan left it out or the size differs.
    pub fn write(&mut self, data: &StreamData) -> bool {
        let Some(first) = self.layout.first[data.stream as usize] else { return false };
        let rays = self.width as usize * self.height as usize;
        if (data.width, data.height) != (self.width, self.height) || data.bits.len() != rays * data.stream.layers() {
            return false;
        }
        for layer in 0..data.stream.layers() {
            for (row, &bits) in self.texels.chunks_exact_mut(self.layout.stride).zip(data.layer(layer)) {
                row[first + layer] = Self::from_stream_bits(data.stream, layer, bits);
            }
        }
        if data.stream == Stream::State {
            self.count();
        }
        true
    }
}
