//! What rounding may change in one pass: how far floats may be off after a kernel, and which rays may take another
//! path.
//!
//! Two executors start from the same streams. After the pass, integers and floats that are only copied must be
//! equal, and computed floats must agree within the bounds in the kernel's row (see
//! [`raystep_kernels::program::rounding`]). Rays that f32 cannot decide are exempt.

mod judge;
mod nudge;

use std::sync::Arc;

use raystep_kernels::Kernel;
use raystep_kernels::numbers::real::{Vec3, ulps};
use raystep_kernels::plan::Plan;
use raystep_kernels::program::rounding::{CONTROL_TERM, DIVISION, Each, Off, Ties};
use raystep_kernels::programs::closest_hit::streams::{self, STATE_CELL, STATE_ITEM, STATE_T};
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::shared::bvh_walk::{finite_inverse, ray_padding};
use raystep_kernels::shared::camera::eye_ray;
use raystep_kernels::shared::constants::NO_TRIANGLE;
use raystep_kernels::shared::dda::slopes;
use raystep_kernels::shared::grid_walk::smallest_axis;
use raystep_kernels::shared::vector::smallest3;
use raystep_kernels::tables::stream::{Stream, StreamData};

use crate::reference::{Possible, possible};
pub use judge::{Component, Judged, Verdict, judging_bytes};

/// The streams of a ray.
const RAY: [Stream; 2] = [streams::RAY_DIRECTION, streams::RAY_ORIGIN];

/// The rays before a pass, and what f32 can decide about them.
#[derive(Clone, Copy, Debug)]
pub struct Rounding<'a> {
    /// The run.
    pub plan: &'a Arc<Plan>,
    /// Its scene.
    pub data: &'a SceneData,
    /// The kernel of the pass.
    pub kernel: Kernel,
    /// Every stream of the run before it.
    pub before: &'a [StreamData],
}

impl Rounding<'_> {
    /// One of these streams that is bound to a stream of the kernel.
    fn bound<'s>(&self, own: Stream, streams: impl IntoIterator<Item = &'s StreamData>) -> Option<&'s StreamData> {
        let stream = self.kernel.stream(own)?;
        streams.into_iter().find(|s| s.stream == stream)
    }

    /// A component before the pass; 0 if the run does not have the stream, or it has no such element.
    fn component(&self, own: Stream, layer: usize, ray: usize) -> u32 {
        self.bound(own, self.before).and_then(|s| s.layer(layer).get(ray).copied()).unwrap_or(0)
    }

    fn floats(&self, stream: Stream, ray: usize) -> [f32; 3] {
        [0, 1, 2].map(|layer| f32::from_bits(self.component(stream, layer, ray)))
    }

    /// Origin and direction: from the streams, or as the kernel generates them itself.
    fn ray(&self, ray: usize) -> [[f32; 3]; 2] {
        if self.data.features.eye_rays {
            let (x, y) = (ray as u32 % self.plan.width, ray as u32 / self.plan.width);
            let (origin, direction) = eye_ray::<f32>(&self.data.camera, self.data.features.perspective, x, y);
            return [origin.to_array(), direction.to_array()];
        }
        let [direction, origin] = RAY.map(|s| self.floats(s, ray));
        [origin, direction]
    }

    /// The factor by which the error of one computation is multiplied.
    fn times(&self, each: Each) -> u64 {
        u64::from(match each {
            Each::Pass => 1,
            Each::Step => self.data.info.steps,
            Each::Iteration => self.data.features.turns,
        })
    }

    /// Whether a component may differ like this by rounding alone. `tested` is the triangle that the pass tested.
    fn allows(&self, (stream, layer): (Stream, usize), a: u32, b: u32, tested: Option<&Possible>) -> bool {
        let is_it = |own: Stream| self.kernel.stream(own) == Some(stream);
        let mut floats = self.kernel.info().rounding.floats.iter();
        let Some((_, _, off)) = floats.find(|(own, layers, _)| layers.contains(&layer) && is_it(*own)) else {
            return false;
        };
        let (x, y) = (f32::from_bits(a), f32::from_bits(b));
        let within = |roundings: f32| (x - y).abs() <= roundings * f32::EPSILON * x.abs().max(y.abs()).max(1.0);
        let bounded = |bound: f64| f64::from((x - y).abs()) <= 2.0 * bound;
        match *off {
            Off::PerAxis(each) if self.data.features.dda => {
                let cells = self.data.grid.cells.into_iter().max().unwrap_or_default();
                within(CONTROL_TERM * (cells as f32 + self.times(each) as f32))
            }
            Off::PerAxis(each) => ulps(a, b) <= DIVISION * self.times(each),
            Off::Roundings(most) => within(most),
            Off::Roots(most) => within((most / f32::EPSILON).sqrt()),
            Off::RoundingsOfLight(most) => {
                within(most * self.data.lights.iter().fold(1.0f32, |m, light| m.max(light.cone_scale)))
            }
            Off::DistanceToTriangle => tested.is_some_and(|p| bounded(p.t_bound)),
            Off::WeightOfTriangle => tested.is_some_and(|p| bounded(p.weight_bound)),
            Off::OneVoxel => a.abs_diff(b) <= 1,
        }
    }

    /// The triangle that the pass tests, or `hit`, the result of a pass with many tests, tested in f64.
    fn tested(&self, ray: usize, hit: u32) -> Option<Possible> {
        let (cell, item) =
            (self.component(streams::STATE, STATE_CELL, ray), self.component(streams::STATE, STATE_ITEM, ray));
        let [origin, direction] = self.ray(ray);
        let seen = |triangle| possible(&self.data.vertices, origin, direction, triangle);
        match self.kernel.info().rounding.ties {
            Ties::Triangle => {
                let (first, count) = self.data.list(cell);
                (item < count).then(|| seen(self.data.listed(first + item))).flatten()
            }
            Ties::Many => (hit < self.data.info.triangles).then(|| seen(hit)).flatten(),
            Ties::None | Ties::FirstCell | Ties::Leap | Ties::Box => None,
        }
    }

    /// Whether the ray hits or misses the node's box by less than the box was grown by.
    fn grazes_a_box(&self, ray: usize, origin: [f64; 3], direction: [f64; 3]) -> bool {
        let [origin, direction] = [origin, direction].map(Vec3::<f64>::from);
        let inverse = finite_inverse(direction);
        let nearest_t = f64::from(f32::from_bits(self.component(streams::STATE, STATE_T, ray)));
        let node = self.component(streams::STATE, STATE_CELL, ray);
        let Some(node) = self.data.bvh_nodes.get(node as usize) else { return false };
        let growth = match self.data.features.ray_padding {
            true => 2.0 * ray_padding(Vec3::<f64>::from_f32(node.min) - origin, Vec3::from_f32(node.max) - origin),
            false => f64::from(self.data.growth),
        };
        let meets = |by: f64| {
            let side = |v: [f32; 3], by: f64| Vec3::<f64>::from_f32(v) + Vec3::splat(by);
            let (t0, t1) = ((side(node.min, -by) - origin) * inverse, (side(node.max, by) - origin) * inverse);
            let (t0, t1) = (t0.to_array(), t1.to_array());
            let enter = (0..3).map(|a| t0[a].min(t1[a])).fold(0.0, f64::max);
            let leave = (0..3).map(|a| t0[a].max(t1[a])).fold(nearest_t, f64::min);
            enter <= leave
        };
        meets(growth) != meets(-growth)
    }

    /// Whether a point is so near to a plane of the grid that f32 cannot tell on which side it lies.
    fn near_plane(&self, point: [f64; 3], without: Option<usize>) -> bool {
        let (grid, growth) = (&self.data.grid, f64::from(self.data.growth));
        (0..3).filter(|&a| without != Some(a)).any(|a| {
            let width = f64::from(grid.width[a]);
            let at = (point[a] - f64::from(grid.corner[a])) / width;
            (at - at.round()).abs() * width <= growth
        })
    }

    /// Whether f32 cannot tell in which cell the ray's walk begins. The entry point lies on a face of the
    /// grid's box: that axis is clamped; on the other two, the point may be near a plane by chance.
    fn walk_may_begin_elsewhere(&self, ray: usize) -> bool {
        let ([origin, direction], grid) = (self.ray(ray).map(|v| v.map(f64::from)), &self.data.grid);
        let (mut enter, mut axis) = (0.0, None);
        for a in (0..3).filter(|&a| direction[a] != 0.0) {
            let face = |i: i32| f64::from(grid.corner[a]) + f64::from(grid.width[a]) * f64::from(i);
            let t = [face(0), face(grid.cells[a])].map(|f| (f - origin[a]) / direction[a]);
            if t[0].min(t[1]) > enter {
                (enter, axis) = (t[0].min(t[1]), Some(a));
            }
        }
        self.near_plane([0, 1, 2].map(|a| origin[a] + direction[a] * enter), axis)
    }

    /// Whether f32 cannot tell in which cell a leap over empty ones ends, or a step through an irregular grid. It ends on
    /// a face of the empty cube, or of the cell's box. If two faces are crossed at nearly the same t, the point is near
    /// both.
    fn leap_may_end_elsewhere(&self, ray: usize) -> bool {
        let (grid, cell) = (&self.data.grid, self.component(streams::STATE, STATE_CELL, ray));
        let [origin, direction] = self.ray(ray).map(Vec3::<f64>::from_f32);
        let grid_ray = grid.ray(self.data.features.walk_rules(), origin, direction);
        let exit = if self.data.features.irregular {
            let Some(cell) = self.data.irregular_cells.get(cell as usize) else { return false };
            cell.exit(grid, &grid_ray)
        } else {
            let distance = self.data.empty_distance(cell);
            if distance <= 1 {
                return false;
            }
            let forward = grid_ray.per_axis.map(|v| if v > 0.0 { distance - 1 } else { 1 - distance }).to_array();
            let here = grid.cell_of_index(cell);
            grid.cell_exit([0, 1, 2].map(|a| here[a].wrapping_add(forward[a])), &grid_ray)
        };
        let (t, axis) = (smallest3(exit), smallest_axis(exit).iter().position(|&is| is));
        self.near_plane((origin + direction * t).to_array(), axis)
    }

    /// Whether f32 cannot tell which axis a 3D-DDA crosses next: two terms are the same in proportion to their slopes,
    /// or two axes are equally fast.
    fn step_may_go_elsewhere(&self, ray: usize) -> bool {
        let control = self.floats(streams::CONTROL, ray).map(f64::from);
        let direction = Vec3::<f64>::from_f32(self.ray(ray)[1]);
        let slope = slopes(direction, Vec3::from_f32(self.data.grid.width)).to_array();
        let same = |x: f64, y: f64| (x - y).abs() < f64::from(8.0 * f32::EPSILON) * x.abs().max(y.abs());
        let pairs = [(0, 1), (0, 2), (1, 2)];
        pairs.into_iter().any(|(a, b)| same(control[a] * slope[b], control[b] * slope[a]))
            || pairs.into_iter().any(|(a, b)| slope[a].max(slope[b]) == 1.0 && same(slope[a], slope[b]))
    }

    /// The same for any step of the search for repeated tests, which walks from the ray's start.
    fn search_may_go_elsewhere(&self, ray: usize) -> bool {
        let (grid, features) = (&self.data.grid, &self.data.features);
        if !(features.dda && features.resumes_scan) {
            return false;
        }
        let [origin, direction] = self.ray(ray).map(Vec3::<f64>::from_f32);
        let rules = features.walk_rules();
        let grid_ray = grid.ray(rules, origin, direction);
        let slope = grid_ray.per_axis.to_array();
        let cells = grid.cells.into_iter().max().unwrap_or_default();
        let close = f64::from(CONTROL_TERM * f32::EPSILON) * f64::from(cells);
        let mut walk = grid.enter(rules, &grid_ray);
        let mut steps = 0;
        // As far as the grid is large along all axes: then the ray has left it.
        while walk.inside && steps < grid.cells.iter().sum::<i32>() {
            let control = walk.per_axis.to_array();
            let is_tie = |(a, b): (usize, usize)| (control[a] * slope[b] - control[b] * slope[a]).abs() <= close;
            if [(0, 1), (0, 2), (1, 2)].into_iter().any(is_tie) {
                return true;
            }
            walk = grid.advance(rules, walk, &grid_ray);
            steps += 1;
        }
        false
    }

    /// Whether rounding alone may make the ray take another path in this pass; `None` if only neighbouring rays can
    /// tell, see [`nudge`].
    fn is_undecided(&self, ray: usize) -> Option<bool> {
        let [origin, direction] = self.ray(ray).map(|v| v.map(f64::from));
        let at = |t: f64| [0, 1, 2].map(|a| origin[a] + direction[a] * t);
        let by_a_triangle = |p: Possible| {
            let exit = self.floats(streams::TMAX, ray).into_iter().fold(f32::INFINITY, f32::min);
            let nearest = f32::from_bits(self.component(streams::STATE, STATE_T, ray));
            let close = |t: f32| (f64::from(t) - p.t).abs() <= 2.0 * p.t_bound;
            let in_cell = self.data.features.in_cell;
            !p.is_definite || close(exit) || close(nearest) || in_cell && self.near_plane(at(p.t), None)
        };
        match self.kernel.info().rounding.ties {
            Ties::None => Some(false),
            Ties::FirstCell => Some(self.walk_may_begin_elsewhere(ray)),
            // The comparisons of a step to the next cell are of numbers that both sides read from the same stream.
            Ties::Leap if self.data.is_outside(self.component(streams::STATE, STATE_CELL, ray)) => {
                Some(self.walk_may_begin_elsewhere(ray))
            }
            Ties::Leap => {
                let features = &self.data.features;
                Some(match features.dda {
                    true => self.step_may_go_elsewhere(ray),
                    false => (features.skip || features.irregular) && self.leap_may_end_elsewhere(ray),
                })
            }
            Ties::Box => Some(self.grazes_a_box(ray, origin, direction)),
            Ties::Triangle => {
                let tested = self.tested(ray, NO_TRIANGLE).is_some_and(by_a_triangle);
                Some(tested || self.search_may_go_elsewhere(ray))
            }
            Ties::Many => None,
        }
    }
}
