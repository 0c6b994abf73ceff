// Products and quotients of numbers with up to 64 bits: vec2u(high, low).

import package::product::{product64};
import package::soft_f64::{less64};

fn times64(a: vec2u, b: u32) -> vec2u {
    return product64(a.y, b) + vec2u(a.x * b, 0u);
}

fn is_at_most64(a: vec2u, b: vec2u) -> bool {
    return !less64(b, a);
}

// a · b / c, which fits in 32 bits: b is at most c, and not 0.
fn share(a: u32, b: u32, c: u32) -> u32 {
    let product = product64(a, b);
    var rest = product.x;
    var quotient = 0u;
    for (var bit = 32u; bit > 0u; bit--) {
        let carry = rest >> 31u;
        rest = (rest << 1u) | ((product.y >> (bit - 1u)) & 1u);
        quotient <<= 1u;
        if (carry == 1u || rest >= c) {
            rest -= c;
            quotient |= 1u;
        }
    }
    return quotient;
}

// The integer part of the logarithm to base 2 of a square.
fn log2_of_square(a: u32) -> u32 {
    let square = product64(a, a);
    return select(firstLeadingBit(square.y), 32u + firstLeadingBit(square.x), square.x != 0u);
}
