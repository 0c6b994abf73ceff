import package::launch::{BLOCK, launch, element, texel};
import package::build::{build};
import package::leaf::{place_in, load_space};
import package::leaf_level::{level_of_box, low_corner, opened_by, top_of};
import package::sums::{sum_before};
import package::tree::{NODE, octant_of};

@group(0) @binding(0) var space: texture_2d_array<u32>;
@group(0) @binding(1) var opened: texture_2d_array<u32>;
@group(0) @binding(5) var opened_of_block: texture_2d_array<u32>;
@group(0) @binding(2) var node: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(3) var tree: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(4) var tree_top: texture_storage_2d_array<r32uint, write>;

// Whether a virtual cell comes before another one: by their top-level cells, then along the Z-order curve (Morton, 1966).
fn is_before(a: vec3u, b: vec3u) -> bool {
    let top_a = top_of(a);
    let top_b = top_of(b);
    if (top_a != top_b) {
        return top_a < top_b;
    }
    // The axis with the highest bit that differs decides, the last one if several have it.
    let differs = a ^ b;
    var highest = differs.z;
    var is_less = a.z < b.z;
    if (is_higher(differs.y, highest)) {
        highest = differs.y;
        is_less = a.y < b.y;
    }
    if (is_higher(differs.x, highest)) {
        is_less = a.x < b.x;
    }
    return is_less;
}

// Whether a number has a higher highest bit than another one.
fn is_higher(a: u32, b: u32) -> bool {
    return b < a && b < (a ^ b);
}

// Number of nodes whose first leaf comes before this one.
fn opened_before(leaf: u32) -> u32 {
    return sum_before(opened, place_in(opened, leaf), opened_of_block, leaf, 0u);
}

// The node of a level whose lowest virtual cell is given; its first leaf is one of those before `end`.
fn node_at(voxel: vec3u, level: u32, end: u32) -> u32 {
    // Mostly it is only a few leaves before: the distance doubles until one is found that does not come after it.
    var high = end;
    var low = end - min(end, 1u);
    var distance = 2u;
    while (low > 0u && is_before(voxel, low_corner(load_space(space, low)))) {
        high = low;
        low = end - min(end, distance);
        distance *= 2u;
    }
    while (high - low > 1u) {
        let middle = low + (high - low) / 2u;
        if (is_before(voxel, low_corner(load_space(space, middle)))) {
            high = middle;
        } else {
            low = middle;
        }
    }
    let extent = load_space(space, low);
    return opened_before(low) + level + opened_by(extent) - level_of_box(extent);
}

// Links the nodes that each leaf is the first of, and the leaf itself, with their parents.
@compute @workgroup_size(BLOCK)
fn link_nodes(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let extent = load_space(space, i);
    let level = level_of_box(extent);
    let voxel = low_corner(extent);
    let nodes = opened_by(extent);
    let first = opened_before(i);
    let width = textureDimensions(tree).x;
    var below = i << 1u;
    for (var k = nodes; k > 0u; k--) {
        let index = first + k - 1u;
        let at = texel(index, textureDimensions(node).x);
        textureStore(node, at, 0, vec4u(i));
        textureStore(node, at, 1, vec4u(level - nodes + k - 1u));
        textureStore(tree, texel(8u * index, width), 0, vec4u(below));
        below = (index << 1u) | NODE;
    }
    let top_level = level - nodes;
    if (top_level == 0u) {
        textureStore(tree_top, texel(top_of(voxel), textureDimensions(tree_top).x), 0, vec4u(below));
        return;
    }
    let shift = build.levels - top_level;
    let parent = node_at((voxel >> vec3u(shift + 1u)) << vec3u(shift + 1u), top_level - 1u, i);
    textureStore(tree, texel(8u * parent + octant_of(voxel, shift), width), 0, vec4u(below));
}
