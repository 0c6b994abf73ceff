// Takes each ray from its start to its nearest hit: the steps of the other kernels in one loop.

import package::constants::{INF, NO_TRIANGLE, WORKGROUP, WIDE_STACK};
import package::state::{TRAV_SETUP, SHADE, BACKGROUND};
import package::triangle::{shear_of};
import package::tracing::{Trace, tested};
import package::scene::{scene};
@if(eye_rays) import package::camera::{eye_ray};
@if(!eye_rays) import package::ray::{load_origin, load_direction};
@if(grid) import package::vector::{smallest3};
@if(grid) import package::grid_walk::{grid, grid_ray, enter_grid, advance, cell_index};
@if(grid && skip) import package::grid_walk::{leap};
@if(grid && skip) import package::grid_lists::{empty_distance};
@if(grid) import package::grid_lists::{grid_cells, grid_items};
@if(bvh) import package::bvh_walk::{finite_inverse};
@if(bvh) import package::wide_walk::{WideGroup, wide_ray, visit_wide, wide_child, wide_entry};

@if(eye_rays) @group(0) @binding(2) var state: texture_storage_2d_array<r32uint, write>;
@if(!eye_rays) @group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_storage_2d_array<r32uint, write>;
@if(counters) @group(0) @binding(5) var counters: texture_storage_2d_array<r32uint, write>;

@if(grid)
fn traced(start: Trace) -> Trace {
    var trace = start;
    let ray = grid_ray(trace.origin, trace.direction);
    var walk = enter_grid(ray);
    // robust leaves the grid long before; the paper's rules may run over a face again and again.
    @if(in_cell) var bound = 4 * (grid.cells.x + grid.cells.y + grid.cells.z) + 64;
    while (walk.inside) {
        let index = cell_index(walk.cell);
        @if(counters) trace.cells += 1u;
        @if(skip) let distance = empty_distance(index);
        @else let distance = 0;
        if (distance == 0) {
            let end = grid_cells[index + 1u];
            for (var item = grid_cells[index]; item < end; item++) {
                trace = tested(trace, grid_items[item], walk.cell);
                @if(any_hit) if (trace.ended) {
                    return trace;
                }
            }
        }
        @if(!in_cell) if (trace.t <= smallest3(walk.tmax)) {
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

@if(bvh)
fn traced(start: Trace) -> Trace {
    var trace = start;
    if (scene.triangles == 0u) {
        return trace;
    }
    let ray = wide_ray(trace.origin, finite_inverse(trace.direction));
    // As high as this scene's tree needs: it is filled with zeros first, for every ray.
    var stack: array<vec2u, WIDE_STACK>;
    var height = 0u;
    // The root, as the one hit of a group; its slot is the octant's, so that no inner child precedes it.
    var group = WideGroup(0u, 0x80000000u);
    loop {
        let bit = firstLeadingBit(group.bits);
        let node = wide_child(group, bit, ray);
        group.bits &= ~(1u << bit);
        if (group.bits > 0x00ffffffu) {
            stack[height] = vec2u(group.base, group.bits);
            height += 1u;
        }
        let hits = visit_wide(node, ray, trace.t);
        @if(counters) trace.cells += 1u;
        group = hits.inner;
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
    }
    return trace;
}

@if(!grid && !bvh)
fn traced(start: Trace) -> Trace {
    var trace = start;
    for (var triangle = 0u; triangle < scene.triangles; triangle++) {
        trace = tested(trace, triangle, vec3i(0));
        @if(any_hit) if (trace.ended) {
            return trace;
        }
    }
    return trace;
}

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn fused(@builtin(global_invocation_id) id: vec3u) {
    let texel = vec2u(id.x, id.y + WORKGROUP * scene.first_row);
    if (any(texel >= textureDimensions(state))) {
        return;
    }
    @if(!eye_rays) if (textureLoad(state, texel, 0).x != TRAV_SETUP) {
        return;
    }
    var trace: Trace;
    @if(eye_rays) {
        let ray = eye_ray(texel);
        trace.origin = ray.origin;
        trace.direction = ray.direction;
    }
    @if(!eye_rays) {
        trace.origin = load_origin(texel);
        trace.direction = load_direction(texel);
    }
    trace.shear = shear_of(trace.direction);
    trace.t = INF;
    @if(any_hit && !eye_rays) trace.t = bitcast<f32>(textureLoad(state, texel, 1).x);
    trace.triangle = NO_TRIANGLE;
    trace = traced(trace);

    textureStore(hit, texel, 0, vec4u(bitcast<u32>(trace.u)));
    textureStore(hit, texel, 1, vec4u(bitcast<u32>(trace.v)));
    textureStore(hit, texel, 2, vec4u(trace.triangle));
    let tag = select(SHADE, BACKGROUND, trace.triangle == NO_TRIANGLE);
    textureStore(state, texel, 0, vec4u(tag));
    textureStore(state, texel, 1, vec4u(bitcast<u32>(trace.t)));
    @if(counters) {
        textureStore(counters, texel, 0, vec4u(trace.cells));
        textureStore(counters, texel, 1, vec4u(trace.tests));
        textureStore(counters, texel, 2, vec4u(0u));
    }
}
