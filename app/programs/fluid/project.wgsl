// Takes the gradient of the pressure from the velocity, so that nothing flows out of cells any more.

@group(0) @binding(0) var pressure: texture_2d_array<f32>;
@group(0) @binding(1) var velocity: texture_storage_2d_array<r32float, read_write>;

@compute @workgroup_size(8, 8)
fn project(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(pressure);
    if (any(id.xy >= size)) {
        return;
    }
    let low = select(id.xy - 1u, vec2u(0u), id.xy == vec2u(0u));
    let high = min(id.xy + 1u, size - 1u);
    let x = textureLoad(pressure, vec2u(high.x, id.y), 0, 0).x - textureLoad(pressure, vec2u(low.x, id.y), 0, 0).x;
    let y = textureLoad(pressure, vec2u(id.x, high.y), 0, 0).x - textureLoad(pressure, vec2u(id.x, low.y), 0, 0).x;
    textureStore(velocity, id.xy, 0, vec4f(textureLoad(velocity, id.xy, 0).x - 0.5 * x));
    textureStore(velocity, id.xy, 1, vec4f(textureLoad(velocity, id.xy, 1).x - 0.5 * y));
}
