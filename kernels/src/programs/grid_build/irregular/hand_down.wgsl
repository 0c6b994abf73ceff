import package::launch::{BLOCK, launch, element, texel};
import package::leaf::{load_at, place_in, level_of};
import package::sums::{sum_before};
import package::ranks::{bits, rank};

@group(0) @binding(0) var owner: texture_2d_array<u32>;
@group(0) @binding(1) var item: texture_2d_array<u32>;
@group(0) @binding(2) var list: texture_2d_array<u32>;
@group(0) @binding(3) var places: texture_2d_array<u32>;
@group(0) @binding(4) var next_list: texture_2d_array<u32>;
@group(0) @binding(9) var places_of_block: texture_2d_array<u32>;
@group(0) @binding(5) var division: texture_2d_array<u32>;
@group(0) @binding(6) var next_division: texture_2d_array<u32>;
@group(0) @binding(7) var next_owner: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(8) var next_item: texture_storage_2d_array<r32uint, write>;

// Moves each reference to its leaf's new place, or to every half in which it lies.
@compute @workgroup_size(BLOCK)
fn hand_down(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let its_place = place_in(owner, i);
    let its_leaf = load_at(owner, its_place, 0u);
    let leaf = place_in(list, its_leaf);
    let triangle = load_at(item, its_place, 0u);
    let first = load_at(list, leaf, 0u);
    let to = sum_before(places, leaf, places_of_block, its_leaf, 0u);
    let to_place = place_in(next_list, to);
    let width = textureDimensions(next_owner).x;
    // A half is a level deeper than what it is a half of.
    if (level_of(load_at(next_division, to_place, 1u)) == level_of(load_at(division, leaf, 1u))) {
        let at = texel(load_at(next_list, to_place, 0u) + i - first, width);
        textureStore(next_owner, at, 0, vec4u(to));
        textureStore(next_item, at, 0, vec4u(triangle));
        return;
    }
    let its_group = place_in(bits, i / 32u);
    for (var half = 0u; half < 8u; half++) {
        if (((load_at(bits, its_group, half) >> (i % 32u)) & 1u) != 0u) {
            let before = rank(half, i) - rank(half, first);
            let place = load_at(next_list, place_in(next_list, to + half), 0u) + before;
            let at = texel(place, width);
            textureStore(next_owner, at, 0, vec4u(to + half));
            textureStore(next_item, at, 0, vec4u(triangle));
        }
    }
}
