//! Pictures as PNG files.

use std::io::Cursor;

use image::codecs::png::PngEncoder;
use image::error::{ParameterError, ParameterErrorKind};
use image::{ExtendedColorType, ImageEncoder as _, ImageError};

/// A PNG of `rgb`: 8 bits a channel, rows from the top.
///
/// # Errors
/// If there are not 3 `width` × `height` bytes, or none.
pub fn encode(width: u32, height: u32, rgb: &[u8]) -> Result<Vec<u8>, ImageError> {
    // The encoder panics. Three times the square of the largest side is more than 64 bits hold.
    if rgb.len() as u128 != 3 * u128::from(width) * u128::from(height) {
        return Err(ImageError::Parameter(ParameterError::from_kind(ParameterErrorKind::DimensionMismatch)));
    }
    let mut file = Cursor::new(Vec::new());
    PngEncoder::new(&mut file).write_image(rgb, width, height, ExtendedColorType::Rgb8)?;
    Ok(file.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_come_back_and_other_numbers_of_them_are_refused() {
        let rgb: Vec<u8> = (0..18).map(|i| i * 14).collect();
        let file = encode(3, 2, &rgb).expect("a picture");
        let read = image::load_from_memory(&file).expect("a PNG").to_rgb8();
        assert_eq!((read.width(), read.height(), read.into_raw()), (3, 2, rgb.clone()));
        assert!(encode(2, 2, &rgb).is_err() && encode(u32::MAX, u32::MAX, &rgb).is_err());
    }
}
