// Advances each ray by up to K steps: a step is a cell, or eight nodes, with all of their triangles. Does what traverse
// and intersect do one step at a time, with the ray kept in registers.
//
// resumes: with long lists, K steps may take more loop iterations than a dispatch allows. The ray then waits before a
// step, or at an item of its list.

@if(in_cell) import package::constants::{INF};
import package::constants::{NOBODY, NODES_A_STEP, NO_NODE, NO_TRIANGLE, LIST_SIDE};
import package::state::{TRAV, ISECT_NO_HIT, ISECT_HIT, SHADE, BACKGROUND};
import package::triangle::{shear_of};
import package::tracing::{Trace, tested};
@if(resumes) import package::tracing::{is_spent};
import package::ray::{load_origin, load_direction};
@if(intervals) import package::ray::{load_interval};
import package::scene::{scene};
import package::live::{listed_texel, send};
@if(grid && !in_cell) import package::vector::{smallest3};
@if(grid) import package::grid_walk::{Walk, grid_ray, advance, cell_index, cell_of_index};
@if(grid && robust && !drifting) import package::grid_walk::{cell_exit};
@if(grid && skip) import package::grid_walk::{leap};
@if(grid && skip) import package::grid_lists::{empty_distance};
@if(grid) import package::grid_lists::{grid_cells, grid_items, list_ended};
@if(irregular) import package::vector::{smallest3};
@if(irregular) import package::grid_walk::{grid, grid_ray};
@if(irregular) import package::grid_lists::{list_ended};
@if(irregular) import package::constants::{NO_LIST, LAST_ITEM};
@if(irregular) import package::ray::{load_voxel, store_voxel};
@if(irregular) import package::irregular_walk::{irregular_items, at_voxel, voxel_exit, step_voxel, unpacked_voxel};
@if(bvh) import package::bvh_walk::{Visit, bvh_nodes, next_node, finite_inverse};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_storage_2d_array<r32uint, read_write>;
@if(dda) @group(0) @binding(4) var control: texture_storage_2d_array<r32float, read_write>;
@if(grid && !dda && (!robust || drifting)) @group(0) @binding(4) var tmax: texture_storage_2d_array<r32float, read_write>;
@if(bvh) @group(0) @binding(4) var previous: texture_storage_2d_array<r32uint, read_write>;
@if(counters) @group(0) @binding(5) var counters: texture_storage_2d_array<r32uint, read_write>;

// A ray's position between two passes.
struct Place {
    tag: u32,
    cell: u32,
    item: u32,
    trace: Trace,
}

@if(grid)
fn walked(start: Place, texel: vec2u) -> Place {
    var place = start;
    let ray = grid_ray(place.trace.origin, place.trace.direction);
    var walk: Walk;
    walk.cell = cell_of_index(place.cell);
    walk.inside = true;
    // robust: computed from the cell each time, so there is nothing to keep.
    @if(robust && !drifting) walk.tmax = cell_exit(walk.cell, ray);
    @if(!dda && (!robust || drifting)) walk.tmax = vec3f(
        textureLoad(tmax, texel, 0).x,
        textureLoad(tmax, texel, 1).x,
        textureLoad(tmax, texel, 2).x,
    );
    @if(dda) walk.control = vec3f(
        textureLoad(control, texel, 0).x,
        textureLoad(control, texel, 1).x,
        textureLoad(control, texel, 2).x,
    );
    @if(resumes) var waits = false;
    for (var step = 0u; step < scene.steps; step++) {
        @if(resumes) if (is_spent(place.trace)) {
            break;
        }
        @if(resumes) place.trace.turns += 1u;
        @if(skip) let distance = empty_distance(place.cell);
        @else let distance = 0;
        if (distance == 0) {
            let end = grid_cells[place.cell + 1u];
            @if(!resumes) let first = grid_cells[place.cell];
            @if(resumes) let first = grid_cells[place.cell] + place.item;
            for (var item = first; item < end; item++) {
                place.trace = tested(place.trace, grid_items[item], walk.cell);
                @if(any_hit) if (place.trace.ended) {
                    place.tag = SHADE;
                    return place;
                }
                @if(resumes) if (is_spent(place.trace) && item + 1u < end) {
                    place.item = item + 1u - grid_cells[place.cell];
                    waits = true;
                    break;
                }
            }
        }
        @if(resumes) if (waits) {
            @if(!any_hit) place.tag = select(ISECT_HIT, ISECT_NO_HIT, place.trace.triangle == NO_TRIANGLE);
            break;
        }
        @if(resumes) place.item = 0u;
        @if(any_hit) let tag = ISECT_NO_HIT;
        @else let tag = select(ISECT_HIT, ISECT_NO_HIT, place.trace.triangle == NO_TRIANGLE);
        @if(in_cell) let exit = INF;
        @else let exit = smallest3(walk.tmax);
        place.tag = list_ended(tag, place.trace.t, exit);
        @if(intervals && !in_cell) if (place.tag == TRAV && place.trace.interval.y <= exit) {
            place.tag = BACKGROUND;
        }
        if (place.tag != TRAV) {
            break;
        }
        @if(skip) {
            if (distance > 1) {
                walk = leap(walk, distance, ray);
            } else {
                walk = advance(walk, ray);
            }
        }
        @if(!skip) walk = advance(walk, ray);
        if (!walk.inside) {
            place.tag = select(SHADE, BACKGROUND, tag == ISECT_NO_HIT);
            break;
        }
        place.tag = tag;
        place.cell = cell_index(walk.cell);
        @if(counters) place.trace.cells += 1u;
    }
    @if(dda) {
        textureStore(control, texel, 0, vec4f(walk.control.x));
        textureStore(control, texel, 1, vec4f(walk.control.y));
        textureStore(control, texel, 2, vec4f(walk.control.z));
    }
    @if(!dda && (!robust || drifting)) {
        textureStore(tmax, texel, 0, vec4f(walk.tmax.x));
        textureStore(tmax, texel, 1, vec4f(walk.tmax.y));
        textureStore(tmax, texel, 2, vec4f(walk.tmax.z));
    }
    return place;
}

@if(irregular)
fn walked(start: Place, texel: vec2u) -> Place {
    var place = start;
    let ray = grid_ray(place.trace.origin, place.trace.direction);
    var walk = at_voxel(load_voxel(texel), place.cell);
    @if(resumes) var waits = false;
    for (var step = 0u; step < scene.steps; step++) {
        @if(resumes) if (is_spent(place.trace)) {
            break;
        }
        // One to find the next cell in each level of the map, at most.
        @if(resumes) place.trace.turns += 1u + grid.levels;
        var goes_on = walk.first != NO_LIST;
        @if(!resumes) var item = walk.first;
        @if(resumes) var item = walk.first + place.item;
        while (goes_on) {
            let entry = irregular_items[item];
            place.trace = tested(place.trace, entry & ~LAST_ITEM, vec3i(0));
            @if(any_hit) if (place.trace.ended) {
                place.tag = SHADE;
                return place;
            }
            goes_on = (entry & LAST_ITEM) == 0u;
            item += 1u;
            @if(resumes) if (is_spent(place.trace) && goes_on) {
                place.item = item - walk.first;
                waits = true;
                break;
            }
        }
        @if(resumes) if (waits) {
            @if(!any_hit) place.tag = select(ISECT_HIT, ISECT_NO_HIT, place.trace.triangle == NO_TRIANGLE);
            break;
        }
        @if(resumes) place.item = 0u;
        @if(any_hit) let tag = ISECT_NO_HIT;
        @else let tag = select(ISECT_HIT, ISECT_NO_HIT, place.trace.triangle == NO_TRIANGLE);
        let exit = voxel_exit(walk, ray);
        place.tag = list_ended(tag, place.trace.t, smallest3(exit.tmax));
        @if(intervals) if (place.tag == TRAV && place.trace.interval.y <= smallest3(exit.tmax)) {
            place.tag = BACKGROUND;
        }
        if (place.tag != TRAV) {
            break;
        }
        walk = step_voxel(walk, exit, ray);
        if (!walk.inside) {
            place.tag = select(SHADE, BACKGROUND, tag == ISECT_NO_HIT);
            break;
        }
        place.tag = tag;
        place.cell = walk.cell;
        @if(counters) place.trace.cells += 1u;
    }
    store_voxel(texel, unpacked_voxel(walk.voxel));
    return place;
}

@if(bvh)
fn walked(start: Place, texel: vec2u) -> Place {
    var place = start;
    let inverse = finite_inverse(place.trace.direction);
    var at = Visit(place.cell, textureLoad(previous, texel, 0).x, false);
    @if(resumes) var waits = false;
    for (var step = 0u; step < NODES_A_STEP * scene.steps && at.node != NO_NODE; step++) {
        @if(resumes) if (is_spent(place.trace)) {
            break;
        }
        @if(resumes) place.trace.turns += 1u;
        // A ray that waits at an item is already in its leaf.
        @if(resumes) at.in_leaf = place.item > 0u;
        @if(resumes) if (!at.in_leaf) {
            @if(intervals) let farthest = min(place.trace.t, place.trace.interval.y);
            @if(intervals) at = next_node(at, place.trace.origin, place.trace.direction, inverse, farthest);
            @else at = next_node(at, place.trace.origin, place.trace.direction, inverse, place.trace.t);
            @if(counters) place.trace.cells += 1u;
        }
        @if(!resumes && intervals) let farthest = min(place.trace.t, place.trace.interval.y);
        @if(!resumes && intervals) at = next_node(at, place.trace.origin, place.trace.direction, inverse, farthest);
        @if(!resumes && !intervals) at = next_node(at, place.trace.origin, place.trace.direction, inverse, place.trace.t);
        @if(counters && !resumes) place.trace.cells += 1u;
        if (at.in_leaf) {
            let node = bvh_nodes[at.node];
            let end = node.first + (node.link & 0x3fffffffu);
            @if(!resumes) let first = node.first;
            @if(resumes) let first = node.first + place.item;
            for (var item = first; item < end; item++) {
                place.trace = tested(place.trace, item, vec3i(0));
                @if(any_hit) if (place.trace.ended) {
                    place.tag = SHADE;
                    return place;
                }
                @if(resumes) if (is_spent(place.trace) && item + 1u < end) {
                    place.item = item + 1u - node.first;
                    waits = true;
                    break;
                }
            }
        }
        @if(resumes) if (waits) {
            break;
        }
        @if(resumes) place.item = 0u;
    }
    if (at.node == NO_NODE) {
        place.tag = select(SHADE, BACKGROUND, place.trace.triangle == NO_TRIANGLE);
    } else {
        place.cell = at.node;
        textureStore(previous, texel, 0, vec4u(at.previous));
    }
    return place;
}

@if(!grid && !irregular && !bvh)
fn walked(start: Place, texel: vec2u) -> Place {
    var place = start;
    let end = min(place.item + scene.steps, scene.triangles);
    for (; place.item < end; place.item++) {
        @if(resumes) if (is_spent(place.trace)) {
            break;
        }
        place.trace = tested(place.trace, place.item, vec3i(0));
        @if(any_hit) if (place.trace.ended) {
            place.tag = SHADE;
            return place;
        }
    }
    if (place.item >= scene.triangles) {
        place.tag = select(SHADE, BACKGROUND, place.trace.triangle == NO_TRIANGLE);
    }
    return place;
}

fn take_steps(texel: vec2u) -> u32 {
    if (any(texel >= textureDimensions(state))) {
        return NOBODY;
    }
    var place: Place;
    place.tag = textureLoad(state, texel, 0).x;
    if (place.tag != TRAV && place.tag != ISECT_NO_HIT && place.tag != ISECT_HIT) {
        return NOBODY;
    }
    place.cell = textureLoad(state, texel, 2).x;
    @if(resumes || (!grid && !irregular && !bvh)) place.item = textureLoad(state, texel, 3).x;
    place.trace.origin = load_origin(texel);
    place.trace.direction = load_direction(texel);
    place.trace.shear = shear_of(place.trace.direction);
    @if(intervals) place.trace.interval = load_interval(texel);
    place.trace.t = bitcast<f32>(textureLoad(state, texel, 1).x);
    place.trace.triangle = textureLoad(hit, texel, 2).x;
    let t_before = place.trace.t;
    let triangle_before = place.trace.triangle;
    place = walked(place, texel);

    if (place.trace.triangle != triangle_before || place.trace.t != t_before) {
        textureStore(hit, texel, 0, vec4u(bitcast<u32>(place.trace.u)));
        textureStore(hit, texel, 1, vec4u(bitcast<u32>(place.trace.v)));
        textureStore(hit, texel, 2, vec4u(place.trace.triangle));
        textureStore(state, texel, 1, vec4u(bitcast<u32>(place.trace.t)));
    }
    textureStore(state, texel, 0, vec4u(place.tag));
    @if(grid || irregular || bvh) textureStore(state, texel, 2, vec4u(place.cell));
    @if(resumes || (!grid && !irregular && !bvh)) textureStore(state, texel, 3, vec4u(place.item));
    @if(counters) {
        textureStore(counters, texel, 0, vec4u(textureLoad(counters, texel, 0).x + place.trace.cells));
        textureStore(counters, texel, 1, vec4u(textureLoad(counters, texel, 1).x + place.trace.tests));
    }
    return place.tag;
}

@compute @workgroup_size(LIST_SIDE, LIST_SIDE)
fn walk(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let texel = listed_texel(group, lane);
    send(lane, texel, take_steps(texel));
}
