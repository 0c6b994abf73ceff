// Counts the rays in each state, after a kernel that does not count them itself: in the fused kernel, a global atomic
// per small workgroup would take longer than its shortest runs.

@group(0) @binding(0) var state: texture_2d_array<u32>;
@group(2) @binding(0) var<storage, read_write> sent: array<atomic<u32>, 8>;

var<workgroup> in_workgroup: array<atomic<u32>, 8>;

@compute @workgroup_size(16, 16)
fn count(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    if (all(id.xy < textureDimensions(state))) {
        let tag = min(textureLoad(state, id.xy, 0, 0).x, 7u);
        atomicAdd(&in_workgroup[tag], 1u);
    }
    workgroupBarrier();
    if (lane < 8u) {
        let rays = atomicLoad(&in_workgroup[lane]);
        if (rays > 0u) {
            atomicAdd(&sent[lane], rays);
        }
    }
}
