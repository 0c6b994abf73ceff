//! The cost of rays, and the share of launched threads that have work to do.

mod cast;
mod lanes;
mod visits;
mod warps;

use raystep_kernels::programs;
use raystep_kernels::tables::kernel::Role;
use raystep_kernels::tables::state::Tag;
use raystep_kernels::{Kernel, StreamData, named};

pub use cast::{Cast, begins_walks, is_shadow};
pub use lanes::{LANES, Lanes, Launch};
pub use visits::{Visits, has_single_steps, single_steps, visits};
pub use warps::{NO_RAY, PassLanes, Survey, WIDTHS, Warp, threads};

/// How to measure a ray's cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Measure {
    /// Cells or nodes visited.
    Cells,
    /// Triangles tested.
    Triangles,
    /// Both together: with one step per pass, the walk's passes that worked on the ray.
    #[default]
    Sum,
}

named!(Measure, Cells "cells", Triangles "triangles", Sum "sum");

/// How often kernels worked on each ray, derived from states: for runs without the `counters` stream, with one step per
/// pass.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Passes that moved the ray to a cell or node.
    pub cells: Vec<u32>,
    /// Passes that tested it against a triangle.
    pub triangles: Vec<u32>,
}

impl Work {
    /// No work so far, for this many rays.
    #[must_use]
    pub fn new(rays: usize) -> Self {
        Self { cells: vec![0; rays], triangles: vec![0; rays] }
    }

    /// Adds a pass; `tags_before` is the first layer of the `state` stream before it.
    pub fn add(&mut self, kernel: Kernel, tags_before: &[Tag]) {
        let counts = match kernel.role() {
            Role::Step => &mut self.cells,
            Role::Test => &mut self.triangles,
            _ => return,
        };
        for (count, tag) in counts.iter_mut().zip(tags_before) {
            *count += u32::from(kernel.takes().contains(tag));
        }
    }

    /// The cost of each ray.
    #[must_use]
    pub fn costs(&self, by: Measure) -> Vec<u32> {
        charged(by, &self.cells, &self.triangles)
    }
}

/// The cost of each of the first `rays` rays in the `counters` stream; `None` for another stream.
#[must_use]
pub fn costs(counters: &StreamData, rays: usize, by: Measure) -> Option<Vec<u32>> {
    let layer = |layer: usize| &counters.layer(layer)[..rays.min(counters.layer(layer).len())];
    programs::are_counters(counters.stream).then(|| charged(by, layer(0), layer(1)))
}

fn charged(by: Measure, cells: &[u32], triangles: &[u32]) -> Vec<u32> {
    match by {
        Measure::Cells => cells.to_vec(),
        Measure::Triangles => triangles.to_vec(),
        Measure::Sum => cells.iter().zip(triangles).map(|(c, t)| c.saturating_add(*t)).collect(),
    }
}

/// Rays by cost, the most expensive first; rays of equal cost are ordered by index. Takes 12 bytes of memory per ray.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CostOrder {
    costs: Vec<u32>,
    rays: Vec<u32>,
    ranks: Vec<u32>,
}

impl CostOrder {
    /// Sorts rays by their costs.
    #[must_use]
    pub fn new(costs: Vec<u32>) -> Self {
        let mut rays: Vec<u32> = (0..costs.len() as u32).collect();
        rays.sort_by_key(|&ray| std::cmp::Reverse(costs[ray as usize]));
        let mut ranks = vec![0; costs.len()];
        for (rank, &ray) in (0..).zip(&rays) {
            ranks[ray as usize] = rank;
        }
        Self { costs, rays, ranks }
    }

    /// The cost of every ray, for a heat map.
    #[must_use]
    pub fn costs(&self) -> &[u32] {
        &self.costs
    }

    /// The rays, most expensive first.
    #[must_use]
    pub fn rays(&self) -> &[u32] {
        &self.rays
    }

    /// A ray's cost.
    #[must_use]
    pub fn cost(&self, ray: usize) -> Option<u32> {
        self.costs.get(ray).copied()
    }

    /// A ray's position in the order; the most expensive one has 0.
    #[must_use]
    pub fn rank(&self, ray: usize) -> Option<usize> {
        self.ranks.get(ray).map(|&rank| rank as usize)
    }

    /// The most expensive ray.
    #[must_use]
    pub fn dearest(&self) -> Option<usize> {
        self.rays.first().map(|&ray| ray as usize)
    }

    /// The next more expensive ray; `None` at the most expensive.
    #[must_use]
    pub fn dearer(&self, ray: usize) -> Option<usize> {
        self.rays.get(self.rank(ray)?.checked_sub(1)?).map(|&ray| ray as usize)
    }

    /// The next cheaper ray; `None` at the cheapest.
    #[must_use]
    pub fn cheaper(&self, ray: usize) -> Option<usize> {
        self.rays.get(self.rank(ray)? + 1).map(|&ray| ray as usize)
    }

    /// The sum of all costs.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.costs.iter().map(|&cost| u64::from(cost)).sum()
    }

    /// The fewest rays that together have half of the total cost; 0 without any.
    #[must_use]
    pub fn half(&self) -> usize {
        let (total, mut sum) = (self.total(), 0);
        let is_needed = |&&ray: &&u32| {
            let is_less = 2 * sum < total;
            sum += u64::from(self.costs[ray as usize]);
            is_less
        };
        self.rays.iter().take_while(is_needed).count()
    }

    /// Share of the total cost in the most expensive `share` (0 to 1) of the rays.
    #[must_use]
    pub fn share_of_dearest(&self, share: f64) -> f64 {
        let count = (share.clamp(0.0, 1.0) * self.rays.len() as f64).round() as usize;
        let theirs: u64 = self.rays[..count].iter().map(|&ray| u64::from(self.costs[ray as usize])).sum();
        theirs as f64 / self.total().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use raystep_kernels::{Device, Options, RaySource, Renderer, ScheduleKind};
    use raystep_scenes::generate;

    use raystep_kernels::programs::closest_hit::streams;

    use super::*;

    #[test]
    fn rays_are_walked_through_from_the_dearest_to_the_cheapest_and_back() {
        let order = CostOrder::new(vec![3, 9, 0, 9, 3, 4]);
        assert_eq!(order.rays(), [1, 3, 5, 0, 4, 2]);
        let mut ray = order.dearest().expect("rays");
        let mut seen = vec![ray];
        while let Some(next) = order.cheaper(ray) {
            assert_eq!(order.dearer(next), Some(ray));
            ray = next;
            seen.push(ray);
        }
        assert_eq!(seen, [1, 3, 5, 0, 4, 2]);
        assert_eq!((order.dearer(1), order.rank(5), order.cost(5)), (None, Some(2), Some(4)));
        assert_eq!((order.dearer(6), order.cheaper(6), order.rank(6), order.cost(6)), (None, None, None, None));
        assert_eq!((order.total(), order.share_of_dearest(1.0 / 3.0)), (28, 18.0 / 28.0));
        assert_eq!((order.share_of_dearest(0.0), order.share_of_dearest(7.0)), (0.0, 1.0));
        let half = |costs: &[u32]| CostOrder::new(costs.to_vec()).half();
        assert_eq!([&[][..], &[0, 0], &[1], &[3, 1, 3], &[5, 1, 4]].map(half), [0, 0, 1, 2, 1]);
        assert_eq!((CostOrder::new(Vec::new()).dearest(), CostOrder::new(Vec::new()).total()), (None, 0));
    }

    /// The derived numbers are what the kernels count.
    #[test]
    fn passes_that_work_on_a_ray_are_its_cells_and_triangles() {
        let scene = generate::cornell_box();
        let camera = scene.cameras[0].clone();
        let mut options = Options::new(RaySource::Camera { camera, width: 12, height: 10 });
        (options.schedule, options.counters) = (ScheduleKind::Second, true);
        pollster::block_on(async {
            let mut renderer = Renderer::new(&scene, &options, &Device::Cpu(None)).await.expect("a renderer");
            let mut work = Work::new(120);
            while let Some(kernel) = renderer.next_kernel() {
                let state = renderer.values(streams::STATE).await.expect("state");
                work.add(kernel, state.layer(0));
                renderer.step().await.expect("a pass");
            }
            renderer.run(|_| ControlFlow::Continue(())).await.expect("at the end");
            let counters = renderer.values(streams::COUNTERS).await.expect("counters");
            let triangles = costs(&counters, 120, Measure::Triangles).expect("counters");
            assert!(triangles.iter().any(|&n| n > 0));
            // A pass may find an empty list, and entering the first cell is not a step.
            let counted = costs(&counters, 120, Measure::Cells).expect("counters");
            for ray in 0..120 {
                assert!(work.triangles[ray] >= triangles[ray], "ray {ray}");
                assert!(work.cells[ray].abs_diff(counted[ray]) <= 1, "ray {ray}");
            }
            let sum = costs(&counters, 120, Measure::Sum).expect("counters");
            assert!((0..120).all(|ray| sum[ray] == counted[ray] + triangles[ray]));
            assert_eq!(costs(&counters, 7, Measure::Sum).expect("counters"), sum[..7]);
            let state = renderer.values(streams::STATE).await.expect("state");
            assert_eq!(costs(&state, 120, Measure::Sum), None);
        });
    }
}
