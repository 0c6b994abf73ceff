// What flows out of a cell, by the velocities of its four neighbours. At a wall, nothing flows.

@group(0) @binding(0) var velocity: texture_2d_array<f32>;
@group(0) @binding(1) var divergence: texture_storage_2d_array<r32float, write>;
@group(0) @binding(2) var pressure: texture_storage_2d_array<r32float, write>;

fn flow(at: vec2i, axis: u32) -> f32 {
    let size = vec2i(textureDimensions(velocity));
    if (any(at < vec2i(0)) || any(at >= size)) {
        return 0.0;
    }
    return textureLoad(velocity, at, axis, 0).x;
}

@compute @workgroup_size(8, 8)
fn diverge(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= textureDimensions(divergence))) {
        return;
    }
    let at = vec2i(id.xy);
    let x = flow(at + vec2i(1, 0), 0u) - flow(at - vec2i(1, 0), 0u);
    let y = flow(at + vec2i(0, 1), 1u) - flow(at - vec2i(0, 1), 1u);
    textureStore(divergence, id.xy, 0, vec4f(0.5 * (x + y)));
    textureStore(pressure, id.xy, 0, vec4f(0.0));
}
