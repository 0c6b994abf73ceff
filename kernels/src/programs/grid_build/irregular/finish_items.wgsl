import package::launch::{BLOCK, launch, element, texel};
import package::leaf::{load};

@group(0) @binding(0) var list: texture_2d_array<u32>;
@group(0) @binding(1) var item: texture_storage_2d_array<r32uint, read_write>;

const LAST_ITEM: u32 = 0x80000000u;

// Marks the last triangle of each list.
@compute @workgroup_size(BLOCK)
fn finish_items(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let length = load(list, i, 1u);
    if (length > 0u) {
        let at = texel(load(list, i, 0u) + length - 1u, textureDimensions(item).x);
        textureStore(item, at, 0, vec4u(textureLoad(item, at, 0).x | LAST_ITEM));
    }
}
