// Counts the rays in each state, after a kernel that does not count them itself: in the fused kernel, a global atomic
// per small workgroup would take longer than its shortest runs.

import package::state::{STATES};

@group(0) @binding(0) var state: texture_2d_array<u32>;
@group(2) @binding(0) var<storage, read_write> sent: array<atomic<u32>, STATES>;

var<workgroup> in_workgroup: array<atomic<u32>, STATES>;

@compute @workgroup_size(16, 16)
fn count(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    if (all(id.xy < textureDimensions(state))) {
        let tag = textureLoad(state, id.xy, 0, 0).x;
        if (tag < STATES) {
            atomicAdd(&in_workgroup[tag], 1u);
        }
    }
    workgroupBarrier();
    if (lane < STATES) {
        let rays = atomicLoad(&in_workgroup[lane]);
        if (rays > 0u) {
            atomicAdd(&sent[lane], rays);
        }
    }
}
