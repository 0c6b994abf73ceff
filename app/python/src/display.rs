//! Pictures for notebooks: images and streams as PNG, in the window's colours.

use numpy::{PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use raystep_inspector::draw::stream::{Colors, state_color};
use raystep_kernels::programs::closest_hit::{states, streams::STREAMS};
use raystep_kernels::shared::constants::INF;
use raystep_kernels::tables::stream::Meaning;
use raystep_kernels::{Image, Stream};
use raystep_lab::layer_stats::{LayerStats, NONE, Others};
use raystep_lab::png;

use crate::border::detached;
use crate::error::OptionError;

/// The colour of values that are no numbers, or that stand for none.
const OTHER: [u8; 3] = [0x60, 0x60, 0x60];

/// Colours of a legend's scale.
const STOPS: usize = 16;

fn encoded(width: u32, height: u32, rgb: &[u8]) -> PyResult<Vec<u8>> {
    png::encode(width, height, rgb).map_err(|e| OptionError::new_err(format!("cannot encode as PNG: {e}")))
}

/// A linear image, H×W×4, as a PNG in sRGB.
#[pyfunction]
pub(crate) fn png_of_image<'py>(py: Python<'py>, image: PyReadonlyArray3<'py, f32>) -> PyResult<Bound<'py, PyBytes>> {
    let [height, width, 4] = *image.shape() else {
        return Err(OptionError::new_err("expected an image of shape (H, W, 4)"));
    };
    let values = image.as_slice().map_err(|_| OptionError::new_err("expected a contiguous array"))?;
    let pixels = values.as_chunks::<4>().0.to_vec();
    let bytes = detached(py, || {
        let image = Image { width: width as u32, height: height as u32, pixels };
        encoded(image.width, image.height, &image.to_srgb8())
    })?;
    Ok(PyBytes::new(py, &bytes))
}

/// A component's picture, the ends of its scale if it has one, the colours of the scale, and its other values in words.
type Drawn<'py> = (Bound<'py, PyBytes>, Option<(f64, f64)>, Vec<String>, Vec<String>);

/// A component of a stream, H×W bits, as a picture: states and ids in colours of their own, other values by a scale.
#[pyfunction]
pub(crate) fn draw_component<'py>(
    py: Python<'py>,
    stream: &str,
    layer: usize,
    bits: PyReadonlyArray2<'py, u32>,
) -> PyResult<Drawn<'py>> {
    let row = STREAMS.iter().find(|row| row.name == stream && layer < row.layers.len());
    let row =
        row.ok_or_else(|| OptionError::new_err(format!("{stream}: no such stream, or component {layer} of it")))?;
    let [height, width] = *bits.shape() else { return Err(OptionError::new_err("expected shape (H, W)")) };
    let values = bits.as_slice().map_err(|_| OptionError::new_err("expected a contiguous array"))?;
    let (bytes, span, scale, others) = detached(py, || {
        let stats = LayerStats::of(Stream::of(row), layer, values);
        let span = stats.span.as_ref().map(|span| (span.min, span.max));
        let meaning = row.meaning[layer];
        let rgb: Vec<u8> = values.iter().flat_map(|&bits| color(meaning, bits, span)).collect();
        let hex = |[r, g, b]: [u8; 3]| format!("#{r:02x}{g:02x}{b:02x}");
        let scale = colors(meaning)
            .map(|map| (0..STOPS).map(|i| hex(map.at(i as f64 / (STOPS - 1) as f64))).collect::<Vec<_>>());
        let span = span.filter(|_| scale.is_some());
        Ok((encoded(width as u32, height as u32, &rgb)?, span, scale.unwrap_or_default(), words(&stats.others)))
    })?;
    Ok((PyBytes::new(py, &bytes), span, scale, others))
}

/// The scale of a meaning; none for what has no order.
fn colors(meaning: Meaning) -> Option<Colors> {
    match meaning {
        Meaning::Float | Meaning::Light | Meaning::Count => Some(Colors::Viridis),
        Meaning::Distance => Some(Colors::Magma),
        Meaning::Id | Meaning::Tag => None,
    }
}

fn color(meaning: Meaning, bits: u32, span: Option<(f64, f64)>) -> [u8; 3] {
    let Some(map) = colors(meaning) else {
        return match meaning {
            Meaning::Tag => state_color(states::ALL, bits),
            _ if bits == NONE => OTHER,
            _ => {
                // Neighbouring ids get distant hues.
                let hue = f64::from(bits.wrapping_mul(0x9e37_79b9)) / f64::from(u32::MAX);
                Colors::Viridis.at(hue)
            }
        };
    };
    let (low, high) = span.unwrap_or_default();
    let value = if meaning.is_float() {
        let value = f32::from_bits(bits);
        if !value.is_finite() || value == INF {
            return OTHER;
        }
        f64::from(value)
    } else if bits == NONE {
        return OTHER;
    } else {
        f64::from(bits)
    };
    map.at(if high > low { (value - low) / (high - low) } else { 0.0 })
}

/// Values that have no place on the scale, in words.
fn words(others: &Others) -> Vec<String> {
    let all = match *others {
        Others::Float { nan, pos_inf, neg_inf, at_inf } => {
            vec![(nan, "NaN"), (pos_inf, "infinite"), (neg_inf, "−infinite"), (at_inf, "none")]
        }
        Others::Integer { none, .. } => vec![(none, "none")],
    };
    all.into_iter().filter(|(count, _)| *count > 0).map(|(count, name)| format!("{count} {name}")).collect()
}
