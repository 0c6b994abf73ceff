// Tests the ray against one triangle of its list, and decides what is next when the list ends. The list is the cell's, the
// leaf's, or all triangles: see the file of the structure, intersect/grid.wgsl, irregular.wgsl, bvh.wgsl or all.wgsl.
// robust keeps the nearest hit and accepts it once it lies within the cells walked; paper accepts a hit only inside its
// own cell, and needs one more step to notice the list's delimiter (Listing 2).
// counters: in a grid, also finds out whether an earlier cell listed the triangle too, see intersect/repetition.wgsl.

import package::constants::{NOBODY, LIST_SIDE};
import package::state::{ISECT_NO_HIT, ISECT_HIT, SHADE};
import package::triangle::{hit_triangle, is_nearer, shear_of};
import package::bounds::{ended_with, latest_of};
import package::corners::{vertex};
import package::ray::{load_ray};
import package::grid::{is_in_cell, cell_of_index};
import package::live::{listed_texel, send};
import package::intersect_acceptance::{is_kept, that_counts};
import package::intersect_structure::{list_of, has_item, entry_of, after_list};
import package::intersect_repetition::{NOT_KNOWN_YET, repetition};

@group(0) @binding(2) var state: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var hit: texture_storage_2d_array<r32uint, read_write>;
@if(counters) @group(0) @binding(5) var counters: texture_storage_2d_array<r32uint, read_write>;

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
    let list = list_of(cell);
    let ray = load_ray(texel);
    let in_list = has_item(list, item);
    var ended = !in_list;
    if (in_list) {
        let entry = entry_of(list, item);
        @if(robust) ended = entry.is_last;
        @if(grid && counters) let repeated = repetition(texel, entry.triangle, cell, ray);
        @if(resumes_scan) if (repeated == NOT_KNOWN_YET) {
            return tag;
        }
        let a = vertex(entry.triangle, 0u);
        let b = vertex(entry.triangle, 1u);
        let c = vertex(entry.triangle, 2u);
        var candidate = hit_triangle(ray.origin, ray.direction, shear_of(ray.direction), a, b, c);
        candidate = that_counts(candidate, texel, entry.triangle);
        @if(exact_order) let accepted = is_kept(candidate, a, b, c, entry.triangle, texel, nearest_t, textureLoad(hit, texel, 2).x);
        @else @if(in_cell) let accepted = candidate.t < nearest_t
            && is_in_cell(ray.origin + ray.direction * candidate.t, cell_of_index(cell));
        @else @if(robust && !any_hit) let accepted = is_nearer(candidate.t, entry.triangle, nearest_t, textureLoad(hit, texel, 2).x);
        @else let accepted = candidate.t < nearest_t;
        if (candidate.is_hit && accepted) {
            textureStore(hit, texel, 0, vec4u(bitcast<u32>(candidate.u)));
            textureStore(hit, texel, 1, vec4u(bitcast<u32>(candidate.v)));
            textureStore(hit, texel, 2, vec4u(entry.triangle));
            nearest_t = candidate.t;
            tag = ISECT_HIT;
        }
        item += 1u;
        @if(counters) textureStore(counters, texel, 1, vec4u(textureLoad(counters, texel, 1).x + 1u));
        @if(grid && counters) textureStore(counters, texel, 2, vec4u(textureLoad(counters, texel, 2).x + repeated));
    }

    if (ended) {
        tag = ended_with(texel, after_list(texel, tag, latest_of(texel, nearest_t)), nearest_t);
    }
    @if(any_hit) if (nearest_t != nearest_before) {
        tag = SHADE;
    }
    if (nearest_t != nearest_before) {
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
