// Where a leaf lies in its octree, before cells are merged: it is a cube of virtual cells whose side is a power of two.

import package::build::{build};
import package::leaf::{low_of, high_of};

fn level_of_box(extent: vec3u) -> u32 {
    return build.levels - firstTrailingBit(high_of(extent.x) - low_of(extent.x));
}

fn low_corner(extent: vec3u) -> vec3u {
    return extent & vec3u(0xffffu);
}

// How many nodes have this leaf as their first: on so many levels above it, it is in the lowest half along each axis.
fn opened_by(extent: vec3u) -> u32 {
    let level = level_of_box(extent);
    let low = low_corner(extent) >> vec3u(build.levels - level);
    let joined = low.x | low.y | low.z;
    return min(level, select(firstTrailingBit(joined), 32u, joined == 0u));
}

// The index of the top-level cell that a virtual cell is in.
fn top_of(voxel: vec3u) -> u32 {
    let top = voxel >> vec3u(build.levels);
    return top.x + build.cells.x * (top.y + build.cells.y * top.z);
}
