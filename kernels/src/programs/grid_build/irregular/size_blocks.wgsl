import package::launch::{BLOCK, launch, element, texel};
import package::build::{build};
import package::leaf::{load, load_space};
import package::leaf_level::{low_corner, top_of};
import package::tree::{NODE, child, octant_of};

@group(0) @binding(0) var space: texture_2d_array<u32>;
@group(0) @binding(1) var node: texture_2d_array<u32>;
@group(0) @binding(2) var tree_top: texture_2d_array<u32>;
@group(0) @binding(3) var first_entry: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(4) var block_levels: texture_storage_2d_array<r32uint, write>;

fn nodes_below(index: u32) -> u32 {
    var nodes = 0u;
    for (var octant = 0u; octant < 8u; octant++) {
        nodes += child(index, octant) & NODE;
    }
    return nodes;
}

// Levels of the block below a node: as many as are divided in at least a sixteenth of its volume, at most 3.
fn levels_below(index: u32) -> u32 {
    var children = 0u;
    var grandchildren = 0u;
    for (var octant = 0u; octant < 8u; octant++) {
        let below = child(index, octant);
        if ((below & NODE) != 0u) {
            children += 1u;
            grandchildren += nodes_below(below >> 1u);
        }
    }
    if (children == 0u) {
        return 1u;
    }
    return select(3u, 2u, grandchildren < 4u);
}

// Finds the nodes with which a block of the voxel map begins, and its size: from its octree's root down to the node.
// Nodes inside of a block have none.
@compute @workgroup_size(BLOCK)
fn size_blocks(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let voxel = low_corner(load_space(space, load(node, i, 0u)));
    var root = load(tree_top, top_of(voxel), 0u) >> 1u;
    var level = 0u;
    let own_level = load(node, i, 1u);
    var levels = levels_below(root);
    // At most 12 turns, as there are levels.
    while (level + levels <= own_level) {
        for (var k = 0u; k < levels; k++) {
            root = child(root, octant_of(voxel, build.levels - level - 1u)) >> 1u;
            level += 1u;
        }
        levels = levels_below(root);
    }
    let begins = level == own_level;
    let at = texel(i, textureDimensions(first_entry).x);
    textureStore(first_entry, at, 0, vec4u(select(0u, 1u << (3u * levels), begins)));
    textureStore(block_levels, at, 0, vec4u(select(0u, levels, begins)));
}
