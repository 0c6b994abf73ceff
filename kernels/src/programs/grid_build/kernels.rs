//! The kernels of the build.

use super::irregular::{finish, map, merge, refine};
use super::scan::EACH;
use super::{checks, passes};
use crate::options::reasons::{Because, Reason, Run};
use crate::options::{Accelerator, GridSize, Options};
use crate::program::breaks::{Break, as_it_is};
use crate::program::kernel::{KernelInfo, PassTwin, Proof, Twin};
use crate::shared::launch::BLOCK;
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
        launch: Launch::List { each, weight: 1 },
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

/// A kernel whose elements take long: tests of boxes, or of many neighbours.
const fn heavy(kernel: KernelInfo) -> KernelInfo {
    KernelInfo { launch: Launch::List { each: 1, weight: 32 }, ..kernel }
}

/// The row of a kernel that only builds irregular grids.
const fn irregular_row(
    source: (&'static str, &'static str),
    twin: PassTwin,
    colour: [u8; 3],
    summary: &'static str,
    breaks: &'static [Break],
) -> KernelInfo {
    KernelInfo { why_absent: not_irregular, ..row(source, twin, 1, colour, summary, breaks) }
}

fn not_irregular(run: &Run<'_>) -> Reason {
    let reason = match run.accelerator {
        Accelerator::Irregular => "the lists are in the other streams, or the grid has two levels only",
        _ => "the cells of a uniform grid are not divided",
    };
    (Because::Options, reason)
}

fn irregular(options: &mut Options) {
    options.accelerator = Accelerator::Irregular;
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

pub(super) const BOUND: KernelInfo = heavy(row(
    wgsl!("bound"),
    passes::bound,
    1,
    [23, 150, 160],
    "finds which cells each triangle's own box touches",
    &[Break::new(as_it_is, "high - low + 1u", "high - low + 2u")],
));
pub(super) const SCAN: KernelInfo = row(
    wgsl!("scan"),
    passes::scan,
    EACH,
    [66, 124, 200],
    "sums the values before each one, in blocks",
    &[Break::new(as_it_is, "from_side][lane - 1u]", "from_side][lane]")],
);
pub(super) const ADD: KernelInfo = row(
    wgsl!("add"),
    passes::add,
    1,
    [66, 124, 200],
    "adds the sum of all blocks before its own",
    &[Break::new(fine, "saturating_add(before,", "saturating_add(0u,")],
);
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
pub(super) const HISTOGRAM: KernelInfo = row(
    wgsl!("histogram"),
    passes::histogram,
    1,
    [150, 120, 190],
    "counts a digit of the cell in each block",
    &[Break::new(as_it_is, "counts[digit_of(cell)], 1u", "counts[digit_of(cell)], 2u")],
);
pub(super) const SCATTER: KernelInfo = row(
    wgsl!("scatter"),
    passes::scatter,
    1,
    [200, 80, 140],
    "moves each reference to its place by a digit",
    &[Break::new(as_it_is, "(bit - 1u)", "(bit | (bit - 1u))")],
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

macro_rules! of_irregular {
    ($name:literal) => {
        ($name, include_str!(concat!("irregular/", $name, ".wgsl")))
    };
}

pub(super) const COUNT_TOP: KernelInfo = irregular_row(
    of_irregular!("count_top"),
    refine::count_top,
    [120, 130, 140],
    "notes how many leaves and references there are at first",
    &[Break::new(irregular, "load(references_in_all, 0u, 0u)", "load(references_in_all, 0u, 0u) + 1u")],
);
pub(super) const MAKE_LEAVES: KernelInfo = irregular_row(
    of_irregular!("make_leaves"),
    refine::make_leaves,
    [90, 165, 90],
    "makes every cell of the top level a leaf, the root of an octree",
    &[Break::new(irregular, "(log2_of_square(CELLS_PER_REFERENCE * length) + 3u)", "(log2_of_square(length) + 3u)")],
);
pub(super) const ADOPT_PAIRS: KernelInfo = irregular_row(
    of_irregular!("adopt_pairs"),
    refine::adopt_pairs,
    [150, 150, 150],
    "copies two streams of references",
    &[Break::new(irregular, "load(second_in, i, 0u)", "load(first_in, i, 0u)")],
);
pub(super) const HALVE: KernelInfo = heavy(irregular_row(
    of_irregular!("halve"),
    refine::halve,
    [232, 140, 60],
    "finds in which halves of its leaf each triangle lies",
    &[Break::new(
        irregular,
        "let found = atomicLoad(&lying_in[lane]);",
        "let found = atomicLoad(&lying_in[lane]) | 1u;",
    )],
));
pub(super) const DECIDE: KernelInfo = irregular_row(
    of_irregular!("decide"),
    refine::decide,
    [190, 150, 30],
    "decides which leaves are divided",
    &[Break::new(irregular, "< 4u * length", "< 2u * length")],
);
pub(super) const DIVIDE: KernelInfo = irregular_row(
    of_irregular!("divide"),
    refine::divide,
    [200, 80, 140],
    "replaces leaves by their halves",
    &[Break::new(irregular, "levels + 1u));", "levels));")],
);
pub(super) const HAND_DOWN: KernelInfo = irregular_row(
    of_irregular!("hand_down"),
    refine::hand_down,
    [66, 124, 200],
    "moves each reference to every half in which it lies",
    &[Break::new(irregular, "- rank(half, first);", "- rank(half, first) + 1u;")],
);
pub(super) const ADOPT_LEAVES: KernelInfo = irregular_row(
    of_irregular!("adopt_leaves"),
    refine::adopt_leaves,
    [150, 150, 150],
    "makes the next leaves the leaves",
    &[Break::new(irregular, "load(next_list, i, 1u)", "load(next_list, i, 0u)")],
);
pub(super) const ADOPT_DIVISION: KernelInfo = irregular_row(
    of_irregular!("adopt_division"),
    refine::adopt_division,
    [150, 150, 150],
    "makes what is left of the next leaves' budgets that of the leaves",
    &[Break::new(irregular, "load(next_division, i, 0u)", "load(next_division, i, 1u)")],
);
pub(super) const OPEN_NODES: KernelInfo = irregular_row(
    of_irregular!("open_nodes"),
    map::open_nodes,
    [23, 150, 160],
    "counts the nodes of octrees, each at its first leaf",
    &[Break::new(irregular, "vec4u(i))", "vec4u(i + 1u))")],
);
pub(super) const LINK_NODES: KernelInfo = irregular_row(
    of_irregular!("link_nodes"),
    map::link_nodes,
    [150, 120, 190],
    "links nodes and leaves with their parents",
    &[Break::new(irregular, "octant_of(voxel, shift), width", "0u, width")],
);
pub(super) const SIZE_BLOCKS: KernelInfo = irregular_row(
    of_irregular!("size_blocks"),
    map::size_blocks,
    [190, 150, 30],
    "finds the nodes with which a block of the voxel map begins",
    &[Break::new(irregular, "if (children == 0u)", "if (children == 9u)")],
);
pub(super) const MAP_TOP_LEVEL: KernelInfo = irregular_row(
    of_irregular!("map_top_level"),
    map::map_top_level,
    [90, 165, 90],
    "writes the voxel map's entries for the top level",
    &[Break::new(irregular, "load(tree_top, i, 0u)", "load(tree_top, 0u, 0u)")],
);
pub(super) const MAP_BLOCKS: KernelInfo = irregular_row(
    of_irregular!("map_blocks"),
    map::map_blocks,
    [90, 165, 90],
    "writes the entries of the voxel map's blocks",
    &[Break::new(irregular, "octant_of(voxel, k - 1u)", "octant_of(voxel, k)")],
);
pub(super) const START_MERGING: KernelInfo = irregular_row(
    of_irregular!("start_merging"),
    merge::start_merging,
    [120, 130, 140],
    "begins merging along the x axis",
    &[Break::new(irregular, "4, vec4u(leaves)", "4, vec4u(0u)")],
);
pub(super) const PAIR: KernelInfo = irregular_row(
    of_irregular!("pair"),
    merge::pair,
    [23, 150, 160],
    "finds the neighbours with which each leaf forms a box",
    &[Break::new(irregular, "voxel[axis] = end;", "voxel[axis] = end - 1u;")],
);
pub(super) const SHARE_LISTS: KernelInfo = irregular_row(
    of_irregular!("share_lists"),
    merge::share_lists,
    [232, 140, 60],
    "finds which triangles the neighbour before lists, too",
    &[Break::new(irregular, "countOneBits(found)", "countOneBits(found) + 1u")],
);
pub(super) const WISH: KernelInfo = irregular_row(
    of_irregular!("wish"),
    merge::wish,
    [190, 150, 30],
    "finds which leaves cost no more together with the next one",
    &[Break::new(irregular, "listed + STEP_COST", "listed")],
);
pub(super) const UNITE: KernelInfo = irregular_row(
    of_irregular!("unite"),
    merge::unite,
    [190, 110, 70],
    "decides which leaves are merged",
    &[Break::new(irregular, "vec4u(u32(!is_gone))", "vec4u(1u)")],
);
pub(super) const GATHER: KernelInfo = irregular_row(
    of_irregular!("gather"),
    merge::gather,
    [200, 80, 140],
    "moves the leaves that remain, with the boxes of those merged into them",
    &[Break::new(irregular, "| (other[axis] & 0xffff0000u)", "| (extent[axis] & 0xffff0000u)")],
);
pub(super) const DEAL: KernelInfo = irregular_row(
    of_irregular!("deal"),
    merge::deal,
    [66, 124, 200],
    "moves each reference to its place in the merged list",
    &[Break::new(irregular, "place += lower_there", "place += 0u")],
);
pub(super) const FOLLOW: KernelInfo = irregular_row(
    of_irregular!("follow"),
    merge::follow,
    [150, 120, 190],
    "follows leaves to the cells that they became part of",
    &[Break::new(irregular, "leaf = load(neighbor, leaf, 1u);", "leaf = leaf;")],
);
pub(super) const NEXT_AXIS: KernelInfo = irregular_row(
    of_irregular!("next_axis"),
    merge::next_axis,
    [120, 130, 140],
    "turns to the next axis or round, or ends merging",
    &[Break::new(irregular, "axis < 3u", "axis < 2u")],
);
pub(super) const EXPAND: KernelInfo = heavy(irregular_row(
    of_irregular!("expand"),
    finish::expand,
    [23, 150, 160],
    "expands each cell over neighbours that list nothing else",
    &[Break::new(irregular, "is_listed(first, listed,", "!is_listed(first, listed,")],
));
pub(super) const NAME_CELLS: KernelInfo = irregular_row(
    of_irregular!("name_cells"),
    finish::name_cells,
    [90, 165, 90],
    "makes the voxel map lead to cells",
    &[Break::new(irregular, "(entry & 3u) == 0u", "(entry & 3u) == 1u")],
);
pub(super) const FINISH_CELLS: KernelInfo = irregular_row(
    of_irregular!("finish_cells"),
    finish::finish_cells,
    [90, 165, 90],
    "writes the records of cells that rays read",
    &[Break::new(irregular, "vec4u(low.x | (low.y << 16u))", "vec4u(low.y | (low.x << 16u))")],
);
pub(super) const FINISH_ITEMS: KernelInfo = irregular_row(
    of_irregular!("finish_items"),
    finish::finish_items,
    [120, 130, 140],
    "marks the last triangle of each list",
    &[Break::new(irregular, "if (i + 1u == load", "if (i == load")],
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
pub(super) const CHECK_CELLS: KernelInfo = KernelInfo {
    why_absent: not_irregular,
    ..row(
        of_checks!("check_cells"),
        checks::check_cells,
        EACH,
        [120, 130, 140],
        "counts cells whose box or list cannot be",
        &[Break::new(irregular, "return load(list, i, 1u) != 0u;", "return true;")],
    )
};
pub(super) const CHECK_MAP: KernelInfo = KernelInfo {
    why_absent: not_irregular,
    ..row(
        of_checks!("check_map"),
        checks::check_map,
        EACH,
        [120, 130, 140],
        "counts entries of the voxel map that lead nowhere or back",
        &[Break::new(irregular, "begin <= own", "begin > own")],
    )
};

/// The kernels, without their instances.
#[cfg(test)]
pub(super) const ROWS: [&KernelInfo; 40] = [
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
    &ADOPT_PAIRS,
    &HALVE,
    &DECIDE,
    &DIVIDE,
    &HAND_DOWN,
    &ADOPT_LEAVES,
    &ADOPT_DIVISION,
    &OPEN_NODES,
    &LINK_NODES,
    &SIZE_BLOCKS,
    &MAP_TOP_LEVEL,
    &MAP_BLOCKS,
    &START_MERGING,
    &PAIR,
    &SHARE_LISTS,
    &WISH,
    &UNITE,
    &GATHER,
    &DEAL,
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
