//! What each pass of a user's program has done to one element, and why: values before and after it, and the conditions that
//! its thread came to in the interpreter.

use raystep_kernels::interpret::pass::{Given, Pass};
use raystep_kernels::interpret::{InterpretError, Recording, SiteKind};
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::tables::elements::Count;
use raystep_kernels::tables::state::States;
use raystep_kernels::tables::stream::{Meaning, STATE_TAG};
use raystep_kernels::{Device, Kernel, Options, Plan, RenderError, Renderer, Stream, StreamData};
use serde::Serialize;

use crate::branch::branch;

/// A component that a pass has changed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// The stream.
    pub stream: &'static str,
    /// The layer.
    pub layer: &'static str,
    /// The value before.
    pub before: String,
    /// The value after.
    pub after: String,
}

/// A pass over the element.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ElementPass {
    /// The pass, from 0.
    pub pass: usize,
    /// Its kernel.
    pub kernel: &'static str,
    /// What has changed.
    pub changes: Vec<Change>,
    /// Conditions with their places, in the order of the file.
    pub why: Vec<String>,
    /// What the kernel has printed.
    pub noted: Vec<String>,
}

/// Why a history cannot be told.
#[derive(Debug, thiserror::Error)]
pub enum HistoryError {
    /// The device has failed.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A kernel cannot be interpreted.
    #[error("{place}: {why}")]
    Interpret {
        /// Where.
        place: String,
        /// Why.
        why: InterpretError,
    },
    /// There is no such element.
    #[error("the program has no element {x},{y}: {of} has {columns} columns and {rows} rows")]
    NoElement {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
        /// The set.
        of: &'static str,
        /// Its columns.
        columns: u32,
        /// Its rows.
        rows: u32,
    },
}

/// Most conditions of a pass that are told: a loop's last turn counts.
const MOST_TOLD: usize = 6;

/// The passes over an element of the main set: pixel (x, y), or element x + y width of a set in rows. Passes that do not take it
/// in its state are left out. `progress` is told the passes that have run, and returns whether to go on.
///
/// # Errors
/// If there is no such element, a kernel cannot be interpreted, or the device fails.
pub async fn element_history(
    device: &Device,
    (plan, data): (Plan, SceneData),
    options: &Options,
    texel: [u32; 2],
    most: usize,
    mut progress: impl FnMut(usize) -> bool,
) -> Result<Vec<ElementPass>, HistoryError> {
    let mut renderer = Renderer::from_plan(plan, data, options, device).await?;
    let plan = renderer.shared_plan();
    let set = plan.program.elements[0];
    let size = plan.size();
    let [x, y] = texel;
    if x >= size.width || y >= size.height || set.count != Count::Image && y * size.width + x >= size.count {
        return Err(HistoryError::NoElement { x, y, of: set.name, columns: size.width, rows: size.height });
    }
    let own: Vec<Stream> = plan
        .streams
        .iter()
        .map(|planned| planned.what)
        .filter(|stream| stream.info().elements.name == set.name)
        .collect();
    let mut passes: Vec<Option<Pass>> = plan.program.kernels.iter().map(|_| None).collect();
    let mut history = Vec::new();
    while let Some(kernel) = renderer.next_kernel() {
        if !progress(renderer.pass_count()) {
            return Err(RenderError::Cancelled { passes: renderer.pass_count() }.into());
        }
        if renderer.pass_count() >= most {
            break;
        }
        let before = values(&renderer, &own, texel).await?;
        if kernel.instance().over.name != set.name || !is_taken(kernel, &own, &before) {
            renderer.step().await?;
            continue;
        }
        let place = |line: Option<usize>| match (plan.variant(kernel), line) {
            (Some(variant), Some(line)) => variant.named_line(line),
            _ => kernel.name().to_owned(),
        };
        let code = &mut passes[kernel.index()];
        let interpreted = match code {
            Some(code) => &*code,
            None => {
                let Some(variant) = plan.variant(kernel) else { break };
                let compiled = Pass::new(variant).map_err(|why| HistoryError::Interpret { place: place(None), why })?;
                &*code.insert(compiled)
            }
        };
        // A device copies some streams before the pass.
        let copies = kernel.instance().copies;
        let mut streams = Vec::new();
        for &stream in interpreted.streams() {
            let from = copies.iter().find(|(to, _)| *to == stream).map_or(stream, |&(_, from)| from);
            let values = renderer.values(from).await?;
            streams.push(StreamData { stream, ..values });
        }
        let Some(pass) = renderer.step().await? else { break };
        let (index, parameter) = (pass.index, pass.parameter);
        let given = Given { data: renderer.data(), size, parameter, streams: &streams };
        let recording = interpreted
            .record(&given, texel)
            .map_err(|error| HistoryError::Interpret { place: place(error.lines.first().copied()), why: error.why })?;
        let after = values(&renderer, &own, texel).await?;
        let notes = interpreted.notes().iter().zip(&recording.noted);
        history.push(ElementPass {
            pass: index,
            kernel: kernel.name(),
            changes: changes(plan.program.states, &own, &before, &after),
            why: why(interpreted, &recording, &|line| place(Some(line))),
            noted: notes.filter_map(|(note, &noted)| note.told(noted)).collect(),
        });
    }
    Ok(history)
}

/// The element's components, stream by stream.
async fn values(renderer: &Renderer, streams: &[Stream], [x, y]: [u32; 2]) -> Result<Vec<Vec<u32>>, RenderError> {
    renderer.texels(streams, x, y).await
}

/// Whether a kernel works on the element in its state.
fn is_taken(kernel: Kernel, streams: &[Stream], before: &[Vec<u32>]) -> bool {
    if kernel.takes().is_empty() {
        return true;
    }
    let of_state = kernel.course().and_then(|course| streams.iter().position(|stream| *stream == course.stream));
    let tag = of_state.and_then(|at| before.get(at)?.get(STATE_TAG));
    tag.is_none_or(|tag| kernel.takes().contains(tag))
}

fn changes(states: States, streams: &[Stream], before: &[Vec<u32>], after: &[Vec<u32>]) -> Vec<Change> {
    let mut all = Vec::new();
    for (stream, (before, after)) in streams.iter().zip(before.iter().zip(after)) {
        for (layer, (&before, &after)) in before.iter().zip(after).enumerate().filter(|(_, (a, b))| a != b) {
            let text = |bits| text(states, *stream, layer, bits);
            let [before, after] = [before, after].map(text);
            all.push(Change { stream: stream.name(), layer: stream.info().layers[layer], before, after });
        }
    }
    all
}

/// A component as a reader knows it.
fn text(states: States, stream: Stream, layer: usize, bits: u32) -> String {
    match stream.info().meaning[layer] {
        Meaning::Tag => states.name(bits).to_owned(),
        _ if stream.is_float_layer(layer) => f32::from_bits(bits).to_string(),
        _ => bits.to_string(),
    }
}

/// The conditions that the thread came to, with their places.
fn why(pass: &Pass, recording: &Recording, place: &dyn Fn(usize) -> String) -> Vec<String> {
    let code = pass.code();
    let mut reached: Vec<_> = (0..pass.sites().len())
        .filter(|&site| pass.sites()[site].kind != SiteKind::ShortCircuit)
        .filter_map(|site| branch(code, recording, site))
        .collect();
    reached.sort_by_key(|branch| branch.line);
    let told = |branch: &crate::branch::Branch| {
        let note = branch.notes.first().map_or("", |note| note.text.as_str());
        format!("{}: {} {note}", place(branch.line + 1), branch.condition)
    };
    // What is in our modules is not what the author asks about.
    let told: Vec<String> = reached.iter().map(told).filter(|text| !text.starts_with("package::")).collect();
    told.into_iter().take(MOST_TOLD).collect()
}
