// Two jets that meet.

import package::program::{STEP};

@group(0) @binding(0) var velocity: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(1) var dye: texture_storage_2d_array<r32float, read_write>;

@compute @workgroup_size(8, 8)
fn push(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(dye);
    if (any(id.xy >= size)) {
        return;
    }
    let at = (vec2f(id.xy) + 0.5) / vec2f(size);
    let left = length(at - vec2f(0.12, 0.46)) < 0.05;
    let right = length(at - vec2f(0.88, 0.54)) < 0.05;
    if (left || right) {
        textureStore(velocity, id.xy, 0, vec4f(select(-3.0, 3.0, left)));
        textureStore(dye, id.xy, 0, vec4f(textureLoad(dye, id.xy, 0).x + STEP * select(0.3, 0.6, left)));
    }
}
