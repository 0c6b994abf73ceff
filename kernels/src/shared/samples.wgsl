// The position of a sample in its pixel. Integers up to the last step, which is exact: every device gives the same.

struct Sampling {
    // Samples per pixel.
    samples: u32,
    seed: u32,
    // Index of the first sample.
    first: u32,
}

@group(1) @binding(21) var<uniform> sampling: Sampling;

// PCG's output permutation on a step of its generator: every bit of the result depends on all bits of the input.
fn hashed(value: u32) -> u32 {
    let step = value * 747796405u + 2891336453u;
    let word = ((step >> ((step >> 28u) + 4u)) ^ step) * 277803737u;
    return (word >> 22u) ^ word;
}

// Digits of the second coordinate: each bit of the index adds a column of Pascal's triangle modulo 2. That matrix is a
// Kronecker product of those of one bit, so one step for each doubling of the width is enough (Ahmed 2024).
@if(sobol)
fn sobol_second(index: u32) -> u32 {
    var digits = reverseBits(index);
    digits ^= (digits & 0x55555555u) << 1u;
    digits ^= (digits & 0x33333333u) << 2u;
    digits ^= (digits & 0x0f0f0f0fu) << 4u;
    digits ^= (digits & 0x00ff00ffu) << 8u;
    return digits ^ (digits << 16u);
}

// Owen's scrambling: whether a digit flips depends on the seed and on the digits before it. Multiplying by an even
// number, and adding, carry only from low bits to high ones, so the digits must be reversed.
@if(sobol)
fn scrambled(digits: u32, seed: u32) -> u32 {
    var x = reverseBits(digits);
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reverseBits(x);
}

// The two coordinates as fractions of 2³².
fn sample_bits(texel: vec2u, sample: u32) -> vec2u {
    let first_seed = hashed(texel.x + hashed(texel.y + hashed(sampling.seed)));
    let second_seed = hashed(first_seed);
    @if(sobol) return vec2u(scrambled(reverseBits(sample), first_seed), scrambled(sobol_second(sample), second_seed));
    @else return vec2u(hashed(sample + first_seed), hashed(hashed(sample) + second_seed));
}

// Position from the pixel's upper left corner, both coordinates below 1: 24 bits, as many as a float holds.
fn jitter(texel: vec2u, sample: u32) -> vec2f {
    return vec2f(sample_bits(texel, sample) >> vec2u(8u)) * 5.9604644775390625e-8;
}
