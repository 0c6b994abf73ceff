// Brings a third of the cells to life, the same in every run.

@group(0) @binding(0) var cell: texture_storage_2d_array<r32uint, write>;

// Mixes the bits of a number: the hash pcg (Jarzynski and Olano 2020).
fn hash(v: u32) -> u32 {
    let state = v * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

@compute @workgroup_size(8, 8)
fn seed(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(cell);
    if (any(id.xy >= size)) {
        return;
    }
    let number = hash(id.y * size.x + id.x);
    textureStore(cell, id.xy, 0, vec4u(u32(number % 3u == 0u)));
}
