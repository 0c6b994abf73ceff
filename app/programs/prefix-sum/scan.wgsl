// Replaces each value of a block of 256 by the sum of those before it, and stores the sum of the block.

import package::launch::{BLOCK, block_index, element, launch, texel};

@group(0) @binding(0) var values: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(1) var sums: texture_storage_2d_array<r32uint, write>;

// Two rows, which are read and written in turn.
var<workgroup> row: array<array<u32, BLOCK>, 2>;

@compute @workgroup_size(BLOCK)
fn scan(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    let at = texel(i, launch.width);
    let is_there = i < launch.elements;
    var own = 0u;
    if (is_there) {
        own = textureLoad(values, at, 0).x;
    }
    row[0][lane] = own;
    var now = 0u;
    // After each turn, an entry is the sum of twice as many values.
    for (var reach = 1u; reach < BLOCK; reach *= 2u) {
        workgroupBarrier();
        var sum = row[now][lane];
        if (lane >= reach) {
            sum += row[now][lane - reach];
        }
        row[1u - now][lane] = sum;
        now = 1u - now;
    }
    workgroupBarrier();
    let sum = row[now][lane];
    if (is_there) {
        textureStore(values, at, 0, vec4u(sum - own));
    }
    if (lane == BLOCK - 1u) {
        let block = block_index(group, groups);
        textureStore(sums, texel(block, textureDimensions(sums).x), 0, vec4u(sum));
    }
}
