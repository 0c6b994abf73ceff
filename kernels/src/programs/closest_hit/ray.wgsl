// The ray streams, as every kernel but generate reads them.

@group(0) @binding(0) var ray_origin: texture_2d_array<f32>;
@group(0) @binding(1) var ray_direction: texture_2d_array<f32>;

@if(intervals) @group(0) @binding(7) var ray_interval: texture_2d_array<f32>;

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

// The t between which hits count; neither end does.
@if(intervals)
fn load_interval(texel: vec2u) -> vec2f {
    return vec2f(textureLoad(ray_interval, texel, 0, 0).x, textureLoad(ray_interval, texel, 1, 0).x);
}
