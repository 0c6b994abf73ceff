// Replaces the values in each block of 16,384 by the sums of those before them, and stores the block's own sum; each
// layer of a stream for itself.
//
// Two levels of scan and one of add give the sums of a whole set: reduce-then-scan in passes (Sengupta, Harris, Zhang,
// Owens 2007). No block waits for another, so nothing is assumed about how a device schedules workgroups, unlike the
// single pass of Merrill and Garland (2016).

import package::launch::{BLOCK, launch, block_index, texel};
import package::saturating::{saturating_add};

@group(0) @binding(0) var values: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(1) var sums: texture_storage_2d_array<r32uint, write>;

// Values per thread, side by side.
const EACH: u32 = 64u;

var<workgroup> partial: array<array<u32, BLOCK>, 2>;

// A thread sums its own values, then, in each of eight steps, adds the value 1, 2, 4 … threads before it (Hillis,
// Steele 1986).
@compute @workgroup_size(BLOCK)
fn scan(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = block_index(group, groups);
    let width = textureDimensions(values).x;
    // A dispatch may have blocks past the last one: with at most 2^26 elements, none begins beyond 2^32.
    let first = (block * BLOCK + lane) * EACH;
    let end = min(first + EACH, launch.elements);
    for (var layer = 0u; layer < textureNumLayers(values); layer++) {
        var own = 0u;
        for (var i = first; i < end; i++) {
            own = saturating_add(own, textureLoad(values, texel(i, width), layer).x);
        }
        partial[0][lane] = own;
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
        var before = 0u;
        if (lane > 0u) {
            before = partial[from_side][lane - 1u];
        }
        for (var i = first; i < end; i++) {
            let at = texel(i, width);
            let value = textureLoad(values, at, layer).x;
            textureStore(values, at, layer, vec4u(before));
            before = saturating_add(before, value);
        }
        if (lane == 0u && first < launch.elements) {
            textureStore(sums, texel(block, textureDimensions(sums).x), layer, vec4u(partial[from_side][BLOCK - 1u]));
        }
        workgroupBarrier();
    }
}
