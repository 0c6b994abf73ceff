import package::launch::{BLOCK, launch, element};
import package::build::{build};
import package::leaf::{load, load_at, place_in, space_at, low_of, high_of};
import package::in_list::{item, is_listed};
import package::voxel_map::{find};

@group(0) @binding(0) var space: texture_2d_array<u32>;
@group(0) @binding(1) var list: texture_2d_array<u32>;
@group(0) @binding(2) var expanded: texture_storage_2d_array<r32uint, write>;

// Most rounds: times that a box is expanded on each side.
const ROUNDS: u32 = 16u;
// Most neighbours and triangles of their lists that are looked at.
const MOST_LOOKED_AT: u32 = 1024u;

var<private> seen: u32;
var<private> first: u32;
var<private> listed: u32;

// Whether the leaf's list has every triangle of another one's.
fn has_all_of(its_first: u32, its_listed: u32) -> bool {
    if (its_listed > listed) {
        seen += 1u;
        return false;
    }
    seen += 1u + min(its_listed, MOST_LOOKED_AT);
    if (seen > MOST_LOOKED_AT) {
        return false;
    }
    for (var k = 0u; k < its_listed; k++) {
        if (!is_listed(first, listed, load(item, its_first + k, 0u))) {
            return false;
        }
    }
    return true;
}

// The component along an axis. An index that is not constant would move vectors to memory.
fn along(vector: vec3u, axis: u32) -> u32 {
    return select(select(vector.x, vector.y, axis == 1u), vector.z, axis == 2u);
}

fn replaced(vector: vec3u, axis: u32, value: u32) -> vec3u {
    return select(vector, vec3u(value), vec3u(0u, 1u, 2u) == vec3u(axis));
}

// Faces of a box that are inside the grid: bits 0, 2 and 4 for the upper ones along x, y and z, 1, 3 and 5 for the lower ones.
fn faces_inside(low: vec3u, high: vec3u) -> u32 {
    let upper = vec3u(high < (build.cells << vec3u(build.levels)));
    let lower = vec3u(low > vec3u(0u));
    return dot(upper | (lower << vec3u(1u)), vec3u(1u, 4u, 16u));
}

// Expands the box of each leaf over neighbours that list nothing it does not list. Each follows from the leaves alone. In
// turn, each face is moved to where the first of the neighbours behind it ends; it stays if one of them lists a triangle
// that the leaf does not list.
//
// Each turn of the only loop over neighbours looks at one of them: with a loop for each face, threads would wait for those
// whose face has most neighbours. There are at most MOST_LOOKED_AT turns and one for each face.
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
    first = load_at(list, own, 0u);
    listed = load_at(list, own, 1u);
    seen = 0u;
    // Faces that no neighbour stops, and those that are still to be moved in this round.
    var free = faces_inside(low, high);
    var left = free;
    var round = 0u;
    var is_moved = false;
    // The face that is being moved, along `axis`; the neighbour that is looked at, in a row along u, in rows along v.
    var is_begun = false;
    var face = 0u;
    var axis = 0u;
    var at = low;
    var next_row = 0u;
    var depth = 0u;
    while (true) {
        if (!is_begun) {
            if (left == 0u) {
                round += 1u;
                left = free;
                if (!is_moved || left == 0u || seen > MOST_LOOKED_AT || round == ROUNDS) {
                    break;
                }
                is_moved = false;
            }
            face = firstTrailingBit(left);
            left &= left - 1u;
            axis = face / 2u;
            at = replaced(low, axis, select(along(low, axis) - 1u, along(high, axis), (face & 1u) == 0u));
            next_row = along(high, (axis + 2u) % 3u);
            depth = 0xffffffffu;
            is_begun = true;
        }
        let u = (axis + 1u) % 3u;
        let v = (axis + 2u) % 3u;
        let is_up = (face & 1u) == 0u;
        // All loads side by side: what takes time is to wait for one after the other.
        let other = place_in(space, find(at));
        let extent = space_at(space, other);
        let its_first = load_at(list, other, 0u);
        let its_listed = load_at(list, other, 1u);
        if (!has_all_of(its_first, its_listed)) {
            free &= ~(1u << face);
            is_begun = false;
            continue;
        }
        let own_end = along(at, axis);
        let its_end = along(extent, axis);
        depth = min(depth, select(own_end + 1u - low_of(its_end), high_of(its_end) - own_end, is_up));
        next_row = min(next_row, high_of(along(extent, v)));
        // A box ends beyond the point where it is found; the max prevents an endless loop if a stream was edited.
        at = replaced(at, u, max(along(at, u) + 1u, high_of(along(extent, u))));
        if (along(at, u) < along(high, u)) {
            continue;
        }
        at = replaced(replaced(at, u, along(low, u)), v, max(along(at, v) + 1u, next_row));
        next_row = along(high, v);
        if (along(at, v) < along(high, v)) {
            continue;
        }
        high = select(high, replaced(high, axis, along(high, axis) + depth), is_up);
        low = select(replaced(low, axis, along(low, axis) - depth), low, is_up);
        is_moved |= depth != 0u;
        free &= faces_inside(low, high) & ~select(0u, 1u << face, depth == 0u);
        is_begun = false;
    }
    textureStore(expanded, own, 0, vec4u(low.x | (high.x << 16u)));
    textureStore(expanded, own, 1, vec4u(low.y | (high.y << 16u)));
    textureStore(expanded, own, 2, vec4u(low.z | (high.z << 16u)));
}
