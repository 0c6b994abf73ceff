// The octrees, by their nodes: eight children each, of which each is a leaf or another node.

import package::leaf::{load};

@group(0) @binding(12) var tree: texture_2d_array<u32>;

// A child is a leaf or a node: bit 0 tells which.
const NODE: u32 = 1u;

// The child of a node.
fn child(node: u32, octant: u32) -> u32 {
    return load(tree, 8u * node + octant, 0u);
}

// Which child of a node, so many levels above the finest, holds a virtual cell.
fn octant_of(voxel: vec3u, shift: u32) -> u32 {
    let bit = (voxel >> vec3u(shift)) & vec3u(1u);
    return bit.x | (bit.y << 1u) | (bit.z << 2u);
}
