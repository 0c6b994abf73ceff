import package::launch::{BLOCK, launch, element, texel};
import package::build::{build};
import package::leaf::{load, load_space};
import package::ranks::{count};
import package::soft_f64::{add64, product64};
import package::u64::{is_at_most64, times64};

@group(0) @binding(0) var space: texture_2d_array<u32>;
@group(0) @binding(1) var list: texture_2d_array<u32>;
@group(0) @binding(2) var neighbor: texture_2d_array<u32>;
@group(0) @binding(3) var round: texture_2d_array<u32>;
@group(0) @binding(4) var wished: texture_storage_2d_array<r32uint, write>;

const NOBODY: u32 = 0xffffffffu;
// Cost of a step from cell to cell, in triangle tests.
const STEP_COST: u32 = 1u;

// What rays pay for a box: half of its surface, for each test and step.
fn cost(extent: vec3u, listed: u32) -> vec2u {
    let side = ((extent >> vec3u(16u)) - (extent & vec3u(0xffffu))) * build.weights;
    let area = add64(add64(product64(side.x, side.y), product64(side.y, side.z)), product64(side.z, side.x));
    return times64(area, listed + STEP_COST);
}

// Proposes to merge a leaf with the neighbour after it if, by the surface area heuristic (Goldsmith and Salmon, 1987),
// the merged leaf costs no more than the two.
@compute @workgroup_size(BLOCK)
fn wish(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let next = load(neighbor, i, 0u);
    var wish = NOBODY;
    if (next != NOBODY) {
        let axis = load(round, 0u, 0u);
        let extent = load_space(space, i);
        let other = load_space(space, next);
        var both = extent;
        both[axis] = (extent[axis] & 0xffffu) | (other[axis] & 0xffff0000u);
        let listed = load(list, i, 1u);
        let its_first = load(list, next, 0u);
        let its_listed = load(list, next, 1u);
        let in_all = listed + its_listed - count(0u, its_first, its_listed);
        if (is_at_most64(cost(both, in_all), add64(cost(extent, listed), cost(other, its_listed)))) {
            wish = next;
        }
    }
    textureStore(wished, texel(i, textureDimensions(wished).x), 0, vec4u(wish));
}
