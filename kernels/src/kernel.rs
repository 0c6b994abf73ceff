//! Every kernel, in one table: its WGSL, its twin, and the states it works on.

use crate::executor::cpu::Twin;
use crate::real::Real;
use crate::state::{self, StateCounts, Tag};
use crate::{generate, intersect, setup, shade, traverse_grid};

/// A kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kernel {
    /// Makes eye rays.
    Generate,
    /// Finds a ray's first cell.
    Setup,
    /// Moves a ray to its next cell.
    TraverseGrid,
    /// Tests one triangle a ray.
    Intersect,
    /// Colours what was hit.
    Shade,
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
    Setup setup &[state::TRAV_SETUP], "finds the ray's first cell, or that it misses the grid";
    TraverseGrid traverse_grid &[state::TRAV], "moves the ray to its next cell";
    Intersect intersect &[state::ISECT_NO_HIT, state::ISECT_HIT], "tests the ray against one triangle of its cell";
    Shade shade &[state::SHADE, state::BACKGROUND], "colours the ray from its hit, or the background";
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
