import package::launch::{BLOCK, launch, element, texel};
import package::leaf::{load};

@group(0) @binding(0) var first_in: texture_2d_array<u32>;
@group(0) @binding(1) var second_in: texture_2d_array<u32>;
@group(0) @binding(2) var first_out: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(3) var second_out: texture_storage_2d_array<r32uint, write>;

// Copies two streams of one component.
@compute @workgroup_size(BLOCK)
fn adopt_pairs(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let at = texel(i, textureDimensions(first_out).x);
    textureStore(first_out, at, 0, vec4u(load(first_in, i, 0u)));
    textureStore(second_out, at, 0, vec4u(load(second_in, i, 0u)));
}
