import package::launch::{BLOCK, launch, element, texel};
import package::leaf::{load};

@group(0) @binding(0) var next_division: texture_2d_array<u32>;
@group(0) @binding(1) var division: texture_storage_2d_array<r32uint, write>;

// What is left of the next leaves' budgets becomes that of the leaves.
@compute @workgroup_size(BLOCK)
fn adopt_division(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let at = texel(i, textureDimensions(division).x);
    textureStore(division, at, 0, vec4u(load(next_division, i, 0u)));
    textureStore(division, at, 1, vec4u(load(next_division, i, 1u)));
}
