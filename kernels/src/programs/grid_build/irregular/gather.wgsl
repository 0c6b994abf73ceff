import package::launch::{BLOCK, HALF, launch, element_of_rows, texel};
import package::leaf::{load, load_at, space_at};
import package::in_list::{item, lower};
import package::sums::{SUMMED};
import package::saturating::{saturating_add};
import package::merging::{NOBODY, merged, place};

@group(0) @binding(0) var space: texture_2d_array<u32>;
@group(0) @binding(1) var list: texture_2d_array<u32>;
@group(0) @binding(2) var round: texture_2d_array<u32>;
@group(0) @binding(3) var kept: texture_2d_array<u32>;
@group(0) @binding(4) var totals: texture_2d_array<u32>;
@group(0) @binding(11) var kept_of_block: texture_2d_array<u32>;
@group(0) @binding(5) var next_space: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(6) var next_list: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(7) var next_item: texture_storage_2d_array<r32uint, write>;

// Threads merge lists of up to so many references each alone, others with the whole workgroup.
const SHORT: u32 = 64u;

// Leaves and references that replace all leaves before those of the block of a scan, for each half of the workgroup.
var<workgroup> before: array<u32, 4>;

// A leaf's list and that of the leaf merged into it, by their first references and lengths; where the merged list goes.
struct Lists {
    own: vec2u,
    other: vec2u,
    first: u32,
}

var<workgroup> long: array<Lists, BLOCK>;
// In any order: each has its own place.
var<workgroup> next_long: atomic<u32>;
var<workgroup> long_count: u32;
// Which of the references that the workgroup moves are in the other list, too.
var<workgroup> in_both: array<atomic<u32>, WORDS>;
const WORDS: u32 = BLOCK / 32u;

fn store(place: u32, triangle: u32) {
    textureStore(next_item, texel(place, textureDimensions(next_item).x), 0, vec4u(triangle));
}

fn merge_alone(lists: Lists) {
    var place = lists.first;
    var i = 0u;
    var k = 0u;
    while (i < lists.own.y || k < lists.other.y) {
        var one = NOBODY;
        if (i < lists.own.y) {
            one = load(item, lists.own.x + i, 0u);
        }
        var other = NOBODY;
        if (k < lists.other.y) {
            other = load(item, lists.other.x + k, 0u);
        }
        store(place, min(one, other));
        place += 1u;
        i += u32(one <= other);
        k += u32(other <= one);
    }
}

// Moves the references of one list to their places: after all lower ones of both lists, of which those that are in both
// count once. A place in two merged lists (Satish, Harris, Garland 2009).
fn move_side_by_side(own: vec2u, other: vec2u, first: u32, with_shared: bool, lane: u32) {
    var shared_before = 0u;
    for (var begin = 0u; begin < own.y; begin += BLOCK) {
        if (lane < WORDS) {
            atomicStore(&in_both[lane], 0u);
        }
        workgroupBarrier();
        let k = begin + lane;
        var triangle = 0u;
        var lower_there = 0u;
        var is_shared = false;
        if (k < own.y) {
            triangle = load(item, own.x + k, 0u);
            lower_there = lower(other.x, other.y, triangle);
            is_shared = lower_there < other.y && load(item, other.x + lower_there, 0u) == triangle;
            if (is_shared) {
                atomicOr(&in_both[lane / 32u], 1u << (lane % 32u));
            }
        }
        workgroupBarrier();
        var own_before = shared_before;
        for (var word = 0u; word < WORDS; word++) {
            let bits = atomicLoad(&in_both[word]);
            shared_before += countOneBits(bits);
            let is_all_before = word < lane / 32u;
            let those_before = select(0u, (1u << (lane % 32u)) - 1u, word == lane / 32u);
            own_before += countOneBits(bits & select(those_before, 0xffffffffu, is_all_before));
        }
        if (k < own.y && (with_shared || !is_shared)) {
            store(first + k + lower_there - own_before, triangle);
        }
        workgroupBarrier();
    }
}

// Moves a leaf to its new place, with the box of the one that is merged into it. Returns the lists that are to be
// moved, empty ones of a leaf that is merged into another one.
fn move_leaf(leaf: vec2u, row: u32) -> Lists {
    let it = merged(leaf);
    let to = saturating_add(before[2u * row], load_at(kept, leaf, 0u));
    let first = saturating_add(before[2u * row + 1u], load_at(kept, leaf, 1u));
    var lists = Lists(vec2u(load_at(list, leaf, 0u), load_at(list, leaf, 1u)), vec2u(0u), first);
    var extent = space_at(space, leaf);
    if (it.is_absorbed) {
        return Lists(vec2u(0u), vec2u(0u), first);
    }
    var length = lists.own.y;
    if (it.absorbed != NOBODY) {
        let axis = load_at(round, vec2u(0u), 0u);
        let next = place(it.absorbed);
        let upper = load_at(space, next, axis) & 0xffff0000u;
        extent[axis] = (extent[axis] & 0xffffu) | upper;
        lists.other = vec2u(load_at(list, next, 0u), load_at(list, next, 1u));
        length += lists.other.y - it.in_both;
    }
    let at = texel(to, textureDimensions(next_space).x);
    textureStore(next_space, at, 0, vec4u(extent.x));
    textureStore(next_space, at, 1, vec4u(extent.y));
    textureStore(next_space, at, 2, vec4u(extent.z));
    textureStore(next_list, at, 0, vec4u(first));
    textureStore(next_list, at, 1, vec4u(length));
    return lists;
}

// No list is longer than all together, unless somebody has edited its length.
fn within_bounds(lists: Lists) -> Lists {
    let most = load_at(totals, vec2u(0u), 1u);
    return Lists(vec2u(lists.own.x, min(lists.own.y, most)), vec2u(lists.other.x, min(lists.other.y, most)), lists.first);
}

// Moves every leaf that remains, and its list merged with that of the leaf merged into it.
@compute @workgroup_size(BLOCK)
fn gather(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = element_of_rows(group, groups, lane);
    if (lane % HALF < 2u) {
        let row = lane / HALF;
        let layer = lane % HALF;
        atomicStore(&next_long, 0u);
        before[2u * row + layer] = load(kept_of_block, element_of_rows(group, groups, row * HALF) / SUMMED, layer);
    }
    workgroupBarrier();
    if (i < launch.elements) {
        let lists = move_leaf(place(i), lane / HALF);
        if (max(lists.own.y, lists.other.y) > SHORT) {
            long[atomicAdd(&next_long, 1u)] = within_bounds(lists);
        } else {
            merge_alone(lists);
        }
    }
    workgroupBarrier();
    if (lane == 0u) {
        long_count = atomicLoad(&next_long);
    }
    let in_all = workgroupUniformLoad(&long_count);
    for (var k = 0u; k < in_all; k++) {
        let lists = workgroupUniformLoad(&long[k]);
        move_side_by_side(lists.own, lists.other, lists.first, true, lane);
        move_side_by_side(lists.other, lists.own, lists.first, false, lane);
    }
}
