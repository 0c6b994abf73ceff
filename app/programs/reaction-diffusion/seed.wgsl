// u everywhere, and v in a few squares.

@group(0) @binding(0) var substance: texture_storage_2d_array<r32float, write>;

@compute @workgroup_size(8, 8)
fn seed(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(substance);
    if (any(id.xy >= size)) {
        return;
    }
    // One square in every block of 48 by 48 pixels, each in another place of its block.
    let block = id.xy / 48u;
    let corner = vec2u(7u * block.y + 11u, 5u * block.x + 9u);
    let inside = id.xy % 48u - corner;
    let has_v = all(inside < vec2u(10u));
    textureStore(substance, id.xy, 0, vec4f(select(1.0, 0.5, has_v)));
    textureStore(substance, id.xy, 1, vec4f(select(0.0, 0.25, has_v)));
}
