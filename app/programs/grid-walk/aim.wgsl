// Begins a ray for each pixel: in the voxel where it enters the grid.

import package::camera::{eye_ray};
import package::constants::{NOBODY};
import package::live::{book};
import package::state::{WALK, MISS};
import package::voxels::{INFINITE, entry, exits, voxel_at};

@group(0) @binding(0) var ray: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(1) var voxel: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(2) var tmax: texture_storage_2d_array<r32float, write>;
@group(0) @binding(3) var nearest: texture_storage_2d_array<r32uint, write>;

@compute @workgroup_size(8, 8)
fn aim(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    var tag = NOBODY;
    if (all(id.xy < textureDimensions(ray))) {
        let eye = eye_ray(id.xy);
        let t = entry(eye.origin, eye.direction);
        tag = select(WALK, MISS, t < 0.0);
        let first = voxel_at(eye.origin + max(t, 0.0) * eye.direction);
        let leave = exits(first, eye.origin, eye.direction);
        for (var axis = 0u; axis < 3u; axis++) {
            textureStore(voxel, id.xy, axis, vec4u(u32(first[axis])));
            textureStore(tmax, id.xy, axis, vec4f(leave[axis]));
        }
        textureStore(nearest, id.xy, 0, vec4u(bitcast<u32>(INFINITE)));
        textureStore(nearest, id.xy, 1, vec4u(0xffffffffu));
        textureStore(ray, id.xy, 0, vec4u(tag));
        textureStore(ray, id.xy, 1, vec4u(0u));
    }
    book(lane, tag);
}
