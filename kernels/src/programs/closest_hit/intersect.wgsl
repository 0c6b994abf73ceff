// Tests the ray against one triangle of its list, and decides what is next when the list ends. The list is the cell's, the leaf's, or all triangles.
//
// robust keeps the nearest hit and accepts it once it lies within the cells walked; paper accepts a hit only inside its
// own cell, and needs one more step to notice the list's delimiter (Listing 2).
//
// counters: repeats the walk from its start to find out whether an earlier cell listed the triangle too. resumes_scan:
// if this search may take more loop iterations than a dispatch allows, it continues in the next one, and the triangle
// is tested when the search ends.

import package::constants::{INF, NOBODY, LIST_SIDE};
import package::state::{TRAV, ISECT_NO_HIT, ISECT_HIT, SHADE, BACKGROUND};
import package::vector::{smallest3};
import package::triangle::{hit_triangle, is_nearer, shear_of};
import package::corners::{vertex};
@if(intervals) import package::triangle::{between};
import package::ray::{load_origin, load_direction};
@if(intervals) import package::ray::{load_interval};
import package::scene::{scene};
import package::live::{send};
@if(live_lists) import package::live::{listed_texel};
@if(grid) import package::grid_lists::{grid_cells, grid_items, list_ended};
@if(irregular) import package::grid_lists::{list_ended};
@if(irregular) import package::constants::{NO_LIST, LAST_ITEM};
@if(irregular) import package::irregular_walk::{irregular_cells, irregular_items};
@if(bvh) import package::bvh_walk::{bvh_nodes};
@if(in_cell) import package::grid_walk::{is_in_cell, cell_of_index};
@if(grid && counters) import package::grid_walk::{Walk, grid, grid_ray, enter_grid, advance, cell_index};
@if(grid && counters && resumes_scan && !in_cell) import package::grid_walk::{cell_of_index};
@if(resumes_scan) import package::constants::{TURNS, NO_CELL};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_storage_2d_array<r32uint, read_write>;
@if((grid || irregular) && !in_cell) @group(0) @binding(4) var tmax: texture_2d_array<f32>;
@if(counters) @group(0) @binding(5) var counters: texture_storage_2d_array<r32uint, read_write>;
@if(bvh) @group(1) @binding(19) var<storage, read> bvh_items: array<u32>;

// Whether a cell lists a triangle; lists are in ascending order.
@if(grid && counters)
fn is_listed(triangle: u32, cell: u32) -> bool {
    var low = grid_cells[cell];
    var high = grid_cells[cell + 1u];
    while (low < high) {
        let middle = low + (high - low) / 2u;
        if (grid_items[middle] < triangle) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low < grid_cells[cell + 1u] && grid_items[low] == triangle;
}

@if(grid && counters && resumes_scan) @group(0) @binding(6) var scan: texture_storage_2d_array<r32uint, read_write>;

@if(grid && counters && resumes_scan)
fn keep_scan(texel: vec2u, cell: u32, per_axis: vec3f) {
    textureStore(scan, texel, 0, vec4u(cell));
    textureStore(scan, texel, 1, vec4u(bitcast<u32>(per_axis.x)));
    textureStore(scan, texel, 2, vec4u(bitcast<u32>(per_axis.y)));
    textureStore(scan, texel, 3, vec4u(bitcast<u32>(per_axis.z)));
}

const NOT_REPEATED: u32 = 0u;
const REPEATED: u32 = 1u;
const NOT_KNOWN_YET: u32 = 2u;

// Whether an earlier cell listed the triangle too: walks again from the start.
@if(grid && counters)
fn repetition(texel: vec2u, triangle: u32, cell: u32, origin: vec3f, direction: vec3f) -> u32 {
    let ray = grid_ray(origin, direction);
    var walk = enter_grid(ray);
    let bound = grid.cells.x + grid.cells.y + grid.cells.z + 2;
    @if(resumes_scan) var turns = 0u;
    @if(resumes_scan) let begun = textureLoad(scan, texel, 0).x;
    @if(resumes_scan) if (begun != NO_CELL) {
        let x = textureLoad(scan, texel, 1).x;
        let y = textureLoad(scan, texel, 2).x;
        let z = textureLoad(scan, texel, 3).x;
        walk = Walk(cell_of_index(begun), bitcast<vec3f>(vec3u(x, y, z)), true);
    }
    for (var step = 0; step < bound && walk.inside; step++) {
        let index = cell_index(walk.cell);
        if (index == cell) {
            break;
        }
        @if(resumes_scan) if (turns >= TURNS) {
            @if(!dda) keep_scan(texel, index, walk.tmax);
            @else keep_scan(texel, index, walk.control);
            return NOT_KNOWN_YET;
        }
        // One iteration for the cell, and at most the bit length of its list for the binary search.
        @if(resumes_scan) turns += 1u + 32u - countLeadingZeros(grid_cells[index + 1u] - grid_cells[index]);
        if (is_listed(triangle, index)) {
            @if(resumes_scan) keep_scan(texel, NO_CELL, vec3f(0.0));
            return REPEATED;
        }
        walk = advance(walk, ray);
    }
    @if(resumes_scan) keep_scan(texel, NO_CELL, vec3f(0.0));
    return NOT_REPEATED;
}

fn step_item(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    var tag = textureLoad(state, texel, 0).x;
    if (tag != ISECT_NO_HIT && tag != ISECT_HIT) {
        return NOBODY;
    }

    let nearest_before = bitcast<f32>(textureLoad(state, texel, 1).x);
    var nearest_t = nearest_before;
    let cell = textureLoad(state, texel, 2).x;
    var item = textureLoad(state, texel, 3).x;
    @if(grid) let first = grid_cells[cell];
    @if(grid) let count = grid_cells[cell + 1u] - first;
    @if(bvh) let first = bvh_nodes[cell].first;
    @if(bvh) let count = bvh_nodes[cell].link & 0x3fffffffu;
    @if(irregular) let first = irregular_cells[cell].w;
    @if(!grid && !irregular && !bvh) let count = scene.triangles;

    let origin = load_origin(texel);
    let direction = load_direction(texel);
    @if(irregular) let in_list = first != NO_LIST;
    @if(irregular) var is_last = !in_list;
    @if(!irregular) let in_list = item < count;
    if (in_list) {
        @if(grid) let triangle = grid_items[first + item];
        @if(bvh) let triangle = bvh_items[first + item];
        @if(irregular) let entry = irregular_items[first + item];
        @if(irregular) let triangle = entry & ~LAST_ITEM;
        @if(irregular) is_last = (entry & LAST_ITEM) != 0u;
        @if(!grid && !irregular && !bvh) let triangle = item;
        @if(grid && counters) let repeated = repetition(texel, triangle, cell, origin, direction);
        @if(grid && counters && resumes_scan) if (repeated == NOT_KNOWN_YET) {
            return tag;
        }
        @if(intervals) let candidate = between(hit_triangle(
            origin, direction, shear_of(direction), vertex(triangle, 0u), vertex(triangle, 1u), vertex(triangle, 2u)),
            load_interval(texel));
        @else let candidate = hit_triangle(
            origin, direction, shear_of(direction), vertex(triangle, 0u), vertex(triangle, 1u), vertex(triangle, 2u));
        @if(robust && !any_hit && !in_cell) let accepted = is_nearer(candidate.t, triangle, nearest_t, textureLoad(hit, texel, 2).x);
        @if(any_hit) let accepted = candidate.t < nearest_t;
        @if(in_cell) let accepted = candidate.t < nearest_t
            && is_in_cell(origin + direction * candidate.t, cell_of_index(cell));
        @if(!robust && !in_cell) let accepted = candidate.t < nearest_t;
        if (candidate.is_hit && accepted) {
            textureStore(hit, texel, 0, vec4u(bitcast<u32>(candidate.u)));
            textureStore(hit, texel, 1, vec4u(bitcast<u32>(candidate.v)));
            textureStore(hit, texel, 2, vec4u(triangle));
            nearest_t = candidate.t;
            tag = ISECT_HIT;
        }
        item += 1u;
        @if(counters) textureStore(counters, texel, 1, vec4u(textureLoad(counters, texel, 1).x + 1u));
        @if(grid && counters) {
            textureStore(counters, texel, 2, vec4u(textureLoad(counters, texel, 2).x + repeated));
        }
    }

    @if(irregular) let ended = is_last;
    @if(!irregular && robust) let ended = item >= count;
    @if(!irregular && !robust) let ended = !in_list;
    if (ended) {
        @if((grid || irregular) && !in_cell) {
            let exit = smallest3(vec3f(
                textureLoad(tmax, texel, 0, 0).x,
                textureLoad(tmax, texel, 1, 0).x,
                textureLoad(tmax, texel, 2, 0).x,
            ));
            tag = list_ended(tag, nearest_t, exit);
            @if(intervals) if (tag == TRAV && load_interval(texel).y <= exit) {
                tag = BACKGROUND;
            }
        }
        @if(in_cell) {
            tag = list_ended(tag, nearest_t, INF);
        }
        @if(bvh) {
            tag = TRAV;
        }
        @if(!grid && !irregular && !bvh) {
            tag = select(BACKGROUND, SHADE, tag == ISECT_HIT);
        }
    }
    @if(any_hit) if (nearest_t < nearest_before) {
        tag = SHADE;
    }
    if (nearest_t < nearest_before) {
        textureStore(state, texel, 1, vec4u(bitcast<u32>(nearest_t)));
    }
    textureStore(state, texel, 0, vec4u(tag));
    textureStore(state, texel, 3, vec4u(item));
    return tag;
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn intersect(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    @if(live_lists) let texel = listed_texel(group, lane);
    @else let texel = id.xy;
    send(lane, texel, step_item(texel));
}
