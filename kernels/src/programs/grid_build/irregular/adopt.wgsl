import package::launch::{BLOCK, launch, element, texel};
import package::leaf::{load};

@group(0) @binding(0) var first_in: texture_2d_array<u32>;
@group(0) @binding(1) var second_in: texture_2d_array<u32>;
@group(0) @binding(2) var first_out: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(3) var second_out: texture_storage_2d_array<r32uint, write>;

// Takes the sorted references as those of the first leaves: copies two streams.
@compute @workgroup_size(BLOCK)
fn adopt(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let at = texel(i, textureDimensions(first_out).x);
    for (var layer = 0u; layer < textureNumLayers(first_out); layer++) {
        textureStore(first_out, at, layer, vec4u(load(first_in, i, layer)));
    }
    for (var layer = 0u; layer < textureNumLayers(second_out); layer++) {
        textureStore(second_out, at, layer, vec4u(load(second_in, i, layer)));
    }
}
