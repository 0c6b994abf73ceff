//! The kinds of panels.

use serde::{Deserialize, Serialize};

macro_rules! kinds {
    ($($(#[$about:meta])* $name:ident),* $(,)?) => {
        /// A kind of panel.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
        pub enum PaneKind {
            $($(#[$about])* $name),*
        }

        impl PaneKind {
            /// Every kind.
            pub const ALL: &[Self] = &[$(Self::$name),*];
        }
    };
}

kinds! {
    /// The passes.
    Passes,
    /// A stream.
    Stream,
    /// The selected ray's history.
    Ray,
    /// Its walk in 3D.
    Walk3d,
    /// Its walk, unfolded.
    Walk2d,
    /// Where the light of the selected pixel comes from.
    LightTree,
    /// The paths of all pixels, bounce by bounce.
    Bounces,
    /// Rays in each state, over passes or time.
    Timeline,
    /// The kernel's WGSL with the branches taken.
    Kernel,
    /// Kernels and streams.
    Dataflow,
    /// Durations.
    Timings,
    /// What the run needs, and what is omitted.
    Plan,
    /// The cost of rays.
    Cost,
    /// Statistics of the grid or BVH.
    Structure,
    /// Comparison of two runs.
    Compare,
    /// Differences between GPU and CPU reference.
    Divergence,
    /// Rays not yet resolved, and resolved wrongly, over time.
    Error,
    /// Time and wrong rays of every structure, schedule and set of rules.
    Choices,
    /// Kept runs.
    Runs,
    /// Watches and edits.
    Watches,
    /// The options of the run.
    Options,
    /// The built-in lessons.
    Lessons,
    /// Messages.
    Log,
}
