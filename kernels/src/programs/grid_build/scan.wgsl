// Turns the values of each block of 256 into the sums of those before them, and keeps the block's own sum.
//
// Levels of scan and then add make the sums of a whole set: reduce-then-scan in passes (Sengupta, Harris, Zhang, Owens
// 2007). A block waits for no other one, so nothing is asked of how a device schedules workgroups, as the single pass
// of Merrill and Garland (2016) does.

import package::launch::{BLOCK, launch, block_index, texel};
import package::saturating::{saturating_add};

@group(0) @binding(0) var values: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(1) var sums: texture_storage_2d_array<r32uint, write>;

var<workgroup> partial: array<array<u32, BLOCK>, 2>;

// In each of eight steps a thread adds what lies 1, 2, 4 … before it (Hillis, Steele 1986).
@compute @workgroup_size(BLOCK)
fn scan(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = block_index(group, groups);
    let i = block * BLOCK + lane;
    let at = texel(i, textureDimensions(values).x);
    var value = 0u;
    if (i < launch.elements) {
        value = textureLoad(values, at, 0).x;
    }
    partial[0][lane] = value;
    workgroupBarrier();
    var from_side = 0u;
    for (var distance = 1u; distance < BLOCK; distance *= 2u) {
        var sum = partial[from_side][lane];
        if (lane >= distance) {
            sum = saturating_add(sum, partial[from_side][lane - distance]);
        }
        from_side = 1u - from_side;
        partial[from_side][lane] = sum;
        workgroupBarrier();
    }
    if (i >= launch.elements) {
        return;
    }
    var before = 0u;
    if (lane > 0u) {
        before = partial[from_side][lane - 1u];
    }
    textureStore(values, at, 0, vec4u(before));
    if (lane == 0u) {
        textureStore(sums, texel(block, textureDimensions(sums).x), 0, vec4u(partial[from_side][BLOCK - 1u]));
    }
}
