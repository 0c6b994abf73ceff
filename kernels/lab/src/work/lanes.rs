//! Useful lanes: how many of the threads that a GPU launches together have a ray to work on.

use raystep_kernels::options::features::Features;
use raystep_kernels::tables::kernel::Role;
use raystep_kernels::tables::state::Tag;
use raystep_kernels::{Kernel, Pass, Plan};

use super::warps::threads;

/// Threads that run in lockstep: 32 on most GPUs. On devices with 64, two adjacent groups run together.
pub const LANES: usize = 32;

/// How a kernel's threads find their rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Launch {
    /// One thread per pixel, in the order of [`threads`].
    Tiles,
    /// One thread per entry of the list of rays that wait for the kernel: all groups except the last are full.
    List,
}

impl Launch {
    /// How a kernel is launched in a run with these options.
    #[must_use]
    pub fn of(kernel: Kernel, features: &Features) -> Self {
        if features.live_lists && kernel.is_walk() { Self::List } else { Self::Tiles }
    }
}

/// How many threads of each group of [`LANES`] have a ray to work on. Says nothing about how long each works: in
/// kernels that loop, fewer lanes are useful than have work at the start.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lanes {
    /// How the kernel was launched.
    pub launch: Launch,
    /// How many groups have 0, 1, … 32 threads with work.
    pub histogram: [u64; LANES + 1],
}

impl Lanes {
    /// Lanes of a pass; `tags_before` is the first layer of the `state` stream before it, needed for tiles only. `None`
    /// if its size differs from the plan's images.
    #[must_use]
    pub fn of(pass: &Pass, plan: &Plan, tags_before: &[Tag]) -> Option<Self> {
        match Launch::of(pass.kernel, &plan.features) {
            Launch::List => Some(Self::of_list(pass.rays_in, pass.threads_launched)),
            Launch::Tiles => Self::of_tiles(pass.kernel, plan, tags_before),
        }
    }

    /// Lanes of a list with this many rays, and of the threads launched for it.
    fn of_list(rays: u32, threads: u64) -> Self {
        let (rays, width) = (rays as usize, LANES);
        let mut histogram = [0; LANES + 1];
        histogram[width] = (rays / width) as u64;
        if rays % width > 0 {
            histogram[rays % width] += 1;
        }
        histogram[0] = (threads / width as u64).saturating_sub(rays.div_ceil(width) as u64);
        Self { launch: Launch::List, histogram }
    }

    fn of_tiles(kernel: Kernel, plan: &Plan, tags: &[Tag]) -> Option<Self> {
        let (width, height) = (plan.width, plan.height);
        if tags.len() as u64 != u64::from(width) * u64::from(height) {
            return None;
        }
        // A kernel that traces whole rays may also generate them.
        let makes = plan.features.eye_rays && kernel.role() == Role::Whole;
        let begins = plan.program.course().filter(|_| makes).map(|course| [course.unborn, course.born]);
        let takes = begins.as_ref().map_or(kernel.takes(), |tags| tags.as_slice());
        let is_active = |tag: &Tag| takes.contains(tag);
        let mut histogram = [0; LANES + 1];
        for group in threads(kernel, [width, height]).chunks(LANES) {
            histogram[group.iter().filter(|&&ray| tags.get(ray as usize).is_some_and(is_active)).count()] += 1;
        }
        Some(Self { launch: Launch::Tiles, histogram })
    }

    /// The number of groups.
    #[must_use]
    pub fn groups(&self) -> u64 {
        self.histogram.iter().sum()
    }

    /// Threads with work.
    #[must_use]
    pub fn working(&self) -> u64 {
        (0..).zip(&self.histogram).map(|(lanes, groups)| lanes * groups).sum()
    }

    /// Threads with work per group, on average; 0 without a group.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.working() as f64 / self.groups().max(1) as f64
    }

    /// The mean over groups that have any work: the others end at once, and cost little.
    #[must_use]
    pub fn mean_where_any(&self) -> f64 {
        self.working() as f64 / (self.groups() - self.histogram[0]).max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use raystep_kernels::programs::closest_hit::kernels;
    use raystep_kernels::programs::closest_hit::states::{ISECT_HIT, ISECT_NO_HIT, TRAV, TRAV_SETUP};
    use raystep_kernels::{Limits, Options, RaySource, ScheduleKind};
    use raystep_scenes::generate;

    use super::*;

    fn planned(schedule: ScheduleKind, steps: u32, width: u32, height: u32) -> Plan {
        let scene = generate::cornell_box();
        let camera = scene.cameras[0].clone();
        let mut options = Options::new(RaySource::Camera { camera, width, height });
        (options.schedule, options.steps_per_pass) = (schedule, steps);
        Plan::new(&scene, &options, &Limits::CPU).expect("a small scene").0
    }

    fn pass(kernel: Kernel, rays_in: u32, threads_launched: u64) -> Pass {
        Pass { rays_in, threads_launched, ..Pass::of(kernel) }
    }

    #[test]
    fn a_group_has_the_pixels_of_32_threads_side_by_side() {
        let plan = planned(ScheduleKind::Second, 1, 40, 20);
        let mut tags = vec![TRAV; 40 * 20];
        // Two rows of 16 pixels each: (9, 6), (15, 7) in one group, (8, 8) in the next, (39, 19) in the last but six.
        for (x, y, tag) in [(9, 6, ISECT_HIT), (15, 7, ISECT_NO_HIT), (8, 8, ISECT_HIT), (39, 19, ISECT_HIT)] {
            tags[y * 40 + x] = tag;
        }
        let lanes = Lanes::of(&pass(kernels::INTERSECT, 4, 0), &plan, &tags).expect("the right size");
        assert_eq!((lanes.launch, lanes.histogram[1], lanes.histogram[2]), (Launch::Tiles, 2, 1));
        // Workgroups of 16 x 16 cover 48 x 32 pixels.
        assert_eq!((lanes.groups(), lanes.working()), (48 * 32 / 32, 4));
        assert_eq!((lanes.mean(), lanes.mean_where_any()), (4.0 / 48.0, 4.0 / 3.0));

        let lanes = Lanes::of(&pass(kernels::TRAVERSE_GRID, 796, 0), &plan, &tags).expect("the right size");
        assert_eq!((lanes.working(), lanes.histogram[32], lanes.histogram[31]), (796, 18, 1));
        // Workgroups of 8 x 8 cover 40 x 24 pixels, and no ray waits for this kernel.
        let lanes = Lanes::of(&pass(kernels::SHADE, 0, 0), &plan, &tags).expect("the right size");
        assert_eq!((lanes.groups(), lanes.histogram[0], lanes.mean_where_any()), (30, 30, 0.0));
        assert_eq!(Lanes::of(&pass(kernels::SHADE, 0, 0), &plan, &tags[1..]), None);
    }

    #[test]
    fn lists_are_dense() {
        let plan = planned(ScheduleKind::Compact, 1, 40, 20);
        for (rays, full, rest) in [(0, 0, 0), (32, 1, 0), (70, 2, 6)] {
            let lanes = Lanes::of(&pass(kernels::INTERSECT, rays, 2048), &plan, &[]).expect("a list");
            assert_eq!((lanes.launch, lanes.histogram[32], lanes.working()), (Launch::List, full, u64::from(rays)));
            assert_eq!(lanes.groups(), 64, "every thread launched is in a group");
            assert!(rest == 0 || lanes.histogram[rest] == 1);
        }
        // Twins have no threads, so nothing is reported about them.
        let lanes = Lanes::of(&pass(kernels::INTERSECT, 70, 0), &plan, &[]).expect("a list");
        assert_eq!((lanes.groups(), lanes.histogram[0]), (3, 0));
        // Set-up works on every pixel, listed or not; the rays that the fused kernel makes are not yet written.
        let tags = vec![TRAV_SETUP; 800];
        let lanes = Lanes::of(&pass(kernels::SETUP, 800, 0), &plan, &tags).expect("the right size");
        assert_eq!((lanes.launch, lanes.working()), (Launch::Tiles, 800));
    }
}
