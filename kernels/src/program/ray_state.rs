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
    /// The search for photons near its hit; absent before and after it.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub gather: Option<Gather>,
    /// What it carries from a light; absent if it comes from the camera.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub photon: Option<Photon>,
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

/// How far a search for the photons near a hit has got.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Gather {
    /// Whether it looks for those that came by mirrors and glass alone, in a map of their own.
    pub is_caustic: bool,
    /// Which of the 27 cells around the hit is searched, x first; `None` before the first and after the last.
    pub around: Option<u32>,
    /// The next photon of the cell, as an index among the sorted ones.
    pub item: u32,
    /// Where the cell's photons end.
    pub end: u32,
    /// Photons found.
    pub found: u32,
    /// How often all cells were searched before.
    pub sweep: u32,
    /// The cells around the hit that were searched, a bit each.
    pub visited: u32,
    /// What is farther away is not taken; traced units.
    pub limit: f32,
    /// Of the photons found, the distance of the farthest one.
    pub farthest: f32,
}

/// What is special about a photon: a ray that carries power from a light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Photon {
    /// Its power, linear.
    pub power: [f32; 3],
    /// How many surfaces it has left.
    pub hits: u32,
    /// The triangle that it leaves; `None` for one from a light without a size.
    pub leaves: Option<u32>,
    /// The bounces after which it is stored in the map of all photons: bit b for bounce b.
    pub stored: u32,
    /// The same for the map of those that came by mirrors and glass alone.
    pub stored_caustic: u32,
    /// Why it ended, as its stream says; 0 if it has not.
    pub ended: u32,
}

impl RayState {
    /// What decides by which face the ray leaves its cell, per axis: the control terms of a 3D-DDA, or tMax.
    #[must_use]
    pub fn per_axis(&self) -> [Option<f32>; 3] {
        self.control.map_or(self.tmax, |control| control.map(Some))
    }
}
