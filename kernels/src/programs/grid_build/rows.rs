//! What the rows of kernels have in common.

use super::reasons;
use crate::options::{Accelerator, Options};
use crate::program::breaks::Break;
use crate::program::kernel::{KernelInfo, PassTwin, Proof, Twin};
use crate::shared::launch::BLOCK;
use crate::tables::kernel::{Counts, Launch, Role};

/// The row of a kernel; all other fields are the same for every kernel.
pub(super) const fn row(
    (name, wgsl): (&'static str, &'static str),
    twin: PassTwin,
    each: u32,
    colour: [u8; 3],
    summary: &'static str,
    breaks: &'static [Break],
) -> KernelInfo {
    KernelInfo {
        name,
        wgsl,
        twin: Twin::Pass(twin),
        takes: &[],
        sends: &[],
        role: Role::Once,
        workgroup: BLOCK as u32,
        launch: Launch::List { each, weight: 1 },
        counts: Counts::None,
        resumes: |_| false,
        list: None,
        proof: Proof::NONE,
        colour,
        why_absent: reasons::every,
        summary,
        breaks,
    }
}

/// A kernel whose elements take long: tests of boxes, or of many neighbours.
pub(super) const fn heavy(kernel: KernelInfo) -> KernelInfo {
    in_portions(1, 32, kernel)
}

/// A kernel with so many elements per thread, each of which takes about so many times as long as moving a few values.
pub(super) const fn in_portions(each: u32, weight: u32, kernel: KernelInfo) -> KernelInfo {
    KernelInfo { launch: Launch::List { each, weight }, ..kernel }
}

/// The row of a kernel that only builds irregular grids.
pub(super) const fn irregular_row(
    source: (&'static str, &'static str),
    twin: PassTwin,
    colour: [u8; 3],
    summary: &'static str,
    breaks: &'static [Break],
) -> KernelInfo {
    row(source, twin, 1, colour, summary, breaks)
}

pub(super) fn irregular(options: &mut Options) {
    options.accelerator = Accelerator::Irregular;
}
