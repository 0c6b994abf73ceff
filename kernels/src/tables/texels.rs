//! The texels of one ray, as a CPU kernel reads and writes them.

use crate::numbers::real::{Real, Vec3};
use crate::tables::stream::Stream;

/// Most streams of a program.
pub const MOST_STREAMS: usize = 32;

/// Where the components of each stream lie in a ray's row of texels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    /// Index of each stream's first component; `None` for a stream that the plan left out.
    pub(crate) first: [Option<usize>; MOST_STREAMS],
    /// Components of a row.
    pub(crate) stride: usize,
}

impl Layout {
    /// These streams, side by side.
    pub(crate) fn of(streams: impl Iterator<Item = Stream>) -> Self {
        let mut layout = Self { first: [None; MOST_STREAMS], stride: 0 };
        for stream in streams {
            layout.first[stream.index()] = Some(layout.stride);
            layout.stride += stream.layers();
        }
        layout
    }
}

/// The texels of one ray in every stream.
pub struct Texels<'a, R: Real> {
    row: &'a mut [R::Bits],
    layout: &'a Layout,
    /// Column of the ray's pixel.
    pub x: u32,
    /// Row of the ray's pixel, 0 at the top.
    pub y: u32,
}

impl<'a, R: Real> Texels<'a, R> {
    /// Of the ray at column `x` and row `y`, whose components are `row`.
    pub(crate) fn new(row: &'a mut [R::Bits], layout: &'a Layout, x: u32, y: u32) -> Self {
        Self { row, layout, x, y }
    }
    fn index(&self, stream: Stream, layer: usize) -> usize {
        // A stream that the plan left out is never asked for: the twins branch on the same options.
        self.layout.first[stream.index()].map_or(usize::MAX, |first| first + layer)
    }
    /// A float component.
    #[must_use]
    pub fn load(&self, stream: Stream, layer: usize) -> R {
        R::from_bits(self.row[self.index(stream, layer)])
    }
    /// An integer component.
    #[must_use]
    pub fn load_u32(&self, stream: Stream, layer: usize) -> u32 {
        R::bits_to_u32(self.row[self.index(stream, layer)])
    }
    /// Three float components.
    #[must_use]
    pub fn load_vec3(&self, stream: Stream) -> Vec3<R> {
        Vec3::new(self.load(stream, 0), self.load(stream, 1), self.load(stream, 2))
    }
    /// Stores a float component.
    pub fn store(&mut self, stream: Stream, layer: usize, value: R) {
        let i = self.index(stream, layer);
        self.row[i] = value.to_bits();
    }
    /// Stores an integer component.
    pub fn store_u32(&mut self, stream: Stream, layer: usize, value: u32) {
        let i = self.index(stream, layer);
        self.row[i] = R::bits_from_u32(value);
    }
    /// Stores three float components.
    pub fn store_vec3(&mut self, stream: Stream, value: Vec3<R>) {
        self.store(stream, 0, value.x);
        self.store(stream, 1, value.y);
        self.store(stream, 2, value.z);
    }
}

/// The streams of a run, as a CPU kernel reads and writes them whose elements look at each other. What is left out, or
/// lies beyond a set's end, reads as 0 and is not written.
pub trait Columns {
    /// How many elements a stream has a texel for.
    fn len(&self, stream: Stream) -> usize;
    /// An integer component.
    fn load(&self, stream: Stream, layer: usize, element: usize) -> u32;
    /// Stores an integer component.
    fn store(&mut self, stream: Stream, layer: usize, element: usize, value: u32);
}
