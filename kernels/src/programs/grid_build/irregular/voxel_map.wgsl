// Where the voxel map leads: to a leaf of the octrees, or, at the end, to a cell.

import package::leaf::{load};
import package::build::{build};

@group(0) @binding(12) var map_top: texture_2d_array<u32>;
@group(0) @binding(13) var map_below: texture_2d_array<u32>;

fn find(voxel: vec3u) -> u32 {
    var shift = build.levels;
    let top = voxel >> vec3u(shift);
    let cells = build.cells.x * build.cells.y * build.cells.z;
    var entry = load(map_top, top.x + build.cells.x * (top.y + build.cells.y * top.z), 0u);
    // At most one turn per level.
    while ((entry & 3u) != 0u && shift > 0u) {
        let depth = entry & 3u;
        shift -= min(depth, shift);
        let at = (voxel >> vec3u(shift)) & vec3u((1u << depth) - 1u);
        entry = load(map_below, (entry >> 2u) - cells + at.x + ((at.y + (at.z << depth)) << depth), 0u);
    }
    return entry >> 2u;
}
