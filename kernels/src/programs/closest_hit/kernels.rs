//! Every kernel, in one table: its WGSL, its twin, and the states it works on.

use super::{accumulate, fused, generate, intersect, setup, shade, traverse_bvh, traverse_grid, walk};
use crate::numbers::real::Real;
use crate::options::features::Features;
use crate::options::reasons::{
    EYE_RAYS, FUSED, GIVEN, MANY_STEPS, NO_SHADE, ONE_SAMPLE, ONE_STEP, Reason, Run, STEPPED, of_a_step,
};
use crate::scene_data::SceneData;
use crate::shared::constants::{LIST_SIDE, WORKGROUP};
use crate::tables::kernel::{Counts, Launch, ListInfo, Role, Transition};
use crate::tables::state::{
    BACKGROUND, DONE, ISECT_HIT, ISECT_NO_HIT, SHADE, StateCounts, TRAV, TRAV_SETUP, Tag, UNWRITTEN,
};
use crate::tables::texels::Texels;

/// A kernel's twin: one ray's work.
pub type Twin<R> = fn(&mut Texels<'_, R>, &SceneData);

/// A kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kernel {
    /// Makes eye rays.
    Generate,
    /// Finds a ray's first cell.
    Setup,
    /// Moves a ray to its next cell.
    TraverseGrid,
    /// Moves a ray to its next node of the tree.
    TraverseBvh,
    /// Tests one triangle.
    Intersect,
    /// Takes a ray several steps on.
    Walk,
    /// Takes a ray from its start to its hit.
    Fused,
    /// Colours what was hit.
    Shade,
    /// Adds a sample to its pixel's mean.
    Accumulate,
}

const fn send(from: Tag, when: &'static str, to: Tag) -> Transition {
    Transition { from, when, to }
}

/// Every list of live rays.
pub const LISTS: [ListInfo; 2] = [
    ListInfo { name: "intersect_list", slots: ["intersect_list_even", "intersect_list_odd"] },
    ListInfo { name: "traverse_list", slots: ["traverse_list_even", "traverse_list_odd"] },
];
const INTERSECT_LIST: usize = 0;
const TRAVERSE_LIST: usize = 1;

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct KernelInfo {
    /// Which kernel.
    pub kernel: Kernel,
    /// Name of the file, of the entry point, and in reports.
    pub name: &'static str,
    /// Source with its options still in it .
    pub wgsl: &'static str,
    /// Tags of the rays that it works on.
    pub takes: &'static [Tag],
    /// Where it sends them. A pass that leaves a ray's tag as it was is listed only where the kernel worked on the ray.
    /// `--numerics paper` and runs without a grid use a subset.
    pub sends: &'static [Transition],
    /// What it is for in a run.
    pub role: Role,
    /// Invocations of its workgroups along x and y.
    pub workgroup: u32,
    /// How it is launched over all rays.
    pub launch: Launch,
    /// How the host learns where it sent rays.
    pub counts: Counts,
    /// Whether a ray may wait there for the next dispatch, as one has too few loop turns for it.
    pub resumes: fn(&Features) -> bool,
    /// The list of the rays that wait for it, where only live rays are launched: an index into [`LISTS`].
    pub list: Option<usize>,
    /// Its colour in every diagram, sRGB: readable on light and dark.
    pub colour: [u8; 3],
    /// Why a run does without it.
    pub why_absent: fn(&Run<'_>) -> Reason,
    /// One sentence.
    pub summary: &'static str,
}

macro_rules! kernels {
    ($($variant:ident $module:ident { takes: $takes:expr, sends: $sends:expr, role: $role:expr, workgroup: $workgroup:expr, launch: $launch:expr, counts: $counts:expr, resumes: $resumes:expr, list: $list:expr, colour: $colour:expr, why_absent: $why_absent:expr, summary: $summary:literal, })*) => {
        /// Every kernel.
        pub const KERNELS: &[KernelInfo] = &[$(KernelInfo {
            kernel: Kernel::$variant,
            name: stringify!($module),
            wgsl: include_str!(concat!(stringify!($module), ".wgsl")),
            takes: $takes,
            sends: $sends,
            role: $role,
            workgroup: $workgroup,
            launch: $launch,
            counts: $counts,
            resumes: $resumes,
            list: $list,
            colour: $colour,
            why_absent: $why_absent,
            summary: $summary,
        }),*];

        impl Kernel {
            /// The kernel's twin: the same algorithm on the CPU.
            #[must_use]
            pub fn twin<R: Real>(self) -> Twin<R> {
                match self {
                    $(Kernel::$variant => $module::$module::<R>,)*
                }
            }
        }
    };
}

// A kernel is two files, x.wgsl and x.rs, and one row here.
kernels! {
    Generate generate {
        takes: &[UNWRITTEN],
        sends: &[
            send(UNWRITTEN, "every ray", TRAV_SETUP),
        ],
        role: Role::Source,
        workgroup: WORKGROUP,
        launch: Launch::Whole,
        counts: Counts::AllTo(TRAV_SETUP),
        resumes: |_| false,
        list: None,
        colour: [23, 150, 160],
        why_absent: |run| if run.features.eye_rays { EYE_RAYS } else { GIVEN },
        summary: "generates a ray for every pixel",
    }
    Setup setup {
        takes: &[TRAV_SETUP],
        sends: &[
            send(TRAV_SETUP, "misses the grid's box", BACKGROUND),
            send(TRAV_SETUP, "enters the grid", ISECT_NO_HIT),
            send(TRAV_SETUP, "with a BVH: at its root", TRAV),
        ],
        role: Role::Enter,
        workgroup: LIST_SIDE,
        launch: Launch::Whole,
        counts: Counts::Sent,
        resumes: |_| false,
        list: None,
        colour: [150, 120, 190],
        why_absent: |_| FUSED,
        summary: "finds where the ray's walk begins, or that it misses the grid",
    }
    TraverseGrid traverse_grid {
        takes: &[TRAV],
        sends: &[
            send(TRAV, "next cell", ISECT_NO_HIT),
            send(TRAV, "next cell, hit kept", ISECT_HIT),
            send(TRAV, "leaves the grid", BACKGROUND),
            send(TRAV, "leaves the grid, hit kept", SHADE),
        ],
        role: Role::Step,
        workgroup: LIST_SIDE,
        launch: Launch::Whole,
        counts: Counts::Sent,
        resumes: |_| false,
        list: Some(TRAVERSE_LIST),
        colour: [66, 124, 200],
        why_absent: of_a_step,
        summary: "moves the ray to its next cell",
    }
    TraverseBvh traverse_bvh {
        takes: &[TRAV],
        sends: &[
            send(TRAV, "inner node or box missed", TRAV),
            send(TRAV, "enters a leaf", ISECT_NO_HIT),
            send(TRAV, "enters a leaf, hit kept", ISECT_HIT),
            send(TRAV, "tree done", BACKGROUND),
            send(TRAV, "tree done, hit kept", SHADE),
        ],
        role: Role::Step,
        workgroup: LIST_SIDE,
        launch: Launch::Whole,
        counts: Counts::Sent,
        resumes: |_| false,
        list: Some(TRAVERSE_LIST),
        colour: [66, 124, 200],
        why_absent: of_a_step,
        summary: "moves the ray to its next node of the BVH",
    }
    Intersect intersect {
        takes: &[ISECT_NO_HIT, ISECT_HIT],
        sends: &[
            send(ISECT_NO_HIT, "tested one triangle, no hit", ISECT_NO_HIT),
            send(ISECT_NO_HIT, "nearer hit", ISECT_HIT),
            send(ISECT_HIT, "tested one triangle", ISECT_HIT),
            send(ISECT_NO_HIT, "last triangle hit, within this cell", SHADE),
            send(ISECT_NO_HIT, "list ended, or last triangle hit beyond this cell", TRAV),
            send(ISECT_HIT, "list ended, t within this cell", SHADE),
            send(ISECT_HIT, "list ended, t beyond the cell's exit", TRAV),
            send(ISECT_NO_HIT, "without a grid: list ended, nothing hit", BACKGROUND),
        ],
        role: Role::Test,
        workgroup: LIST_SIDE,
        launch: Launch::Whole,
        counts: Counts::Sent,
        resumes: |features| features.resumes_scan,
        list: Some(INTERSECT_LIST),
        colour: [232, 140, 60],
        why_absent: |run| if run.features.many_steps { MANY_STEPS } else { FUSED },
        summary: "tests the ray against one triangle of its cell or leaf",
    }
    Walk walk {
        takes: &[TRAV, ISECT_NO_HIT, ISECT_HIT],
        sends: &[
            send(ISECT_NO_HIT, "steps taken, nothing hit", ISECT_NO_HIT),
            send(ISECT_NO_HIT, "steps taken, a hit kept", ISECT_HIT),
            send(ISECT_HIT, "steps taken, the hit kept", ISECT_HIT),
            send(ISECT_NO_HIT, "nearest hit found", SHADE),
            send(ISECT_HIT, "nearest hit found", SHADE),
            send(ISECT_NO_HIT, "walk over, nothing hit", BACKGROUND),
            send(TRAV, "steps taken", TRAV),
            send(TRAV, "tree done, hit", SHADE),
            send(TRAV, "tree done, nothing hit", BACKGROUND),
        ],
        role: Role::Walk,
        workgroup: LIST_SIDE,
        launch: Launch::Whole,
        counts: Counts::Sent,
        resumes: |features| features.resumes,
        list: Some(INTERSECT_LIST),
        colour: [190, 150, 30],
        why_absent: |run| if run.is_fused() { FUSED } else { ONE_STEP },
        summary: "moves the ray by several cells or nodes",
    }
    Fused fused {
        takes: &[TRAV_SETUP, TRAV, ISECT_NO_HIT, ISECT_HIT],
        sends: &[
            send(UNWRITTEN, "loop turns spent, in a list without a hit", ISECT_NO_HIT),
            send(UNWRITTEN, "loop turns spent, in a list, a hit kept", ISECT_HIT),
            send(UNWRITTEN, "loop turns spent, between nodes", TRAV),
            send(TRAV_SETUP, "loop turns spent, in a list without a hit", ISECT_NO_HIT),
            send(TRAV_SETUP, "loop turns spent, in a list, a hit kept", ISECT_HIT),
            send(TRAV_SETUP, "loop turns spent, between nodes", TRAV),
            send(ISECT_NO_HIT, "loop turns spent again", ISECT_NO_HIT),
            send(ISECT_NO_HIT, "loop turns spent again, a hit kept", ISECT_HIT),
            send(ISECT_NO_HIT, "hit", SHADE),
            send(ISECT_NO_HIT, "no hit", BACKGROUND),
            send(ISECT_HIT, "loop turns spent again", ISECT_HIT),
            send(ISECT_HIT, "hit", SHADE),
            send(TRAV, "loop turns spent again", TRAV),
            send(TRAV, "hit", SHADE),
            send(TRAV, "no hit", BACKGROUND),
            send(UNWRITTEN, "hit", SHADE),
            send(UNWRITTEN, "no hit", BACKGROUND),
            send(TRAV_SETUP, "hit", SHADE),
            send(TRAV_SETUP, "no hit", BACKGROUND),
        ],
        role: Role::Whole,
        workgroup: WORKGROUP,
        launch: Launch::Bands,
        counts: Counts::Anew,
        resumes: |features| features.resumes,
        list: None,
        colour: [200, 80, 140],
        why_absent: |_| STEPPED,
        summary: "takes the ray from its start to its nearest hit",
    }
    Shade shade {
        takes: &[SHADE, BACKGROUND],
        sends: &[
            send(SHADE, "loop turns spent, lights are left", SHADE),
            send(SHADE, "shaded", DONE),
            send(BACKGROUND, "background", DONE),
        ],
        role: Role::Finish,
        workgroup: WORKGROUP,
        launch: Launch::Whole,
        counts: Counts::AllTo(DONE),
        resumes: |features| features.resumes_light,
        list: None,
        colour: [90, 165, 90],
        why_absent: |_| NO_SHADE,
        summary: "colours the ray from its hit, or the background",
    }
    Accumulate accumulate {
        takes: &[DONE],
        sends: &[
            send(DONE, "the pixel wants more samples", UNWRITTEN),
            send(DONE, "it was the last sample", DONE),
        ],
        role: Role::Sample,
        workgroup: LIST_SIDE,
        launch: Launch::Whole,
        counts: Counts::Sent,
        resumes: |_| false,
        list: None,
        colour: [120, 130, 140],
        why_absent: |_| ONE_SAMPLE,
        summary: "adds the sample to its pixel's mean, and requests the next one",
    }
}

/// The state machine: what the rows of all kernels say of the states between which they send rays.
pub fn transitions() -> impl Iterator<Item = (Kernel, &'static Transition)> {
    KERNELS.iter().flat_map(|info| info.sends.iter().map(|transition| (info.kernel, transition)))
}

impl Kernel {
    /// Its row of the table.
    #[must_use]
    pub const fn info(self) -> &'static KernelInfo {
        &KERNELS[self as usize]
    }
    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.info().name
    }
    /// The state in which it leaves every ray that it works on, where there is only one.
    #[must_use]
    pub const fn sends_all_to(self) -> Option<Tag> {
        match self.info().counts {
            Counts::AllTo(tag) => Some(tag),
            Counts::Sent | Counts::Anew => None,
        }
    }
    /// Whether the rays in each state are counted anew after a pass of it, in a run with these options.
    #[must_use]
    pub fn is_counted_anew(self, features: &Features) -> bool {
        let info = self.info();
        match info.counts {
            Counts::Sent => false,
            Counts::AllTo(_) => (info.resumes)(features),
            Counts::Anew => true,
        }
    }
    /// What it is for in a run.
    #[must_use]
    pub const fn role(self) -> Role {
        self.info().role
    }
    /// Whether it belongs to the walk: it runs again and again.
    #[must_use]
    pub const fn is_walk(self) -> bool {
        self.info().role.is_walk()
    }
    /// Invocations of its workgroups along x and y.
    #[must_use]
    pub const fn workgroup(self) -> u32 {
        self.info().workgroup
    }
    /// How many of these rays it would work on.
    #[must_use]
    pub fn live(self, counts: &StateCounts) -> u32 {
        self.info().takes.iter().map(|&tag| counts[tag as usize]).sum()
    }
}

#[cfg(test)]
mod tests;
