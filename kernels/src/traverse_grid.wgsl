// Moves the ray to its next cell, the one behind the face that it reaches first.

import package::constants::{INF, WORKGROUP};
import package::state::{TRAV, ISECT_NO_HIT, ISECT_HIT, SHADE, BACKGROUND};
import package::ray::{load_origin, load_direction};
import package::grid_walk::{Walk, advance, cell_index, cell_of_index};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var tmax: texture_storage_2d_array<r32float, read_write>;
@if(counters) @group(0) @binding(4) var counters: texture_storage_2d_array<r32uint, read_write>;

fn load_tmax(texel: vec2u) -> vec3f {
    return vec3f(
        textureLoad(tmax, texel, 0).x,
        textureLoad(tmax, texel, 1).x,
        textureLoad(tmax, texel, 2).x,
    );
}

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn traverse_grid(@builtin(global_invocation_id) id: vec3u) {
    let texel = id.xy;
    if (any(texel >= textureDimensions(state))) {
        return;
    }
    if (textureLoad(state, texel, 0).x != TRAV) {
        return;
    }

    let cell = cell_of_index(textureLoad(state, texel, 2).x);
    let here = Walk(cell, load_tmax(texel), true);
    let next = advance(here, load_origin(texel), load_direction(texel));
    // A hit beyond the cell's exit is kept; a later cell may hold a nearer one.
    let has_hit = bitcast<f32>(textureLoad(state, texel, 1).x) < INF;

    if (!next.inside) {
        textureStore(state, texel, 0, vec4u(select(BACKGROUND, SHADE, has_hit)));
        return;
    }
    textureStore(tmax, texel, 0, vec4f(next.tmax.x));
    textureStore(tmax, texel, 1, vec4f(next.tmax.y));
    textureStore(tmax, texel, 2, vec4f(next.tmax.z));
    textureStore(state, texel, 0, vec4u(select(ISECT_NO_HIT, ISECT_HIT, has_hit)));
    textureStore(state, texel, 2, vec4u(cell_index(next.cell)));
    textureStore(state, texel, 3, vec4u(0u));
    @if(counters) {
        textureStore(counters, texel, 0, vec4u(textureLoad(counters, texel, 0).x + 1u));
    }
}
