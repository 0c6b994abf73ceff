// Tests the ray against one triangle of its cell's list, and decides what is next when the list ends.
//
// With a grid the list is the cell's; without one it is all triangles. robust keeps the nearest hit and
// accepts it once it lies within the cells walked; paper accepts a hit only inside of its own cell, and
// pays one more pass to notice the list's delimiter (Listing 2).

import package::constants::{INF, WORKGROUP};
import package::state::{TRAV, ISECT_NO_HIT, ISECT_HIT, SHADE, BACKGROUND};
import package::vector::{smallest3};
import package::triangle::{hit_triangle, is_nearer};
import package::corners::{vertex};
import package::ray::{load_origin, load_direction};
import package::grid_walk::{grid, cell_of_index, cell_plane};
@if(counters) import package::grid_walk::{Walk, enter_grid, advance, cell_index};

struct SceneInfo {
    triangles: u32,
}

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_storage_2d_array<r32uint, read_write>;
@if(grid) @group(0) @binding(4) var tmax: texture_2d_array<f32>;
@if(counters) @group(0) @binding(5) var counters: texture_storage_2d_array<r32uint, read_write>;
@group(1) @binding(2) var<uniform> scene: SceneInfo;
@if(grid) @group(1) @binding(4) var<storage, read> grid_cells: array<u32>;
@if(grid) @group(1) @binding(5) var<storage, read> grid_items: array<u32>;

@if(grid && !robust)
fn is_in_cell(position: vec3f, cell: vec3i) -> bool {
    let low = cell_plane(cell);
    return all(position >= low) && all(position <= low + grid.width);
}

// Whether a cell before this one held the triangle too: walks again from the start.
@if(grid && counters)
fn is_repeated(triangle: u32, cell: u32, origin: vec3f, direction: vec3f) -> bool {
    var walk = enter_grid(origin, direction);
    let bound = grid.cells.x + grid.cells.y + grid.cells.z + 2;
    for (var step = 0; step < bound && walk.inside; step++) {
        let index = cell_index(walk.cell);
        if (index == cell) {
            return false;
        }
        for (var item = grid_cells[index]; item < grid_cells[index + 1u]; item++) {
            if (grid_items[item] == triangle) {
                return true;
            }
        }
        walk = advance(walk, origin, direction);
    }
    return false;
}

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn intersect(@builtin(global_invocation_id) id: vec3u) {
    let texel = id.xy;
    if (any(texel >= textureDimensions(state))) {
        return;
    }
    var tag = textureLoad(state, texel, 0).x;
    if (tag != ISECT_NO_HIT && tag != ISECT_HIT) {
        return;
    }

    var nearest_t = bitcast<f32>(textureLoad(state, texel, 1).x);
    let cell = textureLoad(state, texel, 2).x;
    var item = textureLoad(state, texel, 3).x;
    @if(grid) let first = grid_cells[cell];
    @if(grid) let count = grid_cells[cell + 1u] - first;
    @else let count = scene.triangles;

    let in_list = item < count;
    if (in_list) {
        @if(grid) let triangle = grid_items[first + item];
        @else let triangle = item;
        let origin = load_origin(texel);
        let direction = load_direction(texel);
        let candidate = hit_triangle(origin, direction, vertex(triangle, 0u), vertex(triangle, 1u), vertex(triangle, 2u));
        @if(robust) let accepted = is_nearer(candidate.t, triangle, nearest_t, textureLoad(hit, texel, 2).x);
        @if(grid && !robust) let accepted = candidate.t < nearest_t
            && is_in_cell(origin + direction * candidate.t, cell_of_index(cell));
        @if(!grid && !robust) let accepted = candidate.t < nearest_t;
        if (candidate.is_hit && accepted) {
            textureStore(hit, texel, 0, vec4u(bitcast<u32>(candidate.u)));
            textureStore(hit, texel, 1, vec4u(bitcast<u32>(candidate.v)));
            textureStore(hit, texel, 2, vec4u(triangle));
            textureStore(state, texel, 1, vec4u(bitcast<u32>(candidate.t)));
            nearest_t = candidate.t;
            tag = ISECT_HIT;
        }
        item += 1u;
        @if(counters) {
            textureStore(counters, texel, 1, vec4u(textureLoad(counters, texel, 1).x + 1u));
        }
        @if(grid && counters) {
            let repeated = u32(is_repeated(triangle, cell, origin, direction));
            textureStore(counters, texel, 2, vec4u(textureLoad(counters, texel, 2).x + repeated));
        }
    }

    @if(robust) let ended = item >= count;
    @else let ended = !in_list;
    if (ended) {
        @if(grid && robust) {
            let exit = smallest3(vec3f(
                textureLoad(tmax, texel, 0, 0).x,
                textureLoad(tmax, texel, 1, 0).x,
                textureLoad(tmax, texel, 2, 0).x,
            ));
            tag = select(TRAV, SHADE, tag == ISECT_HIT && nearest_t <= exit);
        }
        @if(grid && !robust) {
            tag = select(TRAV, SHADE, tag == ISECT_HIT);
        }
        @if(!grid) {
            tag = select(BACKGROUND, SHADE, tag == ISECT_HIT);
        }
    }
    textureStore(state, texel, 0, vec4u(tag));
    textureStore(state, texel, 3, vec4u(item));
}
