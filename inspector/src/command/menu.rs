//! The menus that commands are in.

use raystep_kernels::named;

/// A menu.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Menu {
    /// Scenes, links, exports.
    File,
    /// Passes.
    Step,
    /// The ray.
    Ray,
    /// How things are shown.
    View,
    /// Panels and their layouts.
    Panels,
    /// Two runs.
    Compare,
    /// Help and lessons.
    Help,
}

named!(Menu, File "File", Step "Step", Ray "Ray", View "View", Panels "Panels", Compare "Compare", Help "Help");
