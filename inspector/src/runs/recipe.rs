//! How a run is made.

use crate::session::Edit;
use crate::settings::{DeviceKind, Settings};
use raystep_kernels::Choices;

/// Identifies a kept run as long as the window is open.
pub type RunId = u64;

/// How a run is made.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// Its options.
    pub settings: Settings,
    /// Edits by hand.
    pub edits: Vec<Edit>,
    /// How many of the first passes run on the CPU reference.
    pub twins: Option<usize>,
}

impl Recipe {
    /// A name for the run: what distinguishes most runs from others.
    #[must_use]
    pub fn name(&self) -> String {
        let Choices { program, accelerator, .. } = self.settings.choices;
        if !self.settings.traces_rays() {
            return program.to_string();
        }
        let device = match self.settings.device {
            DeviceKind::CpuF64 => " f64",
            _ => "",
        };
        let edited = if self.edits.is_empty() { "" } else { " edited" };
        let (order, rules) = (self.settings.order(), self.settings.rules());
        format!("{accelerator} {order} {rules}{device}{edited}")
    }

    /// Why the rays of two runs are not the same rays; `None` if they are.
    #[must_use]
    pub fn other_rays(&self, other: &Self) -> Option<&'static str> {
        let (a, b) = (&self.settings, &other.settings);
        if a.ray.is_none() && b.ray.is_none() && a.size != b.size {
            Some("they have different sizes")
        } else if a.ray != b.ray || a.ray.is_none() && a.view != b.view {
            Some("they have different views")
        } else if a.choices.samples != b.choices.samples {
            Some("they have different samples")
        } else {
            None
        }
    }
}
