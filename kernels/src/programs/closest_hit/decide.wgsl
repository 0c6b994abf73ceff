// Traces those rays again whose nearest hit the bounds on rounding errors leave open: whether a triangle is hit, and which of
// two is nearer, is decided in integers (exact.wgsl) wherever f32 cannot tell.

import package::constants::{WORKGROUP};
import package::scene::{scene, size_of_streams};
import package::fused_whole::{trace_ray};

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn decide(@builtin(global_invocation_id) id: vec3u) {
    let texel = vec2u(id.x, id.y + WORKGROUP * scene.first_row);
    // A uniform: asking a texture for its size takes as long as a load, and the loads below wait for it.
    if (any(texel >= size_of_streams())) {
        return;
    }
    trace_ray(texel);
}
