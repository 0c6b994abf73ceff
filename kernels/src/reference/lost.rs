//! Rays that went through a crack between triangles.

use super::{BruteForce, Candidates};

impl BruteForce<'_> {
    /// Whether a ray whose triangle f32 cannot tell has hit none of those that it may: it went on through a crack
    /// between triangles, where the surface has no end. Such a ray counts as missed, though [`Candidates::judge`]
    /// calls it a tie. `found` is the triangle and t that it hit instead, if any.
    #[must_use]
    pub fn is_lost(
        &self,
        origin: [f32; 3],
        direction: [f32; 3],
        candidates: &Candidates,
        found: Option<(u32, f64)>,
    ) -> bool {
        let Some((triangle, t)) = candidates.exact else { return false };
        let bound = |triangle| candidates.of(triangle).map_or(0.0, |p| p.t_bound);
        let goes_on = |(hit, found): (u32, f64)| found > t + bound(hit) + bound(triangle);
        // What lies around must be nearer than what was found: else the ray passes the surface's end, and meets what
        // is close behind.
        let gap = found.map_or(t, |(_, found)| found - t);
        // Of a ray that starts on the surface, the sign of t is that of its rounding.
        t > bound(triangle) && found.is_none_or(goes_on) && self.is_closed_around(origin, direction, t, 0.25 * gap)
    }
}
