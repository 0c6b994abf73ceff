// How many references before a place lie in a half of their leaf: every group of 32 references has a word per half, with
// a bit for each reference, and the number of such references in all groups before it.

import package::leaf::{load_at, place_in};

@group(0) @binding(12) var bits: texture_2d_array<u32>;
@group(0) @binding(13) var tally: texture_2d_array<u32>;

fn rank(half: u32, reference: u32) -> u32 {
    let below = (1u << (reference % 32u)) - 1u;
    let at = place_in(bits, reference / 32u);
    return load_at(tally, at, half) + countOneBits(load_at(bits, at, half) & below);
}

// How many of these references, one after the other, lie in the half.
fn count(half: u32, first: u32, references: u32) -> u32 {
    if (references == 0u) {
        return 0u;
    }
    let last = first + references - 1u;
    // Up to the last one and with it.
    let up_to_last = 0xffffffffu >> (31u - last % 32u);
    let at = place_in(bits, last / 32u);
    return load_at(tally, at, half) + countOneBits(load_at(bits, at, half) & up_to_last) - rank(half, first);
}
