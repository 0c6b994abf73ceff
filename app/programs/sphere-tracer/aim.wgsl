// Begins a ray for each pixel: at the eye.

import package::live::{book};
import package::constants::{NOBODY};
import package::state::{MARCH};

@group(0) @binding(0) var ray: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(1) var distance: texture_storage_2d_array<r32float, write>;

@compute @workgroup_size(8, 8)
fn aim(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    var tag = NOBODY;
    if (all(id.xy < textureDimensions(ray))) {
        tag = MARCH;
        textureStore(ray, id.xy, 0, vec4u(tag));
        textureStore(ray, id.xy, 1, vec4u(0u));
        textureStore(distance, id.xy, 0, vec4f(0.0));
    }
    book(lane, tag);
}
