import package::launch::{BLOCK};
import package::build::{build};
import package::leaf::{load};

@group(0) @binding(0) var depth_of_group: texture_2d_array<u32>;
@group(0) @binding(1) var halving: texture_storage_2d_array<r32uint, write>;

var<workgroup> depth: atomic<u32>;

// Finds the depth of the deepest octree, of those levels down to which they are divided anyway. A single workgroup.
@compute @workgroup_size(BLOCK)
fn start_halving(@builtin(local_invocation_index) lane: u32) {
    if (lane == 0u) {
        atomicStore(&depth, 0u);
    }
    workgroupBarrier();
    let cells = build.cells.x * build.cells.y * build.cells.z;
    for (var i = lane; i < (cells + BLOCK - 1u) / BLOCK; i += BLOCK) {
        atomicMax(&depth, load(depth_of_group, i, 0u));
    }
    workgroupBarrier();
    if (lane == 0u) {
        textureStore(halving, vec2u(0u), 0, vec4u(0u));
        textureStore(halving, vec2u(0u), 1, vec4u(atomicLoad(&depth)));
    }
}
