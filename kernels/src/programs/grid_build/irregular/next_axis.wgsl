import package::launch::{BLOCK, launch, element, texel};
import package::leaf::{load};

@group(0) @binding(0) var totals: texture_2d_array<u32>;
@group(0) @binding(1) var round: texture_storage_2d_array<r32uint, read_write>;

const ROUNDS: u32 = 8u;
// After the first round, merging ends with an axis along which fewer than 1 / LEAST_MERGED of the leaves that existed
// before merging are removed.
const LEAST_MERGED: u32 = 64u;

// Turns to the next axis and, after the third, to the next round, unless merging ends.
@compute @workgroup_size(BLOCK)
fn next_axis(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let axis = textureLoad(round, vec2u(0u), 0).x + 1u;
    let rounds = textureLoad(round, vec2u(0u), 1).x;
    let rounds_after = rounds + select(0u, 1u, axis >= 3u);
    let before = textureLoad(round, vec2u(0u), 2).x;
    let refined = textureLoad(round, vec2u(0u), 4).x;
    let leaves = load(totals, 0u, 0u);
    // Rounded up: the product could be too large.
    let is_worth_it = rounds == 0u || before - leaves >= (refined + LEAST_MERGED - 1u) / LEAST_MERGED;
    textureStore(round, vec2u(0u), 0, vec4u(select(axis, 0u, axis >= 3u)));
    textureStore(round, vec2u(0u), 1, vec4u(rounds_after));
    textureStore(round, vec2u(0u), 2, vec4u(leaves));
    textureStore(round, vec2u(0u), 3, vec4u(u32(rounds_after < ROUNDS && is_worth_it)));
}
