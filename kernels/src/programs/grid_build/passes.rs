//! Twins for whole passes: the kernels' CPU reference functions, applied to an executor's streams.

use super::bound::CellBox;
use super::span::Span;
use crate::program::Kernel;
use crate::scene_data::SceneData;
use crate::tables::stream::Stream;
use crate::tables::texels::Columns;

/// The stream bound to a name in the kernel's WGSL.
fn stream(kernel: Kernel, name: &str) -> Option<Stream> {
    kernel.program().stream(kernel.bound(name))
}

fn layers(kernel: Kernel, name: &str) -> usize {
    stream(kernel, name).map_or(0, Stream::layers)
}

/// All values of a layer.
fn load(columns: &dyn Columns, kernel: Kernel, name: &str, layer: usize) -> Vec<u32> {
    let Some(stream) = stream(kernel, name) else { return Vec::new() };
    (0..columns.len(stream)).map(|element| columns.load(stream, layer, element)).collect()
}

fn store(columns: &mut dyn Columns, kernel: Kernel, name: &str, layer: usize, values: impl IntoIterator<Item = u32>) {
    let Some(stream) = stream(kernel, name) else { return };
    for (element, value) in values.into_iter().enumerate() {
        columns.store(stream, layer, element, value);
    }
}

pub(super) fn bound(columns: &mut dyn Columns, kernel: Kernel, data: &SceneData) {
    let bounds: Vec<_> =
        data.vertices.chunks_exact(9).map(|t| super::bound::bound(t, &data.grid, data.growth)).collect();
    for axis in 0..3 {
        store(columns, kernel, "box", axis, bounds.iter().map(|(cells, _)| cells.low[axis]));
        store(columns, kernel, "box", axis + 3, bounds.iter().map(|(cells, _)| cells.high[axis]));
    }
    store(columns, kernel, "first_span", 0, bounds.iter().map(|&(_, spans)| spans));
}

pub(super) fn scan(columns: &mut dyn Columns, kernel: Kernel, _: &SceneData) {
    for layer in 0..layers(kernel, "values") {
        let (mut values, mut sums) = (load(columns, kernel, "values", layer), load(columns, kernel, "sums", layer));
        super::scan::scan(&mut values, &mut sums);
        store(columns, kernel, "values", layer, values);
        store(columns, kernel, "sums", layer, sums);
    }
}

pub(super) fn add(columns: &mut dyn Columns, kernel: Kernel, _: &SceneData) {
    for layer in 0..layers(kernel, "values") {
        let mut values = load(columns, kernel, "values", layer);
        super::add::add(&mut values, &load(columns, kernel, "sums", layer));
        store(columns, kernel, "values", layer, values);
    }
}

/// The coordinates in three layers.
fn coordinates(columns: &dyn Columns, kernel: Kernel, name: &str, first: usize) -> Vec<[u32; 3]> {
    let [x, y, z] = [0, 1, 2].map(|axis| load(columns, kernel, name, first + axis));
    x.into_iter().zip(y).zip(z).map(|((x, y), z)| [x, y, z]).collect()
}

pub(super) fn span(columns: &mut dyn Columns, kernel: Kernel, data: &SceneData) {
    let (low, high) = (coordinates(columns, kernel, "box", 0), coordinates(columns, kernel, "box", 3));
    let boxes: Vec<_> = low.into_iter().zip(high).map(|(low, high)| CellBox { low, high }).collect();
    let first_span = load(columns, kernel, "first_span", 0);
    let count = load(columns, kernel, "mask", 0).len() as u32;
    let spans: Vec<Span> = (0..count)
        .map(|i| super::span::span(i, &first_span, &boxes, &data.grid, data.growth, &data.vertices))
        .collect();
    store(columns, kernel, "triangle", 0, spans.iter().map(|span| span.triangle));
    for axis in 0..3 {
        store(columns, kernel, "cells_at", axis, spans.iter().map(|span| span.cells_at[axis]));
    }
    store(columns, kernel, "mask", 0, spans.iter().map(|span| span.mask));
    store(columns, kernel, "first_reference", 0, spans.iter().map(|span| span.mask.count_ones()));
}

pub(super) fn emit(columns: &mut dyn Columns, kernel: Kernel, data: &SceneData) {
    let (triangles, masks) = (load(columns, kernel, "triangle", 0), load(columns, kernel, "mask", 0));
    let cells = coordinates(columns, kernel, "cells_at", 0);
    let first = load(columns, kernel, "first_reference", 0);
    let mut out = [load(columns, kernel, "cell_out", 0), load(columns, kernel, "triangle_out", 0)];
    let [cell_out, triangle_out] = &mut out;
    for (((triangle, mask), cells_at), first) in triangles.into_iter().zip(masks).zip(cells).zip(first) {
        let span = Span { triangle, cells_at, mask };
        super::emit::emit(&span, first, data.build.cells, cell_out, triangle_out);
    }
    let [cell_out, triangle_out] = out;
    store(columns, kernel, "cell_out", 0, cell_out);
    store(columns, kernel, "triangle_out", 0, triangle_out);
}

pub(super) fn histogram(columns: &mut dyn Columns, kernel: Kernel, _: &SceneData) {
    let mut tally = load(columns, kernel, "tally", 0);
    super::histogram::histogram(columns.parameter(), &load(columns, kernel, "cell_in", 0), &mut tally);
    store(columns, kernel, "tally", 0, tally);
}

pub(super) fn scatter(columns: &mut dyn Columns, kernel: Kernel, _: &SceneData) {
    let (cells, triangles) = (load(columns, kernel, "cell_in", 0), load(columns, kernel, "triangle_in", 0));
    let tally = load(columns, kernel, "tally", 0);
    let (mut cell_out, mut triangle_out) = (cells.clone(), triangles.clone());
    let digit = columns.parameter();
    super::scatter::scatter(digit, &cells, &triangles, &tally, &mut cell_out, &mut triangle_out);
    store(columns, kernel, "cell_out", 0, cell_out);
    store(columns, kernel, "triangle_out", 0, triangle_out);
}

pub(super) fn mark(columns: &mut dyn Columns, kernel: Kernel, _: &SceneData) {
    let (mut begin, mut end) = (load(columns, kernel, "begin", 0), load(columns, kernel, "end", 0));
    super::mark::mark(&load(columns, kernel, "cell_in", 0), &mut begin, &mut end);
    store(columns, kernel, "begin", 0, begin);
    store(columns, kernel, "end", 0, end);
}

pub(super) fn measure(columns: &mut dyn Columns, kernel: Kernel, _: &SceneData) {
    let mut start = load(columns, kernel, "start", 0);
    super::measure::measure(&load(columns, kernel, "begin", 0), &load(columns, kernel, "end", 0), &mut start);
    store(columns, kernel, "start", 0, start);
}
