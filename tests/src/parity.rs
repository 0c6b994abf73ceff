//! One-step parity: the twin starts from the GPU's streams before a pass, and both must agree after it.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::sync::Arc;

use raystep_kernels::executor::cpu::CpuExecutor;
use raystep_kernels::real::Vec3;
use raystep_kernels::reference::{Possible, possible};
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::shared::bvh_walk::{Visit, finite_inverse, next_node};
use raystep_kernels::state::Tag;
use raystep_kernels::{Device, Gpu, Kernel, Limits, Options, Pass, Plan, Renderer, Stream, StreamData};
use raystep_scenes::Scene;

use crate::{block_on, differences, streams_of, ulp};

/// The largest difference that WGSL's rounding rules allow for a float after one kernel: a division may be
/// off by 2.5 units in the last place, and a product that is added to may be contracted or not. Software
/// Vulkan does neither, and is equal bit for bit; an H200 does both.
///
/// * ray_direction, ray_origin: sums of three terms of the size of the view plane; 4 roundings of those.
/// * tmax: a division and a product: 4 ulp.
/// * color: square roots, divisions and sums of terms below 1 or the value itself; a spot's cone multiplies
///   the error of a cosine by its scale.
/// * t, u, v: by the triangle's own bound, see [`raystep_kernels::reference`].
///
/// Integers, and what is only copied, must be equal but for rays that f32 cannot decide: [`Undecided`].
fn within(component: (Stream, usize), a: u32, b: u32, possible: Option<&Possible>, data: &SceneData) -> bool {
    let (x, y) = (f32::from_bits(a), f32::from_bits(b));
    let size = x.abs().max(y.abs()).max(1.0);
    let difference = f64::from((x - y).abs());
    match component {
        (Stream::RayOrigin | Stream::RayDirection, _) => (x - y).abs() <= 4.0 * f32::EPSILON * size,
        (Stream::TMax, _) => ulp(a, b) <= 4,
        (Stream::Hit, 0 | 1) => possible.is_some_and(|p| difference <= 2.0 * p.weight_bound),
        (Stream::State, 1) => possible.is_some_and(|p| difference <= 2.0 * p.t_bound),
        (Stream::Color, _) => {
            let cone = data.lights.iter().fold(1.0f32, |m, l| m.max(l.cone_scale));
            (x - y).abs() <= 64.0 * f32::EPSILON * size * cone
        }
        _ => false,
    }
}

/// A ray before a pass, and whether f32 can decide what the pass does with it.
struct Undecided<'a> {
    data: &'a SceneData,
    before: &'a [StreamData],
}

impl Undecided<'_> {
    fn component(&self, stream: Stream, layer: usize, ray: usize) -> u32 {
        self.before.iter().find(|s| s.stream == stream).map_or(0, |s| s.get(layer, ray))
    }

    fn floats(&self, stream: Stream, ray: usize) -> [f32; 3] {
        [0, 1, 2].map(|layer| f32::from_bits(self.component(stream, layer, ray)))
    }

    /// The triangles that a pass tests, as f64 sees them.
    fn tested(&self, kernel: Kernel, ray: usize) -> Vec<Possible> {
        let (cell, item) = (self.component(Stream::State, 2, ray), self.component(Stream::State, 3, ray));
        let [origin, direction] = [Stream::RayOrigin, Stream::RayDirection].map(|s| self.floats(s, ray));
        let seen = |triangle| possible(&self.data.vertices, origin, direction, triangle);
        match kernel {
            Kernel::Intersect => {
                let (first, count) = self.data.list(cell);
                (item..count.min(item + 1)).filter_map(|i| seen(self.data.listed(first + i))).collect()
            }
            Kernel::Walk | Kernel::Fused => (0..self.data.info.triangles).filter_map(seen).collect(),
            _ => Vec::new(),
        }
    }

    /// Whether one of the boxes that a pass tests is met or missed by less than it was grown by.
    fn grazes_a_box(&self, ray: usize, origin: [f64; 3], direction: [f64; 3]) -> bool {
        let [origin, direction] = [origin, direction].map(Vec3::<f64>::from);
        let inverse = finite_inverse(direction);
        let nearest_t = f64::from(f32::from_bits(self.component(Stream::State, 1, ray)));
        let (node, previous) = (self.component(Stream::State, 2, ray), self.component(Stream::Previous, 0, ray));
        let mut at = Visit { node, previous, in_leaf: false };
        let steps = if self.data.features.many_steps { self.data.info.steps } else { 1 };
        for _ in 0..steps {
            let Some(node) = self.data.bvh_nodes.get(at.node as usize) else { break };
            let growth = f64::from(self.data.growth);
            let resized = |by: f64| {
                let side = |v: [f32; 3], by: f64| Vec3::<f64>::from_f32(v) + Vec3::splat(by);
                let (t0, t1) = ((side(node.min, -by) - origin) * inverse, (side(node.max, by) - origin) * inverse);
                let (t0, t1) = (t0.to_array(), t1.to_array());
                let enter = (0..3).map(|a| t0[a].min(t1[a])).fold(0.0, f64::max);
                let leave = (0..3).map(|a| t0[a].max(t1[a])).fold(nearest_t, f64::min);
                enter <= leave
            };
            if resized(growth) != resized(-growth) {
                return true;
            }
            at = next_node(&self.data.bvh_nodes, &self.data.bvh_parents, at, origin, direction, inverse, nearest_t);
            if at.in_leaf {
                break;
            }
        }
        false
    }

    /// Whether rounding alone may send the ray another way.
    fn may_part(&self, kernel: Kernel, ray: usize) -> bool {
        let [origin, direction] = [Stream::RayOrigin, Stream::RayDirection].map(|s| self.floats(s, ray).map(f64::from));
        let grid = &self.data.grid;
        let growth = f64::from(self.data.growth);
        // Distance of a point from the nearest plane of the grid, along its axis.
        let near_plane = |point: [f64; 3], without: Option<usize>| {
            (0..3).filter(|&a| without != Some(a)).any(|a| {
                let width = f64::from(grid.width[a]);
                let at = (point[a] - f64::from(grid.corner[a])) / width;
                (at - at.round()).abs() * width <= growth
            })
        };
        let at = |t: f64| [0, 1, 2].map(|a| origin[a] + direction[a] * t);
        match kernel {
            // The entry point lies on a face of the grid's box: that axis is clamped, the other two may be near
            // a plane by chance.
            Kernel::Setup => {
                let (mut enter, mut axis) = (0.0, None);
                for a in (0..3).filter(|&a| direction[a] != 0.0) {
                    let face = |i: i32| f64::from(grid.corner[a]) + f64::from(grid.width[a]) * f64::from(i);
                    let t = [face(0), face(grid.cells[a])].map(|f| (f - origin[a]) / direction[a]);
                    if t[0].min(t[1]) > enter {
                        (enter, axis) = (t[0].min(t[1]), Some(a));
                    }
                }
                near_plane(at(enter), axis)
            }
            Kernel::Intersect | Kernel::Walk | Kernel::Fused => {
                let tested = self.tested(kernel, ray);
                let exit = self.floats(Stream::TMax, ray).into_iter().fold(f32::INFINITY, f32::min);
                let nearest = f32::from_bits(self.component(Stream::State, 1, ray));
                let parts = |(i, p): (usize, &Possible)| {
                    let close = |t: f64| (t - p.t).abs() <= 2.0 * p.t_bound;
                    let is_paper_grid = !self.data.features.robust && self.data.features.grid;
                    let crosses_a_face = is_paper_grid && near_plane(at(p.t), None);
                    let is_tie = || tested[..i].iter().any(|q| close(q.t));
                    !p.is_definite || close(exit.into()) || close(nearest.into()) || crosses_a_face || is_tie()
                };
                tested.iter().enumerate().any(parts)
            }
            Kernel::TraverseBvh => self.grazes_a_box(ray, origin, direction),
            // The comparisons of traverse are of numbers that both sides read from the same stream.
            Kernel::Generate | Kernel::TraverseGrid | Kernel::Shade => false,
        }
    }
}

/// A component that differs by more than it may.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Breach {
    /// The kernel after which it differs.
    pub kernel: Kernel,
    /// Pass of the run.
    pub pass: usize,
    /// Stream and layer.
    pub component: (Stream, usize),
    /// The ray's place, y * width + x.
    pub ray: usize,
    /// The GPU's bits.
    pub gpu: u32,
    /// The twin's bits.
    pub twin: u32,
}

impl fmt::Display for Breach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (stream, layer) = self.component;
        write!(f, "{} (pass {}): ", self.kernel.name(), self.pass)?;
        write!(f, "ray {} {}.{}: ", self.ray, stream.name(), stream.info().layers[layer])?;
        if stream.is_float_layer(layer) {
            write!(f, "gpu {:e}, twin {:e}", f32::from_bits(self.gpu), f32::from_bits(self.twin))
        } else {
            write!(f, "gpu {}, twin {}", self.gpu, self.twin)
        }
    }
}

/// What a comparison found.
#[derive(Clone, Debug, Default)]
pub struct Parity {
    /// Passes compared.
    pub passes: usize,
    /// Components compared.
    pub components: u64,
    /// Components that differ, but by no more than they may.
    pub tolerated: u64,
    /// Rays that went another way where f32 cannot decide.
    pub undecided: u64,
    /// Kernels that were compared on at least one ray.
    pub kernels: Vec<Kernel>,
    /// Rays that passes worked on, summed.
    pub rays: u64,
    /// Every way from a state to the next that a ray was seen to take.
    pub transitions: BTreeSet<(Tag, Kernel, Tag)>,
    /// What differs by more, at most 20 a kernel.
    pub breaches: Vec<Breach>,
}

/// Runs a scene on the GPU and compares every pass with the twin.
#[must_use]
pub fn compare(gpu: &Arc<Gpu>, scene: &Scene, options: &Options) -> Parity {
    compare_with(gpu, scene, options, |_| {})
}

/// The same after `change` had its way with the plan: a comparison that cannot fail proves nothing.
#[must_use]
pub fn compare_with(gpu: &Arc<Gpu>, scene: &Scene, options: &Options, change: impl FnOnce(&mut Plan)) -> Parity {
    block_on(Some(gpu), async {
        let device = Device::Gpu(gpu.clone());
        let limits = Limits::from(&gpu.device.limits());
        let (mut plan, data) = Plan::new(scene, options, &limits).expect("a plan");
        change(&mut plan);
        let mut renderer = Renderer::from_plan(plan, data, options, &device).await.expect("a renderer");
        let streams = streams_of(renderer.plan());
        let mut twin = CpuExecutor::<f32>::new(renderer.plan(), None).expect("memory");
        let mut found = Parity::default();

        // What no kernel writes keeps the poison on both sides and shows where it should not.
        let generates = renderer.next_kernel() == Some(Kernel::Generate);
        for &stream in streams.iter().filter(|&&s| generates && s != Stream::State) {
            let mut poison = renderer.values(stream).await.expect("values");
            poison.bits.fill(0x7fc0_dead);
            assert!(renderer.write(&poison));
        }
        loop {
            let mut before = Vec::new();
            for &stream in &streams {
                let values = renderer.values(stream).await.expect("values");
                assert!(twin.write(&values));
                before.push(values);
            }
            let Some(pass) = renderer.step().await.expect("a pass") else { break };
            twin.run(pass.kernel, renderer.data());
            found.passes += 1;
            if pass.rays_in > 0 && !found.kernels.contains(&pass.kernel) {
                found.kernels.push(pass.kernel);
            }
            let mut after = Vec::new();
            for &stream in &streams {
                after.push((renderer.values(stream).await.expect("values"), twin.read(stream).expect("the same plan")));
            }
            record(&mut found, &pass, &Undecided { data: renderer.data(), before: &before }, &after);
        }
        found
    })
}

fn record(found: &mut Parity, pass: &Pass, rules: &Undecided<'_>, after: &[(StreamData, StreamData)]) {
    found.rays += u64::from(pass.rays_in);
    let tags = after.iter().find(|(s, _)| s.stream == Stream::State).map(|(s, _)| s.layer(0));
    for (ray, &tag) in tags.unwrap_or_default().iter().enumerate() {
        let before = rules.component(Stream::State, 0, ray);
        if pass.kernel.info().active.contains(&before) {
            found.transitions.insert((before, pass.kernel, tag));
        }
    }
    // A ray that goes another way differs in several components: it is judged once, as a whole.
    let mut parted = BTreeMap::new();
    for (on_gpu, on_cpu) in after {
        found.components += on_gpu.bits.len() as u64;
        for (layer, ray, gpu, twin) in differences(on_gpu, on_cpu) {
            let possible = rules.tested(pass.kernel, ray);
            let by_one = |p: Option<&Possible>| within((on_gpu.stream, layer), gpu, twin, p, rules.data);
            if possible.iter().any(|p| by_one(Some(p))) || by_one(None) {
                found.tolerated += 1;
                continue;
            }
            // The count of repeated tests walks from the start again, through another first cell perhaps.
            if (on_gpu.stream, layer) == (Stream::Counters, 2) && rules.may_part(Kernel::Setup, ray) {
                found.undecided += 1;
                continue;
            }
            if *parted.entry(ray).or_insert_with(|| rules.may_part(pass.kernel, ray)) {
                continue;
            }
            let breach =
                Breach { kernel: pass.kernel, pass: pass.index, component: (on_gpu.stream, layer), ray, gpu, twin };
            if found.breaches.iter().filter(|b| b.kernel == pass.kernel).count() < 20 {
                found.breaches.push(breach);
            }
        }
    }
    found.undecided += parted.values().filter(|&&may| may).count() as u64;
}
