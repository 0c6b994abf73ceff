//! A ray as text: six numbers, decimal or bits.

/// The text is not a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RayTextError {
    /// Not six numbers.
    #[error("expected six numbers separated by commas, decimal or hex bits such as 0x3f800000")]
    NotSix,
    /// A number is not finite, or the direction has no length.
    #[error("expected finite numbers, and a direction other than 0")]
    NoRay,
}

/// Origin and direction of a ray: `ox,oy,oz,dx,dy,dz`, each decimal or the bits of an f32 in hex.
///
/// # Errors
/// Where the text is not that.
pub fn parse(text: &str) -> Result<[f32; 6], RayTextError> {
    let number = |text: &str| match text.trim().strip_prefix("0x") {
        Some(bits) => u32::from_str_radix(bits, 16).ok().map(f32::from_bits),
        None => text.trim().parse::<f32>().ok(),
    };
    let numbers: Option<Vec<f32>> = text.split(',').map(number).collect();
    let ray: [f32; 6] = numbers.and_then(|n| n.try_into().ok()).ok_or(RayTextError::NotSix)?;
    let is_ray = ray.iter().all(|v| v.is_finite()) && ray[3..].iter().any(|&v| v != 0.0);
    if is_ray { Ok(ray) } else { Err(RayTextError::NoRay) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_and_bits_are_read_and_nothing_else() {
        assert_eq!(parse("0, 1,2.5,0x40a00000,-0,1e-3"), Ok([0.0, 1.0, 2.5, 5.0, -0.0, 1e-3]));
        for text in ["", "1,2,3", "1,2,3,4,5,x", "0xzz,0,0,0,0,1", "1,2,3,4,5,6,7"] {
            assert_eq!(parse(text), Err(RayTextError::NotSix), "{text}");
        }
        for text in ["0,0,0,0,0,0", "inf,0,0,0,0,1", "0,0,0,0,0,0x7fc00000"] {
            assert_eq!(parse(text), Err(RayTextError::NoRay), "{text}");
        }
    }
}
