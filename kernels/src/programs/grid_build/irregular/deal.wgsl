import package::launch::{BLOCK, launch, element, texel};
import package::leaf::{load};
import package::in_list::{item, lower};
import package::merging::{neighbor, wished, absorbs, is_absorbed};
import package::ranks::{bits, rank};

@group(0) @binding(0) var owner: texture_2d_array<u32>;
@group(0) @binding(1) var list: texture_2d_array<u32>;
@group(0) @binding(2) var places: texture_2d_array<u32>;
@group(0) @binding(3) var next_owner: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(4) var next_item: texture_storage_2d_array<r32uint, write>;

// Moves each reference to its place in the list of the leaf that remains: after all lower ones of both lists, except
// those that the other list has, too. A place in two merged lists (Satish, Harris, Garland 2009).
@compute @workgroup_size(BLOCK)
fn deal(
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
    var to = leaf;
    var place = i - first;
    if (is_absorbed(leaf)) {
        if (((load(bits, i / 32u, 0u) >> (i % 32u)) & 1u) != 0u) {
            return;
        }
        to = load(neighbor, leaf, 1u);
        place += lower(load(list, to, 0u), load(list, to, 1u), triangle) + rank(0u, first) - rank(0u, i);
    } else if (absorbs(leaf)) {
        let next = load(wished, leaf, 0u);
        let its_first = load(list, next, 0u);
        let lower_there = lower(its_first, load(list, next, 1u), triangle);
        if (lower_there > 0u) {
            // Those before the last of the lower ones, and that one.
            let last = its_first + lower_there - 1u;
            let is_known = (load(bits, last / 32u, 0u) >> (last % 32u)) & 1u;
            place += lower_there + rank(0u, its_first) - rank(0u, last) - is_known;
        }
    }
    let at = texel(load(places, to, 1u) + place, textureDimensions(next_owner).x);
    textureStore(next_owner, at, 0, vec4u(load(places, to, 0u)));
    textureStore(next_item, at, 0, vec4u(triangle));
}
