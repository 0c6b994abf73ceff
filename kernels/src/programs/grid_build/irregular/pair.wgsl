import package::launch::{BLOCK, launch, element, texel};
import package::build::{build};
import package::leaf::{load, load_space, low_of, high_of};
import package::voxel_map::{find};

@group(0) @binding(0) var space: texture_2d_array<u32>;
@group(0) @binding(1) var list: texture_2d_array<u32>;
@group(0) @binding(2) var round: texture_2d_array<u32>;
@group(0) @binding(3) var cell_of: texture_2d_array<u32>;
@group(0) @binding(4) var neighbor: texture_storage_2d_array<r32uint, write>;

const NOBODY: u32 = 0xffffffffu;
// Longer lists are never merged.
const LONGEST: u32 = 16384u;

// The neighbour in which a virtual cell lies, if it forms a box with the leaf.
fn partner(i: u32, axis: u32, voxel: vec3u) -> u32 {
    let other = load(cell_of, find(voxel), 0u);
    var differs = load_space(space, i) ^ load_space(space, other);
    differs[axis] = 0u;
    let is_box = all(differs == vec3u(0u));
    return select(NOBODY, other, is_box && load(list, i, 1u) + load(list, other, 1u) <= LONGEST);
}

// Finds the neighbours along the round's axis with which each leaf could be merged: the one after it, and the one before.
@compute @workgroup_size(BLOCK)
fn pair(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let axis = load(round, 0u, 0u);
    let extent = load_space(space, i);
    var after = NOBODY;
    var before = NOBODY;
    var voxel = extent & vec3u(0xffffu);
    let end = high_of(extent[axis]);
    if (end < build.cells[axis] << build.levels) {
        voxel[axis] = end;
        after = partner(i, axis, voxel);
    }
    let low = low_of(extent[axis]);
    if (low > 0u) {
        voxel[axis] = low - 1u;
        before = partner(i, axis, voxel);
    }
    let at = texel(i, textureDimensions(neighbor).x);
    textureStore(neighbor, at, 0, vec4u(after));
    textureStore(neighbor, at, 1, vec4u(before));
}
