//! Compares soft f64 with the processor's f64, bit for bit.

use crate::programs::grid_build::device::tests::{computed, gpu};

/// Input of the shader: a and b, low word second, the bits of an f32 and of an i32.
type Given = [u32; 6];

const RESULTS: [&str; 10] = ["+", "-", "*", "/", "min", "max", "neg", "abs", "from f32", "from i32"];
const WORDS: usize = 2 * (RESULTS.len() + 1);

fn number(sign: bool, exponent: i32, fraction: u64) -> f64 {
    f64::from_bits(u64::from(sign) << 63 | ((exponent + 1023) as u64) << 52 | (fraction & ((1 << 52) - 1)))
}

/// Two numbers whose sums, products and quotients are not subnormal; each `kind` exposes one sort of mistake.
fn pair(random: &mut fastrand::Rng, kind: u32) -> (f64, f64) {
    let exponent = random.i32(-400..400);
    let a = number(random.bool(), exponent, random.u64(..));
    let signed = |random: &mut fastrand::Rng, value: f64| if random.bool() { value } else { -value };
    let b = match kind {
        0 => number(random.bool(), random.i32(-400..400), random.u64(..)),
        // What remains after the upper bits cancel out.
        1 => f64::from_bits(a.to_bits() ^ (1 << random.u32(0..53)) ^ random.u64(..) >> random.u32(12..64)),
        2 => number(random.bool(), exponent + random.i32(-60..60), random.u64(..)),
        // Half of a's last place, and one bit more or less.
        3 => {
            let half = number(random.bool(), exponent - 53 + random.i32(-1..2), 0);
            f64::from_bits(half.to_bits() + random.u64(0..3) - 1)
        }
        4 => number(random.bool(), random.i32(-400..400), 0),
        5 => [0.0, -0.0, a, -a][random.usize(0..4)],
        // Products of 54 bits are ties.
        6 => {
            let bits = |random: &mut fastrand::Rng| random.u64(1 << 26..1 << 27) as f64;
            let (a, b) = (bits(random), bits(random));
            return (signed(random, a), signed(random, b));
        }
        // Near the ends of i32, and near whole numbers.
        7 => {
            let a = f64::from(random.i32(..)) + f64::from(random.i32(-4..5)) * 0.25;
            let end = 2147483648.0 + f64::from(random.i32(-8..9)) * 0.25;
            return (if random.bool() { a } else { signed(random, end) }, f64::from(random.i32(-9..9)));
        }
        // Quotients that are integers, or nearly.
        8 => {
            let divisor = f64::from(random.f32() + 1.0);
            let a = divisor * f64::from(random.u32(1..5000));
            return (f64::from_bits(a.to_bits() + random.u64(0..2)), signed(random, divisor));
        }
        9 => {
            let special = [f64::INFINITY, f64::NEG_INFINITY, f64::NAN, 0.0, -0.0];
            let b = special[random.usize(0..5)];
            return (if random.bool() { a } else { special[random.usize(0..5)] }, b);
        }
        // Products that differ from a tie only in their last bits.
        10 => {
            let odd = f64::from(2 * random.u32(0..64) + 1);
            let any = f64::from(random.u32(0..64));
            let power = number(random.bool(), random.i32(-200..200), 0);
            return ((1.0 + odd * f64::EPSILON) * power, 1.5 + any * f64::EPSILON);
        }
        _ => f64::from(f32::from_bits(random.u32(..))),
    };
    if random.bool() { (a, b) } else { (b, a) }
}

fn words(value: f64) -> [u32; 2] {
    [(value.to_bits() >> 32) as u32, value.to_bits() as u32]
}

/// Whether the bits are equal; any NaN equals any other, and if `zeros` is set, so do both zeros.
fn same(got: f64, wanted: f64, zeros: bool) -> bool {
    got.to_bits() == wanted.to_bits() || (got.is_nan() && wanted.is_nan()) || (zeros && got == 0.0 && wanted == 0.0)
}

#[test]
fn every_operation_gives_the_bits_of_the_processors_f64() {
    let Some(gpu) = gpu() else { return };
    const PAIRS: u32 = 1 << 18;
    for round in 0..4 {
        let mut random = fastrand::Rng::with_seed(round);
        let pairs: Vec<(f64, f64)> = (0..PAIRS).map(|i| pair(&mut random, i % 12)).collect();
        let given: Vec<Given> = pairs
            .iter()
            .map(|&(a, b)| {
                let f32_bits = random.u32(..) & if random.u8(0..4) == 0 { 0x807f_ffff } else { u32::MAX };
                let i32_bits = (random.i32(..) >> random.u32(0..32)) as u32;
                let ([a_high, a_low], [b_high, b_low]) = (words(a), words(b));
                [a_high, a_low, b_high, b_low, f32_bits, i32_bits]
            })
            .collect();
        let shader = ("ops", include_str!("ops.wgsl"));
        let results = computed(&gpu, shader, bytemuck::cast_slice(&given), WORDS * PAIRS as usize, PAIRS / 64);
        assert_eq!(results.len(), WORDS * PAIRS as usize);
        for ((&(a, b), given), results) in pairs.iter().zip(&given).zip(results.chunks_exact(WORDS)) {
            let wanted = [
                a + b,
                a - b,
                a * b,
                a / b,
                a.min(b),
                a.max(b),
                -a,
                a.abs(),
                f64::from(f32::from_bits(given[4])),
                f64::from(given[5] as i32),
            ];
            for (k, (&wanted, operation)) in wanted.iter().zip(RESULTS).enumerate() {
                let got = f64::from_bits(u64::from(results[2 * k]) << 32 | u64::from(results[2 * k + 1]));
                // Which of two zeros is smaller is unspecified.
                let zeros = matches!(operation, "min" | "max");
                assert!(same(got, wanted, zeros), "{a:e} {operation} {b:e} is {wanted:e}, not {got:e}: {given:x?}");
            }
            let [compared, truncated] = [results[WORDS - 2], results[WORDS - 1]];
            assert_eq!(compared, u32::from(a >= b) | u32::from(a < b) << 1, "{a:e} compared with {b:e}");
            assert_eq!(truncated as i32, a as i32, "{a:e}");
        }
    }
}
