import package::launch::{BLOCK, launch, element};
import package::build::{build};
import package::leaf::{load, load_at, place_in, space_at, low_of, high_of};
import package::in_list::{item, is_listed};
import package::voxel_map::{find};

@group(0) @binding(0) var space: texture_2d_array<u32>;
@group(0) @binding(1) var list: texture_2d_array<u32>;
@group(0) @binding(2) var expanded: texture_storage_2d_array<r32uint, write>;

// Most times that a box is expanded on each side.
const ROUNDS: u32 = 16u;
// Most neighbours and triangles of their lists that are looked at.
const MOST_LOOKED_AT: u32 = 1024u;

var<private> seen: u32;
var<private> first: u32;
var<private> listed: u32;

// Whether the leaf's list has every triangle of another one's.
fn has_all_of(other: vec2u) -> bool {
    let its_listed = load_at(list, other, 1u);
    if (its_listed > listed) {
        seen += 1u;
        return false;
    }
    seen += 1u + its_listed;
    if (seen > MOST_LOOKED_AT) {
        return false;
    }
    let its_first = load_at(list, other, 0u);
    for (var k = 0u; k < its_listed; k++) {
        if (!is_listed(first, listed, load(item, its_first + k, 0u))) {
            return false;
        }
    }
    return true;
}

// By how much a face can be moved: to where the first of the neighbours behind it ends; 0 if one of them lists a triangle
// that the leaf does not list.
fn layer(low: vec3u, high: vec3u, axis: u32, is_up: bool) -> u32 {
    let u = (axis + 1u) % 3u;
    let v = (axis + 2u) % 3u;
    var at = low;
    at[axis] = select(low[axis] - 1u, high[axis], is_up);
    var depth = 0xffffffffu;
    while (at[v] < high[v]) {
        var next_row = high[v];
        at[u] = low[u];
        while (at[u] < high[u]) {
            let other = place_in(space, find(at));
            if (!has_all_of(other)) {
                return 0u;
            }
            let extent = space_at(space, other);
            let reach = select(at[axis] + 1u - low_of(extent[axis]), high_of(extent[axis]) - at[axis], is_up);
            depth = min(depth, reach);
            next_row = min(next_row, high_of(extent[v]));
            // A box ends beyond the point where it is found; the max prevents an endless loop if a stream was edited.
            at[u] = max(at[u] + 1u, high_of(extent[u]));
        }
        at[v] = max(at[v] + 1u, next_row);
    }
    return depth;
}

// Expands the box of each leaf over neighbours that list nothing it does not list. Each follows from the leaves alone.
// Its loops take fewer than 40,000 turns: at most MOST_LOOKED_AT neighbours and triangles, each looked up in a list.
@compute @workgroup_size(BLOCK)
fn expand(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let own = place_in(space, i);
    let extent = space_at(space, own);
    var low = extent & vec3u(0xffffu);
    var high = extent >> vec3u(16u);
    let end = build.cells << vec3u(build.levels);
    first = load_at(list, own, 0u);
    listed = load_at(list, own, 1u);
    seen = 0u;
    // Faces that a neighbour stops: bits 0 to 2 for lower ones, 3 to 5 for upper ones.
    var stopped = 0u;
    for (var turn = 0u; turn < ROUNDS; turn++) {
        var is_moved = false;
        for (var axis = 0u; axis < 3u; axis++) {
            if ((stopped & (8u << axis)) == 0u && high[axis] < end[axis]) {
                let by = layer(low, high, axis, true);
                high[axis] += by;
                stopped |= select(0u, 8u << axis, by == 0u);
                is_moved |= by != 0u;
            }
            if ((stopped & (1u << axis)) == 0u && low[axis] > 0u) {
                let by = layer(low, high, axis, false);
                low[axis] -= by;
                stopped |= select(0u, 1u << axis, by == 0u);
                is_moved |= by != 0u;
            }
        }
        if (!is_moved || seen > MOST_LOOKED_AT) {
            break;
        }
    }
    textureStore(expanded, own, 0, vec4u(low.x | (high.x << 16u)));
    textureStore(expanded, own, 1, vec4u(low.y | (high.y << 16u)));
    textureStore(expanded, own, 2, vec4u(low.z | (high.z << 16u)));
}
