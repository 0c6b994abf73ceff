// Numbers from 0 to below 1 for the decisions of a path: for each pair of them, in each pixel, another scrambled and shuffled
// Sobol' sequence. Integers up to the last step, which is exact: every device gives the same.

import package::samples::{hashed, sampling, scrambled, sobol_second};

// What a pair of numbers decides: pairs of a bounce follow each other.
const FOR_EMITTER: u32 = 0u;
const FOR_POINT: u32 = 1u;
const FOR_DIRECTION: u32 = 2u;
const FOR_CHANCE: u32 = 3u;

// What photons have in place of a pixel: each is a sample of one sequence.
const OF_PHOTONS: vec2u = vec2u(0xffffffffu);

@if(samples) @group(0) @binding(20) var accumulated: texture_2d_array<f32>;

// The index of the sample that a pixel is at.
fn next_sample(texel: vec2u) -> u32 {
    @if(samples) return sampling.first + u32(textureLoad(accumulated, texel, 4, 0).x);
    @else return 0u;
}

// The pair of numbers by which a pixel's sample decides something at a depth.
fn decided_by(texel: vec2u, sample: u32, depth: u32, what: u32) -> vec2f {
    let pair = 4u * depth + what;
    let seed = hashed(texel.x + hashed(texel.y + hashed(pair + hashed(sampling.seed))));
    let next_seed = hashed(seed);
    @if(sobol) {
        // Scrambled like a number, an index keeps its place among others: pairs do not depend on each other.
        let index = scrambled(sample, hashed(next_seed));
        let bits = vec2u(scrambled(reverseBits(index), seed), scrambled(sobol_second(index), next_seed));
        return vec2f(bits >> vec2u(8u)) * 5.9604644775390625e-8;
    } @else {
        let bits = vec2u(hashed(sample + seed), hashed(hashed(sample) + next_seed));
        return vec2f(bits >> vec2u(8u)) * 5.9604644775390625e-8;
    }
}
