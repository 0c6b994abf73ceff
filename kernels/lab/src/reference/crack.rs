//! Rays that pass between two triangles. Near an edge f32 cannot tell which of the triangles there a ray hits, but where
//! the surface goes on, it hits one of them.

use super::{BruteForce, Candidates, Mistake, Verdict, largest_axis, wide};

impl BruteForce<'_> {
    /// What became of a ray that found this, as [`Candidates::judge`]; a tie that is a crack is a miss.
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

    /// Whether a ray whose triangle f32 cannot tell has hit none of those that it may: it went on through a crack
    /// between triangles, where the surface has no end.
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
        // What lies around must be nearer than what was found: else the ray passes the surface's end, and meets what
        // is close behind.
        let gap = found.map_or(t, |(_, found)| found - t);
        // Of a ray that starts on the surface, the sign of t is that of its rounding.
        t > bound(triangle)
            && found.is_none_or(goes_on)
            && self.is_joined(origin, direction, candidates, t)
            && self.is_closed_around(origin, direction, t, 0.25 * gap)
    }

    /// Whether every edge that f32 may take the ray to be on either side of belongs to two of the triangles there, by
    /// the same two corners. Where a mesh only looks closed, as at a corner in the middle of a longer edge, it has a gap
    /// of a rounding's width, and no test of triangles can close it.
    fn is_joined(&self, origin: [f32; 3], direction: [f32; 3], candidates: &Candidates, t: f64) -> bool {
        let (o, d) = (wide(origin), wide(direction));
        let mut open: Vec<[[u32; 3]; 2]> = Vec::new();
        for p in candidates.possible.iter().filter(|p| (p.t - t).abs() <= p.t_bound.max(1e-3 * t)) {
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

    /// Whether the surface that the ray exactly meets at `t` goes on all around: whether rays a little to each side,
    /// by more than any rounding of this one, meet something `within` so much of it. Then f32 may not know which of the triangles
    /// around it hits, but a ray that hits none of them is lost: it has gone through a crack.
    #[must_use]
    pub fn is_closed_around(&self, origin: [f32; 3], direction: [f32; 3], t: f64, within: f64) -> bool {
        // Against the direction's largest component, and so along any axis about as far as along the others.
        const ASIDE: f64 = 1.0 / (1u32 << 14) as f64;
        // How much farther or nearer a surface may be there, that is not seen nearly edge-on.
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
        // Two triangles of a square, the diagonal between them, and a wall behind.
        let (a, b, c, d) = ([-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [1.0, 1.0, 2.0], [-1.0, 1.0, 2.0]);
        let wall = [[-90.0, -90.0, 9.0], [90.0, -90.0, 9.0], [0.0, 90.0, 9.0]];
        let vertices: Vec<f32> = [[a, b, c], [a, c, d], wall].into_iter().flatten().flatten().collect();
        let triangles = BruteForce::new(&vertices);
        let is_closed = |x: f32, y: f32| triangles.is_closed_around([0.0; 3], [x, y, 2.0], 1.0, 1.0);
        assert!(is_closed(0.0, 0.0) && is_closed(0.5, 0.5) && is_closed(0.3, -0.2));
        assert!(!is_closed(1.0, 0.0) && !is_closed(1.0, 1.0) && !is_closed(-1.0, 0.3));
        // Close behind the end of one surface is another: whether that goes on from it is a question of how near.
        let behind = wall.map(|[x, y, _]| [x, y, 2.0002]);
        let vertices: Vec<f32> = [[a, b, c], [a, c, d], behind].into_iter().flatten().flatten().collect();
        let is_closed = |within| BruteForce::new(&vertices).is_closed_around([0.0; 3], [1.0, 0.0, 2.0], 1.0, within);
        assert!(is_closed(1e-3) && !is_closed(2.5e-5));
    }

    /// The square's lower triangle is cut in two at the middle of the diagonal, and the upper one is not.
    #[test]
    fn a_corner_in_the_middle_of_a_longer_edge_leaves_a_gap_that_is_nobodys_error() {
        let (a, b, c, d) = ([-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [1.0, 1.0, 2.0], [-1.0, 1.0, 2.0]);
        let middle = [0.1, 0.1, 2.0];
        let vertices: Vec<f32> = [[a, b, middle], [middle, b, c], [a, c, d]].into_iter().flatten().flatten().collect();
        let triangles = BruteForce::new(&vertices);
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
        let triangles = BruteForce::new(&vertices);
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
