//! What rounding may change: how far floats may be off after one kernel, and which rays may go another way.

use std::cell::OnceCell;

use raystep_kernels::executor::cpu::CpuExecutor;
use raystep_kernels::generate::eye_ray;
use raystep_kernels::real::Vec3;
use raystep_kernels::reference::{Possible, possible};
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::shared::bvh_walk::finite_inverse;
use raystep_kernels::shared::constants::NO_TRIANGLE;
use raystep_kernels::{Kernel, Plan, Stream, StreamData};

use crate::ulp;

/// What a ray is made of.
const RAY: [Stream; 2] = [Stream::RayDirection, Stream::RayOrigin];

/// The rays before a pass, and what f32 can decide about them.
pub(super) struct Rounding<'a> {
    /// The run.
    pub(super) plan: &'a Plan,
    /// Its scene.
    pub(super) data: &'a SceneData,
    /// The kernel of the pass.
    pub(super) kernel: Kernel,
    /// Every stream before it.
    pub(super) before: &'a [StreamData],
    /// Where rays go that are nearly these; worked out when it is asked for.
    pub(super) nudged: OnceCell<Vec<Vec<StreamData>>>,
}

impl Rounding<'_> {
    /// A component before the pass; 0 where the run does not have the stream.
    #[must_use]
    pub(super) fn component(&self, stream: Stream, layer: usize, ray: usize) -> u32 {
        self.before.iter().find(|s| s.stream == stream).map_or(0, |s| s.get(layer, ray))
    }

    fn floats(&self, stream: Stream, ray: usize) -> [f32; 3] {
        [0, 1, 2].map(|layer| f32::from_bits(self.component(stream, layer, ray)))
    }

    /// Origin and direction: from the streams, or those that the kernel makes itself.
    fn ray(&self, ray: usize) -> [[f32; 3]; 2] {
        if self.data.features.eye_rays {
            let (x, y) = (ray as u32 % self.plan.width, ray as u32 / self.plan.width);
            let (origin, direction) = eye_ray::<f32>(self.data, x, y);
            return [origin.to_array(), direction.to_array()];
        }
        let [direction, origin] = RAY.map(|s| self.floats(s, ray));
        [origin, direction]
    }

    /// Most steps of a ray in the pass.
    fn steps(&self) -> u32 {
        if self.kernel == Kernel::Walk { self.data.info.steps } else { 1 }
    }

    /// The largest difference that WGSL's rounding rules allow for a float after one kernel: a division may
    /// be off by 2.5 units in the last place, and a product that is added to may be contracted or not.
    /// Software Vulkan does neither, and is equal bit for bit; an H200 does both.
    ///
    /// * ray_direction, ray_origin: sums of three terms of the size of the view plane; 4 roundings of those.
    /// * tmax: a division and a product: 4 ulp; by the paper's rules it grows by that at every step.
    /// * color: square roots, divisions and sums of terms below 1 or the value itself; a spot's cone multiplies
    ///   the error of a cosine by its scale.
    /// * t, u, v: by the triangle's own bound, see [`raystep_kernels::reference`]. It allows the 10 roundings of a
    ///   sheared corner; a ray that the kernel makes itself is off by 4 more, so the double of it covers both.
    ///
    /// Integers, and what is only copied, must be equal but for rays that f32 cannot decide.
    #[must_use]
    pub(super) fn allows(&self, (stream, layer): (Stream, usize), a: u32, b: u32, possible: Option<&Possible>) -> bool {
        let (x, y) = (f32::from_bits(a), f32::from_bits(b));
        let size = x.abs().max(y.abs()).max(1.0);
        let difference = f64::from((x - y).abs());
        match (stream, layer) {
            (Stream::RayOrigin | Stream::RayDirection, _) => (x - y).abs() <= 4.0 * f32::EPSILON * size,
            (Stream::TMax, _) => ulp(a, b) <= 4 * u64::from(self.steps()),
            (Stream::Hit, 0 | 1) => possible.is_some_and(|p| difference <= 2.0 * p.weight_bound),
            (Stream::State, 1) => possible.is_some_and(|p| difference <= 2.0 * p.t_bound),
            (Stream::Color, _) => {
                let cone = self.data.lights.iter().fold(1.0f32, |m, l| m.max(l.cone_scale));
                (x - y).abs() <= 64.0 * f32::EPSILON * size * cone
            }
            _ => false,
        }
    }

    /// The triangle that the pass tests, or `hit`, the one that a pass of many tests ends with, as f64 sees it.
    #[must_use]
    pub(super) fn tested(&self, ray: usize, hit: u32) -> Option<Possible> {
        let (cell, item) = (self.component(Stream::State, 2, ray), self.component(Stream::State, 3, ray));
        let [origin, direction] = self.ray(ray);
        let seen = |triangle| possible(&self.data.vertices, origin, direction, triangle);
        match self.kernel {
            Kernel::Intersect => {
                let (first, count) = self.data.list(cell);
                (item < count).then(|| seen(self.data.listed(first + item))).flatten()
            }
            Kernel::Walk | Kernel::Fused => (hit < self.data.info.triangles).then(|| seen(hit)).flatten(),
            _ => None,
        }
    }

    /// Whether the node's box is met or missed by less than it was grown by.
    fn grazes_a_box(&self, ray: usize, origin: [f64; 3], direction: [f64; 3]) -> bool {
        let [origin, direction] = [origin, direction].map(Vec3::<f64>::from);
        let inverse = finite_inverse(direction);
        let nearest_t = f64::from(f32::from_bits(self.component(Stream::State, 1, ray)));
        let node = self.component(Stream::State, 2, ray);
        let Some(node) = self.data.bvh_nodes.get(node as usize) else { return false };
        let growth = f64::from(self.data.growth);
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
    /// grid's box: that axis is clamped, the other two may be near a plane by chance.
    #[must_use]
    pub(super) fn walk_may_begin_elsewhere(&self, ray: usize) -> bool {
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

    /// Whether rounding alone may send the ray another way; `on_gpu` is where it went there.
    #[must_use]
    pub(super) fn may_part(&self, ray: usize, on_gpu: &[&StreamData]) -> bool {
        let [origin, direction] = self.ray(ray).map(|v| v.map(f64::from));
        let at = |t: f64| [0, 1, 2].map(|a| origin[a] + direction[a] * t);
        let by_a_triangle = |p: Possible| {
            let exit = self.floats(Stream::TMax, ray).into_iter().fold(f32::INFINITY, f32::min);
            let nearest = f32::from_bits(self.component(Stream::State, 1, ray));
            let close = |t: f32| (f64::from(t) - p.t).abs() <= 2.0 * p.t_bound;
            let is_paper_grid = !self.data.features.robust && self.data.features.grid;
            !p.is_definite || close(exit) || close(nearest) || is_paper_grid && self.near_plane(at(p.t), None)
        };
        match self.kernel {
            Kernel::Setup => self.walk_may_begin_elsewhere(ray),
            Kernel::Intersect => self.tested(ray, NO_TRIANGLE).is_some_and(by_a_triangle),
            // Many cells, boxes and triangles, or the end of a leap: the GPU's choices among them must be those of
            // a ray next to this one.
            Kernel::Walk | Kernel::Fused => self.is_nearly(ray, on_gpu),
            Kernel::TraverseGrid if self.data.features.skip => self.is_nearly(ray, on_gpu),
            Kernel::TraverseBvh => self.grazes_a_box(ray, origin, direction),
            // The comparisons of a step to the next cell are of numbers that both sides read from the same stream.
            Kernel::Generate | Kernel::TraverseGrid | Kernel::Shade => false,
        }
    }

    /// Whether the ray went where one goes whose components are off by up to 4 roundings of the largest: what a
    /// division, a product and a sum may make of it.
    fn is_nearly(&self, ray: usize, on_gpu: &[&StreamData]) -> bool {
        let same = |nudged: &Vec<StreamData>| {
            let hit = nudged.iter().find(|s| s.stream == Stream::Hit).map_or(NO_TRIANGLE, |s| s.get(2, ray));
            let possible = self.tested(ray, hit);
            nudged.iter().zip(on_gpu).filter(|(s, _)| !RAY.contains(&s.stream)).all(|(nudged, gpu)| {
                (0..gpu.stream.layers()).all(|layer| {
                    let (a, b) = (nudged.get(layer, ray), gpu.get(layer, ray));
                    a == b || self.allows((gpu.stream, layer), a, b, possible.as_ref())
                })
            })
        };
        self.nudged.get_or_init(|| self.nudge()).iter().any(same)
    }

    /// The streams after the twin's pass, for rays moved along every combination of axes.
    fn nudge(&self) -> Vec<Vec<StreamData>> {
        let mut all = Vec::new();
        for (roundings, moved) in [(1.0, 0), (4.0, 0), (1.0, 1), (4.0, 1)] {
            for way in 0..27 {
                let signs = [way % 3 - 1, way / 3 % 3 - 1, way / 9 - 1].map(|s| s as f32);
                let nudged = |v: [f32; 3], axis: usize| {
                    let largest = v.iter().fold(0.0f32, |m, c| m.max(c.abs()));
                    v[axis] + signs[axis] * roundings * 0.5 * f32::EPSILON * largest
                };
                let mut twin = CpuExecutor::<f32>::new(self.plan, None).expect("memory");
                for stream in self.before {
                    let mut stream = stream.clone();
                    if stream.stream == RAY[moved] {
                        let rays = stream.bits.len() / 3;
                        for ray in 0..rays {
                            let v = [0, 1, 2].map(|axis| stream.get_f32(axis, ray));
                            (0..3).for_each(|axis| stream.bits[axis * rays + ray] = nudged(v, axis).to_bits());
                        }
                    }
                    assert!(twin.write(&stream));
                }
                let mut data = self.data.clone();
                let of_eye = if moved == 0 { &mut data.camera.forward } else { &mut data.camera.eye };
                *of_eye = [0, 1, 2].map(|axis| nudged(*of_eye, axis));
                twin.run(self.kernel, &data);
                all.push(self.before.iter().filter_map(|s| twin.read(s.stream)).collect());
            }
        }
        all
    }
}
