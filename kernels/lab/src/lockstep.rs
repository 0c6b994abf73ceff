//! Compares two runs of a program bit for bit after every pass, and finds where they first differ. This needs a program
//! whose arithmetic has the same result on every device; [`crate::divergence`] compares programs whose floats may be
//! rounded differently.

use std::fmt;
use std::ops::ControlFlow;

use raystep_kernels::{Kernel, Progress, RenderError, Renderer, Stream};

use crate::compared::{Compared, Sums};

/// The result of a comparison.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Lockstep {
    /// What was compared of each kernel: the streams that a pass writes.
    pub compared: Compared,
    /// Where the runs first differ; no pass after that one is compared.
    pub first: Option<Unequal>,
}

/// A component that differs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unequal {
    /// The pass after which it differs.
    pub pass: usize,
    /// The kernel of that pass.
    pub kernel: Kernel,
    /// The stream.
    pub stream: Stream,
    /// Its layer.
    pub layer: usize,
    /// The element's index in the stream, row by row.
    pub element: usize,
    /// The bits in the run under test.
    pub ours: u32,
    /// The bits in the reference run.
    pub reference: u32,
}

impl fmt::Display for Unequal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let info = self.stream.info();
        let (kernel, layer) = (self.kernel.name(), info.layers[self.layer]);
        write!(f, "after pass {} ({kernel}), {}.{layer} of element {}", self.pass, info.name, self.element)?;
        write!(
            f,
            " of {} is {} on the device and {} on the CPU reference",
            info.elements.name, self.ours, self.reference
        )
    }
}

/// Runs both from the start to the end or to the first difference. `reference` must run on the CPU reference kernels.
///
/// `progress` is called after every pass and may stop the comparison.
///
/// # Errors
/// If a run fails, there is not enough memory, or `progress` stopped it.
pub async fn lockstep(
    ours: &mut Renderer,
    reference: &mut Renderer,
    mut progress: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<Lockstep, RenderError> {
    ours.restart();
    reference.restart();
    let mut found = Lockstep::default();
    while let (Some(pass), Some(_)) = (ours.step().await?, reference.step().await?) {
        let plan = ours.shared_plan();
        let mut sums = Sums { passes: 1, rays: u64::from(pass.rays_in), ..Sums::default() };
        for stream in plan.variant(pass.kernel).into_iter().flat_map(|variant| variant.written_streams()) {
            let (left, right) = (ours.values(stream).await?, reference.values(stream).await?);
            sums.components += left.bits.len() as u64;
            let differing = left.bits.iter().zip(&right.bits).position(|(a, b)| a != b);
            if let Some(at) = differing {
                let texels = left.width as usize * left.height as usize;
                let (layer, element) = (at / texels, at % texels);
                let (ours, reference) = (left.bits[at], right.bits[at]);
                let (pass, kernel) = (pass.index, pass.kernel);
                found.first = Some(Unequal { pass, kernel, stream, layer, element, ours, reference });
                break;
            }
        }
        found.compared.add(pass.kernel, sums);
        if found.first.is_some() {
            break;
        }
        if progress(ours.progress()).is_break() && ours.next_kernel().is_some() {
            return Err(RenderError::Cancelled { passes: ours.pass_count() });
        }
    }
    Ok(found)
}
