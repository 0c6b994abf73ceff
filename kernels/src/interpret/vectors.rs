//! Functions whose result depends on several components of a vector. WGSL lets a device add the products in any order: here
//! they are added from the first to the last.

use naga::MathFunction as Fun;

use super::code::{Kind, Slot};
use crate::numbers::real::Real;

/// Most components.
const MOST: usize = 4;

/// Whether a function is one of these.
pub(super) fn is_of_vectors(fun: Fun) -> bool {
    matches!(fun, Fun::Dot | Fun::Cross | Fun::Length | Fun::Distance | Fun::Normalize)
}

/// The function of the first `width` components of two vectors; the second is not used by all. `None` for integers.
pub(super) fn of_vectors(fun: Fun, kind: Kind, width: usize, [a, b]: [[Slot; MOST]; 2]) -> Option<[Slot; MOST]> {
    if kind != Kind::F32 {
        return None;
    }
    let bits = [a, b].map(|side| side.map(|slot| f32::from_bits(slot.bits)));
    let value = of_floats(fun, width, bits);
    let wide = of_floats(fun, width, [a, b].map(|side| side.map(|slot| slot.wide)));
    let mut result = [Slot::default(); MOST];
    for (slot, (value, wide)) in result.iter_mut().zip(value.into_iter().zip(wide)) {
        *slot = Slot { bits: value.to_bits(), from: 0, wide };
    }
    Some(result)
}

fn dot<R: Real>(width: usize, a: [R; MOST], b: [R; MOST]) -> R {
    let products = a.into_iter().zip(b).take(width).map(|(x, y)| x * y);
    products.reduce(|sum, product| sum + product).unwrap_or_else(R::zero)
}

fn of_floats<R: Real>(fun: Fun, width: usize, [a, b]: [[R; MOST]; 2]) -> [R; MOST] {
    let zero = R::zero();
    let one = |value: R| [value, zero, zero, zero];
    match fun {
        Fun::Cross => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0], zero],
        Fun::Length => one(dot(width, a, a).sqrt()),
        Fun::Distance => {
            let between = [0, 1, 2, 3].map(|i| a[i] - b[i]);
            one(dot(width, between, between).sqrt())
        }
        Fun::Normalize => {
            let length = dot(width, a, a).sqrt();
            a.map(|x| x / length)
        }
        _ => one(dot(width, a, b)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_have_products_and_lengths_in_both_precisions() {
        let slot = |value: f32| Slot { bits: value.to_bits(), from: 0, wide: f64::from(value) };
        let [a, b] = [[3.0, 4.0, 12.0, 99.0], [1.0, -2.0, 0.5, 99.0]].map(|v| v.map(slot));
        let told = |fun, width| {
            let result = of_vectors(fun, Kind::F32, width, [a, b]).expect("floats");
            assert!(result.iter().all(|slot| (slot.wide - f64::from(f32::from_bits(slot.bits))).abs() < 1e-6));
            result.map(|slot| f32::from_bits(slot.bits))
        };
        assert_eq!(told(Fun::Dot, 3)[0], 1.0);
        assert_eq!(told(Fun::Dot, 2)[0], -5.0);
        assert_eq!(told(Fun::Length, 3)[0], 13.0);
        assert_eq!(told(Fun::Cross, 3)[..3], [26.0, 10.5, -10.0]);
        assert_eq!(told(Fun::Distance, 2)[0], 40f32.sqrt());
        assert_eq!(told(Fun::Normalize, 2)[..2], [0.6, 0.8]);
        assert!(of_vectors(Fun::Dot, Kind::I32, 3, [a, b]).is_none());
    }
}
