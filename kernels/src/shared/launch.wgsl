// The parameters of a launch, and where the elements of a set lie in their streams' textures.

struct Launch {
    // Number of elements in the set that the kernel is launched over.
    elements: u32,
    // Parameter of the step: the digit that it sorts by.
    parameter: u32,
    // Workgroups that the elements fill with one per thread, the last one perhaps only partly.
    blocks: u32,
    // The first workgroup of this dispatch, if there are several.
    first_block: u32,
    // Texels per row of the set's streams.
    width: u32,
}

@group(2) @binding(1) var<uniform> launch: Launch;

// Threads per workgroup, one per element.
const BLOCK: u32 = 256u;

// The index of a workgroup: those that do not fit along x continue along y.
fn block_index(group: vec3u, groups: vec3u) -> u32 {
    return launch.first_block + group.x + group.y * groups.x;
}

// The element of a thread, if there is one per thread.
fn element(group: vec3u, groups: vec3u, lane: u32) -> u32 {
    return block_index(group, groups) * BLOCK + lane;
}

// Half of a workgroup's threads: those of one row.
const HALF: u32 = BLOCK / 2u;

// The element of a thread, for kernels whose workgroups need not take consecutive elements. Each half of a workgroup takes
// HALF consecutive elements, from two adjacent rows of the textures: on many GPUs, such texels share memory sectors.
fn element_of_rows(group: vec3u, groups: vec3u, lane: u32) -> u32 {
    if (launch.width < HALF) {
        return element(group, groups, lane);
    }
    let block = block_index(group, groups);
    let across = launch.width / HALF;
    let x = (block & (across - 1u)) * HALF + lane % HALF;
    let y = 2u * (block >> firstTrailingBit(across)) + lane / HALF;
    return y * launch.width + x;
}

// The texel of element i in a texture that is filled row by row, whose width is a power of two.
fn texel(i: u32, width: u32) -> vec2u {
    return vec2u(i & (width - 1u), i >> firstTrailingBit(width));
}
