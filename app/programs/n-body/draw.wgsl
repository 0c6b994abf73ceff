// A picture of the bodies from above: each is a small disc of light.

@group(0) @binding(0) var position: texture_2d_array<f32>;
@group(0) @binding(1) var sky: texture_storage_2d_array<r32float, write>;

const SHOWN: f32 = 1.5;
const SIZE: f32 = 0.012;

@compute @workgroup_size(8, 8)
fn draw(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(sky);
    if (any(id.xy >= size)) {
        return;
    }
    let pixel = SHOWN * ((vec2f(id.xy) + 0.5) / vec2f(size) * 2.0 - 1.0);
    let bodies = textureDimensions(position);
    var light = 0.0;
    for (var i = 0u; i < bodies.x * bodies.y; i++) {
        let at = vec2u(i % bodies.x, i / bodies.x);
        let place = vec2f(textureLoad(position, at, 0, 0).x, textureLoad(position, at, 1, 0).x);
        let away = (place - pixel) / SIZE;
        light += exp(-min(dot(away, away), 80.0));
    }
    textureStore(sky, id.xy, 0, vec4f(light));
}
