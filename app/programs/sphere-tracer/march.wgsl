// One step along a ray: nothing is nearer than the nearest surface, so the ray can go that far.

import package::live::{book};
import package::constants::{NOBODY};
import package::shapes::{EYE, direction_of, distance_to};
import package::state::{MARCH, SKY, SURFACE};

@group(0) @binding(0) var ray: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(1) var distance: texture_storage_2d_array<r32float, read_write>;

const NEAR: f32 = 0.001;
const FAR: f32 = 20.0;

@compute @workgroup_size(8, 8)
fn march(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let size = textureDimensions(ray);
    var tag = NOBODY;
    if (all(id.xy < size) && textureLoad(ray, id.xy, 0).x == MARCH) {
        let t = textureLoad(distance, id.xy, 0).x;
        let step = distance_to(EYE + t * direction_of(id.xy, size));
        tag = select(select(MARCH, SKY, t > FAR), SURFACE, step < NEAR);
        textureStore(distance, id.xy, 0, vec4f(t + step));
        textureStore(ray, id.xy, 0, vec4u(tag));
        textureStore(ray, id.xy, 1, vec4u(textureLoad(ray, id.xy, 1).x + 1u));
    }
    book(lane, tag);
}
