// Which rays a pass works on, and where it sends them.
//
// sent counts the rays that the pass sent into each state. With lists of live rays, only the rays of the
// kernel's own list are launched, and each ray is appended to the list of the kernel that it waits for
// next. A list's slot holds its indirect arguments (x groups, y groups, z), its number of rays, and
// where in live_rays it begins; a ray is x | y << 16.

import package::constants::{LIST_SIDE, LIST_GROUPS, NOBODY};
import package::state::{TRAV, ISECT_NO_HIT, ISECT_HIT};

@group(2) @binding(0) var<storage, read_write> sent: array<atomic<u32>, 8>;
@if(live_lists) @group(2) @binding(1) var<storage, read> own_list: array<u32, 8>;
@if(live_lists) @group(2) @binding(2) var<storage, read_write> intersect_list: array<atomic<u32>, 8>;
@if(live_lists && !many_steps && (grid || bvh)) @group(2) @binding(3) var<storage, read_write> traverse_list: array<atomic<u32>, 8>;
@if(live_lists) @group(2) @binding(4) var<storage, read_write> live_rays: array<u32>;

var<workgroup> sent_here: array<atomic<u32>, 8>;
// A bit for each thread of the workgroup that appends to a list.
@if(live_lists) var<workgroup> to_intersect: array<atomic<u32>, LANE_WORDS>;
@if(live_lists) var<workgroup> to_traverse: array<atomic<u32>, LANE_WORDS>;
@if(live_lists) var<workgroup> first_intersect: u32;
@if(live_lists) var<workgroup> first_traverse: u32;

const LANES: u32 = LIST_SIDE * LIST_SIDE;
const LANE_WORDS: u32 = LANES / 32u;

// The texel of a thread where a pass launches them all: 32 threads side by side are a tile of 8 by 4.
fn tiled_texel(group: vec3u, lane: u32) -> vec2u {
    let x = (lane & 7u) | ((lane >> 2u) & 8u);
    let y = ((lane >> 3u) & 3u) | ((lane >> 4u) & 12u);
    return LIST_SIDE * group.xy + vec2u(x, y);
}

// The texel of a thread's ray in the kernel's own list; beyond every image where the list has ended.
@if(live_lists)
fn listed_texel(group: vec3u, lane: u32) -> vec2u {
    let place = (group.y * LIST_GROUPS + group.x) * LANES + lane;
    if (place >= own_list[3]) {
        return vec2u(NOBODY);
    }
    let ray = live_rays[own_list[4] + place];
    return vec2u(ray & 0xffffu, ray >> 16u);
}

fn note_sent(tag: u32) {
    if (tag < 8u) {
        atomicAdd(&sent_here[tag], 1u);
    }
}

fn add_sent(state: u32) {
    let rays = atomicLoad(&sent_here[state]);
    if (rays > 0u) {
        atomicAdd(&sent[state], rays);
    }
}

// Every thread of the workgroup calls this, with NOBODY for a tag where it had no ray to work on.
@if(!live_lists)
fn send(lane: u32, texel: vec2u, tag: u32) {
    note_sent(tag);
    workgroupBarrier();
    if (lane < 8u) {
        add_sent(lane);
    }
}

@if(live_lists)
fn rows_of(rays: u32) -> u32 {
    return (rays + LANES * LIST_GROUPS - 1u) / (LANES * LIST_GROUPS);
}

@if(live_lists)
fn send(lane: u32, texel: vec2u, tag: u32) {
    note_sent(tag);
    // With several steps a pass there is one list for both kernels.
    @if(many_steps) let intersects = tag == ISECT_NO_HIT || tag == ISECT_HIT || tag == TRAV;
    @else let intersects = tag == ISECT_NO_HIT || tag == ISECT_HIT;
    @if(many_steps) let traverses = false;
    @else let traverses = tag == TRAV;
    let word = lane / 32u;
    let bit = 1u << (lane % 32u);
    if (intersects) {
        atomicOr(&to_intersect[word], bit);
    }
    if (traverses) {
        atomicOr(&to_traverse[word], bit);
    }
    workgroupBarrier();
    // Rays keep the order of their threads, pass after pass: what began side by side stays so.
    var place = 0u;
    for (var w = 0u; w <= word; w++) {
        let before = select(0xffffffffu, bit - 1u, w == word);
        place += countOneBits(before & select(atomicLoad(&to_traverse[w]), atomicLoad(&to_intersect[w]), intersects));
    }
    // One thread makes room in each list for the whole workgroup.
    if (lane == 0u) {
        var rays = 0u;
        for (var w = 0u; w < LANE_WORDS; w++) {
            rays += countOneBits(atomicLoad(&to_intersect[w]));
        }
        if (rays > 0u) {
            let first = atomicAdd(&intersect_list[3], rays);
            first_intersect = first + atomicLoad(&intersect_list[4]);
            if (rows_of(first + rays) != rows_of(first)) {
                atomicMax(&intersect_list[1], rows_of(first + rays));
            }
        }
    }
    @if(!many_steps && (grid || bvh)) if (lane == 1u) {
        var rays = 0u;
        for (var w = 0u; w < LANE_WORDS; w++) {
            rays += countOneBits(atomicLoad(&to_traverse[w]));
        }
        if (rays > 0u) {
            let first = atomicAdd(&traverse_list[3], rays);
            first_traverse = first + atomicLoad(&traverse_list[4]);
            if (rows_of(first + rays) != rows_of(first)) {
                atomicMax(&traverse_list[1], rows_of(first + rays));
            }
        }
    }
    if (lane >= 8u && lane < 16u) {
        add_sent(lane - 8u);
    }
    workgroupBarrier();
    let ray = texel.x | (texel.y << 16u);
    if (intersects) {
        live_rays[first_intersect + place] = ray;
    }
    if (traverses) {
        live_rays[first_traverse + place] = ray;
    }
}
