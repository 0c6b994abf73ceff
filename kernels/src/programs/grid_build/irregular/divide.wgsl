import package::launch::{BLOCK, launch, element, texel};
import package::build::{build};
import package::leaf::{STAYS, load_at, place_in, space_at, level_of};
import package::ranks::{count};
import package::sums::{sum_before};
import package::u64::{share};

@group(0) @binding(0) var space: texture_2d_array<u32>;
@group(0) @binding(1) var list: texture_2d_array<u32>;
@group(0) @binding(2) var division: texture_2d_array<u32>;
@group(0) @binding(3) var places: texture_2d_array<u32>;
@group(0) @binding(4) var totals: texture_2d_array<u32>;
@group(0) @binding(8) var places_of_block: texture_2d_array<u32>;
@group(0) @binding(5) var next_space: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(6) var next_list: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(7) var next_division: texture_storage_2d_array<r32uint, write>;

fn store(i: u32, extent: vec3u, list: vec2u, division: vec2u) {
    let at = texel(i, textureDimensions(next_space).x);
    textureStore(next_space, at, 0, vec4u(extent.x));
    textureStore(next_space, at, 1, vec4u(extent.y));
    textureStore(next_space, at, 2, vec4u(extent.z));
    textureStore(next_list, at, 0, vec4u(list.x));
    textureStore(next_list, at, 1, vec4u(list.y));
    textureStore(next_division, at, 0, vec4u(division.x));
    textureStore(next_division, at, 1, vec4u(division.y));
}

// Replaces each divided leaf by its eight octants, and moves the others, which are never divided later.
@compute @workgroup_size(BLOCK)
fn divide(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let at = place_in(places, i);
    let to = sum_before(places, at, places_of_block, i, 0u);
    var reference = sum_before(places, at, places_of_block, i, 1u);
    var end = load_at(totals, vec2u(0u), 0u);
    if (i + 1u < launch.elements) {
        end = sum_before(places, place_in(places, i + 1u), places_of_block, i + 1u, 0u);
    }
    let extent = space_at(space, at);
    let first = load_at(list, at, 0u);
    let length = load_at(list, at, 1u);
    let budget = load_at(division, at, 0u);
    let levels = load_at(division, at, 1u);
    if (end - to != 8u) {
        store(to, extent, vec2u(reference, length), vec2u(budget, levels | STAYS));
        return;
    }
    var after = 0u;
    for (var half = 0u; half < 8u; half++) {
        after += count(half, first, length);
    }
    let width = (1u << build.levels) >> (level_of(levels) + 1u);
    for (var half = 0u; half < 8u; half++) {
        let listed = count(half, first, length);
        let low = (extent & vec3u(0xffffu)) + width * ((vec3u(half) >> vec3u(0u, 1u, 2u)) & vec3u(1u));
        let its_budget = share(budget, listed, max(after, 1u));
        store(to + half, low | ((low + width) << vec3u(16u)), vec2u(reference, listed), vec2u(its_budget, levels + 1u));
        reference += listed;
    }
}
