import package::launch::{BLOCK, launch, element, texel};
import package::leaf::{load};

@group(0) @binding(0) var totals: texture_2d_array<u32>;
@group(0) @binding(1) var round: texture_storage_2d_array<r32uint, write>;

// Begins with the x axis, in the first round.
@compute @workgroup_size(BLOCK)
fn start_merging(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let leaves = load(totals, 0u, 0u);
    textureStore(round, vec2u(0u), 0, vec4u(0u));
    textureStore(round, vec2u(0u), 1, vec4u(0u));
    textureStore(round, vec2u(0u), 2, vec4u(leaves));
    textureStore(round, vec2u(0u), 3, vec4u(1u));
    textureStore(round, vec2u(0u), 4, vec4u(leaves));
}
