// Bodies in a disc, on a spiral of equal areas (Vogel 1979), each on its way around the centre.

import package::launch::{BLOCK, element, launch, texel};

@group(0) @binding(0) var position: texture_storage_2d_array<r32float, write>;
@group(0) @binding(1) var velocity: texture_storage_2d_array<r32float, write>;

// The golden angle, as a part of a turn.
const GOLDEN_PART: f32 = 0.38196602;
const TURN: f32 = 6.2831853;

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
    // WGSL promises the accuracy of sines from -π to π only.
    let angle = (fract(f32(i) * GOLDEN_PART) - 0.5) * TURN;
    let out = vec3f(cos(angle), sin(angle), 0.0);
    let place = radius * out + vec3f(0.0, 0.0, 0.1 * out.x * out.y);
    // The mass inside of the radius is radius², of a total of 1.
    let speed = 0.8 * sqrt(radius) * vec3f(-out.y, out.x, 0.0);
    for (var axis = 0u; axis < 3u; axis++) {
        textureStore(position, at, axis, vec4f(place[axis]));
        textureStore(velocity, at, axis, vec4f(speed[axis]));
    }
}
