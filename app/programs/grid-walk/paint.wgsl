// The colour of a ray: its surface in the light of the camera, tinted by how many voxels it has visited.

import package::camera::{eye_ray};
import package::constants::{NOBODY};
import package::corners::{vertex};
import package::live::{book};
import package::state::{DONE, HIT, MISS};

@group(0) @binding(0) var ray: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(1) var nearest: texture_2d_array<u32>;
@group(0) @binding(2) var color: texture_storage_2d_array<r32float, write>;

@compute @workgroup_size(8, 8)
fn paint(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    var state = NOBODY;
    if (all(id.xy < textureDimensions(ray))) {
        state = textureLoad(ray, id.xy, 0).x;
    }
    var tag = NOBODY;
    if (state == HIT || state == MISS) {
        let visited = f32(textureLoad(ray, id.xy, 1).x);
        let heat = 1.0 - exp(-visited / 8.0);
        var light = 0.15 * vec3f(heat, 0.3 * heat, 1.0 - heat);
        if (state == HIT) {
            let triangle = textureLoad(nearest, id.xy, 1, 0).x;
            let a = vertex(triangle, 0u);
            let normal = normalize(cross(vertex(triangle, 1u) - a, vertex(triangle, 2u) - a));
            let facing = abs(dot(normal, normalize(eye_ray(id.xy).direction)));
            light = facing * mix(vec3f(0.1, 0.35, 0.7), vec3f(0.95, 0.6, 0.15), heat);
        }
        tag = DONE;
        textureStore(ray, id.xy, 0, vec4u(tag));
        for (var c = 0u; c < 3u; c++) {
            textureStore(color, id.xy, c, vec4f(light[c]));
        }
    }
    book(lane, tag);
}
