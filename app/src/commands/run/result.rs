//! The result of a program as a file.

use std::fmt::Write as _;
use std::path::Path;

use raystep_inspector::draw::stream::{Colors, Meaning, state_color};
use raystep_kernels::export::npy;
use raystep_kernels::programs::own::{Colours, OwnResult};
use raystep_kernels::scene_data::linear_to_srgb;
use raystep_kernels::tables::elements::Count;
use raystep_kernels::tables::state::States;
use raystep_kernels::{StreamData, tables};
use raystep_lab::plots::{Axis, Draw as _, Format, Mark, Plot, Scale, Series};
use raystep_lab::png;

use crate::commands::extension;
use crate::error::Error;

/// Most elements of a plot.
const MOST_POINTS: usize = 1 << 16;

/// A stream's values as a file with this ending; `elements` are in the set, the other texels hold none.
pub(super) fn file(
    path: &Path,
    data: &StreamData,
    elements: u32,
    shown: Option<&OwnResult>,
    states: States,
) -> Result<Vec<u8>, Error> {
    let failed = |error: &dyn std::fmt::Display| Error::failed(error.to_string());
    match extension(path).as_str() {
        "png" => picture(data, shown, states),
        "svg" => plot(data, elements as usize, shown),
        "csv" => Ok(table(data, elements as usize).into_bytes()),
        _ => {
            let mut bytes = Vec::new();
            npy::write_stream(&mut bytes, data).map_err(|error| failed(&error))?;
            Ok(bytes)
        }
    }
}

/// A number of a layer.
fn number(data: &StreamData, layer: usize, element: usize) -> f64 {
    match data.stream.is_float_layer(layer) {
        true => data.get_f32(layer, element).into(),
        false => data.get(layer, element).into(),
    }
}

/// The smallest and the largest finite number of a layer, or those that are given; never the same.
fn range(data: &StreamData, layer: usize, elements: usize, shown: Option<&OwnResult>) -> [f64; 2] {
    if let Some(range) = shown.and_then(|shown| shown.range) {
        return range;
    }
    let numbers = (0..elements).map(|element| number(data, layer, element)).filter(|n| n.is_finite());
    let [low, high] = numbers.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], n| [low.min(n), high.max(n)]);
    if low < high { [low, high] } else { [low.min(0.0), low.max(0.0) + 1.0] }
}

fn picture(data: &StreamData, shown: Option<&OwnResult>, states: States) -> Result<Vec<u8>, Error> {
    if data.stream.info().elements.count != Count::Image {
        return Err(Error::usage(
            "-o: the elements of the result are not the pixels of an image: choose .svg, .csv or .npy",
        ));
    }
    let layer = shown.and_then(|shown| shown.layer);
    let texels = data.width as usize * data.height as usize;
    let colors = match shown.map(|shown| shown.colours).unwrap_or_default() {
        Colours::Gray => Colors::Gray,
        Colours::Viridis => Colors::Viridis,
        Colours::Cividis => Colors::Cividis,
        Colours::Magma => Colors::Magma,
    };
    let meaning = Meaning::of(data.stream, layer);
    let at = layer.unwrap_or(0);
    let [low, high] = if meaning == Meaning::Color { [0.0, 1.0] } else { range(data, at, texels, shown) };
    let pixel = |texel: usize| match meaning {
        Meaning::Color => {
            [0, 1, 2].map(|layer| (linear_to_srgb(data.get_f32(layer, texel).clamp(0.0, 1.0)) * 255.0).round() as u8)
        }
        Meaning::Tag => state_color(states, data.get(at, texel)),
        _ => colors.at((number(data, at, texel) - low) / (high - low)),
    };
    let rgb: Vec<u8> = (0..texels).flat_map(pixel).collect();
    png::encode(data.width, data.height, &rgb).map_err(|error| Error::failed(error.to_string()))
}

fn plot(data: &StreamData, elements: usize, shown: Option<&OwnResult>) -> Result<Vec<u8>, Error> {
    if elements > MOST_POINTS {
        return Err(Error::usage(format!(
            "-o: a plot has at most {MOST_POINTS} elements, and the result {elements}: choose .csv or .npy"
        )));
    }
    let info: &tables::stream::StreamInfo = data.stream.info();
    let layers: Vec<usize> =
        shown.and_then(|shown| shown.layer).map_or((0..data.stream.layers()).collect(), |layer| vec![layer]);
    let line = |(color, &layer): (usize, &usize)| {
        let points = (0..elements).map(|element| (element as f64, number(data, layer, element))).collect();
        let name = if layers.len() > 1 { info.layers[layer] } else { "" };
        Series { mark: Mark::None, ..Series::line(name, color, points) }
    };
    let series: Vec<Series> = layers.iter().enumerate().map(line).collect();
    let plot =
        Plot::new(info.name, Axis::new(info.elements.name, Scale::Linear), Axis::new(info.unit, Scale::Linear), series);
    let picture =
        plot.picture(Format::Screen).ok_or_else(|| Error::failed("the result has no finite number to plot"))?;
    Ok(picture.svg().into_bytes())
}

fn table(data: &StreamData, elements: usize) -> String {
    let info = data.stream.info();
    let is_image = info.elements.count == Count::Image;
    let mut text = if is_image { "x,y".to_owned() } else { "element".to_owned() };
    info.layers.iter().for_each(|layer| text += &format!(",{layer}"));
    text.push('\n');
    for element in 0..elements {
        match is_image {
            true => _ = write!(text, "{},{}", element % data.width as usize, element / data.width as usize),
            false => _ = write!(text, "{element}"),
        }
        for layer in 0..info.layers.len() {
            match data.stream.is_float_layer(layer) {
                true => _ = write!(text, ",{}", data.get_f32(layer, element)),
                false => _ = write!(text, ",{}", data.get(layer, element)),
            }
        }
        text.push('\n');
    }
    text
}
