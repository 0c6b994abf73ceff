//! The texels of one ray, for a twin to read and write.

use crate::numbers::real::{Real, Vec3};
use crate::tables::stream::{Stream, StreamInfo};

/// Most streams of a program.
pub const MOST_STREAMS: usize = 96;

/// Layout of the streams' components in a ray's row of texels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    /// Index of each stream's first component; `None` for a stream that the plan left out.
    pub(crate) first: [Option<usize>; MOST_STREAMS],
    /// Components per row.
    pub(crate) stride: usize,
    /// The table of the streams, whose indices `first` has.
    pub(crate) table: &'static [StreamInfo],
}

impl Layout {
    /// The layout of these streams of a program's table, side by side.
    pub(crate) fn of(table: &'static [StreamInfo], streams: impl Iterator<Item = Stream>) -> Self {
        let mut layout = Self { first: [None; MOST_STREAMS], stride: 0, table };
        for stream in streams {
            layout.first[stream.index()] = Some(layout.stride);
            layout.stride += stream.layers();
        }
        layout
    }
}

/// That of no streams.
static NO_STREAMS: Layout = Layout { first: [None; MOST_STREAMS], stride: 0, table: &[] };

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
    /// The ray at column `x` and row `y`, whose components are `row`.
    pub(crate) fn new(row: &'a mut [R::Bits], layout: &'a Layout, x: u32, y: u32) -> Self {
        Self { row, layout, x, y }
    }

    /// A ray without streams, for what keeps it in registers.
    pub(crate) fn none() -> Self {
        Self { row: &mut [], layout: &NO_STREAMS, x: 0, y: 0 }
    }

    fn index(&self, stream: Stream, layer: usize) -> usize {
        debug_assert!(
            self.layout.table.get(stream.index()).is_some_and(|info| Stream::of(info) == stream),
            "{stream:?}"
        );
        // A stream that the plan left out is never accessed: the twins branch on the same options.
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

/// The streams of a run, for twins whose elements read each other. Streams that were left out, and elements beyond a
/// set's end, read as 0 and are not written.
pub trait Columns: Sync {
    /// The stream that is bound to a name in the kernel's WGSL.
    fn stream(&self, name: &str) -> Option<Stream>;
    /// The value of `launch.parameter`.
    fn parameter(&self) -> u32;
    /// Number of elements that a stream has texels for.
    fn len(&self, stream: Stream) -> usize;
    /// An integer component.
    fn load(&self, stream: Stream, layer: usize, element: usize) -> u32;
    /// Stores an integer component.
    fn store(&mut self, stream: Stream, layer: usize, element: usize, value: u32);
}
