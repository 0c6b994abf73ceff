// Traces each ray from its start to its nearest hit: the steps of the other kernels in one loop.
//
// resumes: a ray whose walk takes more loop iterations than one dispatch allows waits for the next one: at an item of
// its cell's list (ISECT_NO_HIT, ISECT_HIT), or between two nodes of the BVH (TRAV).

import package::constants::{INF, NO_TRIANGLE, WORKGROUP, WIDE_STACK};
import package::state::{UNWRITTEN, TRAV_SETUP, TRAV, ISECT_NO_HIT, ISECT_HIT, SHADE, BACKGROUND};
import package::triangle::{shear_of};
import package::tracing::{Trace, tested};
@if(resumes) import package::tracing::{is_spent};
import package::scene::{scene};
@if(eye_rays) import package::camera::{eye_ray};
@if(!eye_rays) import package::ray::{load_origin, load_direction};
@if(intervals) import package::ray::{load_interval};
@if(grid && !in_cell) import package::vector::{smallest3};
@if(grid) import package::grid_walk::{grid, grid_ray, enter_grid, advance, cell_index};
@if(grid && resumes) import package::grid_walk::{GridRay, Walk};
@if(grid && resumes && robust && !drifting) import package::grid_walk::{cell_exit, cell_of_index};
@if(grid && skip) import package::grid_walk::{leap};
@if(grid && skip) import package::grid_lists::{empty_distance};
@if(grid) import package::grid_lists::{grid_cells, grid_items};
@if(irregular) import package::vector::{smallest3};
@if(irregular) import package::grid_walk::{grid_ray};
@if(irregular && resumes) import package::grid_walk::{GridRay, grid};
@if(irregular) import package::constants::{NO_LIST, LAST_ITEM};
@if(irregular && resumes) import package::ray::{load_voxel, store_voxel};
@if(irregular) import package::irregular_walk::{irregular_items, enter_irregular, voxel_exit, step_voxel};
@if(irregular && resumes) import package::irregular_walk::{VoxelWalk, at_voxel, unpacked_voxel};
@if(bvh) import package::bvh_walk::{finite_inverse};
@if(bvh) import package::wide_walk::{WideGroup, wide_ray, visit_wide, wide_child, wide_entry};
@if(bvh && resumes) import package::wide_walk::{TRAIL_WORDS, MOST_LEVELS, NO_CHILD, trail_child, with_trail_child};

@if(eye_rays && !resumes) @group(0) @binding(2) var state: texture_storage_2d_array<r32uint, write>;
@if(!eye_rays || resumes) @group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@if(!resumes) @group(0) @binding(3) var hit: texture_storage_2d_array<r32uint, write>;
@if(resumes) @group(0) @binding(3) var hit: texture_storage_2d_array<r32uint, read_write>;
@if(counters && !resumes) @group(0) @binding(5) var counters: texture_storage_2d_array<r32uint, write>;
@if(counters && resumes) @group(0) @binding(5) var counters: texture_storage_2d_array<r32uint, read_write>;
@if(grid && resumes && (!robust || drifting)) @group(0) @binding(6) var place: texture_storage_2d_array<r32uint, read_write>;
@if(bvh && resumes) @group(0) @binding(6) var trail: texture_storage_2d_array<r32uint, read_write>;

// A ray's position between two dispatches.
@if(resumes)
struct Wait {
    texel: vec2u,
    // Whether it waited before this dispatch, and waits after it.
    before: bool,
    after: bool,
    // As in the stream state: the cell and the item in its list, or the node, or the triangle.
    cell: u32,
    item: u32,
}

@if(resumes) var<private> wait: Wait;

@if(resumes)
fn wait_at(cell: u32, item: u32) {
    wait.after = true;
    wait.cell = cell;
    wait.item = item;
}

// The first cell, or the one at which the ray waits.
@if(grid && resumes)
fn resumed(ray: GridRay) -> Walk {
    if (!wait.before) {
        return enter_grid(ray);
    }
    @if(robust && !drifting) {
        let cell = cell_of_index(wait.cell);
        return Walk(cell, cell_exit(cell, ray), true);
    }
    @if(!robust || drifting) {
        let x = textureLoad(place, wait.texel, 0).x;
        let y = textureLoad(place, wait.texel, 1).x;
        let z = textureLoad(place, wait.texel, 2).x;
        let along_x = textureLoad(place, wait.texel, 4).x;
        let along_y = textureLoad(place, wait.texel, 5).x;
        let along_z = textureLoad(place, wait.texel, 6).x;
        return Walk(vec3i(vec3u(x, y, z)), bitcast<vec3f>(vec3u(along_x, along_y, along_z)), true);
    }
}

// Stores what cannot be computed from the cell's index: the coordinates if a ray wrapped over a face with the paper's
// rules, tmax if it is accumulated or control terms, and how many more cells are allowed.
@if(grid && resumes && (!robust || drifting))
fn keep_place(walk: Walk, left: i32) {
    textureStore(place, wait.texel, 0, vec4u(u32(walk.cell.x)));
    textureStore(place, wait.texel, 1, vec4u(u32(walk.cell.y)));
    textureStore(place, wait.texel, 2, vec4u(u32(walk.cell.z)));
    textureStore(place, wait.texel, 3, vec4u(u32(left)));
    @if(!dda) let per_axis = bitcast<vec3u>(walk.tmax);
    @else let per_axis = bitcast<vec3u>(walk.control);
    textureStore(place, wait.texel, 4, vec4u(per_axis.x));
    textureStore(place, wait.texel, 5, vec4u(per_axis.y));
    textureStore(place, wait.texel, 6, vec4u(per_axis.z));
}

@if(grid)
fn traced(start: Trace) -> Trace {
    var trace = start;
    let ray = grid_ray(trace.origin, trace.direction);
    @if(!resumes) var walk = enter_grid(ray);
    @if(resumes) var walk = resumed(ray);
    // robust leaves the grid long before; with the paper's rules a ray may wrap over a face again and again.
    @if(in_cell) var bound = 4 * (grid.cells.x + grid.cells.y + grid.cells.z) + 64;
    @if(in_cell && resumes && (!robust || drifting)) if (wait.before) {
        bound = i32(textureLoad(place, wait.texel, 3).x);
    }
    @if(!in_cell && resumes && (!robust || drifting)) let bound = 0;
    while (walk.inside) {
        let index = cell_index(walk.cell);
        @if(resumes) if (is_spent(trace)) {
            @if(!robust || drifting) keep_place(walk, bound);
            wait_at(index, 0u);
            return trace;
        }
        @if(resumes) trace.turns += 1u;
        @if(counters && !resumes) trace.cells += 1u;
        @if(counters && resumes) trace.cells += select(0u, 1u, wait.item == 0u);
        @if(skip) let distance = empty_distance(index);
        @else let distance = 0;
        if (distance == 0) {
            let end = grid_cells[index + 1u];
            @if(!resumes) let first = grid_cells[index];
            @if(resumes) let first = grid_cells[index] + wait.item;
            for (var item = first; item < end; item++) {
                trace = tested(trace, grid_items[item], walk.cell);
                @if(any_hit) if (trace.ended) {
                    return trace;
                }
                @if(resumes) if (is_spent(trace) && item + 1u < end) {
                    @if(!robust || drifting) keep_place(walk, bound);
                    wait_at(index, item + 1u - grid_cells[index]);
                    return trace;
                }
            }
        }
        @if(resumes) wait.item = 0u;
        @if(!in_cell) if (trace.t <= smallest3(walk.tmax)) {
            break;
        }
        @if(intervals && !in_cell) if (trace.interval.y <= smallest3(walk.tmax)) {
            break;
        }
        @if(in_cell) {
            bound -= 1;
            if (trace.triangle != NO_TRIANGLE || bound < 0) {
                break;
            }
        }
        @if(skip) if (distance > 1) {
            walk = leap(walk, distance, ray);
            continue;
        }
        walk = advance(walk, ray);
    }
    return trace;
}

// The first cell, or the one at which the ray waits.
@if(irregular && resumes)
fn resumed(ray: GridRay) -> VoxelWalk {
    if (!wait.before) {
        return enter_irregular(ray);
    }
    return at_voxel(load_voxel(wait.texel), wait.cell);
}

@if(irregular && resumes)
fn wait_in(walk: VoxelWalk, item: u32) {
    store_voxel(wait.texel, unpacked_voxel(walk.voxel));
    wait_at(walk.cell, item);
}

// A turn of the loop tests a triangle or, once the list is at its end, steps to the next cell: rays that run together
// then wait for each other's longest list once, not in every cell.
@if(irregular)
fn traced(start: Trace) -> Trace {
    var trace = start;
    let ray = grid_ray(trace.origin, trace.direction);
    @if(!resumes) var walk = enter_irregular(ray);
    @if(resumes) var walk = resumed(ray);
    var item = walk.first;
    @if(resumes) if (item != NO_LIST) {
        item += wait.item;
    }
    @if(counters && !resumes) trace.cells += select(0u, 1u, walk.inside);
    @if(counters && resumes) trace.cells += select(0u, 1u, walk.inside && !wait.before);
    while (walk.inside) {
        if (item != NO_LIST) {
            let entry = irregular_items[item];
            trace = tested(trace, entry & ~LAST_ITEM, vec3i(0));
            @if(any_hit) if (trace.ended) {
                return trace;
            }
            item = select(item + 1u, NO_LIST, (entry & LAST_ITEM) != 0u);
        }
        if (item == NO_LIST) {
            let exit = voxel_exit(walk, ray);
            let t = smallest3(exit.tmax);
            if (trace.t <= t) {
                break;
            }
            @if(intervals) if (trace.interval.y <= t) {
                break;
            }
            walk = step_voxel(walk, exit, ray);
            item = walk.first;
            @if(counters) trace.cells += select(0u, 1u, walk.inside);
            @if(resumes) trace.turns += 1u + grid.levels;
        }
        @if(resumes) if (is_spent(trace) && walk.inside) {
            wait_in(walk, select(item - walk.first, 0u, item == NO_LIST));
            return trace;
        }
    }
    return trace;
}

@if(bvh)
fn traced(start: Trace) -> Trace {
    var trace = start;
    if (scene.triangles == 0u) {
        return trace;
    }
    let ray = wide_ray(trace.origin, finite_inverse(trace.direction));
    // Only as large as this scene's BVH needs: it is filled with zeros first, for every ray.
    var stack: array<vec2u, WIDE_STACK>;
    var height = 0u;
    // The root as the only hit of a group; its slot is chosen by the octant, so that no inner child precedes it.
    var group = WideGroup(0u, 0x80000000u);
    // A restart trail (Laine, 2010): for each level's group, 4 bits with the child that was entered last, or NO_CHILD.
    // A group's level is in bits 8-15 of its word.
    @if(resumes) var path: array<u32, TRAIL_WORDS>;
    @if(resumes) if (wait.before) {
        for (var word = 0u; word < TRAIL_WORDS; word++) {
            path[word] = textureLoad(trail, wait.texel, word).x;
        }
        // Down to where the ray waits: later siblings whose boxes are met wait on the stack again.
        for (var level = 0u; level < wait.item; level++) {
            let child = trail_child(path[level / 8u], level);
            let node = wide_child(group, 24u + child, ray);
            group.bits &= (1u << (24u + child)) - 1u;
            if (group.bits > 0x00ffffffu) {
                stack[height] = vec2u(group.base, group.bits);
                height += 1u;
            }
            @if(intervals) group = visit_wide(node, ray, min(trace.t, trace.interval.y)).inner;
            @else group = visit_wide(node, ray, trace.t).inner;
            group.bits |= (level + 1u) << 8u;
        }
        let child = trail_child(path[wait.item / 8u], wait.item);
        if (child != NO_CHILD) {
            group.bits &= (1u << (24u + child)) - 1u;
        }
        trace.turns += wait.item;
        // The nodes ahead may be behind the nearest hit by now.
        if (group.bits <= 0x00ffffffu) {
            if (height == 0u) {
                return trace;
            }
            height -= 1u;
            group = WideGroup(stack[height].x, stack[height].y);
        }
    }
    loop {
        let bit = firstLeadingBit(group.bits);
        let node = wide_child(group, bit, ray);
        group.bits &= ~(1u << bit);
        @if(resumes) let level = (group.bits >> 8u) & 0xffu;
        @if(resumes) path[level / 8u] = with_trail_child(path[level / 8u], level, bit - 24u);
        @if(resumes) trace.turns += 1u;
        if (group.bits > 0x00ffffffu) {
            stack[height] = vec2u(group.base, group.bits);
            height += 1u;
        }
        @if(intervals) let hits = visit_wide(node, ray, min(trace.t, trace.interval.y));
        @else let hits = visit_wide(node, ray, trace.t);
        @if(counters) trace.cells += 1u;
        group = hits.inner;
        @if(resumes) if (level < MOST_LEVELS) {
            group.bits |= (level + 1u) << 8u;
            path[(level + 1u) / 8u] = with_trail_child(path[(level + 1u) / 8u], level + 1u, NO_CHILD);
        }
        var waiting = hits.leaves.bits;
        while (waiting != 0u) {
            let bit = firstTrailingBit(waiting);
            waiting &= waiting - 1u;
            trace = tested(trace, wide_entry(hits.leaves, bit), vec3i(0));
            @if(any_hit) if (trace.ended) {
                return trace;
            }
        }
        if (group.bits <= 0x00ffffffu) {
            if (height == 0u) {
                break;
            }
            height -= 1u;
            group = WideGroup(stack[height].x, stack[height].y);
        }
        @if(resumes) if (is_spent(trace)) {
            for (var word = 0u; word < TRAIL_WORDS; word++) {
                textureStore(trail, wait.texel, word, vec4u(path[word]));
            }
            wait_at(node, (group.bits >> 8u) & 0xffu);
            return trace;
        }
    }
    return trace;
}

@if(!grid && !irregular && !bvh)
fn traced(start: Trace) -> Trace {
    var trace = start;
    @if(!resumes) let first = 0u;
    @if(resumes) let first = wait.item;
    for (var triangle = first; triangle < scene.triangles; triangle++) {
        trace = tested(trace, triangle, vec3i(0));
        @if(any_hit) if (trace.ended) {
            return trace;
        }
        @if(resumes) if (is_spent(trace) && triangle + 1u < scene.triangles) {
            wait_at(0u, triangle + 1u);
            return trace;
        }
    }
    return trace;
}

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn fused(@builtin(global_invocation_id) id: vec3u) {
    let texel = vec2u(id.x, id.y + WORKGROUP * scene.first_row);
    // A uniform: asking a texture for its size takes as long as a load, and the loads below wait for it.
    if (any(texel >= scene.size)) {
        return;
    }
    // All loads before the next branch, so that they wait for memory together.
    @if(!eye_rays) let origin = load_origin(texel);
    @if(!eye_rays) let direction = load_direction(texel);
    @if(!eye_rays || resumes) let tag = textureLoad(state, texel, 0).x;
    @if(!eye_rays && !resumes) if (tag != TRAV_SETUP) {
        return;
    }
    @if(resumes) {
        wait.texel = texel;
        wait.before = tag == TRAV || tag == ISECT_NO_HIT || tag == ISECT_HIT;
        @if(eye_rays) let is_new = tag == UNWRITTEN;
        @else let is_new = tag == TRAV_SETUP;
        if (!wait.before && !is_new) {
            return;
        }
    }
    var trace: Trace;
    @if(eye_rays) {
        let ray = eye_ray(texel);
        trace.origin = ray.origin;
        trace.direction = ray.direction;
    }
    @if(!eye_rays) {
        trace.origin = origin;
        trace.direction = direction;
    }
    trace.shear = shear_of(trace.direction);
    @if(intervals) trace.interval = load_interval(texel);
    trace.t = INF;
    @if(any_hit && !eye_rays) trace.t = bitcast<f32>(textureLoad(state, texel, 1).x);
    trace.triangle = NO_TRIANGLE;
    @if(resumes) if (wait.before) {
        trace.t = bitcast<f32>(textureLoad(state, texel, 1).x);
        trace.u = bitcast<f32>(textureLoad(hit, texel, 0).x);
        trace.v = bitcast<f32>(textureLoad(hit, texel, 1).x);
        trace.triangle = textureLoad(hit, texel, 2).x;
        wait.cell = textureLoad(state, texel, 2).x;
        wait.item = textureLoad(state, texel, 3).x;
        @if(counters) trace.cells = textureLoad(counters, texel, 0).x;
        @if(counters) trace.tests = textureLoad(counters, texel, 1).x;
    }
    trace = traced(trace);

    textureStore(hit, texel, 0, vec4u(bitcast<u32>(trace.u)));
    textureStore(hit, texel, 1, vec4u(bitcast<u32>(trace.v)));
    textureStore(hit, texel, 2, vec4u(trace.triangle));
    @if(!resumes) let next = select(SHADE, BACKGROUND, trace.triangle == NO_TRIANGLE);
    @if(resumes) var next = select(SHADE, BACKGROUND, trace.triangle == NO_TRIANGLE);
    @if(resumes) if (wait.after) {
        @if(bvh) next = TRAV;
        @else next = select(ISECT_HIT, ISECT_NO_HIT, trace.triangle == NO_TRIANGLE);
        textureStore(state, texel, 2, vec4u(wait.cell));
        textureStore(state, texel, 3, vec4u(wait.item));
    }
    textureStore(state, texel, 0, vec4u(next));
    textureStore(state, texel, 1, vec4u(bitcast<u32>(trace.t)));
    @if(counters) {
        textureStore(counters, texel, 0, vec4u(trace.cells));
        textureStore(counters, texel, 1, vec4u(trace.tests));
        textureStore(counters, texel, 2, vec4u(0u));
    }
}
