//! What the rows of kernels have in common.

use super::reasons;
use crate::options::{Accelerator, Options};
use crate::program::breaks::Break;
use crate::program::kernel::{KernelInfo, PassTwin};
use crate::tables::kernel::Launch;

/// The row of a kernel with so many elements per thread.
pub(super) const fn row(
    source: (&'static str, &'static str),
    twin: PassTwin,
    each: u32,
    colour: [u8; 3],
    summary: &'static str,
    breaks: &'static [Break],
) -> KernelInfo {
    in_portions(each, 1, KernelInfo::once(source, twin, colour, summary, reasons::every, breaks))
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
