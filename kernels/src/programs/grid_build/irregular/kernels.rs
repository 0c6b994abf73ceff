//! The kernels that only build irregular grids.

use super::{finish, map, merge, refine};
use crate::program::breaks::Break;
use crate::program::kernel::KernelInfo;
use crate::programs::grid_build::rows::{heavy, in_portions, irregular, irregular_row};

/// References per thread of `halve`.
pub(in super::super) const HALVE_EACH: u32 = 16;

/// Weight of a kernel that goes through the lists of two leaves.
const TWO_LISTS: u32 = 4;

macro_rules! of_irregular {
    ($name:literal) => {
        ($name, include_str!(concat!($name, ".wgsl")))
    };
}

pub(in super::super) const COUNT_TOP: KernelInfo = irregular_row(
    of_irregular!("count_top"),
    refine::count_top,
    [120, 130, 140],
    "notes how many leaves and references there are at first",
    &[Break::new(irregular, "load(references_in_all, 0u, 0u)", "load(references_in_all, 0u, 0u) + 1u")],
);
pub(in super::super) const MAKE_LEAVES: KernelInfo = irregular_row(
    of_irregular!("make_leaves"),
    refine::make_leaves,
    [90, 165, 90],
    "makes every cell of the top level a leaf, the root of an octree",
    &[Break::new(irregular, "(log2_of_square(CELLS_PER_REFERENCE * length) + 3u)", "(log2_of_square(length) + 3u)")],
);
pub(in super::super) const START_HALVING: KernelInfo = irregular_row(
    of_irregular!("start_halving"),
    refine::start_halving,
    [120, 130, 140],
    "finds how deep the deepest octree is at least",
    &[Break::new(irregular, "vec4u(atomicLoad(&depth))", "vec4u(9u)")],
);
pub(in super::super) const NEXT_HALVING: KernelInfo = irregular_row(
    of_irregular!("next_halving"),
    refine::next_halving,
    [120, 130, 140],
    "counts the halvings",
    &[Break::new(irregular, "textureLoad(halving, vec2u(0u), 0).x + 1u", "textureLoad(halving, vec2u(0u), 0).x + 2u")],
);
pub(in super::super) const ADOPT: KernelInfo = irregular_row(
    of_irregular!("adopt"),
    refine::adopt,
    [150, 150, 150],
    "takes the sorted references as those of the first leaves",
    &[Break::new(irregular, "load(second_in, i, layer)", "load(first_in, i, layer)")],
);
pub(in super::super) const HALVE: KernelInfo = in_portions(
    HALVE_EACH,
    32,
    irregular_row(
        of_irregular!("halve"),
        refine::halve,
        [232, 140, 60],
        "finds in which halves of its leaf each triangle lies",
        &[Break::new(irregular, "let found = atomicLoad(&lying_in[k]);", "let found = atomicLoad(&lying_in[k]) | 1u;")],
    ),
);
pub(in super::super) const DECIDE: KernelInfo = irregular_row(
    of_irregular!("decide"),
    refine::decide,
    [190, 150, 30],
    "decides which leaves are divided",
    &[Break::new(irregular, "select(length, after, is_divided)", "select(after, length, is_divided)")],
);
pub(in super::super) const DIVIDE: KernelInfo = irregular_row(
    of_irregular!("divide"),
    refine::divide,
    [200, 80, 140],
    "replaces leaves by their halves",
    &[Break::new(irregular, "((levels + 1u) << 16u)", "(levels << 16u)")],
);
pub(in super::super) const HAND_DOWN: KernelInfo = irregular_row(
    of_irregular!("hand_down"),
    refine::hand_down,
    [66, 124, 200],
    "moves each reference to every half in which it lies",
    &[Break::new(irregular, "- rank(half, first);", "- rank(half, first) + 1u;")],
);
pub(in super::super) const OPEN_NODES: KernelInfo = irregular_row(
    of_irregular!("open_nodes"),
    map::open_nodes,
    [23, 150, 160],
    "counts the nodes of octrees, each at its first leaf",
    &[Break::new(irregular, "vec4u(i))", "vec4u(i + 1u))")],
);
pub(in super::super) const LINK_NODES: KernelInfo = irregular_row(
    of_irregular!("link_nodes"),
    map::link_nodes,
    [150, 120, 190],
    "links nodes and leaves with their parents",
    &[Break::new(irregular, "octant_of(voxel, shift), width", "0u, width")],
);
pub(in super::super) const SIZE_BLOCKS: KernelInfo = irregular_row(
    of_irregular!("size_blocks"),
    map::size_blocks,
    [190, 150, 30],
    "finds the nodes with which a block of the voxel map begins",
    &[Break::new(irregular, "if (children == 0u)", "if (children == 9u)")],
);
pub(in super::super) const MAP_TOP_LEVEL: KernelInfo = irregular_row(
    of_irregular!("map_top_level"),
    map::map_top_level,
    [90, 165, 90],
    "writes the voxel map's entries for the top level",
    &[Break::new(irregular, "load(tree_top, i, 0u)", "load(tree_top, 0u, 0u)")],
);
pub(in super::super) const MAP_BLOCKS: KernelInfo = irregular_row(
    of_irregular!("map_blocks"),
    map::map_blocks,
    [90, 165, 90],
    "writes the entries of the voxel map's blocks",
    &[Break::new(irregular, "octant_of(voxel, k - 1u)", "octant_of(voxel, k)")],
);
pub(in super::super) const START_MERGING: KernelInfo = irregular_row(
    of_irregular!("start_merging"),
    merge::start_merging,
    [120, 130, 140],
    "begins merging along the x axis",
    &[Break::new(irregular, "4, vec4u(leaves)", "4, vec4u(0u)")],
);
pub(in super::super) const WISH: KernelInfo = in_portions(
    1,
    TWO_LISTS,
    irregular_row(
        of_irregular!("wish"),
        merge::wish,
        [190, 150, 30],
        "finds which leaves cost no more together with the next one",
        &[
            Break::new(irregular, "listed + STEP_COST", "listed"),
            Break::new(irregular, "in_both += u32(one == other)", "in_both += 0u"),
        ],
    ),
);
pub(in super::super) const UNITE: KernelInfo = irregular_row(
    of_irregular!("unite"),
    merge::unite,
    [190, 110, 70],
    "decides which leaves are merged",
    &[Break::new(irregular, "vec4u(u32(!it.is_absorbed))", "vec4u(1u)")],
);
pub(in super::super) const GATHER: KernelInfo = in_portions(
    1,
    TWO_LISTS,
    irregular_row(
        of_irregular!("gather"),
        merge::gather,
        [200, 80, 140],
        "moves the leaves that remain, with the boxes and lists of those merged into them",
        &[
            Break::new(irregular, "(extent[axis] & 0xffffu) | upper", "extent[axis]"),
            Break::new(irregular, "place += 1u;", "place += 2u;"),
        ],
    ),
);
pub(in super::super) const FOLLOW: KernelInfo = irregular_row(
    of_irregular!("follow"),
    merge::follow,
    [150, 120, 190],
    "follows leaves to the cells that they became part of",
    &[Break::new(irregular, "leaf = before;", "leaf = leaf;")],
);
pub(in super::super) const NEXT_AXIS: KernelInfo = irregular_row(
    of_irregular!("next_axis"),
    merge::next_axis,
    [120, 130, 140],
    "turns to the next axis or round, or ends merging",
    &[Break::new(irregular, "axis >= 3u)", "axis >= 2u)")],
);
pub(in super::super) const EXPAND: KernelInfo = heavy(irregular_row(
    of_irregular!("expand"),
    finish::expand,
    [23, 150, 160],
    "expands each cell over neighbours that list nothing else",
    &[Break::new(irregular, "is_listed(first, listed,", "!is_listed(first, listed,")],
));
pub(in super::super) const NAME_CELLS: KernelInfo = irregular_row(
    of_irregular!("name_cells"),
    finish::name_cells,
    [90, 165, 90],
    "makes the voxel map lead to cells",
    &[Break::new(irregular, "(entry & 3u) == 0u", "(entry & 3u) == 1u")],
);
pub(in super::super) const FINISH_CELLS: KernelInfo = irregular_row(
    of_irregular!("finish_cells"),
    finish::finish_cells,
    [90, 165, 90],
    "writes the records of cells that rays read",
    &[Break::new(irregular, "vec4u(low.x | (low.y << 16u))", "vec4u(low.y | (low.x << 16u))")],
);
pub(in super::super) const FINISH_ITEMS: KernelInfo = irregular_row(
    of_irregular!("finish_items"),
    finish::finish_items,
    [120, 130, 140],
    "marks the last triangle of each list",
    &[Break::new(irregular, "+ length - 1u", "+ 0u")],
);
