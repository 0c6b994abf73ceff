// The ray streams, as every kernel but generate reads them.

import package::camera::{Ray};
import package::constants::{NO_TRIANGLE};

@group(0) @binding(0) var ray_origin: texture_2d_array<f32>;
@group(0) @binding(1) var ray_direction: texture_2d_array<f32>;

@if(intervals) @group(0) @binding(7) var ray_interval: texture_2d_array<f32>;
@if(leaves) @group(0) @binding(13) var surface: texture_2d_array<u32>;
@if(irregular) @group(0) @binding(8) var voxel: texture_storage_2d_array<r32uint, read_write>;

fn load_origin(texel: vec2u) -> vec3f {
    return vec3f(
        textureLoad(ray_origin, texel, 0, 0).x,
        textureLoad(ray_origin, texel, 1, 0).x,
        textureLoad(ray_origin, texel, 2, 0).x,
    );
}

fn load_direction(texel: vec2u) -> vec3f {
    return vec3f(
        textureLoad(ray_direction, texel, 0, 0).x,
        textureLoad(ray_direction, texel, 1, 0).x,
        textureLoad(ray_direction, texel, 2, 0).x,
    );
}

// The triangle that the ray leaves.
fn load_surface(texel: vec2u) -> u32 {
    @if(leaves) return textureLoad(surface, texel, 0, 0).x;
    @else return NO_TRIANGLE;
}

fn load_ray(texel: vec2u) -> Ray {
    return Ray(load_origin(texel), load_direction(texel));
}

// The t between which hits count; neither end does.
@if(intervals)
fn load_interval(texel: vec2u) -> vec2f {
    return vec2f(textureLoad(ray_interval, texel, 0, 0).x, textureLoad(ray_interval, texel, 1, 0).x);
}

// The virtual cell by which the ray came into its cell of an irregular grid.
@if(irregular)
fn load_voxel(texel: vec2u) -> vec3i {
    return vec3i(vec3u(
        textureLoad(voxel, texel, 0).x,
        textureLoad(voxel, texel, 1).x,
        textureLoad(voxel, texel, 2).x,
    ));
}

@if(irregular)
fn store_voxel(texel: vec2u, came_by: vec3i) {
    textureStore(voxel, texel, 0, vec4u(u32(came_by.x)));
    textureStore(voxel, texel, 1, vec4u(u32(came_by.y)));
    textureStore(voxel, texel, 2, vec4u(u32(came_by.z)));
}
