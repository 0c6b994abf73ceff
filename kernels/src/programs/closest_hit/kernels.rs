//! Every kernel, in one table: its WGSL, its twin, and the states it works on.

use super::{accumulate, fused, generate, intersect, setup, shade, traverse_bvh, traverse_grid, walk};
use crate::numbers::real::Real;
use crate::scene_data::SceneData;
use crate::shared::constants::{LIST_SIDE, WORKGROUP};
use crate::tables::kernel::Transition;
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
    /// One sentence.
    pub summary: &'static str,
}

macro_rules! kernels {
    ($($variant:ident $module:ident { takes: $takes:expr, sends: $sends:expr, summary: $summary:literal, })*) => {
        /// Every kernel.
        pub const KERNELS: &[KernelInfo] = &[$(KernelInfo {
            kernel: Kernel::$variant,
            name: stringify!($module),
            wgsl: include_str!(concat!(stringify!($module), ".wgsl")),
            takes: $takes,
            sends: $sends,
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
        summary: "makes a ray for every pixel",
    }
    Setup setup {
        takes: &[TRAV_SETUP],
        sends: &[
            send(TRAV_SETUP, "misses the grid's box", BACKGROUND),
            send(TRAV_SETUP, "enters the grid", ISECT_NO_HIT),
            send(TRAV_SETUP, "with a tree: at its root", TRAV),
        ],
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
        summary: "moves the ray to its next node of the tree",
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
        summary: "takes the ray several cells or nodes on",
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
        summary: "takes the ray from its start to its nearest hit",
    }
    Shade shade {
        takes: &[SHADE, BACKGROUND],
        sends: &[
            send(SHADE, "loop turns spent, lights are left", SHADE),
            send(SHADE, "shaded", DONE),
            send(BACKGROUND, "background", DONE),
        ],
        summary: "colours the ray from its hit, or the background",
    }
    Accumulate accumulate {
        takes: &[DONE],
        sends: &[
            send(DONE, "the pixel wants more samples", UNWRITTEN),
            send(DONE, "it was the last sample", DONE),
        ],
        summary: "adds the sample to its pixel's mean, and asks for the next one",
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
        match self {
            Self::Generate => Some(TRAV_SETUP),
            Self::Shade => Some(DONE),
            _ => None,
        }
    }
    /// Whether it belongs to the walk: it runs again and again.
    #[must_use]
    pub const fn is_walk(self) -> bool {
        matches!(self, Self::TraverseGrid | Self::TraverseBvh | Self::Intersect | Self::Walk)
    }
    /// Invocations of its workgroups along x and y.
    #[must_use]
    pub const fn workgroup(self) -> u32 {
        match self {
            Self::Generate | Self::Fused | Self::Shade => WORKGROUP,
            _ => LIST_SIDE,
        }
    }
    /// How many of these rays it would work on.
    #[must_use]
    pub fn live(self, counts: &StateCounts) -> u32 {
        self.info().takes.iter().map(|&tag| counts[tag as usize]).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_the_order_of_the_enum() {
        for (i, info) in KERNELS.iter().enumerate() {
            assert_eq!(info.kernel as usize, i, "{}", info.name);
        }
    }

    #[test]
    fn every_row_sends_what_it_takes_and_no_state_is_a_dead_end() {
        let taken: Vec<Tag> = KERNELS.iter().flat_map(|info| info.takes).copied().collect();
        for info in KERNELS {
            for &tag in info.takes {
                assert!(info.sends.iter().any(|s| s.from == tag), "{} keeps {tag}", info.name);
            }
            for send in info.sends {
                // The fused kernel also takes rays that nothing has made yet, where it makes them itself.
                let is_own = info.takes.contains(&send.from) || (info.kernel, send.from) == (Kernel::Fused, UNWRITTEN);
                assert!(is_own && taken.contains(&send.to), "{}: {send:?}", info.name);
            }
            if let Some(to) = info.kernel.sends_all_to() {
                assert!(info.sends.iter().all(|s| s.to == to || s.to == s.from), "{}", info.name);
            }
        }
    }
}
