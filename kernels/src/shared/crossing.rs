//! Twin of `crossing.wgsl`: whether a ray crosses a triangle, and which of two it crosses first, once its origin is moved by an
//! infinitesimal.

use std::cmp::Ordering;

use super::exact::{Point, Sum, compare_exactly, distance, products, volume};

const AXES: [Point; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// The first component that is not 0 decides.
fn first_sign(component: impl Fn(Point) -> Ordering) -> Ordering {
    AXES.into_iter().fold(Ordering::Equal, |sign, axis| sign.then_with(|| component(axis)))
}

/// On which side of an edge the ray passes; on neither only if the edge is parallel to it.
fn side(origin: Point, direction: Point, tail: Point, head: Point) -> Ordering {
    volume(direction, [tail, head, origin]).settle().then_with(|| {
        // d × (head − tail)
        first_sign(|axis| {
            let mut moved = Sum::new();
            moved.add_volume(axis, [[0.0; 3], direction, head], false);
            moved.add_volume(axis, [[0.0; 3], direction, tail], true);
            moved.settle()
        })
    })
}

/// Whether the ray crosses the triangle at t > 0. One that is seen edge-on is not crossed.
#[must_use]
pub fn crosses_exactly(origin: Point, direction: Point, corners: [Point; 3]) -> bool {
    let [a, b, c] = corners;
    let along = side(origin, direction, a, b);
    along.is_ne()
        && side(origin, direction, b, c) == along
        && side(origin, direction, c, a) == along
        // The sides add up to d · n, and t is a share of that.
        && distance(origin, corners)
            .settle()
            .then_with(|| first_sign(|axis| volume(axis, corners).settle().reverse()))
            == along
}

/// Compares the t of two triangles that the ray crosses; they are equal only if both are in one plane.
#[must_use]
pub fn compare_crossings(origin: Point, direction: Point, corners: [Point; 3], others: [Point; 3]) -> Ordering {
    compare_exactly(origin, direction, corners, others).then_with(|| {
        // t moves by −n / d · n.
        let both = [corners, others];
        let mut along = both.map(|corners| volume(direction, corners));
        let signs = along.each_mut().map(Sum::settle);
        first_sign(|axis| {
            let mut by = both.map(|corners| volume(axis, corners));
            let [one, other] = [0, 1].map(|i| if signs[i].is_gt() { by[i].settle().reverse() } else { by[i].settle() });
            one.cmp(&other).then_with(|| {
                let sizes = products(&by[0], &along[1]).cmp(&products(&by[1], &along[0]));
                if one.is_lt() { sizes.reverse() } else { sizes }
            })
        })
    })
}

/// Whether the ray sees the side of the triangle from which its corners run counterclockwise, which a closed surface turns
/// outwards.
#[must_use]
pub fn sees_front(direction: Point, corners: [Point; 3]) -> bool {
    volume(direction, corners).settle().is_lt()
}

#[cfg(test)]
mod tests;
