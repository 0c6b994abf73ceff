// Substance u is fed, v decays, and where they meet, two parts of v turn one of u into v.

import package::program::{FEED, KILL, SPREAD};

@group(0) @binding(0) var substance: texture_storage_2d_array<r32float, read_write>;

@compute @workgroup_size(8, 8)
fn react(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(substance);
    if (any(id.xy >= size)) {
        return;
    }
    let here = vec2f(textureLoad(substance, id.xy, 0).x, textureLoad(substance, id.xy, 1).x);
    // The Laplacian by the eight neighbours; the field has no edges.
    var around = vec2f(0.0);
    for (var i = 0u; i < 9u; i++) {
        let step = vec2u(i % 3u, i / 3u);
        let there = (id.xy + size + step - 1u) % size;
        // 0.2 for the four that share a side, 0.05 for those at the corners, -1 for the pixel itself.
        let is_side = (step.x == 1u) != (step.y == 1u);
        let weight = select(select(0.05, 0.2, is_side), -1.0, i == 4u);
        around += weight * vec2f(textureLoad(substance, there, 0).x, textureLoad(substance, there, 1).x);
    }
    let reacts = here.x * here.y * here.y;
    let change = 4.0 * SPREAD * around + vec2f(FEED * (1.0 - here.x) - reacts, reacts - (FEED + KILL) * here.y);
    let next = here + change;
    textureStore(substance, id.xy, 0, vec4f(next.x));
    textureStore(substance, id.xy, 1, vec4f(next.y));
}
