//! The kernels of the build, and their instances in the program.

use super::elements::{
    CELL_BLOCKS, CELLS, REFERENCES, SPAN_BLOCKS, SPANS, TALLIES, TALLY_BLOCKS, TRIANGLE_BLOCKS, TRIANGLES,
};
use super::scan::EACH;
use super::{PROGRAM, passes};
use crate::options::reasons::Because;
use crate::options::{GridSize, Options};
use crate::program::breaks::{Break, as_it_is};
use crate::program::kernel::{Instance, Kernel, KernelInfo, PassTwin, Proof, Twin};
use crate::shared::launch::BLOCK;
use crate::tables::elements::Elements;
use crate::tables::kernel::{Counts, Launch, Role};

/// The row of a kernel; all other fields are the same for every kernel.
const fn row(
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
        launch: Launch::List { each },
        counts: Counts::None,
        resumes: |_| false,
        list: None,
        proof: Proof::NONE,
        colour,
        why_absent: |_| (Because::Scene, "the grid has too few cells to sort by so many digits"),
        summary,
        breaks,
    }
}

/// More cells than a block of a scan has.
fn fine(options: &mut Options) {
    options.grid = GridSize::Cells([32; 3]);
}

macro_rules! wgsl {
    ($name:literal) => {
        ($name, include_str!(concat!($name, ".wgsl")))
    };
}

const BOUND: KernelInfo = row(
    wgsl!("bound"),
    passes::bound,
    1,
    [23, 150, 160],
    "finds which cells each triangle's own box touches",
    &[Break::new(as_it_is, "high - low + 1u", "high - low + 2u")],
);
const SCAN: KernelInfo = row(
    wgsl!("scan"),
    passes::scan,
    EACH,
    [66, 124, 200],
    "sums the values before each one, in blocks",
    &[Break::new(as_it_is, "from_side][lane - 1u]", "from_side][lane]")],
);
const ADD: KernelInfo = row(
    wgsl!("add"),
    passes::add,
    1,
    [66, 124, 200],
    "adds the sum of all blocks before its own",
    &[Break::new(fine, "saturating_add(before,", "saturating_add(0u,")],
);
const SPAN: KernelInfo = row(
    wgsl!("span"),
    passes::span,
    1,
    [232, 140, 60],
    "tests up to 32 cells of a row against their triangle",
    &[Break::new(as_it_is, "u32(meets(x))", "1u")],
);
const EMIT: KernelInfo = row(
    wgsl!("emit"),
    passes::emit,
    1,
    [190, 150, 30],
    "writes a reference for each cell that a span overlaps",
    &[Break::new(as_it_is, "first + firstTrailingBit(left)", "first + firstTrailingBit(left) + 1u")],
);
const HISTOGRAM: KernelInfo = row(
    wgsl!("histogram"),
    passes::histogram,
    1,
    [150, 120, 190],
    "counts a digit of the cell in each block",
    &[Break::new(as_it_is, "counts[digit_of(cell)], 1u", "counts[digit_of(cell)], 2u")],
);
const SCATTER: KernelInfo = row(
    wgsl!("scatter"),
    passes::scatter,
    1,
    [200, 80, 140],
    "moves each reference to its place by a digit",
    &[Break::new(as_it_is, "(bit - 1u)", "(bit | (bit - 1u))")],
);
const MARK: KernelInfo = row(
    wgsl!("mark"),
    passes::mark,
    1,
    [90, 165, 90],
    "finds where the references to each cell begin and end",
    &[Break::new(as_it_is, "vec4u(i + 1u)", "vec4u(i)")],
);
const MEASURE: KernelInfo = row(
    wgsl!("measure"),
    passes::measure,
    1,
    [120, 130, 140],
    "the length of each cell's list",
    &[Break::new(as_it_is, "vec4u(length)", "vec4u(length + 1u)")],
);

/// The kernels, without their instances.
#[cfg(test)]
pub(super) const ROWS: [&KernelInfo; 9] = [&BOUND, &SCAN, &ADD, &SPAN, &EMIT, &HISTOGRAM, &SCATTER, &MARK, &MEASURE];

type Binds = &'static [(&'static str, &'static str)];

const fn place(
    index: usize,
    name: &'static str,
    kernel: KernelInfo,
    over: &'static Elements,
    parameter: u32,
    binds: Binds,
) -> Instance {
    Instance { index, name, program: &PROGRAM, kernel, over, parameter, binds }
}

macro_rules! places {
    ($($index:literal $name:literal: $row:ident over $over:ident $(by $parameter:literal)? $(binds $binds:ident)?;)*) => {
        /// All instances, in the order of the build.
        pub static KERNELS: [Instance; [$($index),*].len()] =
            [$(place($index, $name, $row, &$over, 0 $(+ $parameter)?, places!(@binds $($binds)?))),*];
    };
    (@binds) => { &[] };
    (@binds $binds:ident) => { $binds };
}

const SPAN_SUMS: Binds = &[("values", "first_span"), ("sums", "spans_of_block")];
const ALL_SPAN_SUMS: Binds = &[("values", "spans_of_block"), ("sums", "spans_in_all")];
const OF_SPAN: Binds = &[("triangle", "span_triangle"), ("cells_at", "span_cell")];
const EMITTED: Binds = &[
    ("triangle", "span_triangle"),
    ("cells_at", "span_cell"),
    ("cell_out", "cell_even"),
    ("triangle_out", "triangle_even"),
];
const REFERENCE_SUMS: Binds = &[("values", "first_reference"), ("sums", "references_of_block")];
const ALL_REFERENCE_SUMS: Binds = &[("values", "references_of_block"), ("sums", "references_in_all")];
const TALLY_SUMS: Binds = &[("values", "tally"), ("sums", "tally_of_block")];
const ALL_TALLY_SUMS: Binds = &[("values", "tally_of_block"), ("sums", "tally_in_all")];
const START_SUMS: Binds = &[("values", "start"), ("sums", "starts_of_block")];
const ALL_START_SUMS: Binds = &[("values", "starts_of_block"), ("sums", "starts_in_all")];
const FROM_EVEN: Binds = &[
    ("cell_in", "cell_even"),
    ("triangle_in", "triangle_even"),
    ("cell_out", "cell_odd"),
    ("triangle_out", "triangle_odd"),
];
const FROM_ODD: Binds = &[
    ("cell_in", "cell_odd"),
    ("triangle_in", "triangle_odd"),
    ("cell_out", "cell_even"),
    ("triangle_out", "triangle_even"),
];

places! {
    0 "bound": BOUND over TRIANGLES;
    1 "scan_spans": SCAN over TRIANGLES binds SPAN_SUMS;
    2 "scan_span_blocks": SCAN over TRIANGLE_BLOCKS binds ALL_SPAN_SUMS;
    3 "add_spans": ADD over TRIANGLES binds SPAN_SUMS;
    4 "span": SPAN over SPANS binds OF_SPAN;
    5 "scan_references": SCAN over SPANS binds REFERENCE_SUMS;
    6 "scan_reference_blocks": SCAN over SPAN_BLOCKS binds ALL_REFERENCE_SUMS;
    7 "add_references": ADD over SPANS binds REFERENCE_SUMS;
    8 "emit": EMIT over SPANS binds EMITTED;
    9 "histogram_0": HISTOGRAM over REFERENCES by 0 binds FROM_EVEN;
    10 "scan_tallies": SCAN over TALLIES binds TALLY_SUMS;
    11 "scan_tally_blocks": SCAN over TALLY_BLOCKS binds ALL_TALLY_SUMS;
    12 "add_tallies": ADD over TALLIES binds TALLY_SUMS;
    13 "scatter_0": SCATTER over REFERENCES by 0 binds FROM_EVEN;
    14 "histogram_1": HISTOGRAM over REFERENCES by 1 binds FROM_ODD;
    15 "scatter_1": SCATTER over REFERENCES by 1 binds FROM_ODD;
    16 "histogram_2": HISTOGRAM over REFERENCES by 2 binds FROM_EVEN;
    17 "scatter_2": SCATTER over REFERENCES by 2 binds FROM_EVEN;
    18 "histogram_3": HISTOGRAM over REFERENCES by 3 binds FROM_ODD;
    19 "scatter_3": SCATTER over REFERENCES by 3 binds FROM_ODD;
    20 "histogram_4": HISTOGRAM over REFERENCES by 4 binds FROM_EVEN;
    21 "scatter_4": SCATTER over REFERENCES by 4 binds FROM_EVEN;
    22 "histogram_5": HISTOGRAM over REFERENCES by 5 binds FROM_ODD;
    23 "scatter_5": SCATTER over REFERENCES by 5 binds FROM_ODD;
    24 "histogram_6": HISTOGRAM over REFERENCES by 6 binds FROM_EVEN;
    25 "scatter_6": SCATTER over REFERENCES by 6 binds FROM_EVEN;
    26 "mark_even": MARK over REFERENCES binds FROM_EVEN;
    27 "mark_odd": MARK over REFERENCES binds FROM_ODD;
    28 "measure": MEASURE over CELLS;
    29 "scan_starts": SCAN over CELLS binds START_SUMS;
    30 "scan_start_blocks": SCAN over CELL_BLOCKS binds ALL_START_SUMS;
    31 "add_starts": ADD over CELLS binds START_SUMS;
}

const fn at(index: usize) -> Kernel {
    Kernel::of(&KERNELS[index])
}

/// Instances up to the references, which are in the order of their triangles.
pub(super) const COUNTED: [Kernel; 9] = [at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7), at(8)];
/// Instances that compute the prefix sums of tallies.
pub(super) const TALLIED: [Kernel; 3] = [at(10), at(11), at(12)];
/// Instances that count and move references, for each digit.
pub(super) const SORTED: [[Kernel; 2]; 7] = [
    [at(9), at(13)],
    [at(14), at(15)],
    [at(16), at(17)],
    [at(18), at(19)],
    [at(20), at(21)],
    [at(22), at(23)],
    [at(24), at(25)],
];
/// Instances that find the lists, after an even and after an odd number of digits.
pub(super) const MARKED: [Kernel; 2] = [at(26), at(27)];
/// Instances that compute the lists' starts.
pub(super) const STARTED: [Kernel; 4] = [at(28), at(29), at(30), at(31)];
