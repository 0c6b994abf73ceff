import package::launch::{BLOCK, launch, element};
import package::build::{build};
import package::leaf::{load, load_at, place_in, space_at, high_of};
import package::voxel_map::{find};

@group(0) @binding(0) var space: texture_2d_array<u32>;
@group(0) @binding(1) var list: texture_2d_array<u32>;
@group(0) @binding(2) var round: texture_2d_array<u32>;
@group(0) @binding(3) var cell_of: texture_2d_array<u32>;
@group(0) @binding(4) var neighbor: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(5) var wished_by: texture_storage_2d_array<r32uint, write>;

const NOBODY: u32 = 0xffffffffu;
// Longer lists are never merged.
const LONGEST: u32 = 16384u;

// Finds the neighbour after each leaf along the round's axis, if the two form a box.
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
    let axis = load_at(round, vec2u(0u), 0u);
    let at = place_in(space, i);
    let extent = space_at(space, at);
    let end = high_of(extent[axis]);
    var after = NOBODY;
    if (end < build.cells[axis] << build.levels) {
        var voxel = extent & vec3u(0xffffu);
        voxel[axis] = end;
        let other = load(cell_of, find(voxel), 0u);
        let there = place_in(space, other);
        var differs = extent ^ space_at(space, there);
        differs[axis] = 0u;
        if (all(differs == vec3u(0u)) && load_at(list, at, 1u) + load_at(list, there, 1u) <= LONGEST) {
            after = other;
        }
    }
    textureStore(neighbor, at, 0, vec4u(after));
    textureStore(wished_by, at, 0, vec4u(NOBODY));
}
