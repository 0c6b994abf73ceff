//! Twins for whole passes: the kernels' CPU reference functions, applied to an executor's streams.

use super::bound::CellBox;
use super::span::Span;
use crate::programs::primitives::{load, store};
use crate::scene_data::SceneData;
use crate::tables::texels::Columns;

pub(super) fn bound(columns: &mut dyn Columns, data: &SceneData) {
    let bounds: Vec<_> =
        data.vertices.chunks_exact(9).map(|t| super::bound::bound(t, &data.grid, data.growth)).collect();
    for axis in 0..3 {
        store(columns, "box", axis, bounds.iter().map(|(cells, _)| cells.low[axis]));
        store(columns, "box", axis + 3, bounds.iter().map(|(cells, _)| cells.high[axis]));
    }
    store(columns, "first_span", 0, bounds.iter().map(|&(_, spans)| spans));
}

/// The coordinates in three layers.
fn coordinates(columns: &dyn Columns, name: &str, first: usize) -> Vec<[u32; 3]> {
    let [x, y, z] = [0, 1, 2].map(|axis| load(columns, name, first + axis));
    x.into_iter().zip(y).zip(z).map(|((x, y), z)| [x, y, z]).collect()
}

pub(super) fn span(columns: &mut dyn Columns, data: &SceneData) {
    let (low, high) = (coordinates(columns, "box", 0), coordinates(columns, "box", 3));
    let boxes: Vec<_> = low.into_iter().zip(high).map(|(low, high)| CellBox { low, high }).collect();
    let first_span = load(columns, "first_span", 0);
    let count = load(columns, "mask", 0).len() as u32;
    let spans: Vec<Span> = (0..count)
        .map(|i| super::span::span(i, &first_span, &boxes, &data.grid, data.growth, &data.vertices))
        .collect();
    store(columns, "triangle", 0, spans.iter().map(|span| span.triangle));
    for axis in 0..3 {
        store(columns, "cells_at", axis, spans.iter().map(|span| span.cells_at[axis]));
    }
    store(columns, "mask", 0, spans.iter().map(|span| span.mask));
    store(columns, "first_reference", 0, spans.iter().map(|span| span.mask.count_ones()));
}

pub(super) fn emit(columns: &mut dyn Columns, data: &SceneData) {
    let (triangles, masks) = (load(columns, "triangle", 0), load(columns, "mask", 0));
    let cells = coordinates(columns, "cells_at", 0);
    let first = load(columns, "first_reference", 0);
    let mut out = [load(columns, "cell_out", 0), load(columns, "triangle_out", 0)];
    let [cell_out, triangle_out] = &mut out;
    for (((triangle, mask), cells_at), first) in triangles.into_iter().zip(masks).zip(cells).zip(first) {
        let span = Span { triangle, cells_at, mask };
        super::emit::emit(&span, first, data.build.cells, cell_out, triangle_out);
    }
    let [cell_out, triangle_out] = out;
    store(columns, "cell_out", 0, cell_out);
    store(columns, "triangle_out", 0, triangle_out);
}

pub(super) fn mark(columns: &mut dyn Columns, _: &SceneData) {
    let (mut begin, mut end) = (load(columns, "begin", 0), load(columns, "end", 0));
    super::mark::mark(&load(columns, "cell_in", 0), &mut begin, &mut end);
    store(columns, "begin", 0, begin);
    store(columns, "end", 0, end);
}

pub(super) fn measure(columns: &mut dyn Columns, _: &SceneData) {
    let mut start = load(columns, "start", 0);
    super::measure::measure(&load(columns, "begin", 0), &load(columns, "end", 0), &mut start);
    store(columns, "start", 0, start);
}
