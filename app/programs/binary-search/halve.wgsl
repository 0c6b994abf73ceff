// Compares the number with the entry in the middle of its interval, and keeps the half in which it must be.

import package::launch::{BLOCK, element, launch, texel};

@group(0) @binding(0) var table: texture_2d_array<u32>;
@group(0) @binding(1) var question: texture_2d_array<u32>;
@group(0) @binding(2) var interval: texture_storage_2d_array<r32uint, read_write>;

@compute @workgroup_size(BLOCK)
fn halve(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let at = texel(i, launch.width);
    let low = textureLoad(interval, at, 0).x;
    let high = textureLoad(interval, at, 1).x;
    if (low >= high) {
        return;
    }
    let middle = (low + high) / 2u;
    let entry = textureLoad(table, texel(middle, textureDimensions(table).x), 0, 0).x;
    if (entry < textureLoad(question, at, 0, 0).x) {
        textureStore(interval, at, 0, vec4u(middle + 1u));
    } else {
        textureStore(interval, at, 1, vec4u(middle));
    }
}
