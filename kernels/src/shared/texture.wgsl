// Base colour textures. All texels are in one buffer: linear light, 16 bits per channel, two words per texel.

struct Texture {
    // Index of the first texel.
    first: u32,
    width: i32,
    height: i32,
    // Bits 0-1 wrap of u, 2-3 wrap of v (0 repeat, 1 mirror, 2 clamp), bit 4 bilinear.
    sampling: u32,
}

@group(1) @binding(12) var<storage, read> textures: array<Texture>;
@group(1) @binding(13) var<storage, read> texels: array<u32>;

fn wrap(i: i32, size: i32, mode: u32) -> i32 {
    if (mode == 2u) {
        return clamp(i, 0, size - 1);
    }
    if (mode == 1u) {
        let period = 2 * size;
        let folded = ((i % period) + period) % period;
        return min(folded, period - 1 - folded);
    }
    return ((i % size) + size) % size;
}

fn texel_at(texture: Texture, x: i32, y: i32) -> vec3f {
    let column = wrap(x, texture.width, texture.sampling & 3u);
    let row = wrap(y, texture.height, (texture.sampling >> 2u) & 3u);
    let word = 2u * (texture.first + u32(row * texture.width + column));
    let rg = texels[word];
    let b = texels[word + 1u];
    return vec3f(f32(rg & 0xffffu), f32(rg >> 16u), f32(b & 0xffffu)) * (1.0 / 65535.0);
}

fn sample_texture(index: u32, u: f32, v: f32) -> vec3f {
    let texture = textures[index];
    // Far outside, the position has no fraction left; the clamp keeps it an integer that can be wrapped.
    let x = clamp(u * f32(texture.width), -1e9, 1e9);
    let y = clamp(v * f32(texture.height), -1e9, 1e9);
    if ((texture.sampling & 16u) == 0u) {
        return texel_at(texture, i32(floor(x)), i32(floor(y)));
    }
    // Texel centres are at +0.5.
    let left = floor(x - 0.5);
    let top = floor(y - 0.5);
    let fx = x - 0.5 - left;
    let fy = y - 0.5 - top;
    let i = i32(left);
    let j = i32(top);
    let upper = texel_at(texture, i, j) * (1.0 - fx) + texel_at(texture, i + 1, j) * fx;
    let lower = texel_at(texture, i, j + 1) * (1.0 - fx) + texel_at(texture, i + 1, j + 1) * fx;
    return upper * (1.0 - fy) + lower * fy;
}
