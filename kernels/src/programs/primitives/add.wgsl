// Adds to each value the sum of all blocks before its own.

import package::launch::{BLOCK, launch, element, texel};
import package::saturating::{saturating_add};

@group(0) @binding(0) var values: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(1) var sums: texture_2d_array<u32>;

// Number of values that share one of `sums`: those of a workgroup of scan.
const SCAN_BLOCK: u32 = 8192u;

@compute @workgroup_size(BLOCK)
fn add(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let at = texel(i, textureDimensions(values).x);
    let block = texel(i / SCAN_BLOCK, textureDimensions(sums).x);
    for (var layer = 0u; layer < textureNumLayers(values); layer++) {
        let before = textureLoad(sums, block, layer, 0).x;
        textureStore(values, at, layer, vec4u(saturating_add(before, textureLoad(values, at, layer).x)));
    }
}
