//! Rays that pass between two triangles. Near an edge f32 cannot tell which adjacent triangle a ray hits, but if the
//! surface continues on all sides, the ray hits one of them.

use super::{Candidates, Mistake, Triangles, Verdict, largest_axis, wide};

/// Relative difference of t up to which two triangles at an edge belong to the same surface.
pub(super) const ASTRIDE: f64 = 1e-3;

impl Triangles<'_> {
    /// The verdict on a ray with this result, as [`Candidates::judge`], except that a tie at a crack counts as missed.
    #[must_use]
    pub fn judge(
        &self,
        ray: usize,
        origin: [f32; 3],
        direction: [f32; 3],
        candidates: &Candidates,
        found: Option<(u32, f64)>,
    ) -> (Mistake, f64) {
        let (mut mistake, t_ulp) = candidates.judge(ray, found);
        if mistake.verdict == Verdict::Tie && self.is_lost(origin, direction, candidates, found) {
            mistake.verdict = Verdict::Missed;
        }
        (mistake, t_ulp)
    }

    /// Whether a ray at an edge that f32 cannot decide hit none of the adjacent triangles, although the surface
    /// continues on all sides: it passed through a crack.
    fn is_lost(
        &self,
        origin: [f32; 3],
        direction: [f32; 3],
        candidates: &Candidates,
        found: Option<(u32, f64)>,
    ) -> bool {
        let Some((triangle, t)) = candidates.exact else { return false };
        let bound = |triangle| candidates.of(triangle).map_or(0.0, |p| p.t_bound);
        let goes_on = |(hit, found): (u32, f64)| found > t + bound(hit) + bound(triangle);
        // The surroundings must be nearer than the hit that was found: otherwise the ray passes the surface's end and
        // hits something close behind it.
        let gap = found.map_or(t, |(_, found)| found - t);
        // For a ray that starts on the surface, the sign of t is a matter of rounding.
        t > bound(triangle)
            && candidates
                .interval
                .is_none_or(|[t_min, t_max]| t - bound(triangle) > t_min && t + bound(triangle) < t_max)
            && found.is_none_or(goes_on)
            && self.is_joined(origin, direction, candidates, t)
            && self.is_closed_around(origin, direction, t, 0.25 * gap)
    }

    /// Whether every edge that the ray is nearer to than f32's error belongs to two of the triangles there, with the
    /// same two vertices. Some meshes only look closed, for example at a vertex in the middle of a longer edge: they
    /// have a gap as wide as a rounding error, which no triangle test can close.
    fn is_joined(&self, origin: [f32; 3], direction: [f32; 3], candidates: &Candidates, t: f64) -> bool {
        let (o, d) = (wide(origin), wide(direction));
        let mut open: Vec<[[u32; 3]; 2]> = Vec::new();
        for p in candidates.possible.iter().filter(|p| (p.t - t).abs() <= p.t_bound.max(ASTRIDE * t)) {
            let corners = self.corners(p.triangle).map(|c| c.map(|v| (v + 0.0).to_bits()));
            for (i, edge) in self.edges(o, d, p.triangle).0.into_iter().enumerate() {
                if edge.value.abs() > edge.bound {
                    continue;
                }
                let mut ends = [corners[(i + 1) % 3], corners[(i + 2) % 3]];
                ends.sort_unstable();
                match open.iter().position(|other| *other == ends) {
                    Some(same) => {
                        open.swap_remove(same);
                    }
                    None => open.push(ends),
                }
            }
        }
        open.is_empty()
    }

    /// Whether the surface that the exact ray meets at `t` continues on all sides: whether rays slightly to each side,
    /// farther than any rounding error, meet something `within` this distance of it. Then f32 may not know which of the
    /// adjacent triangles the ray hits, but a ray that hits none of them passed through a crack.
    #[must_use]
    pub fn is_closed_around(&self, origin: [f32; 3], direction: [f32; 3], t: f64, within: f64) -> bool {
        // Relative to the direction's largest component, so that the offset is similar along all axes.
        const ASIDE: f64 = 1.0 / (1u32 << 14) as f64;
        // Relative change of t at which a neighbouring hit still counts as the same surface, unless it is nearly
        // edge-on.
        const NEXT_TO_IT: f64 = 1.0 / (1u32 << 9) as f64;
        let d = wide(direction);
        let k = largest_axis(d);
        let (i, j, step) = ((k + 1) % 3, (k + 2) % 3, ASIDE * d[k].abs());
        (0..8).all(|turn| {
            let [across, up] = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]][turn];
            let mut aside = d;
            aside[i] += step * f64::from(across);
            aside[j] += step * f64::from(up);
            let found = self.candidates(origin, aside.as_vec3().to_array());
            found.exact.is_some_and(|(_, other)| (other - t).abs() <= within.min(NEXT_TO_IT * t))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surface_goes_on_around_an_inner_edge_and_ends_at_an_outer_one() {
        // Two triangles of a square with a diagonal between them, and a wall behind.
        let (a, b, c, d) = ([-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [1.0, 1.0, 2.0], [-1.0, 1.0, 2.0]);
        let wall = [[-90.0, -90.0, 9.0], [90.0, -90.0, 9.0], [0.0, 90.0, 9.0]];
        let vertices: Vec<f32> = [[a, b, c], [a, c, d], wall].into_iter().flatten().flatten().collect();
        let triangles = Triangles::new(&vertices);
        let is_closed = |x: f32, y: f32| triangles.is_closed_around([0.0; 3], [x, y, 2.0], 1.0, 1.0);
        assert!(is_closed(0.0, 0.0) && is_closed(0.5, 0.5) && is_closed(0.3, -0.2));
        assert!(!is_closed(1.0, 0.0) && !is_closed(1.0, 1.0) && !is_closed(-1.0, 0.3));
        // Another surface is close behind the end of the first; only their distance tells that it is not a
        // continuation.
        let behind = wall.map(|[x, y, _]| [x, y, 2.0002]);
        let vertices: Vec<f32> = [[a, b, c], [a, c, d], behind].into_iter().flatten().flatten().collect();
        let is_closed = |within| Triangles::new(&vertices).is_closed_around([0.0; 3], [1.0, 0.0, 2.0], 1.0, within);
        assert!(is_closed(1e-3) && !is_closed(2.5e-5));
    }

    /// The square's lower triangle is split at the middle of the diagonal; the upper one is not.
    #[test]
    fn a_corner_in_the_middle_of_a_longer_edge_leaves_a_gap_that_is_nobodys_error() {
        let (a, b, c, d) = ([-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [1.0, 1.0, 2.0], [-1.0, 1.0, 2.0]);
        let middle = [0.1, 0.1, 2.0];
        let vertices: Vec<f32> = [[a, b, middle], [middle, b, c], [a, c, d]].into_iter().flatten().flatten().collect();
        let triangles = Triangles::new(&vertices);
        let verdict = |direction: [f32; 3]| {
            let candidates = triangles.candidates([0.0; 3], direction);
            triangles.judge(0, [0.0; 3], direction, &candidates, None).0.verdict
        };
        assert_eq!(verdict([0.5, 0.5, 2.0]), Verdict::Tie, "on the long edge and a short one");
        assert_eq!(verdict([0.55, -0.45, 2.0]), Verdict::Missed, "on the edge that the two short ones share");
    }

    #[test]
    fn a_ray_between_two_triangles_is_missed_and_one_past_the_end_of_both_is_a_tie() {
        let (a, b, c, d) = ([-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [1.0, 1.0, 2.0], [-1.0, 1.0, 2.0]);
        let vertices: Vec<f32> = [[a, b, c], [a, c, d]].into_iter().flatten().flatten().collect();
        let triangles = Triangles::new(&vertices);
        let verdict = |x: f32, y: f32, found| {
            let direction = [x, y, 2.0];
            let candidates = triangles.candidates([0.0; 3], direction);
            triangles.judge(0, [0.0; 3], direction, &candidates, found).0.verdict
        };
        assert_eq!(verdict(0.5, 0.5, None), Verdict::Missed, "on the diagonal");
        assert_eq!(verdict(1.0, 0.3, None), Verdict::Tie, "on the outer edge");
        assert_eq!(
            [verdict(0.5, 0.5, Some((0, 1.0))), verdict(0.5, 0.5, Some((1, 1.0)))]
                .iter()
                .filter(|v| **v == Verdict::Same)
                .count(),
            1
        );
    }
}
