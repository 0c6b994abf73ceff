// Replaces the values in each block of 8,192 by the sums of those before them, and stores the block's own sum; each
// layer of a stream for itself.
//
// Two levels of scan and one of add give the sums of a whole set: scan-then-propagate in passes (Sengupta, Harris,
// Zhang, Owens 2007). No block waits for another, so nothing is assumed about how a device schedules workgroups, unlike
// the single pass of Merrill and Garland (2016).

import package::launch::{BLOCK, launch, block_index, texel};
import package::saturating::{saturating_add};

@group(0) @binding(0) var values: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(1) var sums: texture_storage_2d_array<r32uint, write>;

// Values per thread.
const EACH: u32 = 32u;
// Values per thread of a tile, which is loaded and stored side by side.
const EACH_OF_TILE: u32 = 8u;
const TILE: u32 = BLOCK * EACH_OF_TILE;
const TILES: u32 = EACH / EACH_OF_TILE;

var<workgroup> tile: array<u32, TILE + TILE / 32u>;
var<workgroup> partial: array<array<u32, BLOCK>, 2>;

// Where a value of the tile is: the threads' first values are in different banks.
fn slot(k: u32) -> u32 {
    return k + k / 32u;
}

// Tile by tile, a thread sums its own values, then, in each of eight steps, adds the value 1, 2, 4 … threads before it
// (Hillis, Steele 1986).
@compute @workgroup_size(BLOCK)
fn scan(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = block_index(group, groups);
    let width = textureDimensions(values).x;
    // A dispatch may have blocks past the last one: with at most 2^26 elements, none begins beyond 2^32.
    let first = block * BLOCK * EACH;
    for (var layer = 0u; layer < textureNumLayers(values); layer++) {
        var all_before = 0u;
        for (var t = 0u; t < TILES; t++) {
            let begin = first + t * TILE;
            if (begin >= launch.elements) {
                break;
            }
            for (var k = lane; k < TILE; k += BLOCK) {
                var value = 0u;
                if (begin + k < launch.elements) {
                    value = textureLoad(values, texel(begin + k, width), layer).x;
                }
                tile[slot(k)] = value;
            }
            workgroupBarrier();
            var own = 0u;
            for (var k = 0u; k < EACH_OF_TILE; k++) {
                own = saturating_add(own, tile[slot(lane * EACH_OF_TILE + k)]);
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
            var before = all_before;
            if (lane > 0u) {
                before = saturating_add(before, partial[from_side][lane - 1u]);
            }
            for (var k = 0u; k < EACH_OF_TILE; k++) {
                let at = slot(lane * EACH_OF_TILE + k);
                let value = tile[at];
                tile[at] = before;
                before = saturating_add(before, value);
            }
            all_before = saturating_add(all_before, partial[from_side][BLOCK - 1u]);
            workgroupBarrier();
            for (var k = lane; k < TILE && begin + k < launch.elements; k += BLOCK) {
                textureStore(values, texel(begin + k, width), layer, vec4u(tile[slot(k)]));
            }
        }
        if (lane == 0u && first < launch.elements) {
            textureStore(sums, texel(block, textureDimensions(sums).x), layer, vec4u(all_before));
        }
    }
}
