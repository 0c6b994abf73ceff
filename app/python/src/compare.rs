//! Two runs compared: the first pass after which they differ, and their streams and rays at the end.

use pollster::block_on;
use pyo3::prelude::*;
use raystep_inspector::runs::Picture;
use raystep_inspector::runs::differ::{Aspect, Counts, differences};
use raystep_kernels::tables::stream::StreamData;
use raystep_kernels::{Pass, RenderError, Renderer as Kernels, Stream};
use raystep_lab::compare::{CompareError, Comparison};
use serde_json::{Value, json};

use crate::border::{Watcher, detached};
use crate::error::OptionError;
use crate::renderer::Renderer;

/// What two runs have in common, and where they differ.
#[derive(Default)]
struct Found {
    /// Passes of the same kernel that were compared.
    compared: usize,
    first: Vec<Value>,
}

/// Runs both from their starts to their ends, and returns the tables `runs`, `first` and `streams` as JSON.
#[pyfunction]
pub(crate) fn compare(py: Python<'_>, a: &Renderer, b: &Renderer, callback: Option<Py<PyAny>>) -> PyResult<String> {
    let [size, other] = [a, b].map(|run| [run.plan.width, run.plan.height]);
    if size != other {
        return Err(OptionError::new_err(CompareError::Size(size, other).to_string()));
    }
    let mut runs = [a.another(py)?, b.another(py)?];
    detached(py, || {
        let mut watcher = Watcher::new(callback);
        let result = block_on(tables(&mut runs, &mut watcher));
        watcher.finish(result).map(|tables| tables.to_string())
    })
}

async fn tables(runs: &mut [Kernels; 2], watcher: &mut Watcher) -> Result<Value, RenderError> {
    let found = together(runs, watcher).await?;
    for run in runs.iter_mut() {
        run.run(|progress| watcher.tell(progress)).await?;
    }
    let [a, b] = &*runs;
    let mut streams = Vec::new();
    for stream in common(a, b) {
        let _ = watcher.ask();
        watcher.expect_calm(a)?;
        let (left, right) = (a.values(stream).await?, b.values(stream).await?);
        streams.extend(of_stream(&left, &right));
    }
    let pictures = [picture(a).await?, picture(b).await?];
    let counts = match pictures {
        [Some(a), Some(b)] => differences(&a, &b, Aspect::Triangle).map(|found| found.counts),
        _ => None,
    };
    Ok(json!({ "runs": [of_runs(a, b, &found, counts.as_ref())], "first": found.first, "streams": streams }))
}

/// Steps both as long as they run the same kernels and agree.
async fn together([a, b]: &mut [Kernels; 2], watcher: &mut Watcher) -> Result<Found, RenderError> {
    let mut found = Found::default();
    while a.next_kernel().is_some() && a.next_kernel() == b.next_kernel() {
        a.run_to(found.compared + 1, |progress| watcher.tell(progress)).await?;
        b.run_to(found.compared + 1, |_| std::ops::ControlFlow::Continue(())).await?;
        watcher.expect_calm(a)?;
        let Some(pass) = a.passes().get(found.compared).cloned() else { break };
        found.compared += 1;
        let plan = a.shared_plan();
        let written: Vec<Stream> =
            plan.variant(pass.kernel).into_iter().flat_map(|variant| variant.written_streams()).collect();
        for stream in written.into_iter().filter(|&stream| b.plan().has_stream(stream)) {
            let (left, right) = (a.values(stream).await?, b.values(stream).await?);
            found.first.extend(first_of(&pass, &left, &right));
        }
        if !found.first.is_empty() {
            break;
        }
    }
    Ok(found)
}

/// The streams that both have.
fn common(a: &Kernels, b: &Kernels) -> Vec<Stream> {
    a.plan().streams.iter().map(|planned| planned.what).filter(|&stream| b.plan().has_stream(stream)).collect()
}

/// A component's bits as a number.
fn number(stream: Stream, layer: usize, bits: u32) -> Value {
    if stream.is_float_layer(layer) { real(f32::from_bits(bits).into()) } else { json!(bits) }
}

/// A number, or text for one that JSON does not have.
fn real(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { json!(value.to_string()) }
}

/// A row for each component that differs after a pass, with the first ray that does.
fn first_of(pass: &Pass, left: &StreamData, right: &StreamData) -> Vec<Value> {
    let stream = left.stream;
    let Some(compared) = Comparison::new(left, right).ok().filter(|_| left.bits != right.bits) else {
        return Vec::new();
    };
    let row = |layer: usize| {
        let found = compared.layer(layer);
        let ray = found.first?;
        Some(json!({
            "pass": pass.index,
            "kernel": pass.kernel.name(),
            "stream": stream.name(),
            "component": stream.info().layers[layer],
            "x": ray % left.width as usize,
            "y": ray / left.width as usize,
            "a": number(stream, layer, left.get(layer, ray)),
            "b": number(stream, layer, right.get(layer, ray)),
            "rays": found.differing,
            "max_ulps": found.floats.map(|floats| floats.max_ulps),
        }))
    };
    (0..stream.layers()).filter_map(row).collect()
}

/// A row for each component of a stream.
fn of_stream(left: &StreamData, right: &StreamData) -> Vec<Value> {
    let stream = left.stream;
    let Ok(compared) = Comparison::new(left, right) else { return Vec::new() };
    let width = left.width as usize;
    let row = |layer: usize| {
        let found = compared.layer(layer);
        let floats = found.floats;
        json!({
            "stream": stream.name(),
            "component": stream.info().layers[layer],
            "rays": found.differing,
            "one_sided_rays": found.one_sided,
            "first_x": found.first.map(|ray| ray % width),
            "first_y": found.first.map(|ray| ray / width),
            "max_ulps": floats.map(|floats| floats.max_ulps),
            "median_ulps": floats.map(|floats| floats.median_ulps),
            "max_difference": floats.map(|floats| real(floats.largest)),
        })
    };
    (0..stream.layers()).map(row).collect()
}

/// The results of a run at its end.
async fn picture(run: &Kernels) -> Result<Option<Picture>, RenderError> {
    let Some(results) = run.plan().program.results else { return Ok(None) };
    let mut streams: Vec<StreamData> = Vec::new();
    for stream in [results.color, results.triangle.stream, results.t.stream] {
        if run.plan().has_stream(stream) && streams.iter().all(|data| data.stream != stream) {
            streams.push(run.values(stream).await?);
        }
    }
    Ok(Some(Picture { results, streams, t_scale: run.t_scale(0) }))
}

fn of_runs(a: &Kernels, b: &Kernels, found: &Found, counts: Option<&Counts>) -> Value {
    json!({
        "passes_a": a.pass_count(),
        "passes_b": b.pass_count(),
        "compared_passes": found.compared,
        "rays": a.plan().rays,
        "hit_or_miss_rays": counts.map(|counts| counts.hit_or_miss),
        "other_triangle_rays": counts.map(|counts| counts.triangle),
        "other_t_rays": counts.map(|counts| counts.t),
        "max_t_ulps": counts.map(|counts| counts.max_ulps),
        "max_t_difference": counts.map(|counts| real(counts.max_t)),
        "other_weights_rays": counts.map(|counts| counts.weights),
        "other_color_pixels": counts.map(|counts| counts.color),
        "max_color_difference": counts.map(|counts| real(counts.max_color.into())),
    })
}
