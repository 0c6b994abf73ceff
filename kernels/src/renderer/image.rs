//! The image: linear light in memory and EXR, sRGB in PNG.

use crate::numbers::srgb::linear_to_srgb;
use crate::shared::constants::NO_TRIANGLE;
use crate::tables::stream::StreamData;

/// A linear image, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// R G B in linear light; A is 1 if a ray hit something, else 0; with several samples, the share of rays that did.
    pub pixels: Vec<[f32; 4]>,
}

impl Image {
    pub(crate) fn from_streams(color: &StreamData, triangles: &[u32]) -> Self {
        let pixels = (0..color.width as usize * color.height as usize)
            .map(|i| {
                let alpha = if triangles[i] == NO_TRIANGLE { 0.0 } else { 1.0 };
                [color.get_f32(0, i), color.get_f32(1, i), color.get_f32(2, i), alpha]
            })
            .collect();
        Self { width: color.width, height: color.height, pixels }
    }

    /// From the mean of several samples.
    pub(crate) fn from_mean(mean: &StreamData) -> Self {
        let pixel = |i| [0, 1, 2, 3].map(|layer| mean.get_f32(layer, i));
        let pixels = (0..mean.width as usize * mean.height as usize).map(pixel).collect();
        Self { width: mean.width, height: mean.height, pixels }
    }

    /// R G B, 8 bits each, sRGB-encoded and clamped.
    #[must_use]
    pub fn to_srgb8(&self) -> Vec<u8> {
        let encode = |v: f32| (linear_to_srgb(v.clamp(0.0, 1.0)) * 255.0 + 0.5) as u8;
        self.pixels.iter().flat_map(|p| [encode(p[0]), encode(p[1]), encode(p[2])]).collect()
    }
}
