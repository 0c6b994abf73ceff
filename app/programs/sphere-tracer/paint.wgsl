// The colour of a ray: a surface in the light of the sun, or the sky.

import package::live::{book};
import package::constants::{NOBODY};
import package::shapes::{EYE, direction_of, distance_to};
import package::state::{DONE, SKY, SURFACE};

@group(0) @binding(0) var ray: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(1) var distance: texture_2d_array<f32>;
@group(0) @binding(2) var color: texture_storage_2d_array<r32float, write>;

const SUN: vec3f = vec3f(-0.48, 0.64, -0.6);

@compute @workgroup_size(8, 8)
fn paint(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let size = textureDimensions(ray);
    var state = NOBODY;
    if (all(id.xy < size)) {
        state = textureLoad(ray, id.xy, 0).x;
    }
    var tag = NOBODY;
    if (state == SURFACE || state == SKY) {
        let direction = direction_of(id.xy, size);
        var light = mix(vec3f(0.6, 0.75, 0.9), vec3f(0.2, 0.4, 0.8), max(direction.y, 0.0));
        if (state == SURFACE) {
            let p = EYE + textureLoad(distance, id.xy, 0, 0).x * direction;
            // The gradient of the distance is the normal. Over a shorter way, rounding would show.
            let e = vec2f(0.01, 0.0);
            let normal = normalize(vec3f(
                distance_to(p + e.xyy) - distance_to(p - e.xyy),
                distance_to(p + e.yxy) - distance_to(p - e.yxy),
                distance_to(p + e.yyx) - distance_to(p - e.yyx),
            ));
            // What is near a surface in the direction of its normal keeps light away.
            let open = clamp(distance_to(p + 0.4 * normal) / 0.4, 0.0, 1.0);
            let albedo = select(vec3f(0.8, 0.45, 0.25), vec3f(0.5), p.y < 0.01);
            light = albedo * (open * 0.3 + 0.8 * max(dot(normal, SUN), 0.0));
        }
        tag = DONE;
        textureStore(ray, id.xy, 0, vec4u(tag));
        for (var c = 0u; c < 3u; c++) {
            textureStore(color, id.xy, c, vec4f(light[c]));
        }
    }
    book(lane, tag);
}
