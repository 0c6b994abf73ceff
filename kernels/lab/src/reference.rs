//! Correct hits: triangles against rays in f64, from the exact f32 rays and vertices that the kernels read, with a bound
//! on f32's errors. A conservative hierarchy of boxes leaves out most of the triangles that a ray misses by far, and none
//! that testing all of them would find.
//!
//! With u = 2⁻²⁴, a difference, product or sum rounds by a factor of at most 1 ± u, a division by WGSL's
//! 2.5 units in the last place by 1 ± 5u. For the watertight test (see [`raystep_kernels::shared::triangle`]):
//!
//! * a sheared vertex p = a − s·c, |s| ≤ 1, is off by at most (2|a| + 8|c|)·u ≤ 10u·r, r being the
//!   vertex's largest distance along an axis from the origin;
//! * an edge function of vertices q and r is off by at most |q|₁·10u·r_r + |r|₁·10u·r_q + 3u·(|qx·ry| +
//!   |qy·rx|) + 2·10u·r_q·10u·r_r, and what underflows; |·|₁ sums x and y;
//! * t, a weighted mean of the vertices' depths z, moves by Σ bound_i·|z_i − t| / |det| when the weights
//!   move (twice that covers the higher orders), and by 18u·max|z| in its own arithmetic. Where the
//!   bounds reach half the determinant, t may be anywhere between the nearest and the farthest vertex.
//!
//! A **tie** is a ray for which those bounds allow more than one result: an edge function within its bound, or two
//! triangles whose |Δt| is within the sum of theirs. Every other ray has one correct result. If the surface continues
//! on all sides, a ray that hits none of the triangles there counts as missed, whatever the bounds are.

mod crack;
mod crossing;
mod exact;
mod rational;
mod tree;
mod verdict;

use std::sync::Arc;

use glam::DVec3;

use crate::portions::map_in_portions;
pub use rational::error_of_t;
pub use tree::Tree;
pub use verdict::{Counts, Mistake, Verdict};

const U: f64 = 1.0 / (1u64 << 24) as f64;

/// Four times f32's smallest normal number: the loss if two products are flushed to 0.
const UNDERFLOW: f64 = 4.0 * f32::MIN_POSITIVE as f64;

/// What each ray (origin and direction) may hit, computed on all cores. Lets other tasks run every few milliseconds.
pub async fn candidates_of(vertices: &[f32], rays: &[[[f32; 3]; 2]]) -> Vec<Candidates> {
    let triangles = Triangles::new(vertices);
    map_in_portions(rays.len(), |i| triangles.candidates(rays[i][0], rays[i][1])).await
}

/// Triangles in f64, nine floats each, with the hierarchy that finds those which a ray may hit.
#[derive(Clone)]
pub struct Triangles<'a> {
    vertices: &'a [f32],
    tree: Arc<Tree>,
}

/// An edge function with its f32 error bound.
#[derive(Clone, Copy)]
struct Edge {
    value: f64,
    bound: f64,
}

/// A triangle that a ray may hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Possible {
    /// Its id.
    pub triangle: u32,
    /// t at which the ray meets its plane.
    pub t: f64,
    /// Bound on f32's error of t.
    pub t_bound: f64,
    /// Weight of vertex 1; not finite if the triangle is exactly edge-on.
    pub u: f64,
    /// Weight of vertex 2, likewise.
    pub v: f64,
    /// Bound on f32's error of u and v.
    pub weight_bound: f64,
    /// Whether the ray hits it despite any error within the bounds.
    pub is_definite: bool,
    /// Whether the exact ray hits the exact triangle; edges and vertices count.
    pub is_exact: bool,
    /// Depth of the farthest vertex, which the arithmetic's rounding error is relative to.
    pub far: f64,
    /// Its place among all that the exact ray hits, by exact t, of equal ones by id.
    pub place: usize,
}

/// Tests one triangle (nine floats each in `vertices`) in f64. `None` if f32, too, must find a miss.
#[must_use]
pub fn possible(vertices: &[f32], origin: [f32; 3], direction: [f32; 3], triangle: u32) -> Option<Possible> {
    Triangles { vertices, tree: Arc::default() }.test(origin, direction, triangle)
}

/// Whether the ray sees a triangle exactly edge-on, as it does every triangle without area. Such a triangle is never
/// hit.
#[must_use]
pub fn is_edge_on(vertices: &[f32], direction: [f32; 3], triangle: u32) -> bool {
    exact::is_edge_on(direction, Triangles { vertices, tree: Arc::default() }.corners(triangle))
}

/// Everything that a ray may hit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Candidates {
    /// Ordered by triangle id.
    pub possible: Vec<Possible>,
    /// The nearest triangle that the exact ray hits, and its t.
    pub exact: Option<(u32, f64)>,
    /// Smallest upper bound of t among definite hits: nothing behind it can be correct.
    surely_by: Option<f64>,
    /// The t between which hits count; `None` for all.
    interval: Option<[f64; 2]>,
}

impl Candidates {
    /// What is left for a ray whose hits count between two t only, neither end included. A hit whose t is within its
    /// error bound of an end may count or not: a tie.
    #[must_use]
    pub fn within(self, [t_min, t_max]: [f64; 2]) -> Self {
        let mut within = Self { interval: Some([t_min, t_max]), ..Self::default() };
        for p in self.possible {
            let (from, to) = (p.t - p.t_bound, p.t + p.t_bound);
            if to > t_min && from < t_max {
                let is_exact = p.is_exact && p.t > t_min && p.t < t_max;
                within.add(Possible { is_exact, is_definite: p.is_definite && from > t_min && to < t_max, ..p });
            }
        }
        within
    }

    /// The same for a ray that leaves a triangle, and cannot hit it.
    #[must_use]
    pub fn without(mut self, triangle: u32) -> Self {
        self.possible.retain(|p| p.triangle != triangle);
        Self::of_possible(self.possible)
    }

    /// Of all that a ray may hit, in the order of triangles.
    fn of_possible(possible: Vec<Possible>) -> Self {
        let mut all = Self::default();
        possible.into_iter().for_each(|p| all.add(p));
        all
    }

    /// Without what lies so far behind a definite hit that no verdict depends on it: rays in dense scenes may hit very
    /// many triangles, of which few are near.
    #[must_use]
    pub fn near(mut self) -> Self {
        if let Some(by) = self.surely_by {
            // What a surface continues with at an edge may be behind by this share.
            self.possible.retain(|p| p.t - p.t_bound <= by * (1.0 + 2.0 * crack::ASTRIDE));
            self.possible.shrink_to_fit();
        }
        self
    }

    /// Adds what the ray may hit, in the order of triangles.
    fn add(&mut self, p: Possible) {
        if p.is_definite {
            self.surely_by = Some(self.surely_by.map_or(p.t + p.t_bound, |by| by.min(p.t + p.t_bound)));
        }
        let is_before = |of: &Possible| p.place < of.place;
        if p.is_exact && self.exact.and_then(|(triangle, _)| self.of(triangle)).is_none_or(is_before) {
            self.exact = Some((p.triangle, p.t));
        }
        self.possible.push(p);
    }

    /// Whether a ray's hits count at this t.
    fn counts(&self, t: f64) -> bool {
        self.interval.is_none_or(|[t_min, t_max]| t > t_min && t < t_max)
    }

    /// The candidate with this triangle id, if there is one.
    #[must_use]
    pub fn of(&self, triangle: u32) -> Option<&Possible> {
        self.possible.binary_search_by_key(&triangle, |p| p.triangle).ok().map(|i| &self.possible[i])
    }

    /// Whether the bounds allow more than one result.
    #[must_use]
    pub fn is_open(&self) -> bool {
        let reachable = |p: &&Possible| self.surely_by.is_none_or(|by| p.t - p.t_bound <= by);
        match self.possible.iter().filter(reachable).count() {
            0 => false,
            1 => self.surely_by.is_none(),
            _ => true,
        }
    }

    /// The verdict on a ray with this result, and its error of t in the units of
    /// [`Report::largest_t_ulp`](crate::judge::Report::largest_t_ulp).
    #[must_use]
    pub fn judge(&self, ray: usize, found: Option<(u32, f64)>) -> (Mistake, f64) {
        let surely_by = self.surely_by.unwrap_or(f64::INFINITY);
        let exact = self.exact;
        let mut t_ulp = 0.0;
        let verdict = match (found, found.and_then(|(triangle, _)| self.of(triangle))) {
            (None, _) if surely_by.is_finite() => Verdict::Missed,
            (None, _) if exact.is_some() => Verdict::Tie,
            (None, _) => Verdict::Same,
            (Some(_), None) if exact.is_none() && !surely_by.is_finite() => Verdict::False,
            (Some(_), None) => Verdict::Wrong,
            (Some((_, t)), Some(p)) => {
                let error = (t - p.t).abs();
                // The negated comparison catches NaN.
                #[allow(clippy::neg_cmp_op_on_partial_ord, reason = "NaN is within no bound")]
                if !(error <= p.t_bound) || surely_by < p.t - p.t_bound || !self.counts(t) {
                    Verdict::Wrong
                } else if exact.is_some_and(|(k, _)| k == p.triangle) {
                    t_ulp = error / (2.0 * U * p.far.max(t.abs()));
                    Verdict::Same
                } else {
                    Verdict::Tie
                }
            }
        };
        (Mistake { ray, verdict, found: found.map(|(triangle, t)| (triangle, t as f32)), exact }, t_ulp)
    }
}

impl<'a> Triangles<'a> {
    /// Takes triangles of nine floats each.
    #[must_use]
    pub fn new(vertices: &'a [f32]) -> Self {
        Self { vertices, tree: Arc::new(Tree::new(vertices)) }
    }

    /// The same triangles with the hierarchy that was made of them before.
    #[must_use]
    pub fn with(vertices: &'a [f32], tree: Arc<Tree>) -> Self {
        Self { vertices, tree }
    }

    /// The hierarchy.
    #[must_use]
    pub fn tree(&self) -> Arc<Tree> {
        self.tree.clone()
    }

    /// What the ray may hit.
    #[must_use]
    pub fn candidates(&self, origin: [f32; 3], direction: [f32; 3]) -> Candidates {
        let mut possible = Vec::new();
        self.tree.visit(origin, direction, |triangle| possible.extend(self.test(origin, direction, triangle)));
        possible.sort_unstable_by_key(|p: &Possible| p.triangle);
        self.place(origin, direction, &mut possible);
        Candidates::of_possible(possible)
    }

    /// Whether the exact ray hits any of these before `end`.
    #[must_use]
    pub fn are_hit_before(&self, end: f32, origin: [f32; 3], direction: [f32; 3], of: &Candidates) -> bool {
        let is_before = |p: &Possible| rational::is_before(end, origin, direction, self.corners(p.triangle));
        of.possible.iter().any(|p| p.is_exact && is_before(p))
    }

    /// Puts what the exact ray hits in order: by f64 where its t differ by more than f32 errs, which f64 tells for sure,
    /// else by integers.
    fn place(&self, origin: [f32; 3], direction: [f32; 3], possible: &mut [Possible]) {
        let mut hits: Vec<usize> = (0..possible.len()).filter(|&i| possible[i].is_exact).collect();
        hits.sort_by(|&i, &j| {
            let [a, b] = [possible[i], possible[j]];
            if (a.t - b.t).abs() > a.t_bound + b.t_bound {
                return a.t.total_cmp(&b.t);
            }
            let corners = [a, b].map(|p| self.corners(p.triangle));
            rational::compare_t(origin, direction, corners).then(a.triangle.cmp(&b.triangle))
        });
        hits.into_iter().enumerate().for_each(|(place, i)| possible[i].place = place);
    }

    /// The same without the hierarchy, by looking at every triangle: what [`candidates`](Self::candidates) is tested
    /// against.
    #[must_use]
    pub fn brute_force(&self, origin: [f32; 3], direction: [f32; 3]) -> Candidates {
        let mut possible = Vec::new();
        self.tree.visit_all(origin, direction, |triangle| possible.extend(self.test(origin, direction, triangle)));
        self.place(origin, direction, &mut possible);
        Candidates::of_possible(possible)
    }

    /// The work of finding what a ray may hit: boxes, spheres and triangles, by the time they take.
    pub(crate) fn work(&self, origin: [f32; 3], direction: [f32; 3]) -> u64 {
        /// A test of a triangle takes as long as about so many of boxes and spheres.
        const TEST: u64 = 8;
        let mut met = 0;
        let looked = self.tree.visit(origin, direction, |_| met += 1);
        looked as u64 + TEST * met
    }

    /// The vertices of a triangle.
    fn corners(&self, triangle: u32) -> [[f32; 3]; 3] {
        let first = 9 * triangle as usize;
        [0, 3, 6].map(|c| [0, 1, 2].map(|a| self.vertices[first + c + a]))
    }

    /// The edge functions of a triangle, opposite vertices 0, 1 and 2, and its vertices' depths.
    fn edges(&self, o: DVec3, d: DVec3, triangle: u32) -> ([Edge; 3], [f64; 3]) {
        let corners = self.corners(triangle);
        let largest = largest_axis(d);
        let [i, j, k] = [(largest + 1) % 3, (largest + 2) % 3, largest];
        let (sx, sy, sz) = (d[i] / d[k], d[j] / d[k], 1.0 / d[k]);
        let (mut p, mut reach) = ([[0.0; 3]; 3], [0.0; 3]);
        for c in 0..3 {
            let a = wide(corners[c]) - o;
            p[c] = [a[i] - sx * a[k], a[j] - sy * a[k], sz * a[k]];
            reach[c] = 10.0 * U * a.x.abs().max(a.y.abs()).max(a.z.abs());
        }
        let edge = |q: usize, r: usize| {
            let (a, b) = (p[q][0] * p[r][1], p[q][1] * p[r][0]);
            let size = |c: usize| p[c][0].abs() + p[c][1].abs();
            let bound = size(q) * reach[r]
                + size(r) * reach[q]
                + 2.0 * reach[q] * reach[r]
                + 3.0 * U * (a.abs() + b.abs())
                + UNDERFLOW;
            Edge { value: a - b, bound }
        };
        ([edge(1, 2), edge(2, 0), edge(0, 1)], p.map(|c| c[2]))
    }

    /// `None` if f32, too, must find that the ray misses the triangle.
    fn test(&self, origin: [f32; 3], direction: [f32; 3], triangle: u32) -> Option<Possible> {
        let corners = self.corners(triangle);
        let (edges, z) = self.edges(wide(origin), wide(direction), triangle);
        let could_be = |sign: f64| edges.iter().all(|e| sign * e.value >= -e.bound);
        if !could_be(1.0) && !could_be(-1.0) {
            return None;
        }
        let det: f64 = edges.iter().map(|e| e.value).sum();
        let det_bound: f64 = edges.iter().map(|e| e.bound).sum();
        let (near, far) = (z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2]));
        let own = 18.0 * U * near.abs().max(far.abs());
        let weight_bound = (2.0 * det_bound / det.abs()).min(1.0) + 16.0 * U;
        let (t, t_bound) = if det.abs() <= 2.0 * det_bound {
            (0.5 * (near + far), 0.5 * (far - near) + own)
        } else {
            let t = (0..3).map(|c| edges[c].value * z[c]).sum::<f64>() / det;
            let moved: f64 = (0..3).map(|c| edges[c].bound * (z[c] - t).abs()).sum();
            (t, 2.0 * moved / det.abs() + own)
        };
        if t <= -t_bound {
            return None;
        }
        let clear = |sign: f64| edges.iter().all(|e| sign * e.value > e.bound);
        // f64's own error is far below 2⁻²⁰ of f32's.
        let certain = edges.iter().all(|e| e.value.abs() > e.bound * exp2_minus_20());
        // Likewise where it tells the sign of t.
        let is_in_front = if t.abs() > t_bound { t > 0.0 } else { rational::is_in_front(origin, direction, corners) };
        let is_exact = is_in_front
            && if certain {
                edges.iter().all(|e| e.value > 0.0) || edges.iter().all(|e| e.value < 0.0)
            } else {
                exact::hits(origin, direction, corners)
            };
        let is_definite = (clear(1.0) || clear(-1.0)) && t > t_bound;
        let (u, v) = (edges[1].value / det, edges[2].value / det);
        let far = near.abs().max(far.abs());
        Some(Possible { triangle, t, t_bound, u, v, weight_bound, is_definite, is_exact, far, place: 0 })
    }
}

const fn exp2_minus_20() -> f64 {
    1.0 / (1u64 << 20) as f64
}

/// The axis that the kernels choose.
fn largest_axis(d: DVec3) -> usize {
    let m = d.abs();
    if m[0] > m[1] && m[0] > m[2] {
        0
    } else if m[1] > m[2] {
        1
    } else {
        2
    }
}

/// An f32 vector in f64, exactly.
fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from(v.map(f64::from))
}
