//! Compares what integers of a fixed size decide with arbitrary ones, and a device with its twin.

use std::cmp::Ordering;

use num_bigint::{BigInt, Sign};

use super::*;

/// A ray and two triangles.
pub(crate) type Given = [Point; 8];

/// `value` · 2¹⁴⁹
pub(in crate::shared) fn integer(value: f32) -> BigInt {
    let (bits, exponent) = (value.to_bits(), value.to_bits() >> 23 & 0xff);
    let fraction = BigInt::from(bits & 0x7f_ffff | if exponent > 0 { 0x80_0000 } else { 0 });
    let magnitude = fraction << (exponent.max(1) - 1);
    if bits >> 31 == 1 { -magnitude } else { magnitude }
}

pub(in crate::shared) fn dot(a: &[BigInt; 3], b: &[BigInt; 3]) -> BigInt {
    (0..3).map(|i| &a[i] * &b[i]).sum()
}

pub(in crate::shared) fn minus(a: &[BigInt; 3], b: &[BigInt; 3]) -> [BigInt; 3] {
    [0, 1, 2].map(|i| &a[i] - &b[i])
}

pub(in crate::shared) fn cross(a: &[BigInt; 3], b: &[BigInt; 3]) -> [BigInt; 3] {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| &a[i] * &b[j] - &a[j] * &b[i])
}

/// The distance of the plane and the weights of the three corners, in parts of the last number, which is not negative.
pub(crate) fn parts(o: Point, d: Point, corners: [Point; 3]) -> ([BigInt; 4], BigInt) {
    let [o, d] = [o, d].map(|point| point.map(integer));
    let p = corners.map(|corner| minus(&corner.map(integer), &o));
    let normal = cross(&minus(&p[1], &p[0]), &minus(&p[2], &p[0]));
    let side = |i: usize, j: usize| dot(&d, &cross(&p[i], &p[j]));
    let (along, mut parts) = (dot(&d, &normal), [dot(&p[0], &normal), side(1, 2), side(2, 0), side(0, 1)]);
    if along.sign() == Sign::Minus {
        parts = parts.map(|part| -part);
    }
    (parts, along.magnitude().clone().into())
}

pub(crate) fn meets(o: Point, d: Point, corners: [Point; 3]) -> bool {
    let ([t, weights @ ..], along) = parts(o, d, corners);
    along.sign() == Sign::Plus && t.sign() == Sign::Plus && weights.iter().all(|weight| weight.sign() != Sign::Minus)
}

pub(in crate::shared) fn two([o, d, a, b, c, e, f, g]: Given) -> (Point, Point, [Point; 3], [Point; 3]) {
    (o, d, [a, b, c], [e, f, g])
}

/// A ray and two triangles of one of several kinds, most of which it meets.
pub(crate) fn given(random: &mut fastrand::Rng, kind: u32) -> Given {
    let signed = |random: &mut fastrand::Rng| random.f32() * 2.0 - 1.0;
    let point = |random: &mut fastrand::Rng| [0; 3].map(|_| signed(random));
    let lattice = |random: &mut fastrand::Rng| [0; 3].map(|_| random.i32(-2..3) as f32);
    let mut all = [0; 8].map(|_| point(random));
    // Towards the first triangle, through a point of it, of an edge, or a corner.
    let aim = |random: &mut fastrand::Rng, all: &mut Given| {
        let share = [[random.f32(), random.f32()], [random.f32(), 0.0], [0.0; 2]][random.usize(0..3)];
        let [o, _, a, b, c, ..] = *all;
        all[1] = [0, 1, 2].map(|i| a[i] + share[0] * (b[i] - a[i]) + share[1] * (c[i] - a[i]) - o[i]);
    };
    aim(random, &mut all);
    match kind {
        0 => {}
        // Whole numbers: rays through edges and corners, edge-on, in planes; triangles without an area.
        1 => {
            all = [0; 8].map(|_| lattice(random));
            if random.bool() {
                aim(random, &mut all);
            }
        }
        // The same plane, or the same triangle, or nearly.
        2 => {
            let [.., a, b, c, _, _, _] = all;
            all[5..].copy_from_slice(&[b, c, a]);
            if random.bool() {
                let (corner, axis) = (random.usize(5..8), random.usize(0..3));
                all[corner][axis] = f32::from_bits(all[corner][axis].to_bits() ^ 1);
            }
        }
        // Across each other in a line that the ray meets.
        3 => (all[5], all[6]) = (all[2], all[3]),
        // Needles.
        4 => {
            let along = random.f32();
            all[4] = [0, 1, 2].map(|i| all[2][i] + along * (all[3][i] - all[2][i]));
            aim(random, &mut all);
        }
        // Any exponents, and any bits.
        5 => all = all.map(|p| p.map(|v| v * 2f32.powi(random.i32(-149..120)))),
        6 => {
            let exponent = random.i32(-140..100);
            all = all.map(|p| p.map(|v| v * 2f32.powi(exponent + random.i32(-4..5))));
            aim(random, &mut all);
        }
        // Far away, and small.
        _ => {
            let far = 2f32.powi(random.i32(0..20));
            let at = point(random).map(|v| v * far);
            for point in &mut all[2..] {
                *point = [0, 1, 2].map(|i| point[i] + at[i]);
            }
            aim(random, &mut all);
        }
    }
    // Rays of a device have finite directions.
    all.map(|p| p.map(|v| if v.is_finite() { v } else { 1.0 }))
}

pub(crate) const KINDS: u32 = 8;

#[test]
fn integers_of_a_fixed_size_decide_as_arbitrary_ones() {
    let mut random = fastrand::Rng::with_seed(47);
    let (mut met, mut orders, mut fit, mut before) = ([0; KINDS as usize], [0; 3], [0; KINDS as usize], [0; 2]);
    for i in 0..40_000 {
        let kind = i % KINDS;
        let given = given(&mut random, kind);
        let (o, d, corners, others) = two(given);
        let wanted = [corners, others].map(|corners| meets(o, d, corners));
        assert_eq!([corners, others].map(|corners| meets_exactly(o, d, corners)), wanted, "{kind}: {given:?}");
        // Few words where they are enough, and many where they are not.
        assert_eq!([corners, others].map(|corners| meets_widely(o, d, corners)), wanted, "{kind}: {given:?}");
        fit[kind as usize] += u32::from(Units::of(&given[2..], d).is_some());
        let (parts_here, along) = parts(o, d, corners);
        if wanted[0] {
            met[kind as usize] += 1;
            // Ends at the rounded t, and beside it.
            let [t, _, _] = values::rounded_values(o, d, corners).expect("a triangle that is met");
            for end in [t.next_down(), t, t.next_up()].into_iter().filter(|end| *end > 0.0 && *end < INF) {
                let is_between = [rounds_between([0.0, end], o, d, corners), rounds_between([end, INF], o, d, corners)];
                assert_eq!(is_between, [t < end, t > end], "{kind}: {given:?} before or after {end}");
                before[usize::from(is_between[0])] += 1;
            }
        }
        if wanted == [true; 2] {
            let (parts_there, along_there) = parts(o, d, others);
            let order = (&parts_here[0] * &along_there).cmp(&(&parts_there[0] * &along));
            assert_eq!(compare_exactly(o, d, corners, others), order, "{kind}: {given:?}");
            assert_eq!(compare_widely(o, d, corners, others), order, "{kind}: {given:?}");
            orders[match order {
                Ordering::Less => 0,
                Ordering::Equal => 1,
                Ordering::Greater => 2,
            }] += 1;
        }
    }
    assert!(met.iter().all(|&met| met > 50) && orders.iter().all(|&of| of > 100), "{met:?} {orders:?}");
    assert!(fit[0] > 4000 && fit[5] < 10, "fit into few words: {fit:?}");
    assert!(before.iter().all(|&of| of > 1000), "{before:?}");
}

/// Whether a ray meets a triangle.
#[cfg(feature = "gpu")]
type Meets = fn(Point, Point, [Point; 3]) -> bool;
/// Which of two it meets first.
#[cfg(feature = "gpu")]
type Compare = fn(Point, Point, [Point; 3], [Point; 3]) -> Ordering;

/// Compares what a device answers by `asked.wgsl` with what two functions do, which have these names in a module of WGSL.
#[cfg(feature = "gpu")]
pub(in crate::shared) fn compare_with_a_device(
    module: &str,
    names: [&str; 2],
    (meets, compare): (Meets, Compare),
    seed: u64,
) {
    use crate::programs::grid_build::device::tests::{computed, gpu};
    const RAYS: u32 = 1 << 13;
    let Some(gpu) = gpu() else { return };
    let mut random = fastrand::Rng::with_seed(seed);
    let all: Vec<Given> = (0..RAYS).map(|i| given(&mut random, i % KINDS)).collect();
    let [meets_in_wgsl, compare_in_wgsl] = names;
    let source = include_str!("asked.wgsl")
        .replace("package::exact", &format!("package::{module}"))
        .replace("meets_exactly", meets_in_wgsl)
        .replace("compare_exactly", compare_in_wgsl);
    let results = computed(&gpu, ("asked", &source), bytemuck::cast_slice(&all), 2 * RAYS as usize, RAYS / 64);
    for (i, (given, found)) in all.iter().zip(results.chunks_exact(2)).enumerate() {
        let (o, d, corners, others) = two(*given);
        let [one, other] = [corners, others].map(|corners| meets(o, d, corners));
        let order = if one && other { compare(o, d, corners, others) as i32 } else { 0 };
        let wanted = [u32::from(one) | u32::from(other) << 1, (order + 1) as u32];
        assert_eq!(found, wanted, "{}: {given:?}", i as u32 % KINDS);
    }
}

#[cfg(feature = "gpu")]
#[test]
fn a_device_decides_as_its_twin() {
    compare_with_a_device("exact", ["meets_exactly", "compare_exactly"], (meets_exactly, compare_exactly), 48);
}
