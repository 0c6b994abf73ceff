//! Inputs of operations: the same on every machine, extremes among them.

use crate::self_test::probe::Inputs;

/// A float with an exponent in this range: a random one, or in one of four cases one with the fewest or most digits.
fn with_exponent(random: u64, from: i64, to: i64) -> u32 {
    let exponent = from + ((random >> 32) % (to - from + 1) as u64) as i64;
    let digits = match (random >> 28) & 0xf {
        0 | 1 => 0,
        2 | 3 => 0x007f_ffff,
        _ => (random & 0x007f_ffff) as u32,
    };
    (((random >> 27) & 1) as u32) << 31 | ((exponent + 127) as u32) << 23 | digits
}

/// Floats around 1.
pub(super) fn ordinary(random: [u64; 4]) -> Inputs {
    random.map(|r| with_exponent(r, -12, 12))
}

/// Floats whose products of two are normal.
pub(super) fn of_any_size(random: [u64; 4]) -> Inputs {
    random.map(|r| with_exponent(r, -62, 62))
}

/// a and b such that a / b and 1 / b are normal, and b is neither too small nor too large for WGSL's bound.
pub(super) fn to_divide(random: [u64; 4]) -> Inputs {
    let b = with_exponent(random[1], -125, 125);
    let of_b = i64::from((b >> 23) & 0xff) - 127;
    let a = with_exponent(random[0], (of_b - 124).max(-125), (of_b + 125).min(126));
    [a, b, 0, 0]
}

/// Positive floats.
pub(super) fn positive(random: [u64; 4]) -> Inputs {
    random.map(|r| with_exponent(r, -126, 127) & 0x7fff_ffff)
}

/// Products a b and c d that are nearly or exactly the same when rounded: c is a neighbour of a, and d of b.
pub(super) fn near_products(random: [u64; 4]) -> Inputs {
    let [a, b] = [random[0], random[1]].map(|r| with_exponent(r, -12, 12));
    let step = |r: u64| (r % 5) as u32;
    [a, b, a + step(random[2]), b - step(random[3])]
}

/// a and b whose sum loses digits, which c = -a would bring back in another order.
pub(super) fn to_cancel(random: [u64; 4]) -> Inputs {
    let a = with_exponent(random[0], 0, 12);
    [a, with_exponent(random[1], -24, -2), a ^ (1 << 31), with_exponent(random[3], -12, 12)]
}

/// Floats from the smallest normal one to nearly 2³¹, halves and whole numbers among them.
pub(super) fn to_round(random: [u64; 4]) -> Inputs {
    random.map(|r| match r & 7 {
        0 => ((r >> 40) as f32 * 0.5).to_bits(),
        1 => with_exponent(r, -126, -1),
        _ => with_exponent(r, -2, 30),
    })
}

/// Floats within an i32.
pub(super) fn to_convert(random: [u64; 4]) -> Inputs {
    random.map(|r| with_exponent(r, -3, 30))
}

/// Floats beyond an i32 and a u32.
pub(super) fn beyond_integers(random: [u64; 4]) -> Inputs {
    random.map(|r| with_exponent(r, 32, 127))
}

/// Integers: 0, few bits, many bits, small ones and others.
pub(super) fn integers(random: [u64; 4]) -> Inputs {
    random.map(|r| match (r >> 32) & 7 {
        0 => 0,
        1 => 1 << (r & 31),
        2 => u32::MAX >> (r & 31),
        3 => (r & 0xff) as u32,
        _ => r as u32,
    })
}

/// The same, where y is not 0.
pub(super) fn with_divisor(random: [u64; 4]) -> Inputs {
    let [x, y, z, w] = integers(random);
    [x, y.max(1), z, w]
}

/// Subnormal a and b; or normal ones with a subnormal difference, or with a subnormal product with c.
pub(super) fn small(random: [u64; 4]) -> Inputs {
    let subnormal = |r: u64| (r as u32 & 0x807f_ffff) | 1;
    match random[3] & 3 {
        0 => [subnormal(random[0]), subnormal(random[1]), with_exponent(random[2], 100, 120), 0],
        1 => [with_exponent(random[0], -126, -126), with_exponent(random[1], -126, -126), 0.5f32.to_bits(), 0],
        _ => [with_exponent(random[0], -100, -60), subnormal(random[1]), with_exponent(random[2], -60, -40), 0],
    }
}

/// Infinities, NaNs with and without a payload, 1 and 0.
pub(super) fn not_finite(random: [u64; 4]) -> Inputs {
    const ALL: [u32; 6] = [0x7f80_0000, 0xff80_0000, 0x7fc0_0000, 0xffc0_dead, 0x3f80_0000, 0];
    random.map(|r| ALL[(r % 6) as usize])
}
