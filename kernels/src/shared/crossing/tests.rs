//! Compares what is decided for an origin that is moved by an infinitesimal with rational arithmetic for one that is moved by
//! 2⁻²⁰⁰⁰, and a device with its twin.

use num_bigint::{BigInt, Sign};

use super::*;
#[cfg(feature = "gpu")]
use crate::shared::exact::tests::compare_with_a_device;
use crate::shared::exact::tests::{KINDS, cross, dot, given, integer, minus, two};

/// Coordinates are multiples of 2⁻¹⁴⁹ times this power of two, so that e³ is one.
const SHIFT: u32 = 6000;

/// A number by which nothing that is not 0 here becomes 0, nor 0 what it is multiplied by: sums of products of three f32 are
/// multiples of 2⁻⁴⁴⁷, of two 2⁻²⁹⁸, of two such sums 2⁻⁸⁹⁴, and all are below 2⁸⁰⁰.
const E: u32 = 2000;

fn wide(point: Point) -> [BigInt; 3] {
    point.map(|v| integer(v) << SHIFT)
}

fn moved(origin: Point) -> [BigInt; 3] {
    let [x, y, z] = wide(origin);
    let e = |power: u32| BigInt::from(1) << (149 + SHIFT - power * E);
    [x + e(1), y + e(2), z + e(3)]
}

/// t as numerator and denominator, which is positive, and the smallest weight of a corner times that. `None` if the triangle is
/// edge-on.
fn parts(o: &[BigInt; 3], d: Point, corners: [Point; 3]) -> Option<([BigInt; 2], BigInt)> {
    let d = wide(d);
    let p = corners.map(|corner| minus(&wide(corner), o));
    let normal = cross(&minus(&p[1], &p[0]), &minus(&p[2], &p[0]));
    let side = |i: usize, j: usize| dot(&d, &cross(&p[i], &p[j]));
    let (along, t, sides) = (dot(&d, &normal), dot(&p[0], &normal), [side(1, 2), side(2, 0), side(0, 1)]);
    let turned = |value: BigInt| if along.sign() == Sign::Minus { -value } else { value };
    let least = sides.map(turned).into_iter().min()?;
    (along.sign() != Sign::NoSign).then(|| ([turned(t), turned(along.clone())], least))
}

fn t_of_crossing(origin: Point, d: Point, corners: [Point; 3]) -> Option<[BigInt; 2]> {
    let (t, least) = parts(&moved(origin), d, corners)?;
    (t[0].sign() == Sign::Plus && least.sign() == Sign::Plus).then_some(t)
}

#[test]
fn an_infinitesimal_decides_as_a_tiny_number() {
    let mut random = fastrand::Rng::with_seed(49);
    // Crossed and not, decided by the infinitesimal alone.
    let (mut at_edges, mut at_start, mut orders) = ([0; 2], [0; 2], [0; 3]);
    for i in 0..40_000 {
        let kind = i % KINDS;
        let mut given = given(&mut random, kind);
        if i % 16 == 1 {
            // Starts on the triangle, whose corners are whole numbers.
            given[0] = [0, 1, 2].map(|axis| 0.5 * given[2][axis] + 0.25 * (given[3][axis] + given[4][axis]));
        }
        let (o, d, corners, others) = two(given);
        let wanted = [corners, others].map(|corners| t_of_crossing(o, d, corners));
        let found = [corners, others].map(|corners| crosses_exactly(o, d, corners));
        assert_eq!(found, [0, 1].map(|i| wanted[i].is_some()), "{kind}: {given:?}");
        if let Some((t, least)) = parts(&wide(o), d, corners) {
            let is_crossed = usize::from(found[0]);
            at_edges[is_crossed] += usize::from(least.sign() == Sign::NoSign && t[0].sign() == Sign::Plus);
            at_start[is_crossed] += usize::from(least.sign() == Sign::Plus && t[0].sign() == Sign::NoSign);
        }
        if let [Some([t, by]), Some([other, other_by])] = wanted {
            let order = (t * other_by).cmp(&(other * by));
            assert_eq!(compare_crossings(o, d, corners, others), order, "{kind}: {given:?}");
            orders[usize::from(order.is_eq()) + 2 * usize::from(order.is_gt())] += 1;
        }
        if parts(&wide(o), d, corners).is_some() {
            let towards = dot(
                &wide(d),
                &cross(&minus(&wide(corners[1]), &wide(corners[0])), &minus(&wide(corners[2]), &wide(corners[0]))),
            );
            assert_eq!(sees_front(d, corners), towards.sign() == Sign::Minus);
        }
    }
    let seen = [at_edges, at_start].concat();
    assert!(seen.iter().chain(&orders).all(|&count| count > 50), "{seen:?} {orders:?}");
}

/// A ray to a corner, an edge or a silhouette of a closed surface, whichever of its triangles meet there.
#[test]
fn a_closed_surface_is_entered_as_often_as_it_is_left() {
    let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2].map(|v| v as f32);
    // Six faces, two triangles each, turned outwards.
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<[Point; 3]> =
        faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).map(|ids| ids.map(corner)).collect();
    let (mut crossed, mut grazed) = (0, 0);
    let lattice = |i: u32| [i % 7, i / 7 % 7, i / 49].map(|v| v as f32 * 0.5 - 1.0);
    for from in 0..343 {
        for to in (0..343).filter(|&to| to != from) {
            let (o, target) = (lattice(from), lattice(to));
            let d = [0, 1, 2].map(|i| target[i] - o[i]);
            let mut met: Vec<_> = triangles.iter().filter(|&&corners| crosses_exactly(o, d, corners)).collect();
            met.sort_by(|&&a, &&b| compare_crossings(o, d, a, b));
            // Starts inside, moved by the infinitesimal: within the box's lower faces, outside of the upper ones.
            let is_inside = o.iter().all(|v| (0.0..1.0).contains(v));
            assert_eq!(met.len(), if is_inside { 1 } else { met.len() / 2 * 2 }, "{o:?} {d:?}");
            for (i, corners) in met.iter().enumerate() {
                assert_eq!(sees_front(d, **corners), (i % 2 == 0) != is_inside, "{o:?} {d:?}: {met:?}");
            }
            crossed += usize::from(!met.is_empty());
            let meets_any = triangles.iter().any(|&corners| crate::shared::exact::meets_exactly(o, d, corners));
            grazed += usize::from(met.is_empty() && meets_any);
        }
    }
    assert!(crossed > 10_000 && grazed > 1000, "{crossed} {grazed}");
}

#[cfg(feature = "gpu")]
#[test]
fn a_device_decides_as_its_twin() {
    let names = ["crosses_exactly", "compare_crossings"];
    compare_with_a_device("crossing", names, (crosses_exactly, compare_crossings), 50);
}
