// Records of the leaves of octrees, which are the cells before and after they are merged, and of their references.

import package::launch::{texel};

// A component of an element in a stream.
fn load(stream: texture_2d_array<u32>, i: u32, layer: u32) -> u32 {
    return textureLoad(stream, texel(i, textureDimensions(stream).x), layer, 0).x;
}

// A leaf's box along an axis: its first virtual cell in the lower half of a word, the one after its last in the upper.
fn low_of(extent: u32) -> u32 {
    return extent & 0xffffu;
}

fn high_of(extent: u32) -> u32 {
    return extent >> 16u;
}

// Where an element is in all streams of its set. To ask a texture for its size takes as long as a load.
fn place_in(stream: texture_2d_array<u32>, i: u32) -> vec2u {
    return texel(i, textureDimensions(stream).x);
}

fn load_at(stream: texture_2d_array<u32>, at: vec2u, layer: u32) -> u32 {
    return textureLoad(stream, at, layer, 0).x;
}

fn space_at(space: texture_2d_array<u32>, at: vec2u) -> vec3u {
    return vec3u(load_at(space, at, 0u), load_at(space, at, 1u), load_at(space, at, 2u));
}

fn load_space(space: texture_2d_array<u32>, i: u32) -> vec3u {
    return space_at(space, place_in(space, i));
}

// A leaf's level, and the one down to which its octree is divided anyway, share a word; bit 16 marks a leaf that stays.
const STAYS: u32 = 0x10000u;

fn level_of(levels: u32) -> u32 {
    return levels & 0xffu;
}

fn even_of(levels: u32) -> u32 {
    return (levels >> 8u) & 0xffu;
}
