// A step of Jacobi's method: the mean of the neighbours' pressures less a quarter of what flows out. All cells read the
// pressures of the step before.

@group(0) @binding(0) var divergence: texture_2d_array<f32>;
@group(0) @binding(1) var pressure: texture_storage_2d_array<r32float, read_write>;

@compute @workgroup_size(8, 8)
fn relax(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(pressure);
    if (any(id.xy >= size)) {
        return;
    }
    // Outside of the walls the pressure is that of the cell at the wall.
    let low = select(id.xy - 1u, vec2u(0u), id.xy == vec2u(0u));
    let high = min(id.xy + 1u, size - 1u);
    let around = textureLoad(pressure, vec2u(low.x, id.y), 0).x + textureLoad(pressure, vec2u(high.x, id.y), 0).x
        + textureLoad(pressure, vec2u(id.x, low.y), 0).x + textureLoad(pressure, vec2u(id.x, high.y), 0).x;
    let out = textureLoad(divergence, id.xy, 0, 0).x;
    textureStore(pressure, id.xy, 0, vec4f(0.25 * (around - out)));
}
