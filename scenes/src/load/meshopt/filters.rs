//! Filters, which turn decompressed elements into those that accessors expect.

use super::Problem;

/// Applies a filter to all elements of `stride` bytes.
pub(super) fn apply(name: &str, stride: usize, elements: &mut [u8]) -> Result<(), Problem> {
    match (name, stride) {
        ("NONE", _) => {}
        ("EXPONENTIAL", _) => each(elements, exponential),
        ("OCTAHEDRAL", 4) => each(elements, |e: [u8; 4]| bytes(octahedral(e.map(|c| f32::from(c as i8)), 127.0))),
        ("OCTAHEDRAL", 8) => each(elements, |e| words(octahedral(signed(e).map(f32::from), 32767.0))),
        ("QUATERNION", 8) => each(elements, |e| words(quaternion(signed(e)))),
        ("COLOR", 4) => each(elements, |e: [u8; 4]| {
            bytes(color([i32::from(e[0]), i32::from(e[1] as i8), i32::from(e[2] as i8), i32::from(e[3])], 255.0))
        }),
        ("COLOR", 8) => each(elements, |e| {
            let [y, co, cg, a] = signed(e);
            words(color([i32::from(y as u16), i32::from(co), i32::from(cg), i32::from(a as u16)], 65535.0))
        }),
        _ => return Err("its filter is unknown, or not for elements of this size"),
    }
    Ok(())
}

fn each<const N: usize>(elements: &mut [u8], filter: impl Fn([u8; N]) -> [u8; N]) {
    for element in elements.as_chunks_mut::<N>().0 {
        *element = filter(*element);
    }
}

fn signed([a, b, c, d, e, f, g, h]: [u8; 8]) -> [i16; 4] {
    [[a, b], [c, d], [e, f], [g, h]].map(i16::from_le_bytes)
}

/// The low bytes; what is out of range, which only a wrong file has, wraps.
fn bytes(values: [i32; 4]) -> [u8; 4] {
    values.map(|value| value as u8)
}

fn words(values: [i32; 4]) -> [u8; 8] {
    let [[a, b], [c, d], [e, f], [g, h]] = values.map(|value| (value as u16).to_le_bytes());
    [a, b, c, d, e, f, g, h]
}

/// 2 to the power of the high byte, times the other three.
fn exponential(element: [u8; 4]) -> [u8; 4] {
    let value = i32::from_le_bytes(element);
    // Exponents beyond ±100 are not allowed; f64 holds them, too.
    let scaled = f64::from(value << 8 >> 8) * f64::from(value >> 24).exp2();
    (scaled as f32).to_le_bytes()
}

/// A unit vector from its projection to an octahedron; the third component is 1 in the same units.
fn octahedral([x, y, one, rest]: [f32; 4], most: f32) -> [i32; 4] {
    let (x, y) = (x / one, y / one);
    let z = 1.0 - x.abs() - y.abs();
    // The lower half is folded outwards.
    let fold = z.min(0.0);
    let (x, y) = (x - fold.copysign(x), y - fold.copysign(y));
    let length = (x * x + y * y + z * z).sqrt();
    let [x, y, z] = [x, y, z].map(|c| (c / length * most).round() as i32);
    [x, y, z, rest as i32]
}

/// A unit quaternion from its three smaller components; the fourth is 1 in the same units, and in its two lowest bits
/// says which is left out.
fn quaternion([x, y, z, one]: [i16; 4]) -> [i32; 4] {
    let left_out = usize::from(one as u16 & 3);
    let unit = f32::from(one | 3);
    let [x, y, z] = [x, y, z].map(|c| f32::from(c) / unit * std::f32::consts::FRAC_1_SQRT_2);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let mut out = [w, x, y, z].map(|c| (c * 32767.0).round() as i32);
    out.rotate_right(left_out);
    out
}

/// Red, green, blue and alpha from luma, two chroma differences, and alpha, whose highest bit tells how many bits all
/// have.
fn color([y, co, cg, a]: [i32; 4], most: f32) -> [i32; 4] {
    let all = (1_i32 << (32 - a.leading_zeros())) - 1;
    let alpha = a & (all >> 1);
    let alpha = alpha << 1 | (alpha & 1);
    let scale = most / all as f32;
    [y + co - cg, y + cg, y - co - cg, alpha].map(|c| (c as f32 * scale).round() as i32)
}
