//! The bounding volume hierarchy: a binary tree for single steps, or a compressed eight-wide one.
//!
//! ```text
//! bvh_nodes     8 words    per node, see [`BvhNode`]; the root is node 0, siblings are adjacent
//! bvh_parents   u32        per node: its parent
//! bvh_items     u32        triangle ids, in the order of the leaves
//! wide_nodes    20 words   per node, see [`WideNode`]; the root is node 0
//! packed_triangles 12 words  a corner and the triangle's id, a corner and 0, a corner and 0, in the order of the leaves
//! ```
//!
//! **Boxes are conservative.** Every box contains the exact boxes of everything below it, grown by what [`Padding`] says,
//! like the grid's cells (see [`crate::structures::grid`]): binary boxes are rounded outwards to f32, wide ones to their
//! 8-bit planes, both decided in f64. `check` verifies this for a whole tree.
//!
//! **A triangle may be listed more than once.** Large oblique triangles are first cut into pieces, each with its own
//! box ([`BvhQuality`] says how many); a ray may then test such a triangle again.
//!
//! **Any scene builds, in about n log n.** If clustering stalls (nested or identical boxes), neighbours are joined
//! anyway; the optimiser's search is bounded if boxes overlap so much that it would visit the whole tree; and a tree
//! deeper than [`MAX_DEPTH`] or [`WIDE_MAX_DEPTH`] is replaced by one that is halved at medians. A scene without
//! triangles has one node that no ray hits: see [`EMPTY`] and [`WideNode`].

mod binary;
mod check;
mod cluster;
mod median;
mod padding;
mod polygon;
mod references;
mod split;
mod tree;
mod wide;

pub use crate::shared::bvh_walk::{BvhNode, EMPTY};
pub use crate::shared::constants::{NO_NODE, WIDE_MAX_DEPTH};
pub use crate::shared::wide_node::{WideChild, WideContent, WideNode};
pub use binary::{BvhData, MAX_LEAF};
pub use check::BvhFault;
pub use padding::Padding;
pub use tree::{MAX_DEPTH, TreeShape};
pub use wide::{MAX_WIDE_LEAF, WideBvhData};

use references::References;

/// Effort of the build. Each level traces faster than the one before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum BvhQuality {
    /// Only clusters, among close neighbours.
    Fast,
    /// Cuts large triangles, with at most three additional references for ten triangles, clusters among more
    /// neighbours, and moves subtrees to better places.
    #[default]
    Balanced,
    /// Moves five times as many subtrees.
    High,
}

impl BvhQuality {
    /// All qualities, fastest to build first.
    pub const ALL: [Self; 3] = [Self::Fast, Self::Balanced, Self::High];

    /// The best quality that builds a tree over this many triangles within about a second on two cores, at least
    /// `Balanced`.
    #[must_use]
    pub fn for_triangles(triangles: u64) -> Self {
        if triangles <= 1 << 18 { Self::High } else { Self::Balanced }
    }

    fn effort(self) -> Effort {
        match self {
            Self::Fast => Effort { pieces: 0.0, search: 8, reinsertion: 0.0, budget: 0.0 },
            Self::Balanced => Effort { pieces: 0.3, search: 14, reinsertion: 0.2, budget: 200.0 },
            Self::High => Effort { pieces: 0.3, search: 14, reinsertion: 1.0, budget: 1000.0 },
        }
    }
}

/// Parameters of a quality.
#[derive(Clone, Copy)]
struct Effort {
    /// Most additional references from cutting, per triangle.
    pieces: f64,
    /// Number of neighbours on either side among which a cluster looks for its best partner.
    search: usize,
    /// Share of nodes considered by the first round of reinsertion; 15 smaller rounds follow.
    reinsertion: f32,
    /// Most nodes that all rounds together may visit, per node of the tree: bounds the time if boxes overlap so much
    /// that every search visits most of them. Scenes of separate objects need about 20.
    budget: f64,
}

/// Options of a build, and the limit it has to fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BvhOptions {
    /// Effort of the build.
    pub quality: BvhQuality,
    /// Most 32-bit words in one buffer of the executor.
    pub most_words: u64,
}

impl Default for BvhOptions {
    fn default() -> Self {
        Self { quality: BvhQuality::default(), most_words: u64::from(u32::MAX) }
    }
}

/// The BVH cannot be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BvhError {
    /// More triangles than references can address.
    #[error("{triangles} triangles are more than the {MAX_TRIANGLES} that a bounding volume hierarchy can hold")]
    TooManyTriangles {
        /// Number of triangles.
        triangles: u64,
    },
    /// A corner whose boxes would have no finite area.
    #[error("triangle {triangle} has a corner that is not a number or farther away than 2^40 traced units")]
    Corner {
        /// The first such triangle.
        triangle: u32,
    },
    /// Boxes cannot be grown by this distance.
    #[error("boxes cannot be grown by {0}: it must be 0 to 2^40 traced units")]
    Growth(f32),
    /// A buffer would be larger than the executor can hold.
    #[error("{buffer} would take {words} words, more than the {limit} that fit one buffer here")]
    TooLarge {
        /// The buffer's name.
        buffer: &'static str,
        /// Words it would take.
        words: u64,
        /// Words that fit.
        limit: u64,
    },
}

/// Most triangles: together with their pieces, and with two nodes for each, they can still be counted with 30 bits.
pub const MAX_TRIANGLES: u64 = 1 << 28;

/// Largest coordinate and growth, in traced units: areas and their sums stay finite in f32.
pub(crate) const MAX_COORDINATE: f32 = (1u64 << 40) as f32;

/// Builds the binary BVH over `vertices` (nine floats per triangle, traced units).
///
/// # Errors
/// If a corner is not finite or much too far away, or if the BVH does not fit the buffers.
pub fn build(vertices: &[f32], padding: impl Into<Padding>, options: &BvhOptions) -> Result<BvhData, BvhError> {
    let padding = padding.into();
    let references = gather(vertices, padding, options)?;
    binary::build(vertices, padding, &references, options)
}

/// Builds the wide BVH over `vertices` (nine floats per triangle, traced units).
///
/// # Errors
/// If a corner is not finite or much too far away, or if the BVH does not fit the buffers.
pub fn build_wide(
    vertices: &[f32],
    padding: impl Into<Padding>,
    options: &BvhOptions,
) -> Result<WideBvhData, BvhError> {
    let padding = padding.into();
    // Checked before anything is allocated: each triangle takes at least 12 words.
    fits("packed_triangles", 12 * (vertices.len() / 9) as u64, options)?;
    let references = gather(vertices, padding, options)?;
    wide::build(vertices, padding, &references, options)
}

fn gather(vertices: &[f32], padding: Padding, options: &BvhOptions) -> Result<References, BvhError> {
    let growth = padding.growth();
    if !(0.0..=MAX_COORDINATE).contains(&growth) {
        return Err(BvhError::Growth(growth));
    }
    let mut references = References::of(vertices)?;
    split::split(vertices, &mut references, options.quality.effort().pieces);
    if padding == Padding::PerRay {
        references.grow_pieces(vertices);
    }
    Ok(references)
}

fn fits(buffer: &'static str, words: u64, options: &BvhOptions) -> Result<(), BvhError> {
    let limit = options.most_words.min(u64::from(u32::MAX));
    if words > limit { Err(BvhError::TooLarge { buffer, words, limit }) } else { Ok(()) }
}

/// The largest f32 that is not above `value`.
fn down(value: f64) -> f32 {
    let rounded = value as f32;
    if f64::from(rounded) > value { rounded.next_down() } else { rounded }
}

/// The smallest f32 that is not below `value`.
fn up(value: f64) -> f32 {
    -down(-value)
}
