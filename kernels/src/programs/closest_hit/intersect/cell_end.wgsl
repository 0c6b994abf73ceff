// What follows when the list of a cell has ended, in a grid of either kind.

import package::constants::{INF};
import package::state::{TRAV, BACKGROUND};
import package::vector::{smallest3};
import package::grid_lists::{list_ended};
import package::ray::{load_interval};

@if(!in_cell) @group(0) @binding(4) var tmax: texture_2d_array<f32>;

@if(in_cell)
fn after_cell(texel: vec2u, tag: u32, nearest_t: f32) -> u32 {
    return list_ended(tag, nearest_t, INF);
}
@else
fn after_cell(texel: vec2u, tag: u32, nearest_t: f32) -> u32 {
    let exit = smallest3(vec3f(
        textureLoad(tmax, texel, 0, 0).x,
        textureLoad(tmax, texel, 1, 0).x,
        textureLoad(tmax, texel, 2, 0).x,
    ));
    let next = list_ended(tag, nearest_t, exit);
    @if(intervals) if (next == TRAV && load_interval(texel).y <= exit) {
        return BACKGROUND;
    }
    return next;
}
