// Which rays a pass works on, and to which states it sends them. Twins need none of this: their executor counts tags
// itself, and calls them for every ray.
//
// sent counts the rays that the pass sent to each state. With lists of live rays, only the rays in the kernel's own
// list are launched, and each ray is appended to the list of the kernel that it waits for next. A list's slot holds its
// indirect arguments (x groups, y groups, z), its number of rays, and its start in live_rays; a ray is x | y << 16.

import package::constants::{LIST_SIDE, LIST_GROUPS, NOBODY};
import package::state::{STATES};
// Made from the program's rows: the number of lists in use, the list of the kernel that takes a state (LISTS if none
// does), and a function that reserves room in a list.
@if(live_lists) import package::lists::{LISTS, waiting_list, reserve};

@group(2) @binding(0) var<storage, read_write> sent: array<atomic<u32>, STATES>;
@if(live_lists) @group(2) @binding(2) var<storage, read> own_list: array<u32, 8>;
@if(live_lists) @group(2) @binding(100) var<storage, read_write> live_rays: array<u32>;

var<workgroup> sent_here: array<atomic<u32>, STATES>;

// For each list: a bit for each thread of the workgroup that appends to it, and where in live_rays they begin.
@if(live_lists) var<workgroup> appending: array<array<atomic<u32>, LANE_WORDS>, LISTS>;
@if(live_lists) var<workgroup> first_ray: array<u32, LISTS>;

const LANES: u32 = LIST_SIDE * LIST_SIDE;
const LANE_WORDS: u32 = LANES / 32u;

// The texel of a thread if a pass launches all rays: 32 threads side by side are a tile of 8 by 4.
fn tiled_texel(group: vec3u, lane: u32) -> vec2u {
    let x = (lane & 7u) | ((lane >> 2u) & 8u);
    let y = ((lane >> 3u) & 3u) | ((lane >> 4u) & 12u);
    return LIST_SIDE * group.xy + vec2u(x, y);
}

// The texel of a thread's ray in the kernel's own list; outside of any image after the end of the list.
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
    if (tag < STATES) {
        atomicAdd(&sent_here[tag], 1u);
    }
}

fn add_sent(state: u32) {
    let rays = atomicLoad(&sent_here[state]);
    if (rays > 0u) {
        atomicAdd(&sent[state], rays);
    }
}

// Counts like send, for kernels that are never followed directly by a kernel with a list.
fn book(lane: u32, tag: u32) {
    note_sent(tag);
    workgroupBarrier();
    if (lane < STATES) {
        add_sent(lane);
    }
}

// Every thread of the workgroup must call this, with tag NOBODY if it had no ray to work on.
@if(!live_lists)
fn send(lane: u32, texel: vec2u, tag: u32) {
    book(lane, tag);
}

// How many threads append to a list: those in the first words, and those in the mask of the next word.
@if(live_lists)
fn appended(list: u32, words: u32, mask: u32) -> u32 {
    var threads = 0u;
    for (var w = 0u; w < words; w++) {
        threads += countOneBits(atomicLoad(&appending[list][w]));
    }
    if (mask != 0u) {
        threads += countOneBits(atomicLoad(&appending[list][words]) & mask);
    }
    return threads;
}

@if(live_lists)
fn send(lane: u32, texel: vec2u, tag: u32) {
    note_sent(tag);
    let list = waiting_list(tag);
    let word = lane / 32u;
    let bit = 1u << (lane % 32u);
    if (list < LISTS) {
        atomicOr(&appending[list][word], bit);
    }
    workgroupBarrier();
    // One thread reserves room in each list for the whole workgroup; others add up where rays went.
    if (lane < LISTS) {
        let rays = appended(lane, LANE_WORDS, 0u);
        if (rays > 0u) {
            first_ray[lane] = reserve(lane, rays);
        }
    } else if (lane < LISTS + STATES) {
        add_sent(lane - LISTS);
    }
    workgroupBarrier();
    if (list < LISTS) {
        // Rays keep the order of their threads in every pass, so that neighbouring rays stay together.
        let place = appended(list, word, bit - 1u);
        live_rays[first_ray[list] + place] = texel.x | (texel.y << 16u);
    }
}
