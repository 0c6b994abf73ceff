//! Photon maps: how many photons are emitted, how the map of those that surfaces received is built, and which of them the
//! light at a point is estimated from.

use crate::numbers::named::named;

/// How the photons of a map get into the order of its cells. The lists are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PhotonSort {
    /// By a bitonic sort, and a binary search for the first photon of each cell (Purcell et al., 2003).
    Bitonic,
    /// By a radix sort, which counts digits, adds up, and moves photons; and the same search.
    #[default]
    Scan,
}

/// Which photons near a point the light there is estimated from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Neighbours {
    /// The kNN-grid (Purcell et al., 2003): cells by growing distance. A photon counts while fewer than enough are found, or
    /// if it is no farther away than the farthest of these.
    #[default]
    KnnGrid,
    /// The nearest, exactly.
    Exact,
}

/// Where the light that photons brought is looked up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Gather {
    /// At the surface that is seen.
    #[default]
    Direct,
    /// There, caustics alone; other light where rays arrive that this surface sends on (Jensen, 1996).
    Final,
}

named!(PhotonSort, "bitonic, scan", Bitonic "bitonic", Scan "scan");
named!(Gather, "direct, final", Direct "direct", Final "final");
named!(Neighbours, "knn-grid, exact", KnnGrid "knn-grid", Exact "exact");

/// The photons of a map, and how it is built and searched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
pub struct Photons {
    /// How many are emitted, at least: a texture has whole rows of them.
    pub count: u32,
    /// How they are sorted by cell.
    pub sort: PhotonSort,
    /// Which of them count at a point.
    pub neighbours: Neighbours,
    /// Where they are looked up.
    pub gather: Gather,
    /// How many of them.
    pub nearest: u32,
    /// How far away they may be, in thousandths of the diagonal of the scene's box.
    pub radius: u32,
}

impl Default for Photons {
    fn default() -> Self {
        let (sort, neighbours, gather) = (PhotonSort::default(), Neighbours::default(), Gather::default());
        Self { count: 100_000, sort, neighbours, gather, nearest: 50, radius: 15 }
    }
}

impl Photons {
    /// Most photons, and most places where photons are stored: a bitonic sort of these then takes 253 passes.
    pub const MOST: u32 = 1 << 22;
    /// Most photons that the light at a point is estimated from.
    pub const MOST_NEAREST: u32 = 10_000;
    /// The largest radius.
    pub const MOST_RADIUS: u32 = 1000;
}
