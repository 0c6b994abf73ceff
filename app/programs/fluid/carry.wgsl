// Each cell takes the velocity and the dye of the place from which the fluid came (semi-Lagrangian advection).

import package::program::{STEP};

@group(0) @binding(0) var velocity: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(1) var dye: texture_storage_2d_array<r32float, read_write>;

@compute @workgroup_size(8, 8)
fn carry(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(dye);
    if (any(id.xy >= size)) {
        return;
    }
    let flow = vec2f(textureLoad(velocity, id.xy, 0).x, textureLoad(velocity, id.xy, 1).x);
    let from_where = clamp(vec2f(id.xy) - STEP * flow, vec2f(0.0), vec2f(size - 1u));
    let corner = min(vec2u(from_where), size - 2u);
    let part = from_where - vec2f(corner);
    // Between the centres of four cells.
    var found = vec3f(0.0);
    for (var i = 0u; i < 4u; i++) {
        let side = vec2u(i & 1u, i >> 1u);
        let weights = select(1.0 - part, part, side == vec2u(1u));
        let there = corner + side;
        let values = vec3f(
            textureLoad(velocity, there, 0).x,
            textureLoad(velocity, there, 1).x,
            textureLoad(dye, there, 0).x,
        );
        found += weights.x * weights.y * values;
    }
    textureStore(velocity, id.xy, 0, vec4f(found.x));
    textureStore(velocity, id.xy, 1, vec4f(found.y));
    textureStore(dye, id.xy, 0, vec4f(found.z));
}
