//! What each pass of a user's program has done to one element, and why: values before and after it, and the conditions that
//! its thread came to in the interpreter.

use raystep_kernels::interpret::{InterpretError, Interpreter, Recording};
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::shader::Variant;
use raystep_kernels::tables::elements::Count;
use raystep_kernels::tables::state::States;
use raystep_kernels::tables::stream::Meaning;
use raystep_kernels::{Device, Options, Plan, RenderError, Renderer, Stream, StreamData};
use serde::Serialize;

use crate::branch::{Branch, branch};
use crate::passed::{Begun, Code, step};

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
    let mut codes: Vec<Option<Code>> = plan.program.kernels.iter().map(|_| None).collect();
    let mut history = Vec::new();
    while let Some(kernel) = renderer.next_kernel() {
        if !progress(renderer.pass_count()) {
            return Err(RenderError::Cancelled { passes: renderer.pass_count() }.into());
        }
        let variant = plan.variant(kernel).filter(|_| kernel.instance().over.name == set.name);
        let Some(variant) = variant else {
            renderer.step().await?;
            continue;
        };
        let failed = |line: Option<&usize>, why| {
            let place = line.map_or_else(|| kernel.name().to_owned(), |&line| variant.named_line(line));
            HistoryError::Interpret { place, why }
        };
        let code = match &mut codes[kernel.index()] {
            Some(code) => &*code,
            none => &*none.insert(Code::new(variant, plan.turns).map_err(|why| failed(None, why))?),
        };
        let Some(begun) = step(&mut renderer, code.streams()).await? else { break };
        if !code.works_on(&begun, texel) {
            continue;
        }
        let recording = code.record(&begun, renderer.data(), texel);
        let recording = recording.map_err(|failure| failed(failure.lines.first(), failure.why))?;
        let code = code.interpreter();
        let notes = code.notes().iter().zip(&recording.noted);
        history.push(ElementPass {
            pass: begun.pass.index,
            kernel: kernel.name(),
            changes: changes(&renderer, &begun, variant, texel).await?,
            why: why(code, &recording, variant),
            noted: notes.filter_map(|(note, &noted)| note.told(noted)).collect(),
        });
    }
    Ok(history)
}

/// What a pass has changed of the element.
async fn changes(
    renderer: &Renderer,
    begun: &Begun,
    variant: &Variant,
    [x, y]: [u32; 2],
) -> Result<Vec<Change>, RenderError> {
    let states = renderer.plan().program.states;
    let is_written = |before: &&StreamData| {
        let is_own = before.stream.info().elements.name == variant.kernel.instance().over.name;
        is_own && variant.written_streams().any(|stream| stream == before.stream)
    };
    let written: Vec<&StreamData> = begun.streams.iter().filter(is_written).collect();
    let streams: Vec<Stream> = written.iter().map(|before| before.stream).collect();
    let after = renderer.texels(&streams, x, y).await?;
    let mut all = Vec::new();
    for (before, after) in written.into_iter().zip(after) {
        let at = y as usize * before.width as usize + x as usize;
        for (layer, after) in after.into_iter().enumerate() {
            let (stream, before) = (before.stream, before.get(layer, at));
            if before != after {
                let [before, after] = [before, after].map(|bits| text(states, stream, layer, bits));
                all.push(Change { stream: stream.name(), layer: stream.info().layers[layer], before, after });
            }
        }
    }
    Ok(all)
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
fn why(code: &Interpreter, recording: &Recording, variant: &Variant) -> Vec<String> {
    let mut reached: Vec<Branch> = (0..code.sites().len()).filter_map(|site| branch(code, recording, site)).collect();
    reached.sort_by_key(|branch| branch.line);
    let told = |branch: &Branch| {
        let note = branch.notes.first().map_or("", |note| note.text.as_str());
        format!("{}: {} {note}", variant.named_line(branch.line + 1), branch.condition)
    };
    // What is in our modules is not what the author asks about.
    let told = reached.iter().map(told).filter(|text| !text.starts_with("package::"));
    told.take(MOST_TOLD).collect()
}
