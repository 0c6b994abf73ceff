// Traces each ray from its start to its nearest hit: the steps of the other kernels in one loop. The loop is in the file
// of the structure that the scene is traced through: fused/grid.wgsl, irregular.wgsl, bvh.wgsl or all.wgsl.
//
// resumes: a ray whose walk takes more loop iterations than one dispatch allows waits for the next one, see
// fused/waiting.wgsl.

import package::constants::{WORKGROUP};
import package::scene::{scene, size_of_streams};
import package::fused_whole::{trace_ray};

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn fused(@builtin(global_invocation_id) id: vec3u) {
    let texel = vec2u(id.x, id.y + WORKGROUP * scene.first_row);
    // A uniform: asking a texture for its size takes as long as a load, and the loads below wait for it.
    if (any(texel >= size_of_streams())) {
        return;
    }
    trace_ray(texel);
}
