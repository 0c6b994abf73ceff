// One generation: a cell lives on with two or three neighbours, and comes to life with three (Conway 1970).

@group(0) @binding(0) var cell: texture_storage_2d_array<r32uint, read_write>;

@compute @workgroup_size(8, 8)
fn generation(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(cell);
    if (any(id.xy >= size)) {
        return;
    }
    // The field has no edges: its right side meets its left one, and its top its bottom.
    var neighbours = 0u;
    for (var i = 0u; i < 9u; i++) {
        let there = (id.xy + size + vec2u(i % 3u, i / 3u) - 1u) % size;
        neighbours += textureLoad(cell, there, 0).x;
    }
    let alive = textureLoad(cell, id.xy, 0).x;
    neighbours -= alive;
    let lives = neighbours == 3u || (alive == 1u && neighbours == 2u);
    textureStore(cell, id.xy, 0, vec4u(u32(lives)));
}
