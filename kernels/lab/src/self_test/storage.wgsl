// Bits on their way through textures and buffers, as kernels move them.

// Written by the host; then each texel is replaced by itself.
@group(0) @binding(0) var floats: texture_storage_2d_array<r32float, read_write>;
// Written here.
@group(0) @binding(1) var stored: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(2) var words: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(3) var<storage, read> given: array<u32>;
@group(0) @binding(4) var<storage, read> given_floats: array<f32>;
@group(0) @binding(5) var<storage, read_write> loaded: array<u32>;
@group(0) @binding(6) var<storage, read_write> copied: array<f32>;

@compute @workgroup_size(64)
fn pass_bits(@builtin(global_invocation_id) id: vec3u) {
    let texel = vec2u(id.x, 0u);
    let bits = given[id.x];
    loaded[id.x] = bitcast<u32>(textureLoad(floats, texel, 0).x);
    textureStore(floats, texel, 0, textureLoad(floats, texel, 0));
    textureStore(stored, texel, 0, vec4f(bitcast<f32>(bits)));
    textureStore(words, texel, 0, vec4u(textureLoad(words, texel, 0).x ^ bits));
    copied[id.x] = given_floats[id.x];
}
