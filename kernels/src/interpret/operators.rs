//! Operators and functions on scalars, as WGSL defines them; floats as the CPU reference kernels compute them.

use naga::{BinaryOperator as Op, MathFunction as Fun};

use super::code::{Kind, Slot};
use crate::numbers::real::Real;

fn float(value: f32, wide: f64) -> Slot {
    Slot { bits: value.to_bits(), from: 0, wide }
}

fn int(bits: u32) -> Slot {
    Slot { bits, from: 0, wide: 0.0 }
}

fn truth(holds: bool, holds_wide: bool) -> Slot {
    Slot { bits: holds.into(), from: 0, wide: f64::from(u8::from(holds_wide)) }
}

/// How a comparison is written; `None` for other operators.
pub(super) fn comparison(op: Op) -> Option<&'static str> {
    Some(match op {
        Op::Equal => "==",
        Op::NotEqual => "!=",
        Op::Less => "<",
        Op::LessEqual => "<=",
        Op::Greater => ">",
        Op::GreaterEqual => ">=",
        _ => return None,
    })
}

fn compare<T: PartialOrd>(op: Op, a: T, b: T) -> bool {
    match op {
        Op::Equal => a == b,
        Op::NotEqual => a != b,
        Op::Less => a < b,
        Op::LessEqual => a <= b,
        Op::Greater => a > b,
        _ => a >= b,
    }
}

/// `None` where WGSL has no such operator, or none that is supported.
pub(super) fn binary(op: Op, kind: Kind, [a, b]: [Slot; 2]) -> Option<Slot> {
    let is_comparison = comparison(op).is_some();
    Some(match kind {
        Kind::F32 => {
            let (x, y) = (f32::from_bits(a.bits), f32::from_bits(b.bits));
            match op {
                _ if is_comparison => truth(compare(op, x, y), compare(op, a.wide, b.wide)),
                Op::Add => float(x + y, a.wide + b.wide),
                Op::Subtract => float(x - y, a.wide - b.wide),
                Op::Multiply => float(x * y, a.wide * b.wide),
                Op::Divide => float(x / y, a.wide / b.wide),
                Op::Modulo => float(x % y, a.wide % b.wide),
                _ => return None,
            }
        }
        Kind::Bool => match op {
            Op::And | Op::LogicalAnd => truth(a.bits & b.bits != 0, a.wide * b.wide != 0.0),
            Op::InclusiveOr | Op::LogicalOr => truth(a.bits | b.bits != 0, a.wide + b.wide != 0.0),
            Op::Equal => truth(a.bits == b.bits, a.wide == b.wide),
            Op::NotEqual | Op::ExclusiveOr => truth(a.bits != b.bits, a.wide != b.wide),
            _ => return None,
        },
        Kind::U32 | Kind::I32 => integer(op, kind == Kind::I32, a.bits, b.bits, is_comparison)?,
    })
}

fn integer(op: Op, is_signed: bool, a: u32, b: u32, is_comparison: bool) -> Option<Slot> {
    let (x, y) = (a.cast_signed(), b.cast_signed());
    if is_comparison {
        let holds = if is_signed { compare(op, x, y) } else { compare(op, a, b) };
        return Some(truth(holds, holds));
    }
    Some(int(match op {
        Op::Add => a.wrapping_add(b),
        Op::Subtract => a.wrapping_sub(b),
        Op::Multiply => a.wrapping_mul(b),
        // WGSL: x / 0 is x, and so is the lowest integer by -1.
        Op::Divide if is_signed => if y == 0 { x } else { x.wrapping_div(y) }.cast_unsigned(),
        Op::Divide => a.checked_div(b).unwrap_or(a),
        Op::Modulo if is_signed => if y == 0 { 0 } else { x.wrapping_rem(y) }.cast_unsigned(),
        Op::Modulo => a.checked_rem(b).unwrap_or(0),
        Op::And => a & b,
        Op::ExclusiveOr => a ^ b,
        Op::InclusiveOr => a | b,
        Op::ShiftLeft => a.wrapping_shl(b),
        Op::ShiftRight if is_signed => x.wrapping_shr(b).cast_unsigned(),
        Op::ShiftRight => a.wrapping_shr(b),
        _ => return None,
    }))
}

/// `None` for a function that is not supported.
pub(super) fn math(fun: Fun, kind: Kind, [a, b, c]: [Slot; 3]) -> Option<Slot> {
    match kind {
        Kind::F32 => {
            let [x, y, z] = [a, b, c].map(|slot| f32::from_bits(slot.bits));
            let (value, wide) = (of_floats(fun, [x, y, z])?, of_floats(fun, [a.wide, b.wide, c.wide])?);
            Some(float(value, wide))
        }
        Kind::I32 => {
            let [x, y, z] = [a, b, c].map(|slot| slot.bits.cast_signed());
            let value = match fun {
                Fun::Abs => x.wrapping_abs(),
                Fun::Min => x.min(y),
                Fun::Max => x.max(y),
                Fun::Clamp => x.max(y).min(z),
                Fun::Sign => x.signum(),
                _ => return of_bits(fun, a.bits).map(int),
            };
            Some(int(value.cast_unsigned()))
        }
        Kind::U32 => Some(int(match fun {
            Fun::Abs => a.bits,
            Fun::Min => a.bits.min(b.bits),
            Fun::Max => a.bits.max(b.bits),
            Fun::Clamp => a.bits.max(b.bits).min(c.bits),
            Fun::FirstLeadingBit => a.bits.checked_ilog2().unwrap_or(u32::MAX),
            _ => return of_bits(fun, a.bits).map(int),
        })),
        Kind::Bool => None,
    }
}

fn of_floats<R: Real>(fun: Fun, [x, y, z]: [R; 3]) -> Option<R> {
    Some(match fun {
        Fun::Abs => x.abs(),
        Fun::Min => x.min(y),
        Fun::Max => x.max(y),
        Fun::Clamp => x.max(y).min(z),
        Fun::Floor => x.floor(),
        Fun::Ceil => -((-x).floor()),
        Fun::Round => rounded(x),
        Fun::Trunc if x < R::zero() => -((-x).floor()),
        Fun::Trunc => x.floor(),
        Fun::Fract => x - x.floor(),
        Fun::Saturate => x.max(R::zero()).min(R::one()),
        Fun::Step if x <= y => R::one(),
        Fun::Step => R::zero(),
        Fun::Mix => x * (R::one() - z) + y * z,
        Fun::InverseSqrt => R::one() / x.sqrt(),
        Fun::Sqrt => x.sqrt(),
        Fun::Fma => x.fused(y, z),
        Fun::Sign if x > R::zero() => R::one(),
        Fun::Sign if x < R::zero() => -R::one(),
        Fun::Sign => R::zero(),
        _ => return None,
    })
}

/// To the nearest integer, from halfway to the even one.
fn rounded<R: Real>(x: R) -> R {
    let (below, half) = (x.floor(), R::from_f32(0.5));
    let is_even = (below * half).floor() == below * half;
    if x - below < half || x - below == half && is_even { below } else { below + R::one() }
}

fn of_bits(fun: Fun, bits: u32) -> Option<u32> {
    Some(match fun {
        Fun::CountOneBits => bits.count_ones(),
        Fun::CountLeadingZeros => bits.leading_zeros(),
        Fun::CountTrailingZeros => bits.trailing_zeros(),
        Fun::ReverseBits => bits.reverse_bits(),
        Fun::FirstTrailingBit => {
            if bits == 0 {
                u32::MAX
            } else {
                bits.trailing_zeros()
            }
        }
        _ => return None,
    })
}

/// A conversion of the value, or of its bits.
pub(super) fn convert(slot: Slot, from: Kind, to: Kind, is_of_value: bool) -> Slot {
    if !is_of_value {
        let wide = match to {
            // Bits of a float that nothing has changed still have its shadow.
            Kind::F32 if slot.wide == 0.0 => f64::from(f32::from_bits(slot.bits)),
            _ => slot.wide,
        };
        return Slot { wide, ..slot };
    }
    let value = f32::from_bits(slot.bits);
    let (bits, wide) = match (from, to) {
        (Kind::F32, Kind::F32) | (Kind::Bool, Kind::Bool) => (slot.bits, slot.wide),
        (Kind::F32, Kind::U32) => (value as u32, 0.0),
        (Kind::F32, Kind::I32) => ((value as i32).cast_unsigned(), 0.0),
        (Kind::F32, Kind::Bool) => ((value != 0.0).into(), f64::from(u8::from(slot.wide != 0.0))),
        (Kind::U32, Kind::F32) => ((slot.bits as f32).to_bits(), f64::from(slot.bits)),
        (Kind::I32, Kind::F32) => {
            let value = slot.bits.cast_signed();
            ((value as f32).to_bits(), f64::from(value))
        }
        (Kind::Bool, Kind::F32) => ((slot.bits as f32).to_bits(), f64::from(slot.bits)),
        (_, Kind::Bool) => (u32::from(slot.bits != 0), f64::from(u8::from(slot.bits != 0))),
        (_, Kind::U32 | Kind::I32) => (slot.bits, 0.0),
    };
    Slot { bits, wide, ..slot }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_are_rounded_and_mixed_as_wgsl_says() {
        let told = |fun, values| of_floats::<f32>(fun, values).expect("a function");
        let rounded = [-1.5f32, -0.5, 0.4, 0.5, 1.5, 2.5, 2.6].map(|x| told(Fun::Round, [x, 0.0, 0.0]));
        assert_eq!(rounded, [-2.0, 0.0, 0.0, 0.0, 2.0, 2.0, 3.0]);
        assert_eq!([-1.7f32, 1.7].map(|x| told(Fun::Trunc, [x, 0.0, 0.0])), [-1.0, 1.0]);
        assert_eq!(told(Fun::Fract, [-0.25, 0.0, 0.0]), 0.75);
        assert_eq!([-1.0f32, 0.5, 2.0].map(|x| told(Fun::Saturate, [x, 0.0, 0.0])), [0.0, 0.5, 1.0]);
        assert_eq!([told(Fun::Step, [1.0, 1.0, 0.0]), told(Fun::Step, [1.0, 0.9, 0.0])], [1.0, 0.0]);
        assert_eq!(told(Fun::Mix, [2.0, 4.0, 0.25]), 2.5);
        assert_eq!(told(Fun::InverseSqrt, [4.0, 0.0, 0.0]), 0.5);
    }
}
