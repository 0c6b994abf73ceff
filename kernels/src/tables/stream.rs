//! Every per-ray stream, in one table.
//!
//! A stream is a 2D-array texture: one texel a ray, one layer a component, `r32float` or `r32uint`.
//! Pixel (x, y) is texel (x, y); row 0 is at the top. A kernel updates its own texel in place.
//!
//! ```text
//! ray_origin    f32  x  y  z             traced units
//! ray_direction f32  x  y  z             traced units per unit of t; not normalised
//! state         u32  tag  nearest-t  cell  item      while lights are summed: item is 2³¹ + how many
//! tmax          f32  x  y  z             t
//! previous      u32  node                index of the tree's node before this one
//! hit           u32  u  v  triangle      u, v as f32 bits
//! color         f32  r  g  b             linear light
//! counters      u32  cells  triangles  repeated
//! accumulated   f32  r  g  b  a  samples mean so far, linear light; a: share of samples that hit
//! place         u32  x  y  z  left  tx  ty  tz   cell, cells still allowed, tmax (f32 bits)
//! trail         u32  levels 0, 8, 16, 24  4 bits a level
//! scan          u32  cell  tx  ty  tz    cell, tmax (f32 bits)
//! ```
//!
//! Lengths are in *traced units*: scene units times a power of two, see [`crate::numbers::units`]. `t` is the
//! parameter of `origin + t * direction`; a camera's direction has length 1 along the view axis, so t
//! of a primary ray is its depth.
//!
//! The last three are what a ray needs to go on in the next dispatch, where a walk or a search may take more loop turns
//! than one dispatch has (see [`crate::plan::Limits`]).
//!
//! With several samples a pixel, every sample's ray uses the same texels: all streams but `accumulated` hold the
//! latest sample's, at the end of a run the last one's. Only `color` is given the mean then.

use serde::{Deserialize, Serialize};

use crate::shared::constants::{INF, NO_CELL, NO_NODE, NO_TRIANGLE};

/// A per-ray stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stream {
    /// Where the ray starts.
    RayOrigin,
    /// Where it goes.
    RayDirection,
    /// Tag, nearest t, cell, item offset.
    State,
    /// t at which the ray leaves its cell, per axis.
    #[serde(rename = "tmax")]
    TMax,
    /// Node visited before this one.
    Previous,
    /// Barycentrics and triangle of the nearest hit.
    Hit,
    /// Shaded colour.
    Color,
    /// Cells visited, triangles tested, repeated tests.
    Counters,
    /// Mean colour and coverage of the samples so far, and their number.
    Accumulated,
    /// Where in the grid a ray waits for the next dispatch of `fused`, where that does not follow from its cell.
    Place,
    /// Where in the wide tree it does: the child entered last on each level.
    Trail,
    /// Where the search for repeated tests waits for the next dispatch.
    Scan,
}

/// What a texel component is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Texel {
    /// `r32float`
    F32,
    /// `r32uint`
    U32,
}

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct StreamInfo {
    /// Which stream.
    pub stream: Stream,
    /// Its name in WGSL, files and options.
    pub name: &'static str,
    /// Component type.
    pub texel: Texel,
    /// One name a layer.
    pub layers: &'static [&'static str],
    /// Layers of a `u32` stream that hold f32 bits.
    pub float_layers: &'static [usize],
    /// Unit of the numbers.
    pub unit: &'static str,
    /// What each layer holds before any kernel has written it (bits).
    pub unwritten: &'static [u32],
}

const fn row(
    stream: Stream,
    name: &'static str,
    texel: Texel,
    layers: &'static [&'static str],
    float_layers: &'static [usize],
    unit: &'static str,
    unwritten: &'static [u32],
) -> StreamInfo {
    StreamInfo { stream, name, texel, layers, float_layers, unit, unwritten }
}

/// Layer of the `state` stream: the tag.
pub const STATE_TAG: usize = 0;
/// Layer of the `state` stream: bits of the nearest t so far, [`INF`] without a hit.
pub const STATE_T: usize = 1;
/// Layer of the `state` stream: 1-D index of the cell, or index of the node.
pub const STATE_CELL: usize = 2;
/// Layer of the `state` stream: offset into the cell's or leaf's triangle list.
pub const STATE_ITEM: usize = 3;
/// Layer of the `hit` stream: the triangle, [`NO_TRIANGLE`] without a hit.
pub const HIT_TRIANGLE: usize = 2;
/// Layer of the `accumulated` stream: the samples in the mean; exact, as a float counts to 2²⁴.
pub const ACCUMULATED_SAMPLES: usize = 4;

/// Every stream.
pub const STREAMS: [StreamInfo; 12] = [
    row(Stream::RayOrigin, "ray_origin", Texel::F32, &["x", "y", "z"], &[], "traced units", &[0; 3]),
    row(Stream::RayDirection, "ray_direction", Texel::F32, &["x", "y", "z"], &[], "traced units per t", &[0; 3]),
    row(
        Stream::State,
        "state",
        Texel::U32,
        &["tag", "t", "cell", "item"],
        &[STATE_T],
        "tag, t as f32 bits, 1-D index, count",
        &[0, INF.to_bits(), 0, 0],
    ),
    row(Stream::TMax, "tmax", Texel::F32, &["x", "y", "z"], &[], "t", &[0; 3]),
    row(Stream::Previous, "previous", Texel::U32, &["node"], &[], "index of a node", &[NO_NODE]),
    row(
        Stream::Hit,
        "hit",
        Texel::U32,
        &["u", "v", "triangle"],
        &[0, 1],
        "barycentric weights of vertices 1 and 2 as f32 bits, triangle id",
        &[0, 0, NO_TRIANGLE],
    ),
    row(Stream::Color, "color", Texel::F32, &["r", "g", "b"], &[], "linear light", &[0; 3]),
    row(Stream::Counters, "counters", Texel::U32, &["cells", "triangles", "repeated"], &[], "count", &[0; 3]),
    row(
        Stream::Accumulated,
        "accumulated",
        Texel::F32,
        &["r", "g", "b", "a", "samples"],
        &[],
        "linear light, share of samples that hit, count",
        &[0; 5],
    ),
    row(
        Stream::Place,
        "place",
        Texel::U32,
        &["x", "y", "z", "left", "tmax_x", "tmax_y", "tmax_z"],
        &[4, 5, 6],
        "cell coordinates, count of cells, t as f32 bits",
        &[0; 7],
    ),
    row(
        Stream::Trail,
        "trail",
        Texel::U32,
        &["levels_0", "levels_8", "levels_16", "levels_24"],
        &[],
        "child entered last, 4 bits per level",
        &[0; 4],
    ),
    row(
        Stream::Scan,
        "scan",
        Texel::U32,
        &["cell", "tmax_x", "tmax_y", "tmax_z"],
        &[1, 2, 3],
        "1-D index, t as f32 bits",
        &[NO_CELL, 0, 0, 0],
    ),
];

/// The streams that rays from outside begin with.
pub const INPUTS: [Stream; 3] = [Stream::RayOrigin, Stream::RayDirection, Stream::State];

impl Stream {
    /// Its row of the table.
    #[must_use]
    pub const fn info(self) -> &'static StreamInfo {
        &STREAMS[self as usize]
    }
    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.info().name
    }
    /// Components a texel.
    #[must_use]
    pub const fn layers(self) -> usize {
        self.info().layers.len()
    }
    /// The stream with this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        STREAMS.iter().find(|s| s.name == name).map(|s| s.stream)
    }
    /// Bytes for `rays` rays on the GPU; `None` where that overflows.
    #[must_use]
    pub fn bytes(self, rays: u64) -> Option<u64> {
        rays.checked_mul(4 * self.layers() as u64)
    }
    /// Whether a layer holds a float, as such or as bits.
    #[must_use]
    pub fn is_float_layer(self, layer: usize) -> bool {
        let info = self.info();
        info.texel == Texel::F32 || info.float_layers.contains(&layer)
    }
}

/// A part of an image, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// Its first column.
    pub x: u32,
    /// Its first row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Region {
    /// Whether it has pixels, all of them in an image of this size.
    #[must_use]
    pub fn is_in(&self, width: u32, height: u32) -> bool {
        let fits =
            |first: u32, count: u32, all: u32| count > 0 && first.checked_add(count).is_some_and(|end| end <= all);
        fits(self.x, self.width, width) && fits(self.y, self.height, height)
    }
}

/// The values of one stream, or of a part of it, after some pass: layer-major, then rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StreamData {
    /// Which stream.
    pub stream: Stream,
    /// Texels a row.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_the_order_of_the_enum_and_complete() {
        for (i, info) in STREAMS.iter().enumerate() {
            assert_eq!(info.stream as usize, i, "{}", info.name);
            assert_eq!(info.layers.len(), info.unwritten.len(), "{}", info.name);
            assert_eq!(Stream::from_name(info.name), Some(info.stream));
        }
    }
}
