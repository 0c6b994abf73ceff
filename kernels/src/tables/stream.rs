//! Streams: the values that a program keeps for each of its elements.
//!
//! A stream is a 2D-array texture: one texel per element, one layer per component, `r32float` or `r32uint`. Elements
//! that are pixels of an image have pixel (x, y) in texel (x, y), row 0 at the top; others fill the rows one after the
//! other. A kernel updates its own texel in place.

use std::cmp::Ordering;
use std::fmt;
use std::hash::{Hash, Hasher};

use super::elements::Elements;
use crate::options::reasons::{Reason, Run};

/// Type of a texel's component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Texel {
    /// `r32float`
    F32,
    /// `r32uint`
    U32,
}

/// The meaning of a layer's numbers, which decides how they are compared, printed and coloured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// A float.
    Float,
    /// A float, the t of a ray; [`INF`](crate::shared::constants::INF) stands for no hit, or a plane never reached.
    Distance,
    /// A float: linear light. Three layers of it, the first of a stream, are a colour.
    Light,
    /// A count, or an offset into a list.
    Count,
    /// An id: two of them are equal or different.
    Id,
    /// A state.
    Tag,
}

impl Meaning {
    /// Whether the layer holds a float, directly or as bits.
    #[must_use]
    pub const fn is_float(self) -> bool {
        matches!(self, Self::Float | Self::Distance | Self::Light)
    }
}

/// A row of a program's table of streams.
#[derive(Clone, Copy, Debug)]
pub struct StreamInfo {
    /// Its index in the table.
    pub index: usize,
    /// Its name in WGSL, files and options.
    pub name: &'static str,
    /// The elements that it has texels for.
    pub elements: &'static Elements,
    /// Component type.
    pub texel: Texel,
    /// One name per layer.
    pub layers: &'static [&'static str],
    /// The meaning of each layer's numbers. Floats of a `u32` stream are their bits.
    pub meaning: &'static [Meaning],
    /// Unit of the numbers.
    pub unit: &'static str,
    /// Initial value of each layer (bits), before any kernel has written it.
    pub unwritten: &'static [u32],
    /// Why a run does without it.
    pub why_absent: fn(&Run<'_>) -> Reason,
}

impl StreamInfo {
    /// The names of its layers; of many, the first ten and the last.
    #[must_use]
    pub fn layer_names(&self) -> String {
        match self.layers {
            [first @ .., last] if self.layers.len() > 12 => format!("{} … {last}", first[..10].join(" ")),
            all => all.join(" "),
        }
    }
}

/// Layer with the tag in a program's stream of states.
pub const STATE_TAG: usize = 0;

/// A stream of a program: a row of its table.
#[derive(Clone, Copy)]
pub struct Stream(&'static StreamInfo);

impl Stream {
    /// The stream of a row.
    #[must_use]
    pub const fn of(info: &'static StreamInfo) -> Self {
        Self(info)
    }
    /// Its row of the table.
    #[must_use]
    pub const fn info(self) -> &'static StreamInfo {
        self.0
    }
    /// Its index in its program's table.
    #[must_use]
    pub const fn index(self) -> usize {
        self.0.index
    }
    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.0.name
    }
    /// Components per texel.
    #[must_use]
    pub const fn layers(self) -> usize {
        self.0.layers.len()
    }
    /// Bytes for this many texels on the GPU; `None` if that overflows.
    #[must_use]
    pub fn bytes(self, texels: u64) -> Option<u64> {
        texels.checked_mul(4 * self.layers() as u64)
    }
    /// Whether a layer holds a float, directly or as bits.
    #[must_use]
    pub fn is_float_layer(self, layer: usize) -> bool {
        self.0.meaning.get(layer).is_some_and(|meaning| meaning.is_float())
    }
    /// Whether its first three layers are a colour.
    #[must_use]
    pub fn is_color(self) -> bool {
        matches!(self.0.meaning, [Meaning::Light, Meaning::Light, Meaning::Light, ..])
    }
}

impl PartialEq for Stream {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.0, other.0)
    }
}

impl Eq for Stream {}

impl PartialOrd for Stream {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Stream {
    /// In table order; the order between streams of different programs is arbitrary.
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |stream: &Self| (stream.0.index, std::ptr::from_ref(stream.0).addr());
        key(self).cmp(&key(other))
    }
}

impl Hash for Stream {
    fn hash<H: Hasher>(&self, state: &mut H) {
        std::ptr::from_ref(self.0).hash(state);
    }
}

impl fmt::Debug for Stream {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for Stream {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// A layer of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Component {
    /// The stream.
    pub stream: Stream,
    /// The layer.
    pub layer: usize,
}

/// A region of an image, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
}

impl Region {
    /// Whether it is not empty, and inside an image of this size.
    #[must_use]
    pub fn is_in(&self, width: u32, height: u32) -> bool {
        let fits =
            |first: u32, count: u32, all: u32| count > 0 && first.checked_add(count).is_some_and(|end| end <= all);
        fits(self.x, self.width, width) && fits(self.y, self.height, height)
    }
}

/// The values of a stream, or of a region of it, after some pass: layer-major, then rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StreamData {
    /// Which stream.
    pub stream: Stream,
    /// Texels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `layers * height * width` components, floats as bits.
    pub bits: Vec<u32>,
}

impl StreamData {
    /// One component of ray `index` (= y * width + x).
    #[must_use]
    pub fn get(&self, layer: usize, index: usize) -> u32 {
        self.bits[layer * (self.width as usize * self.height as usize) + index]
    }
    /// One component as f32.
    #[must_use]
    pub fn get_f32(&self, layer: usize, index: usize) -> f32 {
        f32::from_bits(self.get(layer, index))
    }
    /// All components of one layer.
    #[must_use]
    pub fn layer(&self, layer: usize) -> &[u32] {
        let n = self.width as usize * self.height as usize;
        &self.bits[layer * n..(layer + 1) * n]
    }
}

/// Defines a program's table of streams, and a constant for each of them.
macro_rules! streams {
    ($($(#[doc = $doc:literal])* $stream:ident of $elements:ident: $name:literal $texel:ident $layers:expr, meaning: $meaning:expr, unit: $unit:literal, unwritten: $unwritten:expr, why_absent: $why:expr;)*) => {
        #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
        enum Index { $($stream),* }

        /// Every stream.
        pub static STREAMS: [$crate::tables::stream::StreamInfo; [$(Index::$stream as usize),*].len()] =
            [$($crate::tables::stream::StreamInfo {
                index: Index::$stream as usize,
                name: $name,
                elements: &$elements,
                texel: $crate::tables::stream::Texel::$texel,
                layers: $layers,
                meaning: $meaning,
                unit: $unit,
                unwritten: $unwritten,
                why_absent: $why,
            }),*];

        $($(#[doc = $doc])* pub const $stream: Stream = Stream::of(&STREAMS[Index::$stream as usize]);)*
    };
}
pub(crate) use streams;
