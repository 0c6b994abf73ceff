// Moves each body, by the velocity after its change: the steps of Euler's method in turn keep the energy bounded.

import package::launch::{BLOCK, element, launch, texel};
import package::program::{STEP};

@group(0) @binding(0) var position: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(1) var velocity: texture_2d_array<f32>;

@compute @workgroup_size(BLOCK)
fn advance(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let at = texel(i, launch.width);
    for (var axis = 0u; axis < 3u; axis++) {
        let speed = textureLoad(velocity, at, axis, 0).x;
        textureStore(position, at, axis, vec4f(textureLoad(position, at, axis).x + STEP * speed));
    }
}
