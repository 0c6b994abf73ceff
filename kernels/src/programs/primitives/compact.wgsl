// Moves the values that are kept side by side, in order, each layer of a stream for itself (Blelloch 1990): after prefix
// sums of ones and zeros, an element is kept if the next one's place is another than its own.

import package::launch::{BLOCK, launch, element, texel};

@group(0) @binding(0) var place: texture_2d_array<u32>;
@group(0) @binding(1) var total: texture_2d_array<u32>;
@group(0) @binding(2) var value_in: texture_2d_array<u32>;
@group(0) @binding(3) var value_out: texture_storage_2d_array<r32uint, write>;

@compute @workgroup_size(BLOCK)
fn compact(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let width = textureDimensions(place).x;
    let to = textureLoad(place, texel(i, width), 0, 0).x;
    var next = textureLoad(total, vec2u(0u), 0, 0).x;
    if (i + 1u < launch.elements) {
        next = textureLoad(place, texel(i + 1u, width), 0, 0).x;
    }
    if (next != to) {
        let at = texel(to, textureDimensions(value_out).x);
        for (var layer = 0u; layer < textureNumLayers(value_in); layer++) {
            textureStore(value_out, at, layer, textureLoad(value_in, texel(i, width), layer, 0));
        }
    }
}
