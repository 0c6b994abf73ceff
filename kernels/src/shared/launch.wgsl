// What a kernel is launched over, and where the elements of a set lie in the images of its streams.

struct Launch {
    // Of the set that the kernel is launched over.
    elements: u32,
    // The step's number: which digit is sorted by.
    parameter: u32,
    // Workgroups that one element a thread fills, the last one perhaps in part.
    blocks: u32,
    _pad: u32,
}

@group(2) @binding(0) var<uniform> launch: Launch;

// Threads of a workgroup, each for one element.
const BLOCK: u32 = 256u;

// The number of a workgroup: more than fit along x go on along y.
fn block_index(group: vec3u, groups: vec3u) -> u32 {
    return group.x + group.y * groups.x;
}

// The element of a thread where each has one.
fn element(group: vec3u, groups: vec3u, lane: u32) -> u32 {
    return block_index(group, groups) * BLOCK + lane;
}

// Where element i lies in an image that is folded row by row.
fn texel(i: u32, width: u32) -> vec2u {
    return vec2u(i % width, i / width);
}
