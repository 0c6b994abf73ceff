// Finds the ray's first cell and the t at which it leaves it, or that the ray misses the grid.

import package::constants::{WORKGROUP};
import package::state::{TRAV_SETUP, ISECT_NO_HIT, BACKGROUND};
import package::ray::{load_origin, load_direction};
import package::grid_walk::{enter_grid, cell_index};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@if(grid) @group(0) @binding(3) var tmax: texture_storage_2d_array<r32float, write>;
@if(counters) @group(0) @binding(4) var counters: texture_storage_2d_array<r32uint, write>;

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn setup(@builtin(global_invocation_id) id: vec3u) {
    let texel = id.xy;
    if (any(texel >= textureDimensions(state))) {
        return;
    }
    if (textureLoad(state, texel, 0).x != TRAV_SETUP) {
        return;
    }

    @if(counters) {
        textureStore(counters, texel, 0, vec4u(0u));
        textureStore(counters, texel, 1, vec4u(0u));
        textureStore(counters, texel, 2, vec4u(0u));
    }
    @if(grid) {
        let walk = enter_grid(load_origin(texel), load_direction(texel));
        if (!walk.inside) {
            textureStore(state, texel, 0, vec4u(BACKGROUND));
            return;
        }
        textureStore(tmax, texel, 0, vec4f(walk.tmax.x));
        textureStore(tmax, texel, 1, vec4f(walk.tmax.y));
        textureStore(tmax, texel, 2, vec4f(walk.tmax.z));
        textureStore(state, texel, 2, vec4u(cell_index(walk.cell)));
        @if(counters) {
            textureStore(counters, texel, 0, vec4u(1u));
        }
    }
    textureStore(state, texel, 0, vec4u(ISECT_NO_HIT));
    textureStore(state, texel, 3, vec4u(0u));
}
