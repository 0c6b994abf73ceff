//! The text of a plan's kernels with the places of its lines.

use super::Plan;
use crate::program::{Kernel, live};
use crate::shader::{ShaderError, Sourced};

impl Plan {
    /// The text of a kernel for the interpreter, each line of which has a place in a file; `None` if the run has no such kernel.
    ///
    /// # Errors
    /// If the WGSL is invalid: a plan has only valid kernels.
    pub fn sourced(&self, kernel: Kernel) -> Result<Option<Sourced>, ShaderError> {
        let Some(variant) = self.variant(kernel) else { return Ok(None) };
        let kernels: Vec<Kernel> = self.variants.iter().map(|variant| variant.kernel).collect();
        let lists = live::lists_of(kernel, &live::lists(&kernels, &self.features));
        Sourced::new(variant, &self.features, &lists).map(Some)
    }
}
