//! Warps: the threads that a GPU runs in lockstep, and the rays that they work on.
//!
//! No stream tells in which subgroup a thread ran, so the mapping is assumed: the threads of a workgroup in the order of
//! their local index, as many at a time as a warp has lanes, and workgroups in the order of their index. Lists of live
//! rays are in the order in which workgroups would append to them if they ended in that order.

use raystep_kernels::shared::constants::LIST_GROUPS;
use raystep_kernels::tables::kernel::Role;
use raystep_kernels::tables::state::Tag;
use raystep_kernels::{Kernel, Plan};

use super::lanes::Launch;

/// The entry of a thread without a ray.
pub const NO_RAY: u32 = u32::MAX;

/// Widths of warps that can be assumed: each divides every workgroup.
pub const WIDTHS: [usize; 4] = [8, 16, 32, 64];

/// Threads of a workgroup that takes its rays from a list.
const LIST_THREADS: usize = 256;

/// The pixel of a thread within its workgroup, if the kernel launches every pixel: see `tiled_texel` in `live.wgsl`.
fn texel_in_workgroup(kernel: Kernel, lane: u32) -> [u32; 2] {
    if is_tiled(kernel) {
        return [(lane & 7) | ((lane >> 2) & 8), ((lane >> 3) & 3) | ((lane >> 4) & 12)];
    }
    let side = kernel.workgroup().max(1);
    [lane % side, lane / side]
}

/// Whether 32 threads side by side work on a tile of 8 by 4 pixels, by their own calculation.
fn is_tiled(kernel: Kernel) -> bool {
    matches!(kernel.role(), Role::Enter | Role::Sample)
}

/// The ray of every thread of a kernel that launches every pixel of an image, in launch order; [`NO_RAY`] outside of the
/// image.
#[must_use]
pub fn threads(kernel: Kernel, [width, height]: [u32; 2]) -> Vec<u32> {
    let side = kernel.workgroup().max(1);
    let in_workgroup: Vec<[u32; 2]> = (0..side * side).map(|lane| texel_in_workgroup(kernel, lane)).collect();
    let (columns, rows) = (width.div_ceil(side), height.div_ceil(side));
    let groups = (0..rows).flat_map(|row| (0..columns).map(move |column| [column * side, row * side]));
    let texels = groups.flat_map(|[left, top]| in_workgroup.iter().map(move |[x, y]| [left + x, top + y]));
    texels.map(|[x, y]| if x < width && y < height { y * width + x } else { NO_RAY }).collect()
}

/// The lanes of one pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassLanes {
    /// Its kernel.
    pub kernel: Kernel,
    /// How it finds its rays.
    pub launch: Launch,
    /// Threads with a ray to work on.
    pub working: u64,
    /// Warps launched.
    pub warps: u64,
    /// Warps in which any thread had work.
    pub busy: u64,
    /// Turns of the loops of all lanes, and the turns that they would be if every lane took as many as the longest of
    /// its warp; only for kernels of several steps, in runs with counters.
    pub turns: Option<[u64; 2]>,
}

impl PassLanes {
    /// Share of lanes with work, in warps with any; 0 without one.
    #[must_use]
    pub fn useful(&self, lanes: usize) -> f64 {
        self.working as f64 / (self.busy * lanes as u64).max(1) as f64
    }

    /// Share of lanes with work, of all that were launched.
    #[must_use]
    pub fn useful_of_all(&self, lanes: usize) -> f64 {
        self.working as f64 / (self.warps * lanes as u64).max(1) as f64
    }
}

/// Rays that share a warp: in every pass, or if rays are listed, when their walk begins.
#[derive(Clone, Debug, PartialEq)]
pub struct Warp {
    /// Its rays.
    pub rays: Vec<u32>,
    /// Passes of the walk that worked on any of them.
    pub passes: u32,
    /// Passes of those in which fewer than a quarter of its rays had work.
    pub sparse: u32,
    /// Share of its lanes that had work, over those passes.
    pub useful: f64,
    /// The ray with the longest walk: it held the others.
    pub slowest: u32,
    /// The passes that worked on it.
    pub slowest_passes: u32,
    /// The passes that worked on the median ray.
    pub median_passes: u32,
}

/// How the lanes of all passes of a run are used, one pass after the other.
#[derive(Clone, Debug)]
pub struct Survey {
    lanes: usize,
    passes: Vec<PassLanes>,
    /// Passes that worked on each ray.
    of_ray: Vec<u32>,
    /// Passes of the walk that worked on each ray.
    of_walk: Vec<u32>,
    /// The rays of each warp, `lanes` at a time.
    members: Vec<u32>,
    /// The warp of each ray.
    warp_of: Vec<u32>,
    /// For each warp: its rays with work in this pass, passes with any, and passes with fewer than a quarter.
    counts: Vec<[u32; 3]>,
    is_listed: bool,
    /// Rays that wait in each list, in order.
    lists: Vec<Vec<u32>>,
    /// The list of the rays in each state.
    list_of: Vec<Option<usize>>,
    size: [u32; 2],
}

impl Survey {
    /// Before the first pass of a run, for warps of this many lanes (one of [`WIDTHS`]). `None` for a program without
    /// rays.
    #[must_use]
    pub fn new(plan: &Plan, lanes: usize) -> Option<Self> {
        plan.program.course()?;
        let (size, kernels) = ([plan.width, plan.height], plan.schedule.kernels());
        let is_listed = plan.features.live_lists;
        let begins = |kernel: &&Kernel| if is_listed { kernel.role() == Role::Enter } else { kernel.is_walk() };
        let shape = kernels.iter().find(begins).or(kernels.first())?;
        let (members, rays) = (threads(*shape, size), plan.width as usize * plan.height as usize);
        let mut warp_of = vec![0; rays];
        for (thread, &ray) in members.iter().enumerate() {
            if let Some(warp) = warp_of.get_mut(ray as usize) {
                *warp = (thread / lanes) as u32;
            }
        }
        let list_of_tag = |tag: Tag| {
            let mut walk = kernels.iter().filter(|kernel| kernel.is_walk());
            walk.find(|kernel| kernel.takes().contains(&tag)).and_then(|kernel| kernel.list())
        };
        Some(Self {
            lanes,
            passes: Vec::new(),
            of_ray: vec![0; rays],
            of_walk: vec![0; rays],
            counts: vec![[0; 3]; members.len().div_ceil(lanes)],
            members,
            warp_of,
            is_listed,
            lists: vec![Vec::new(); plan.program.lists.len()],
            list_of: plan.program.states.iter().map(|state| list_of_tag(state.tag)).collect(),
            size,
        })
    }

    /// Adds a pass: the tags of all rays before and after it, and if the kernel loops, the turns of each ray's loop.
    /// Ignored if there are not as many as rays.
    pub fn add(&mut self, kernel: Kernel, before: &[Tag], after: &[Tag], turns: Option<&[u32]>) {
        if before.len() != self.of_ray.len() || after.len() != before.len() {
            return;
        }
        let is_list = self.is_listed && kernel.is_walk();
        let order = match kernel.list() {
            Some(list) if is_list => self.lists.get_mut(list).map(std::mem::take).unwrap_or_default(),
            _ => threads(kernel, self.size),
        };
        let takes = kernel.takes();
        let has_work = |ray: u32| before.get(ray as usize).is_some_and(|tag| takes.contains(tag));
        let mut now = PassLanes {
            kernel,
            launch: if is_list { Launch::List } else { Launch::Tiles },
            working: 0,
            warps: order.len().div_ceil(self.lanes) as u64,
            busy: 0,
            turns: turns.map(|_| [0; 2]),
        };
        if is_list {
            // Whole rows of workgroups are launched.
            let row = LIST_THREADS * LIST_GROUPS as usize;
            now.warps = (order.len().div_ceil(row) * row / self.lanes) as u64;
        }
        for warp in order.chunks(self.lanes) {
            let (mut working, mut longest) = (0, 0);
            for &ray in warp.iter().filter(|&&ray| has_work(ray)) {
                working += 1;
                self.of_ray[ray as usize] += 1;
                let turns = turns.and_then(|turns| turns.get(ray as usize)).copied().unwrap_or(0);
                longest = longest.max(turns);
                if let Some([taken, _]) = &mut now.turns {
                    *taken += u64::from(turns);
                }
            }
            now.working += working;
            now.busy += u64::from(working > 0);
            if let Some([_, waited]) = &mut now.turns {
                *waited += u64::from(longest) * self.lanes as u64;
            }
        }
        if kernel.is_walk() {
            self.charge(order.iter().copied().filter(|&ray| has_work(ray)));
        }
        if self.is_listed {
            for &ray in order.iter().filter(|&&ray| has_work(ray)) {
                let list = self.list_of.get(after[ray as usize] as usize).copied().flatten();
                if let Some(list) = list.and_then(|list| self.lists.get_mut(list)) {
                    list.push(ray);
                }
            }
        }
        self.passes.push(now);
    }

    /// Counts a pass for the warps of these rays.
    fn charge(&mut self, rays: impl Iterator<Item = u32>) {
        for ray in rays {
            self.of_walk[ray as usize] += 1;
            self.counts[self.warp_of[ray as usize] as usize][0] += 1;
        }
        for [now, any, sparse] in self.counts.iter_mut().filter(|[now, ..]| *now > 0) {
            *any += 1;
            *sparse += u32::from((*now as usize) * 4 < self.lanes);
            *now = 0;
        }
    }

    /// Lanes per warp.
    #[must_use]
    pub fn lanes(&self) -> usize {
        self.lanes
    }

    /// The passes so far.
    #[must_use]
    pub fn passes(&self) -> &[PassLanes] {
        &self.passes
    }

    /// The number of passes that worked on each ray.
    #[must_use]
    pub fn passes_of_rays(&self) -> &[u32] {
        &self.of_ray
    }

    /// Whether rays change warps from pass to pass, as they are listed anew.
    #[must_use]
    pub fn is_listed(&self) -> bool {
        self.is_listed
    }

    /// The warps with the most passes, at most `most`; those of equally many with the fewest useful lanes first.
    #[must_use]
    pub fn slowest(&self, most: usize) -> Vec<Warp> {
        let mut order: Vec<usize> = (0..self.counts.len()).filter(|&warp| self.counts[warp][1] > 0).collect();
        let worked = |warp: usize| self.rays(warp).map(|ray| u64::from(self.of_walk[ray as usize])).sum::<u64>();
        order.sort_by_cached_key(|&warp| (std::cmp::Reverse(self.counts[warp][1]), worked(warp)));
        order.truncate(most);
        order.into_iter().filter_map(|warp| self.warp(warp)).collect()
    }

    fn rays(&self, warp: usize) -> impl Iterator<Item = u32> + '_ {
        let members = self.members.chunks(self.lanes).nth(warp).unwrap_or_default();
        members.iter().copied().filter(|&ray| (ray as usize) < self.of_walk.len())
    }

    fn warp(&self, warp: usize) -> Option<Warp> {
        let [_, passes, sparse] = self.counts[warp];
        let rays: Vec<u32> = self.rays(warp).collect();
        let walked = |ray: u32| self.of_walk[ray as usize];
        let slowest = rays.iter().copied().max_by_key(|&ray| (walked(ray), std::cmp::Reverse(ray)))?;
        let mut sorted: Vec<u32> = rays.iter().map(|&ray| walked(ray)).collect();
        sorted.sort_unstable();
        let all = u64::from(passes) * self.lanes as u64;
        let useful = sorted.iter().map(|&n| u64::from(n)).sum::<u64>() as f64 / all.max(1) as f64;
        let median_passes = sorted.get(sorted.len() / 2).copied()?;
        Some(Warp { rays, passes, sparse, useful, slowest, slowest_passes: walked(slowest), median_passes })
    }
}

#[cfg(test)]
mod tests;
