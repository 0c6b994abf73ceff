// Bodies in a disc, on a spiral of equal areas (Vogel 1979), each on its way around the centre.

import package::launch::{BLOCK, element, launch, texel};

@group(0) @binding(0) var position: texture_storage_2d_array<r32float, write>;
@group(0) @binding(1) var velocity: texture_storage_2d_array<r32float, write>;

const GOLDEN_ANGLE: f32 = 2.3999632;

@compute @workgroup_size(BLOCK)
fn place(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let at = texel(i, launch.width);
    let radius = sqrt((f32(i) + 0.5) / f32(launch.elements));
    let angle = f32(i) * GOLDEN_ANGLE;
    let out = vec3f(cos(angle), sin(angle), 0.0);
    let place = radius * out + vec3f(0.0, 0.0, 0.05 * sin(7.0 * angle));
    // The mass inside of the radius is radius², of a total of 1.
    let speed = 0.8 * sqrt(radius) * vec3f(-out.y, out.x, 0.0);
    for (var axis = 0u; axis < 3u; axis++) {
        textureStore(position, at, axis, vec4f(place[axis]));
        textureStore(velocity, at, axis, vec4f(speed[axis]));
    }
}
