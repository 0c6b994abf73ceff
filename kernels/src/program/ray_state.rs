//! A ray of a run, decoded from its texels: what explanations, histories and drawings of walks read.

use crate::tables::state::Tag;

/// A ray's texels after some pass, decoded. Lengths and t are in traced units, as in the streams.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct RayState {
    /// Origin.
    pub origin: [f32; 3],
    /// Direction.
    pub direction: [f32; 3],
    /// The t between which hits count; absent if no ray of the run has an interval.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub interval: Option<[f32; 2]>,
    /// The tag's name.
    pub state: &'static str,
    /// Tag of the state stream.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub tag: Tag,
    /// Nearest t so far.
    pub t: Option<f32>,
    /// Whether it is in a cell or at a node: its walk has begun and is not over.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub is_walking: bool,
    /// 1-D index of the cell, or index of the BVH's node.
    pub cell_index: u32,
    /// The BVH's previous node; `None` without a BVH.
    pub previous: Option<u32>,
    /// Offset into the cell's list.
    pub item: u32,
    /// t at which the ray leaves its cell, per axis; `None` for an axis along which it never does.
    pub tmax: [Option<f32>; 3],
    /// Control terms of a 3D-DDA, per axis, in cells; absent without one.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub control: Option<[f32; 3]>,
    /// Nearest triangle hit so far.
    pub triangle: Option<u32>,
    /// Weights of vertices 1 and 2 at the hit.
    pub barycentric: Option<[f32; 2]>,
    /// Linear colour.
    pub color: Option<[f32; 3]>,
    /// The triangle that a shadow ray leaves; absent if it is none.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub surface: Option<u32>,
    /// The light to which a shadow ray leads, from 1; absent if it is none.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub light: Option<u32>,
    /// The linear light that arrives if the light is visible.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub pending: Option<[f32; 3]>,
    /// How the ray came about; absent if all rays are the camera's.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub bounce: Option<Bounce>,
    /// Samples in the pixel's mean; absent if a pixel has one.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub samples: Option<u32>,
}

/// A ray in the tree of a pixel's rays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Bounce {
    /// How many surfaces have reflected or refracted it.
    pub depth: u32,
    /// The depths at which another ray waits: bit d for depth d.
    pub waiting: u32,
    /// The share of its light that reaches the pixel.
    pub throughput: [f32; 3],
    /// The pdf of its direction, by solid angle; 0 if no other direction was possible.
    pub pdf: f32,
    /// The light that reaches the pixel by all rays so far; for a pixel's first ray, what is left from the sample before.
    pub radiance: [f32; 3],
    /// Why the path ended, as the stream `ended` says.
    pub ended: u32,
}

impl RayState {
    /// What decides by which face the ray leaves its cell, per axis: the control terms of a 3D-DDA, or tMax.
    #[must_use]
    pub fn per_axis(&self) -> [Option<f32>; 3] {
        self.control.map_or(self.tmax, |control| control.map(Some))
    }
}
