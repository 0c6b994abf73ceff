import package::launch::{BLOCK, launch, element_of_rows};
import package::build::{build};
import package::leaf::{load, load_at, place_in, space_at, high_of};
import package::product::{product64};
import package::soft_f64::{add64};
import package::u64::{is_at_most64, times64};
import package::voxel_map::{find};

@group(0) @binding(0) var space: texture_2d_array<u32>;
@group(0) @binding(1) var list: texture_2d_array<u32>;
@group(0) @binding(2) var item: texture_2d_array<u32>;
@group(0) @binding(3) var cell_of: texture_2d_array<u32>;
@group(0) @binding(4) var round: texture_2d_array<u32>;
@group(0) @binding(5) var wished: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(6) var wished_by: texture_storage_2d_array<r32uint, write>;

// Longer lists are never merged.
const LONGEST: u32 = 16384u;
// Cost of a step from cell to cell, in triangle tests.
const STEP_COST: u32 = 1u;

// What rays pay for a box: half of its surface, for each test and step.
fn cost(extent: vec3u, listed: u32) -> vec2u {
    let side = ((extent >> vec3u(16u)) - (extent & vec3u(0xffffu))) * build.weights;
    let area = add64(add64(product64(side.x, side.y), product64(side.y, side.z)), product64(side.z, side.x));
    return times64(area, listed + STEP_COST);
}

// How many triangles two lists share, each given by its first reference and its length.
fn shared_by(a: vec2u, b: vec2u) -> u32 {
    var in_both = 0u;
    var i = 0u;
    var k = 0u;
    while (i < a.y && k < b.y) {
        let one = load(item, a.x + i, 0u);
        let other = load(item, b.x + k, 0u);
        in_both += u32(one == other);
        i += u32(one <= other);
        k += u32(other <= one);
    }
    return in_both;
}

// Proposes to merge a leaf with the neighbour after it along the round's axis if the two form a box and, by the surface
// area heuristic (Goldsmith and Salmon, 1987), the merged leaf costs no more than the two. Leaves without a wish write
// nothing: if the previous axis merged any leaves, both streams were created anew, unwritten; otherwise no leaf had a wish.
@compute @workgroup_size(BLOCK)
fn wish(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element_of_rows(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let axis = load_at(round, vec2u(0u), 0u);
    let at = place_in(space, i);
    let extent = space_at(space, at);
    let end = high_of(extent[axis]);
    if (end >= build.cells[axis] << build.levels) {
        return;
    }
    var voxel = extent & vec3u(0xffffu);
    voxel[axis] = end;
    let next = load(cell_of, find(voxel), 0u);
    let there = place_in(space, next);
    // All loads side by side: what takes time is to wait for one after the other.
    let other = space_at(space, there);
    let listed = load_at(list, at, 1u);
    let its_listed = load_at(list, there, 1u);
    var differs = extent ^ other;
    differs[axis] = 0u;
    // Somebody may have edited a length: the sum could be too large.
    if (any(differs != vec3u(0u)) || max(listed, its_listed) > LONGEST || listed + its_listed > LONGEST) {
        return;
    }
    var both = extent;
    both[axis] = (extent[axis] & 0xffffu) | (other[axis] & 0xffff0000u);
    let apart = add64(cost(extent, listed), cost(other, its_listed));
    // The merged list has at least as many triangles as the longer one.
    if (!is_at_most64(cost(both, max(listed, its_listed)), apart)) {
        return;
    }
    var in_both = 0u;
    if (min(listed, its_listed) > 0u) {
        in_both = shared_by(vec2u(load_at(list, at, 0u), listed), vec2u(load_at(list, there, 0u), its_listed));
    }
    if (is_at_most64(cost(both, listed + its_listed - in_both), apart)) {
        textureStore(wished, at, 0, vec4u(next));
        textureStore(wished, at, 1, vec4u(in_both));
        textureStore(wished_by, there, 0, vec4u(i));
    }
}
