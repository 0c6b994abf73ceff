// The stream that decides by which face a ray leaves its cell: tmax, or control with a 3D-DDA.

@if(irregular) @group(0) @binding(4) var tmax: texture_storage_2d_array<r32float, write>;
@else @group(0) @binding(4) var tmax: texture_storage_2d_array<r32float, read_write>;
@if(dda) @group(0) @binding(4) var control: texture_storage_2d_array<r32float, read_write>;

@if(!dda)
fn load_per_axis(texel: vec2u) -> vec3f {
    return vec3f(textureLoad(tmax, texel, 0).x, textureLoad(tmax, texel, 1).x, textureLoad(tmax, texel, 2).x);
}
@else
fn load_per_axis(texel: vec2u) -> vec3f {
    return vec3f(textureLoad(control, texel, 0).x, textureLoad(control, texel, 1).x, textureLoad(control, texel, 2).x);
}

@if(!dda)
fn store_per_axis(texel: vec2u, along: vec3f) {
    textureStore(tmax, texel, 0, vec4f(along.x));
    textureStore(tmax, texel, 1, vec4f(along.y));
    textureStore(tmax, texel, 2, vec4f(along.z));
}
@else
fn store_per_axis(texel: vec2u, along: vec3f) {
    textureStore(control, texel, 0, vec4f(along.x));
    textureStore(control, texel, 1, vec4f(along.y));
    textureStore(control, texel, 2, vec4f(along.z));
}
