import package::launch::{BLOCK, launch, block_index, texel};
import package::build::{build};
import package::leaf::{load};
import package::u64::{log2_of_square};

@group(0) @binding(0) var start: texture_2d_array<u32>;
@group(0) @binding(1) var totals: texture_2d_array<u32>;
@group(0) @binding(2) var space: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(3) var list: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(4) var division: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(5) var depth_of_group: texture_storage_2d_array<r32uint, write>;

const CELLS_PER_REFERENCE: u32 = 10u;
const GROWTH: u32 = 12u;
const GROWTH_OF_ALL: u32 = 64u;
const CROWDED: u32 = 16u;

var<workgroup> depth: atomic<u32>;

// Makes a cell of the top level a leaf. Returns the levels down to which it is divided anyway.
fn make_leaf(i: u32) -> u32 {
    let first = load(start, i, 0u);
    var end = load(totals, 0u, 1u);
    if (i + 1u < launch.elements) {
        end = load(start, i + 1u, 0u);
    }
    let length = end - first;
    var even = 0u;
    if (length > 0u && ((build.flags & 1u) != 0u || length > CROWDED)) {
        even = (log2_of_square(CELLS_PER_REFERENCE * length) + 3u) / 6u;
    }
    let cell = vec3u(i, i / build.cells.x, i / (build.cells.x * build.cells.y)) % build.cells;
    let low = cell << vec3u(build.levels);
    let extent = low | ((low + (1u << build.levels)) << vec3u(16u));
    let at = texel(i, textureDimensions(space).x);
    textureStore(space, at, 0, vec4u(extent.x));
    textureStore(space, at, 1, vec4u(extent.y));
    textureStore(space, at, 2, vec4u(extent.z));
    textureStore(list, at, 0, vec4u(first));
    textureStore(list, at, 1, vec4u(length));
    textureStore(division, at, 0, vec4u(GROWTH * length + GROWTH_OF_ALL));
    textureStore(division, at, 1, vec4u(even << 8u));
    return even;
}

// Makes every cell of the top level a leaf: the root of its octree.
@compute @workgroup_size(BLOCK)
fn make_leaves(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = block_index(group, groups);
    let i = block * BLOCK + lane;
    if (lane == 0u) {
        atomicStore(&depth, 0u);
    }
    workgroupBarrier();
    if (i < launch.elements) {
        atomicMax(&depth, make_leaf(i));
    }
    workgroupBarrier();
    if (lane == 0u && i < launch.elements) {
        let at = texel(block, textureDimensions(depth_of_group).x);
        textureStore(depth_of_group, at, 0, vec4u(atomicLoad(&depth)));
    }
}
