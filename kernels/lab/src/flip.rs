//! How different two pictures look: the metric FLIP for a pair of low-dynamic-range images (Andersson, Nilsson,
//! Akenine-Möller, Oskarsson, Åström and Fairchild, *FLIP: A Difference Evaluator for Alternating Images*, 2020), and the
//! plain errors RMSE and MAE.

use std::f64::consts::PI;

/// Pixels per degree of visual angle, as the authors propose: a display 0.7 m wide with 3,840 pixels, 0.7 m away.
pub const PIXELS_PER_DEGREE: f64 = 67.020_643_276_58;

/// Plain errors of channels, in linear light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// Root of the mean square difference.
    pub rmse: f64,
    /// Mean absolute difference.
    pub mae: f64,
}

/// The plain errors of two pictures in linear light; `None` if they differ in size, are empty, or are not finite.
#[must_use]
pub fn errors(reference: &[[f32; 3]], test: &[[f32; 3]]) -> Option<Errors> {
    are_sound([reference, test], reference.len()).then(|| {
        let pairs = reference.as_flattened().iter().zip(test.as_flattened());
        let apart = pairs.map(|(a, b)| (f64::from(*a) - f64::from(*b)).abs());
        let (squares, sum) = apart.fold((0.0, 0.0), |(squares, sum), d| (squares + d * d, sum + d));
        let channels = 3.0 * reference.len() as f64;
        Errors { rmse: (squares / channels).sqrt(), mae: sum / channels }
    })
}

/// FLIP of each pixel, from 0 (no visible difference) to 1, row by row. The pictures are in linear light; a display clamps
/// them to 0 to 1. `None` if a picture has not `width` × `height` pixels, or one is not finite.
#[must_use]
pub fn flip(reference: &[[f32; 3]], test: &[[f32; 3]], size: [usize; 2]) -> Option<Vec<f32>> {
    let count = size[0].checked_mul(size[1])?;
    let pictures = [reference, test];
    are_sound(pictures, count).then(|| flip_map(pictures.map(displayed), size, PIXELS_PER_DEGREE))
}

fn are_sound(pictures: [&[[f32; 3]]; 2], count: usize) -> bool {
    let is_finite = |picture: &[[f32; 3]]| picture.as_flattened().iter().all(|value| value.is_finite());
    count > 0 && pictures.iter().all(|picture| picture.len() == count && is_finite(picture))
}

/// What a display shows.
fn displayed(picture: &[[f32; 3]]) -> Vec<Vec3> {
    picture.iter().map(|pixel| pixel.map(|value| f64::from(value.clamp(0.0, 1.0)))).collect()
}

type Vec3 = [f64; 3];

/// The white of D65, in CIE XYZ.
const WHITE: Vec3 = [0.950_428_545_377, 1.0, 1.088_900_370_798];
const TO_XYZ: [Vec3; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

fn xyz(rgb: Vec3) -> Vec3 {
    TO_XYZ.map(|row| row.iter().zip(rgb).map(|(a, b)| a * b).sum())
}

/// From CIE XYZ to linear light, by Cramer's rule.
fn rgb(xyz: Vec3) -> Vec3 {
    let [a, b, c] = TO_XYZ;
    let cross = |a: Vec3, b: Vec3| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let [x, y, z] = [cross(b, c), cross(c, a), cross(a, b)];
    let determinant: f64 = a.iter().zip(x).map(|(a, b)| a * b).sum();
    [0, 1, 2].map(|i| (x[i] * xyz[0] + y[i] * xyz[1] + z[i] * xyz[2]) / determinant)
}

/// A linear space of opponents: luminance, red against green, blue against yellow.
fn opponents(rgb: Vec3) -> Vec3 {
    let [x, y, z] = {
        let v = xyz(rgb);
        [v[0] / WHITE[0], v[1] / WHITE[1], v[2] / WHITE[2]]
    };
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn from_opponents([l, c, h]: Vec3) -> Vec3 {
    let y = (l + 16.0) / 116.0;
    rgb([(y + c / 500.0) * WHITE[0], y * WHITE[1], (y - h / 200.0) * WHITE[2]])
}

/// CIELab, with chroma scaled by lightness (Hunt's effect): dark colours look less colourful.
fn lab(rgb: Vec3) -> Vec3 {
    let f = |t: f64| {
        const D: f64 = 6.0 / 29.0;
        if t > D * D * D { t.cbrt() } else { t / (3.0 * D * D) + 4.0 / 29.0 }
    };
    let v = xyz(rgb);
    let [x, y, z] = [0, 1, 2].map(|i| f(v[i] / WHITE[i]));
    let l = 116.0 * y - 16.0;
    [l, 0.01 * l * 500.0 * (x - y), 0.01 * l * 200.0 * (y - z)]
}

/// HyAB: lightness and chroma add up.
fn hyab(a: Vec3, b: Vec3) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// A plane of the picture, row by row.
struct Plane<'a> {
    values: &'a [f64],
    size: [usize; 2],
}

impl Plane<'_> {
    /// Convolved with one kernel along rows and with one along columns; the border is repeated.
    fn filtered(&self, along_x: &[f64], along_y: &[f64]) -> Vec<f64> {
        let [width, height] = self.size;
        let half = along_x.len() / 2;
        let near = |at: usize, tap: usize, end: usize| (at + tap).saturating_sub(half).min(end - 1);
        let rows = self.values.chunks_exact(width).flat_map(|row| {
            (0..width).map(move |x| along_x.iter().enumerate().map(|(i, w)| w * row[near(x, i, width)]).sum::<f64>())
        });
        let rows: Vec<f64> = rows.collect();
        let column = |x: usize, y: usize| {
            along_y.iter().enumerate().map(|(i, w)| w * rows[near(y, i, height) * width + x]).sum::<f64>()
        };
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| column(x, y)).collect()
    }
}

/// A Gaussian of the contrast sensitivity function as a kernel along one axis, not normalised.
fn gaussian(b: f64, radius: i32, ppd: f64) -> Vec<f64> {
    (-radius..=radius).map(|i| (-(PI * f64::from(i) / ppd).powi(2) / b).exp()).collect()
}

/// What is seen of each channel of opponents: the contrast sensitivity functions (their weights a and widths b, from the
/// paper's table 1), as separable Gaussians.
const SENSITIVITY: [[[f64; 2]; 2]; 3] =
    [[[1.0, 0.0047], [0.0, 1e-5]], [[1.0, 0.0053], [0.0, 1e-5]], [[34.1, 0.04], [13.5, 0.025]]];

/// The picture as it is seen: filtered, in the space of colour differences.
fn seen(opponents: &[Vec<f64>; 3], size: [usize; 2], ppd: f64) -> Vec<Vec3> {
    let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * ppd).ceil() as i32;
    let filtered = [0, 1, 2].map(|channel| {
        let plane = Plane { values: &opponents[channel], size };
        let mut sum = vec![0.0; plane.values.len()];
        let mut weight = 0.0;
        for [a, b] in SENSITIVITY[channel].into_iter().filter(|[a, _]| *a > 0.0) {
            let kernel = gaussian(b, radius, ppd);
            let height = a * (PI / b).sqrt();
            weight += height * kernel.iter().sum::<f64>().powi(2);
            let part = plane.filtered(&kernel, &kernel);
            sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += height * part);
        }
        sum.iter_mut().for_each(|value| *value /= weight);
        sum
    });
    let pixel = |i: usize| from_opponents([0, 1, 2].map(|channel| filtered[channel][i]));
    (0..filtered[0].len()).map(|i| lab(pixel(i).map(|value| value.clamp(0.0, 1.0)))).collect()
}

/// Edges and points of the luminance, as the lengths of its first and second derivatives.
fn features(luminance: &[f64], size: [usize; 2], ppd: f64) -> [Vec<f64>; 2] {
    /// Width of what is detected, in degrees.
    const WIDTH: f64 = 0.082;
    let deviation = 0.5 * WIDTH * ppd;
    let radius = (3.0 * deviation).ceil() as i32;
    let axis = || (-radius..=radius).map(f64::from);
    let bell: Vec<f64> = axis().map(|x| (-x * x / (2.0 * deviation * deviation)).exp()).collect();
    let first: Vec<f64> = axis().zip(&bell).map(|(x, g)| -x * g).collect();
    let square = deviation * deviation;
    let second: Vec<f64> = axis().zip(&bell).map(|(x, g)| (x * x / square - 1.0) * g).collect();
    let total: f64 = bell.iter().sum();
    let smooth: Vec<f64> = bell.iter().map(|g| g / total).collect();
    let plane = Plane { values: luminance, size };
    [first, second].map(|mut kernel| {
        // Positive weights sum to 1, negative ones to −1.
        let sums = [1.0, -1.0].map(|sign| kernel.iter().map(|k| (sign * k).max(0.0)).sum::<f64>());
        kernel.iter_mut().for_each(|k| *k /= if *k > 0.0 { sums[0] } else { sums[1] });
        let (x, y) = (plane.filtered(&kernel, &smooth), plane.filtered(&smooth, &kernel));
        x.iter().zip(y).map(|(x, y)| x.hypot(y)).collect()
    })
}

fn flip_map(pictures: [Vec<Vec3>; 2], size: [usize; 2], ppd: f64) -> Vec<f32> {
    /// The exponent of colour differences, and the part of them that is spread over most of the range, and how much.
    const EXPONENT: f64 = 0.7;
    const PART: f64 = 0.4;
    const SPREAD: f64 = 0.95;
    let sides = pictures.map(|picture| {
        let pixels: Vec<Vec3> = picture.iter().map(|&rgb| opponents(rgb)).collect();
        let opponents: [Vec<f64>; 3] = [0, 1, 2].map(|i| pixels.iter().map(|pixel| pixel[i]).collect());
        let luminance: Vec<f64> = opponents[0].iter().map(|l| (l + 16.0) / 116.0).collect();
        (seen(&opponents, size, ppd), features(&luminance, size, ppd))
    });
    let [(a, [edges_a, points_a]), (b, [edges_b, points_b])] = sides;
    let most = hyab(lab([0.0, 1.0, 0.0]), lab([0.0, 0.0, 1.0])).powf(EXPONENT);
    let limit = PART * most;
    let pixel = |i: usize| {
        let color = hyab(a[i], b[i]).powf(EXPONENT);
        let color = if color < limit {
            SPREAD / limit * color
        } else {
            SPREAD + (color - limit) / (most - limit) * (1.0 - SPREAD)
        };
        let feature = (edges_a[i] - edges_b[i]).abs().max((points_a[i] - points_b[i]).abs());
        let feature = (feature / 2.0_f64.sqrt()).sqrt();
        color.powf(1.0 - feature) as f32
    };
    (0..a.len()).map(pixel).collect()
}

#[cfg(test)]
mod tests;
