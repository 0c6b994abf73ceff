//! The kernels of the build.

use super::checks;
#[cfg(test)]
use super::irregular::kernels::*;
use super::passes;
use super::reasons::every;
use super::rows::{heavy, irregular, row};
use crate::options::{GridSize, Options};
use crate::program::breaks::{Break, as_it_is};
use crate::program::kernel::KernelInfo;
use crate::programs::primitives;
use crate::programs::primitives::scan::EACH;

/// More cells than a block of a scan has.
fn fine(options: &mut Options) {
    options.grid = GridSize::Cells([32; 3]);
}

/// A shared kernel, as every build may need it.
const fn shared(row: KernelInfo) -> KernelInfo {
    KernelInfo { why_absent: every, ..row }
}

pub(super) const SCAN: KernelInfo = shared(primitives::SCAN);
pub(super) const ADD: KernelInfo =
    KernelInfo { breaks: &[Break { run: fine, ..primitives::ADD.breaks[0] }], ..shared(primitives::ADD) };
pub(super) const HISTOGRAM: KernelInfo = shared(primitives::HISTOGRAM);
pub(super) const SCATTER: KernelInfo = shared(primitives::SCATTER);

macro_rules! wgsl {
    ($name:literal) => {
        ($name, include_str!(concat!($name, ".wgsl")))
    };
}

pub(super) const BOUND: KernelInfo = heavy(row(
    wgsl!("bound"),
    passes::bound,
    1,
    [23, 150, 160],
    "finds which cells each triangle's own box touches",
    &[Break::new(as_it_is, "high - low + 1u", "high - low + 2u")],
));
pub(super) const SPAN: KernelInfo = heavy(row(
    wgsl!("span"),
    passes::span,
    1,
    [232, 140, 60],
    "tests up to 32 cells of a row against their triangle",
    &[Break::new(as_it_is, "cells |= overlaps <<", "cells |= 1u <<")],
));
pub(super) const EMIT: KernelInfo = row(
    wgsl!("emit"),
    passes::emit,
    1,
    [190, 150, 30],
    "writes a reference for each cell that a span overlaps",
    &[Break::new(as_it_is, "first + firstTrailingBit(left)", "first + firstTrailingBit(left) + 1u")],
);
pub(super) const MARK: KernelInfo = row(
    wgsl!("mark"),
    passes::mark,
    1,
    [90, 165, 90],
    "finds where the references to each cell begin and end",
    &[Break::new(as_it_is, "vec4u(i + 1u)", "vec4u(i)")],
);
pub(super) const MEASURE: KernelInfo = row(
    wgsl!("measure"),
    passes::measure,
    1,
    [120, 130, 140],
    "the length of each cell's list",
    &[Break::new(as_it_is, "vec4u(length)", "vec4u(length + 1u)")],
);

macro_rules! of_checks {
    ($name:literal) => {
        ($name, include_str!(concat!("checks/", $name, ".wgsl")))
    };
}

pub(super) const CHECK_STARTS: KernelInfo = row(
    of_checks!("check_starts"),
    checks::check_starts,
    EACH,
    [120, 130, 140],
    "counts lists that end before they start",
    &[Break::new(as_it_is, "0u) > end ||", "0u) >= end ||")],
);
pub(super) const CHECK_ITEMS: KernelInfo = row(
    of_checks!("check_items"),
    checks::check_items,
    EACH,
    [120, 130, 140],
    "counts references to triangles that do not exist",
    &[Break::new(as_it_is, ">= build.triangles", "< build.triangles")],
);
pub(super) const CHECK_CELLS: KernelInfo = row(
    of_checks!("check_cells"),
    checks::check_cells,
    EACH,
    [120, 130, 140],
    "counts cells whose box or list cannot be",
    &[Break::new(irregular, "return load(list, i, 1u) != 0u;", "return true;")],
);
pub(super) const CHECK_MAP: KernelInfo = row(
    of_checks!("check_map"),
    checks::check_map,
    EACH,
    [120, 130, 140],
    "counts entries of the voxel map that lead nowhere or back",
    &[Break::new(irregular, "begin <= own", "begin > own")],
);

/// The kernels, without their instances.
#[cfg(test)]
pub(super) const ROWS: [&KernelInfo; 37] = [
    &BOUND,
    &SCAN,
    &ADD,
    &SPAN,
    &EMIT,
    &HISTOGRAM,
    &SCATTER,
    &MARK,
    &MEASURE,
    &COUNT_TOP,
    &MAKE_LEAVES,
    &START_HALVING,
    &NEXT_HALVING,
    &ADOPT,
    &HALVE,
    &DECIDE,
    &DIVIDE,
    &HAND_DOWN,
    &OPEN_NODES,
    &LINK_NODES,
    &SIZE_BLOCKS,
    &MAP_TOP_LEVEL,
    &MAP_BLOCKS,
    &START_MERGING,
    &WISH,
    &UNITE,
    &GATHER,
    &FOLLOW,
    &NEXT_AXIS,
    &EXPAND,
    &NAME_CELLS,
    &FINISH_CELLS,
    &FINISH_ITEMS,
    &CHECK_STARTS,
    &CHECK_ITEMS,
    &CHECK_CELLS,
    &CHECK_MAP,
];
