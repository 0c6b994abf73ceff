//! Where the results of a program's rays are, so that images, hits and costs are read alike from every such program.

use crate::options::Ray;
use crate::scene_data::SceneData;
use crate::shared::constants::{INF, NO_TRIANGLE};
use crate::tables::stream::{Component, Stream, StreamData};

/// The streams of a program that traces rays.
#[derive(Clone, Copy, Debug)]
pub struct Results {
    /// Origin of each ray: x, y, z.
    pub origin: Stream,
    /// Its direction: x, y, z.
    pub direction: Stream,
    /// The t between which its hits count, if a run's rays have intervals: t_min, t_max.
    pub interval: Stream,
    /// The triangle of the hit after which the ray looks for the next one, if all hits are wanted.
    pub last: Stream,
    /// t of the nearest hit so far, [`INF`] without one. Its stream holds the tags, too.
    pub t: Component,
    /// The triangle that was hit, [`NO_TRIANGLE`] without a hit.
    pub triangle: Component,
    /// Barycentric weights of vertices 1 and 2, in the stream of the triangle.
    pub weights: [usize; 2],
    /// The ray's colour: r, g, b in linear light.
    pub color: Stream,
    /// The mean of the latest block's samples of a pixel: r, g, b, the share of samples that hit, and the number of
    /// samples of all blocks.
    pub mean: Stream,
    /// Sums of the means of complete blocks.
    pub blocks: Stream,
    /// Costs: cells or nodes visited, triangles tested, tests repeated.
    pub counters: Stream,
    /// What a surface reflects of red, green and blue light, by triangle and weights of vertices 1 and 2, if the run shades.
    pub albedo: fn(&SceneData, u32, [f32; 2]) -> [f32; 3],
    /// What a twin that traces a ray in one pass stores for it, in f32 and in f64.
    pub hit_of: [HitOf; 2],
}

/// The triangle that a ray in traced units hits, t, and the weights of vertices 1 and 2, by a twin that takes no stream: in a run
/// that reads its rays, and whose walks never wait. If all hits are wanted, the one after that on the given triangle, or the
/// first if it is [`NO_TRIANGLE`].
pub type HitOf = fn(&Ray, u32, &SceneData) -> Option<(u32, [f32; 3])>;

impl Results {
    /// The streams that every ray's hit follows from: origin, direction, t and triangle.
    #[must_use]
    pub fn of_hits(&self) -> [Stream; 4] {
        [self.origin, self.direction, self.t.stream, self.triangle.stream]
    }

    /// The triangle that a ray (y * width + x) hit and t in traced units, from the streams of t and of the triangle.
    #[must_use]
    pub fn hit(&self, t: &StreamData, triangle: &StreamData, ray: usize) -> Option<(u32, f32)> {
        let (triangle, t) = (triangle.get(self.triangle.layer, ray), t.get_f32(self.t.layer, ray));
        (triangle != NO_TRIANGLE && t < INF).then_some((triangle, t))
    }
}
