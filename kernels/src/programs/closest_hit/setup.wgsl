// Finds where the ray's walk begins: its first cell and the t at which it leaves it (dda: its control terms), or that it
// misses the grid; the root of the BVH; the first triangle if there is neither.

import package::constants::{NOBODY, NO_NODE, LIST_SIDE};
import package::state::{TRAV_SETUP, TRAV, ISECT_NO_HIT, BACKGROUND};
import package::bounds::{reset_bounds};
import package::ray::{load_origin, load_direction, store_voxel};
import package::live::{send, tiled_texel};
import package::scene::{scene};
import package::grid::{cell_index};
import package::grid_walk::{grid_ray, enter_grid};
import package::irregular_walk::{enter_irregular, unpacked_voxel, voxel_exit};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@if(dda) @group(0) @binding(3) var control: texture_storage_2d_array<r32float, write>;
@if(!dda) @group(0) @binding(3) var tmax: texture_storage_2d_array<r32float, write>;
@if(bvh) @group(0) @binding(3) var previous: texture_storage_2d_array<r32uint, write>;
@if(counters) @group(0) @binding(4) var counters: texture_storage_2d_array<r32uint, write>;

fn set_up(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    if (textureLoad(state, texel, 0).x != TRAV_SETUP) {
        return NOBODY;
    }

    reset_bounds(texel);
    @if(counters) {
        textureStore(counters, texel, 0, vec4u(0u));
        textureStore(counters, texel, 1, vec4u(0u));
        textureStore(counters, texel, 2, vec4u(0u));
    }
    @if(grid) {
        let walk = enter_grid(grid_ray(load_origin(texel), load_direction(texel)));
        if (!walk.inside) {
            textureStore(state, texel, 0, vec4u(BACKGROUND));
            return BACKGROUND;
        }
        @if(dda) {
            textureStore(control, texel, 0, vec4f(walk.control.x));
            textureStore(control, texel, 1, vec4f(walk.control.y));
            textureStore(control, texel, 2, vec4f(walk.control.z));
        }
        @if(!dda && !(many_steps && robust && !drifting)) {
            textureStore(tmax, texel, 0, vec4f(walk.tmax.x));
            textureStore(tmax, texel, 1, vec4f(walk.tmax.y));
            textureStore(tmax, texel, 2, vec4f(walk.tmax.z));
        }
        textureStore(state, texel, 2, vec4u(cell_index(walk.cell)));
        @if(counters) {
            textureStore(counters, texel, 0, vec4u(1u));
        }
    }
    @if(irregular) {
        let ray = grid_ray(load_origin(texel), load_direction(texel));
        let walk = enter_irregular(ray);
        if (!walk.inside) {
            textureStore(state, texel, 0, vec4u(BACKGROUND));
            return BACKGROUND;
        }
        @if(!many_steps) {
            let exit = voxel_exit(walk, ray);
            textureStore(tmax, texel, 0, vec4f(exit.tmax.x));
            textureStore(tmax, texel, 1, vec4f(exit.tmax.y));
            textureStore(tmax, texel, 2, vec4f(exit.tmax.z));
        }
        store_voxel(texel, unpacked_voxel(walk.voxel));
        textureStore(state, texel, 2, vec4u(walk.cell));
        @if(counters) {
            textureStore(counters, texel, 0, vec4u(1u));
        }
    }
    @if(bvh) {
        textureStore(previous, texel, 0, vec4u(NO_NODE));
        textureStore(state, texel, 2, vec4u(0u));
    }
    textureStore(state, texel, 3, vec4u(0u));
    @if(bvh) let next = select(TRAV, BACKGROUND, scene.triangles == 0u);
    @else let next = ISECT_NO_HIT;
    textureStore(state, texel, 0, vec4u(next));
    return next;
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn setup(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let texel = tiled_texel(group, lane);
    send(lane, texel, set_up(texel));
}
