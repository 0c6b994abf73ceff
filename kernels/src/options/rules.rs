//! The numerical rules of a run.

use super::mapping::Mapping;
use crate::numbers::named::named;

/// The rules for planes, steps and hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Numerics {
    /// No missed, false or wrong hits except ties.
    #[default]
    Robust,
    /// The paper's rules, kept as a baseline.
    Paper,
}

/// Which of several hits is the nearest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Order {
    /// The one with the smallest t as f32 has it. Of two that are closer than rounding, the structure may decide.
    #[default]
    Rounded,
    /// The one with the smallest exact t, whatever the structure, the schedule and the device.
    Exact,
}

/// How rays walk through a uniform grid. Both visit the same cells, but for rounding and ties.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Traversal {
    /// By the smallest tMax (Amanatides and Woo, 1987).
    #[default]
    AmanatidesWoo,
    /// By control terms along a driving axis (Fujimoto, Tanaka and Iwata, 1986). It computes no t, so it is only for the
    /// paper's numerics, which need none to accept a hit.
    Dda3d,
}

/// A rule of robust numerics that can be switched off to measure its effect. See `docs/numerics.md`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Rule {
    /// tMax is computed from the cell's integer coordinates. Without this rule it is accumulated from tDelta, and so is
    /// its error; empty cells are then not skipped.
    TMax,
    /// The nearest hit is kept, and accepted at t ≤ exit. Without this rule, a hit counts only inside the cell being
    /// tested.
    Acceptance,
    /// The watertight test. Without it, Möller and Trumbore's test.
    TriangleTest,
    /// Cells are grown by the bound on rounding errors before triangles are assigned to them. Without this rule, they
    /// are not.
    CellGrowth,
    /// Boxes of the BVH are grown likewise. Without this rule, they are not.
    BoxPadding,
    /// Of [`Order::Exact`]: hits are ordered by exact t. Without this rule, by t as f32 has it.
    ExactOrder,
}

named!(
    Rule,
    "tmax, acceptance, triangle-test, cell-growth, box-padding, exact-order",
    TMax "tmax",
    Acceptance "acceptance",
    TriangleTest "triangle-test",
    CellGrowth "cell-growth",
    BoxPadding "box-padding",
    ExactOrder "exact-order"
);
named!(Numerics, "robust, paper", Robust "robust", Paper "paper");
named!(Order, "rounded, exact", Rounded "rounded", Exact "exact");
named!(Traversal, "amanatides-woo, 3d-dda", AmanatidesWoo "amanatides-woo", Dda3d "3d-dda");

impl Order {
    /// Why hits cannot be ordered so in a run with these options, and what would work.
    #[must_use]
    pub fn fault(self, numerics: Numerics, mapping: Mapping) -> Option<&'static str> {
        let why = match (self, numerics, mapping) {
            (Self::Exact, Numerics::Paper, _) => "the paper accepts the first hit in a cell; use --numerics robust",
            (Self::Exact, _, Mapping::Fragment(_)) => {
                "fragment programs have no outputs left for its bounds; use --mapping compute"
            }
            _ => return None,
        };
        Some(why)
    }
}
