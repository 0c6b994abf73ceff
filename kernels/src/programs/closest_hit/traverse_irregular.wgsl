// Moves the ray to its next cell of the irregular grid, the one behind the face by which it leaves the cell's box.

import package::constants::{NOBODY, LIST_SIDE};
import package::state::{TRAV};
import package::ray::{load_origin, load_direction, load_voxel, store_voxel};
import package::grid_walk::{grid_ray};
import package::irregular_walk::{at_voxel, voxel_exit, step_voxel, unpacked_voxel};
import package::arrival::{state, leave, arrive};
import package::live::{send, listed_texel};

fn step_cell(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    if (textureLoad(state, texel, 0).x != TRAV) {
        return NOBODY;
    }

    let ray = grid_ray(load_origin(texel), load_direction(texel));
    let left = at_voxel(load_voxel(texel), textureLoad(state, texel, 2).x);
    let walk = step_voxel(left, voxel_exit(left, ray), ray);
    if (!walk.inside) {
        return leave(texel);
    }
    store_voxel(texel, unpacked_voxel(walk.voxel));
    return arrive(texel, walk.cell, voxel_exit(walk, ray).tmax);
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn traverse_irregular(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    @if(live_lists) let texel = listed_texel(group, lane);
    @else let texel = id.xy;
    send(lane, texel, step_cell(texel));
}
