//! Functions of whole vectors and matrices, as WGSL defines them; the summands of a product are added in order.

use naga::MathFunction as Fun;

use super::code::{Kind, Slot};
use super::recording::KNOWN;
use crate::numbers::real::Real;

/// Whether a function's result depends on more than one component of each argument.
pub(super) fn is_of_whole(fun: Fun) -> bool {
    matches!(
        fun,
        Fun::Dot
            | Fun::Cross
            | Fun::Length
            | Fun::Distance
            | Fun::Normalize
            | Fun::FaceForward
            | Fun::Reflect
            | Fun::Refract
            | Fun::Transpose
            | Fun::Determinant
            | Fun::Modf
    )
}

/// Such a function of its arguments' components; `rows` of the first, if it is a matrix. `None` for one that is not supported.
pub(super) fn of_whole(fun: Fun, kind: Kind, arguments: &[Vec<Slot>], rows: usize) -> Option<Vec<Slot>> {
    match kind {
        Kind::F32 => in_both(arguments, |a| floats(fun, a, rows), |a| floats(fun, a, rows)),
        Kind::U32 | Kind::I32 if fun == Fun::Dot => {
            let [a, b]: &[Vec<Slot>; 2] = arguments.get(..2)?.as_array()?;
            let product = |(a, b): (&Slot, &Slot)| a.bits.wrapping_mul(b.bits);
            let bits = a.iter().zip(b).map(product).fold(0, u32::wrapping_add);
            Some(vec![Slot { bits, from: KNOWN, wide: 0.0 }])
        }
        _ => None,
    }
}

/// The product of two matrices, or of a matrix and a vector, each with the number of its rows, or 0.
pub(super) fn product([left, right]: [&[Slot]; 2], [rows, other]: [usize; 2]) -> Option<Vec<Slot>> {
    let arguments = [left.to_vec(), right.to_vec()];
    in_both(&arguments, |a| products(a, [rows, other]), |a| products(a, [rows, other]))
}

/// A function in f32, with its shadow in f64.
fn in_both(
    arguments: &[Vec<Slot>],
    f32: impl Fn(&[Vec<f32>]) -> Option<Vec<f32>>,
    f64: impl Fn(&[Vec<f64>]) -> Option<Vec<f64>>,
) -> Option<Vec<Slot>> {
    let narrow: Vec<Vec<f32>> = arguments.iter().map(|a| a.iter().map(|s| f32::from_bits(s.bits)).collect()).collect();
    let wide: Vec<Vec<f64>> = arguments.iter().map(|a| a.iter().map(|slot| slot.wide).collect()).collect();
    let (narrow, wide) = (f32(&narrow)?, f64(&wide)?);
    Some(narrow.iter().zip(wide).map(|(value, wide)| Slot { bits: value.to_bits(), from: KNOWN, wide }).collect())
}

fn dot<R: Real>(a: &[R], b: &[R]) -> R {
    let mut products = a.iter().zip(b).map(|(&a, &b)| a * b);
    let first = products.next().unwrap_or_default();
    products.fold(first, |sum, product| sum + product)
}

fn floats<R: Real>(fun: Fun, arguments: &[Vec<R>], rows: usize) -> Option<Vec<R>> {
    let argument = |index: usize| arguments.get(index).map(Vec::as_slice);
    let a = argument(0)?;
    let b = argument(1).unwrap_or_default();
    let each = |of: &dyn Fn(usize) -> R| (0..a.len()).map(of).collect::<Vec<R>>();
    let is_pair = a.len() == b.len();
    Some(match fun {
        Fun::Dot if is_pair => vec![dot(a, b)],
        Fun::Cross if is_pair => {
            let [x, y, z] = *a.as_array()?;
            let [u, v, w] = *b.as_array()?;
            vec![y * w - z * v, z * u - x * w, x * v - y * u]
        }
        Fun::Length => vec![dot(a, a).sqrt()],
        Fun::Distance if is_pair => {
            let between = each(&|i| a[i] - b[i]);
            vec![dot(&between, &between).sqrt()]
        }
        Fun::Normalize => {
            let length = dot(a, a).sqrt();
            each(&|i| a[i] / length)
        }
        Fun::FaceForward if is_pair => {
            let is_toward = dot(b, argument(2)?) < R::zero();
            each(&|i| if is_toward { a[i] } else { -a[i] })
        }
        Fun::Reflect if is_pair => {
            let twice = R::from_f32(2.0) * dot(b, a);
            each(&|i| a[i] - twice * b[i])
        }
        Fun::Refract if is_pair => {
            let ratio = *argument(2)?.first()?;
            let cosine = dot(b, a);
            let k = R::one() - ratio * ratio * (R::one() - cosine * cosine);
            let along = if k < R::zero() { R::zero() } else { ratio * cosine + k.sqrt() };
            each(&|i| if k < R::zero() { R::zero() } else { ratio * a[i] - along * b[i] })
        }
        Fun::Transpose if rows > 0 => {
            let columns = a.len() / rows;
            each(&|i| a[i % columns * rows + i / columns])
        }
        Fun::Determinant if rows > 0 => vec![determinant(a, rows)],
        // The fractions, then the whole parts.
        Fun::Modf => {
            let whole = each(&|i| if a[i] < R::zero() { -((-a[i]).floor()) } else { a[i].floor() });
            each(&|i| a[i] - whole[i]).into_iter().chain(whole.clone()).collect()
        }
        _ => return None,
    })
}

/// By the first row, as there are at most four.
fn determinant<R: Real>(matrix: &[R], side: usize) -> R {
    if side == 1 {
        return matrix.first().copied().unwrap_or_default();
    }
    let mut sum = R::zero();
    for column in 0..side {
        let of_column = |c: usize| matrix[c * side + 1..(c + 1) * side].iter().copied();
        let minor: Vec<R> = (0..side).filter(|&c| c != column).flat_map(of_column).collect();
        let product = matrix[column * side] * determinant(&minor, side - 1);
        sum = if column % 2 == 0 { sum + product } else { sum - product };
    }
    sum
}

fn products<R: Real>(arguments: &[Vec<R>], [rows, other]: [usize; 2]) -> Option<Vec<R>> {
    let [a, b]: &[Vec<R>; 2] = arguments.as_array()?;
    // A matrix by a column: a sum of its own columns.
    let by_column = |column: &[R]| -> Vec<R> {
        let across = |row: usize| a.iter().skip(row).step_by(rows).copied().collect::<Vec<R>>();
        (0..rows).map(|row| dot(&across(row), column)).collect()
    };
    match (rows, other) {
        (0, 0) => None,
        (0, other) => Some(b.chunks_exact(other).map(|column| dot(a, column)).collect()),
        (_, 0) => Some(by_column(b)),
        (_, other) => Some(b.chunks_exact(other).flat_map(by_column).collect()),
    }
}

/// Functions of a float that no kernel of ours has, computed in f64. `None` for one that is not supported.
pub(super) fn in_f64(fun: Fun, [x, y, z]: [f64; 3]) -> Option<f64> {
    Some(match fun {
        Fun::Saturate => x.clamp(0.0, 1.0),
        Fun::Cos => x.cos(),
        Fun::Cosh => x.cosh(),
        Fun::Sin => x.sin(),
        Fun::Sinh => x.sinh(),
        Fun::Tan => x.tan(),
        Fun::Tanh => x.tanh(),
        Fun::Acos => x.acos(),
        Fun::Asin => x.asin(),
        Fun::Atan => x.atan(),
        Fun::Atan2 => x.atan2(y),
        Fun::Asinh => x.asinh(),
        Fun::Acosh => x.acosh(),
        Fun::Atanh => x.atanh(),
        Fun::Radians => x.to_radians(),
        Fun::Degrees => x.to_degrees(),
        Fun::Round => x.round_ties_even(),
        Fun::Fract => x - x.floor(),
        Fun::Trunc => x.trunc(),
        Fun::Exp => x.exp(),
        Fun::Exp2 => x.exp2(),
        Fun::Log => x.ln(),
        Fun::Log2 => x.log2(),
        Fun::Pow => x.powf(y),
        Fun::InverseSqrt => 1.0 / x.sqrt(),
        Fun::Mix => x * (1.0 - z) + y * z,
        Fun::Step => f64::from(u8::from(y >= x)),
        Fun::SmoothStep => {
            let t = ((z - x) / (y - x)).clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t)
        }
        _ => return None,
    })
}
