import package::launch::{BLOCK, launch, element, texel};
import package::leaf::{load};
import package::map_entry::{entry_of, first_entry, block_levels};
import package::tree::{NODE, child, octant_of};

@group(0) @binding(0) var nodes_in_all: texture_2d_array<u32>;
@group(0) @binding(1) var map_below: texture_storage_2d_array<r32uint, write>;

// The nodes of a workgroup's first entry and of its last one.
var<workgroup> ends: array<u32, 2>;
// Where the entries of these nodes and of those between them begin, unless they are too many.
const MOST_NODES: u32 = 1024u;
var<workgroup> begins: array<u32, MOST_NODES>;

// The last of some nodes whose entries begin at or before an entry: those without entries begin where the next ones do.
fn node_of(entry: u32, nodes: u32) -> u32 {
    var low = 0u;
    var high = nodes;
    while (high - low > 1u) {
        let middle = low + (high - low) / 2u;
        if (load(first_entry, middle, 0u) <= entry) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

// The same for a node of the workgroup, and where its entries begin.
fn near_node_of(entry: u32) -> vec2u {
    let first = ends[0];
    let nodes = ends[1] + 1u - first;
    if (nodes > MOST_NODES) {
        let node = node_of(entry, ends[1] + 1u);
        return vec2u(node, load(first_entry, node, 0u));
    }
    var low = 0u;
    var high = nodes;
    while (high - low > 1u) {
        let middle = low + (high - low) / 2u;
        if (begins[middle] <= entry) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return vec2u(first + low, begins[low]);
}

// Writes the entries of the voxel map's blocks: each goes down from the node with which its block begins.
@compute @workgroup_size(BLOCK)
fn map_blocks(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (lane < 2u) {
        let entry = select(i, i - 1u + BLOCK - 1u, lane == 1u);
        ends[lane] = node_of(min(entry, launch.elements - 1u), load(nodes_in_all, 0u, 0u));
    }
    workgroupBarrier();
    for (var k = lane; k < min(ends[1] + 1u - ends[0], MOST_NODES); k += BLOCK) {
        begins[k] = load(first_entry, ends[0] + k, 0u);
    }
    workgroupBarrier();
    if (i >= launch.elements) {
        return;
    }
    let found = near_node_of(i);
    let node = found.x;
    // At most three, unless somebody has edited the stream.
    let levels = min(load(block_levels, node, 0u), 3u);
    let place = i - found.y;
    let voxel = vec3u(place, place >> levels, place >> (2u * levels)) & vec3u((1u << levels) - 1u);
    var below = (node << 1u) | NODE;
    for (var k = levels; k > 0u && (below & NODE) != 0u; k--) {
        below = child(below >> 1u, octant_of(voxel, k - 1u));
    }
    textureStore(map_below, texel(i, textureDimensions(map_below).x), 0, vec4u(entry_of(below)));
}
