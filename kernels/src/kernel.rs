//! Every kernel, in one table: its WGSL, its twin, and the states it works on.

use crate::real::Real;
use crate::scene_data::SceneData;
use crate::shared::constants::{LIST_SIDE, WORKGROUP};
use crate::state::{self, StateCounts, Tag};
use crate::tables::texels::Texels;
use crate::{accumulate, fused, generate, intersect, setup, shade, traverse_bvh, traverse_grid, walk};

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

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct KernelInfo {
    /// Which kernel.
    pub kernel: Kernel,
    /// Name of the file, of the entry point, and in reports.
    pub name: &'static str,
    /// Source with its options still in it (WESL).
    pub wgsl: &'static str,
    /// Tags of the rays it works on.
    pub active: &'static [Tag],
    /// One sentence.
    pub summary: &'static str,
}

macro_rules! kernels {
    ($($variant:ident $module:ident $active:expr, $summary:literal;)*) => {
        /// Every kernel.
        pub const KERNELS: &[KernelInfo] = &[$(KernelInfo {
            kernel: Kernel::$variant,
            name: stringify!($module),
            wgsl: include_str!(concat!(stringify!($module), ".wgsl")),
            active: $active,
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

// A kernel is two files, x.wgsl and x.rs, and one line here.
kernels! {
    Generate generate &[state::UNWRITTEN], "makes a ray for every pixel";
    Setup setup &[state::TRAV_SETUP], "finds where the ray's walk begins, or that it misses the grid";
    TraverseGrid traverse_grid &[state::TRAV], "moves the ray to its next cell";
    TraverseBvh traverse_bvh &[state::TRAV], "moves the ray to its next node of the tree";
    Intersect intersect &[state::ISECT_NO_HIT, state::ISECT_HIT], "tests the ray against one triangle of its cell or leaf";
    Walk walk &[state::TRAV, state::ISECT_NO_HIT, state::ISECT_HIT], "takes the ray several cells or nodes on";
    Fused fused &[state::TRAV_SETUP, state::TRAV, state::ISECT_NO_HIT, state::ISECT_HIT], "takes the ray from its start to its nearest hit";
    Shade shade &[state::SHADE, state::BACKGROUND], "colours the ray from its hit, or the background";
    Accumulate accumulate &[state::DONE], "adds the sample to its pixel's mean, and asks for the next one";
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
            Self::Generate => Some(state::TRAV_SETUP),
            Self::Shade => Some(state::DONE),
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
        self.info().active.iter().map(|&tag| counts[tag as usize]).sum()
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
}
