import package::launch::{BLOCK, launch, element, texel};
import package::leaf::{load, level_of};
import package::ranks::{bits, rank};

@group(0) @binding(0) var owner: texture_2d_array<u32>;
@group(0) @binding(1) var item: texture_2d_array<u32>;
@group(0) @binding(2) var list: texture_2d_array<u32>;
@group(0) @binding(3) var places: texture_2d_array<u32>;
@group(0) @binding(4) var next_list: texture_2d_array<u32>;
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
    let leaf = load(owner, i, 0u);
    let triangle = load(item, i, 0u);
    let first = load(list, leaf, 0u);
    let to = load(places, leaf, 0u);
    let width = textureDimensions(next_owner).x;
    // A half is a level deeper than what it is a half of.
    if (level_of(load(next_division, to, 1u)) == level_of(load(division, leaf, 1u))) {
        let at = texel(load(next_list, to, 0u) + i - first, width);
        textureStore(next_owner, at, 0, vec4u(to));
        textureStore(next_item, at, 0, vec4u(triangle));
        return;
    }
    for (var half = 0u; half < 8u; half++) {
        if (((load(bits, i / 32u, half) >> (i % 32u)) & 1u) != 0u) {
            let place = load(next_list, to + half, 0u) + rank(half, i) - rank(half, first);
            let at = texel(place, width);
            textureStore(next_owner, at, 0, vec4u(to + half));
            textureStore(next_item, at, 0, vec4u(triangle));
        }
    }
}
