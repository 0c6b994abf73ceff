//! The layouts: an arrangement of panels for each task.

use raystep_kernels::named;

/// Most layouts that a user can save: each has a key.
pub const MOST_OWN: usize = 4;

/// An arrangement of panels for a task.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Layout {
    /// The picture, the selected ray's unfolded walk and its history.
    #[default]
    Overview,
    /// The passes, the stream after each, and the timeline.
    Step,
    /// The selected ray: its walk in 3D and unfolded, its history, and the kernel's lines.
    Ray,
    /// Two runs.
    Compare,
    /// Where the time goes.
    Cost,
    /// Lessons, and what they speak of.
    Learn,
}

named!(Layout, Overview "Overview", Step "Step", Ray "Ray", Compare "Compare", Cost "Cost", Learn "Learn");
