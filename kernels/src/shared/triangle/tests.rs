//! Bounds on the errors of the triangle test against integers: they hold, and neither could be much smaller.

use super::*;
use crate::shared::exact::meets_exactly;

/// What a bound may be wrong about.
#[derive(Debug, Default, PartialEq)]
struct Violations {
    /// The ray misses for sure what it meets, or hits for sure what it does not meet.
    sides: u32,
    /// t is off by more than the bound.
    t: u32,
}

/// t in f64, whose own error does not matter here.
fn t_of(o: [f64; 3], d: [f64; 3], [a, b, c]: [[f64; 3]; 3]) -> f64 {
    let minus = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|i| p[i] - q[i]);
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let cross = |p: [f64; 3], q: [f64; 3]| [(1, 2), (2, 0), (0, 1)].map(|(i, j)| p[i] * q[j] - p[j] * q[i]);
    let normal = cross(minus(b, a), minus(c, a));
    dot(minus(a, o), normal) / dot(d, normal)
}

fn check([edges, t]: [f32; 2], contracted: bool) -> Violations {
    let mut random = fastrand::Rng::with_seed(7);
    let bounds = [EDGE_ERROR * edges, CORNER_ERROR, DEPTH_ERROR * t];
    let mut found = Violations::default();
    for i in 0..300_000 {
        let mut point = |size: f32| [0; 3].map(|_| (2.0 * random.f32() - 1.0) * size);
        // Large, small, far away, or so far along the ray that rounding moves it by more than its size.
        let (size, far) = [(1.0, 1.0), (0.01, 1.0), (1.0, 1000.0), (8.0, 8.0)][i % 4];
        let (o, mut at) = (point(far), point(far));
        if i % 4 == 3 {
            at[2] += 268_435_456.0;
        }
        let corners = [point(size), point(size), point(size)].map(|p| [0, 1, 2].map(|axis| p[axis] + at[axis]));
        let [a, b, c] = corners;
        // Near an edge, as far as the kinds of i say; on it and beyond it, too.
        let along = random.f32();
        let off = [0.3, 1e-5, 1e-6, 1e-7, 0.0][i / 4 % 5] * (2.0 * random.f32() - 0.5);
        let d = [0, 1, 2].map(|axis| a[axis] + along * (b[axis] - a[axis]) + off * (c[axis] - a[axis]) - o[axis]);
        let [origin, direction] = [o, d].map(Vec3::<f32>::from_f32);
        let (shear, seen) = (Shear::of(direction), corners.map(Vec3::from_f32));
        let candidate = match contracted {
            true => bounded_by::<f32, true>(bounds, origin, &shear, seen),
            false => bounded_by::<f32, false>(bounds, origin, &shear, seen),
        };
        let meets = meets_exactly(o, d, corners);
        found.sides += u32::from(meets && !candidate.is_hit || candidate.is_sure && !meets);
        if candidate.is_hit && meets {
            let wide = |p: [f32; 3]| p.map(f64::from);
            let error = (t_of(wide(o), wide(d), corners.map(wide)) - f64::from(candidate.t)).abs();
            found.t += u32::from(error > f64::from(candidate.error));
        }
    }
    found
}

#[test]
fn bounds_hold_and_a_fault_in_either_is_seen() {
    for contracted in [false, true] {
        assert_eq!(check([1.0; 2], contracted), Violations::default(), "contracted {contracted}");
        assert!(check([1.0 / 64.0, 1.0], contracted).sides > 0, "of edges, contracted {contracted}");
        assert!(check([1.0, 1.0 / 64.0], contracted).t > 0, "of t, contracted {contracted}");
    }
}

#[test]
fn weights_are_those_of_a_point_also_where_a_triangle_is_seen_edge_on() {
    let shear = Shear::of(Vec3::from_f32([0.0, 0.0, 1.0]));
    let in_plane = [[0.0, 0.0, 1.0], [0.0, 1.0, 2.0], [0.0, -1.0, 3.0]];
    let without_area = [[0.0, 0.0, 1.0], [1e-9, 0.0, 2.0], [3e-9, 0.0, 3.0]];
    for corners in [in_plane, without_area] {
        let corners = corners.map(Vec3::from_f32);
        let found = bounded::<f32, false>(Vec3::from_f32([0.0; 3]), &shear, corners);
        assert!(found.is_hit && !found.is_sure, "{found:?}");
        assert!(found.u >= 0.0 && found.v >= 0.0 && found.u + found.v <= 1.0, "{found:?}");
    }
}
