//! A user's kernel beside the one that it replaces: the first ray that it treats otherwise, and why.
//!
//! Both start every pass from the same streams, so the kernel is not blamed for what an earlier pass did. The built-in one is
//! the CPU reference kernel; the user's runs on a device, or in the interpreter.

mod condition;

use raystep_kernels::interpret::{Element, Interpreter};
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::shader::Variant;
use raystep_kernels::{Device, Options, Plan, PlanError, RenderError, Stream};
use raystep_scenes::Scene;
use serde::Serialize;

use crate::branch::text_of;
use crate::parity::{Breach, Miscount, Parity, ParityError, compare_plan};

/// A line of a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Line {
    /// The file, or the module that it imports from.
    pub file: String,
    /// From 1; 0 in a module.
    pub line: usize,
    /// Its text.
    pub text: String,
}

/// A condition of the user's kernel that led to a value.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Decided {
    /// Where it is.
    #[serde(flatten)]
    pub at: Line,
    /// How it came out, with the values that it compared.
    pub how: Vec<String>,
}

/// The first value that differs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// The pass, from 0.
    pub pass: usize,
    /// Column and row of the ray's pixel.
    pub pixel: [u32; 2],
    /// Rays that differ after this pass, at most 20 counted.
    pub rays: usize,
    /// Its stream.
    pub stream: &'static str,
    /// Its layer.
    pub layer: &'static str,
    /// What the user's kernel left there.
    pub value: String,
    /// What the built-in kernel leaves there.
    pub expected: String,
    /// Other values of this ray that differ after this pass, as stream.layer.
    pub also: Vec<String>,
    /// The cells of a uniform grid with these two indices, if they are indices of cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cells: Option<[[i32; 3]; 2]>,
    /// The line that stored it, or called a function of ours that did; `None` if none did.
    pub stored: Option<Line>,
    /// The condition that decided.
    pub decided: Option<Decided>,
    /// What the kernel prints for this ray in this pass, as `label = value`.
    pub notes: Vec<String>,
    /// Why the two are not known: the interpreter fails on the ray, as for an index that is out of range.
    pub fails: Option<String>,
}

/// What a check has found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "verdict", rename_all = "snake_case")]
pub enum Outcome {
    /// The same values after every pass.
    Same {
        /// Passes of the kernel.
        passes: usize,
        /// Rays that it worked on, summed over the passes.
        rays: u64,
    },
    /// Other values.
    Differs(Box<Difference>),
    /// The same values, but rays are not counted in the states that their tags say.
    Miscounts {
        /// The pass, from 0.
        pass: usize,
        /// Name of the state, rays counted, and rays with its tag: of each state that differs.
        states: Vec<(&'static str, u32, u32)>,
    },
    /// It does not run to its end.
    Fails {
        /// Place and reason.
        message: String,
    },
    /// The run never used it.
    Idle,
}

/// Compares the only kernel that the options replace with the built-in one, on a device.
///
/// # Errors
/// If the scene cannot be planned, the WGSL is invalid, or the device fails.
pub async fn check_kernel(scene: &Scene, options: &Options, device: &Device) -> Result<Outcome, ParityError> {
    check(scene, options, device, device.is_gpu()).await
}

/// The same; `may_round` says whether a ray may go another way where f32 cannot tell which is right.
pub(crate) async fn check(
    scene: &Scene,
    options: &Options,
    device: &Device,
    may_round: bool,
) -> Result<Outcome, ParityError> {
    let (plan, data) = Plan::on(scene, options, device).await.map_err(of_plan)?;
    let Some(variant) = plan.variants.iter().find(|variant| variant.replaced.is_some()).cloned() else {
        return Ok(Outcome::Idle);
    };
    let (width, height) = (plan.width, plan.height);
    let found = match compare_plan(device, plan, data.clone(), options, may_round, Parity::is_broken).await {
        Ok(found) => found,
        Err(ParityError::Pass { error: error @ (RenderError::Failed(_) | RenderError::Gpu(_)), .. }) => {
            return Ok(Outcome::Fails { message: error.to_string() });
        }
        Err(error) => return Err(error),
    };
    let first = found.breaches.iter().min_by_key(|breach| (breach.pass, breach.ray));
    if let Some(first) = first {
        let mut rays: Vec<usize> = found.breaches.iter().map(|breach| breach.ray).collect();
        rays.dedup();
        let is_other = |breach: &&Breach| {
            breach.pass == first.pass && breach.ray == first.ray && breach.component != first.component
        };
        let name = |(stream, layer): (Stream, usize)| format!("{}.{}", stream.name(), stream.info().layers[layer]);
        let mut difference = Difference {
            pass: first.pass,
            pixel: [first.ray as u32 % width, first.ray as u32 / width],
            rays: rays.len(),
            stream: first.component.0.name(),
            layer: first.component.0.info().layers[first.component.1],
            value: shown(first, first.gpu),
            expected: shown(first, first.twin),
            also: found.breaches.iter().filter(is_other).map(|breach| name(breach.component)).collect(),
            cells: cells(&data, first),
            stored: None,
            decided: None,
            notes: Vec::new(),
            fails: None,
        };
        explain(&variant, &data, first, &found, [width, height], &mut difference);
        return Ok(Outcome::Differs(Box::new(difference)));
    }
    if let Some(Miscount { pass, counted, found, kernel }) = found.miscounts.first() {
        let states = kernel.program().states;
        let pairs = (0..).zip(counted.iter().zip(found.iter())).filter(|(_, (counted, found))| counted != found);
        let states = pairs.map(|(tag, (&counted, &found))| (states.name(tag), counted, found)).collect();
        return Ok(Outcome::Miscounts { pass: *pass, states });
    }
    let sums = found.compared.iter().find(|(kernel, _)| *kernel == variant.kernel).map(|(_, sums)| sums);
    Ok(sums.map_or(Outcome::Idle, |sums| Outcome::Same { passes: sums.passes, rays: sums.rays }))
}

fn of_plan(error: RenderError) -> ParityError {
    match error {
        RenderError::Plan(error) => ParityError::Plan(error),
        error => ParityError::Render(error),
    }
}

/// The mistake in a user's WGSL, if that is why a check failed.
#[must_use]
pub fn mistake(error: &ParityError) -> Option<&raystep_kernels::shader::Mistake> {
    match error {
        ParityError::Plan(PlanError::Shader(raystep_kernels::shader::ShaderError::Mistake(mistake))) => Some(mistake),
        _ => None,
    }
}

fn shown(of: &Breach, bits: u32) -> String {
    let (stream, layer) = of.component;
    if stream.is_float_layer(layer) {
        return condition::float(f32::from_bits(bits));
    }
    let states = of.kernel.program().states;
    let is_tag = of.kernel.program().has_states(stream) && layer == raystep_kernels::tables::stream::STATE_TAG;
    if is_tag && states.iter().any(|state| state.tag == bits) {
        return states.name(bits).to_owned();
    }
    if bits == u32::MAX { "none (0xffffffff)".into() } else { bits.to_string() }
}

/// The cells whose indices these are, in a uniform grid.
fn cells(data: &SceneData, of: &Breach) -> Option<[[i32; 3]; 2]> {
    let (stream, layer) = of.component;
    let is_cell = stream.name() == "state" && stream.info().layers[layer] == "cell";
    let grid = data.grid;
    let count: i64 = grid.cells.iter().map(|&cells| i64::from(cells)).product();
    let is_index = |index: u32| i64::from(index) < count;
    let are_cells = is_cell && data.features.grid && is_index(of.gpu) && is_index(of.twin);
    are_cells.then(|| [of.gpu, of.twin].map(|index| grid.cell_of_index(index)))
}

/// Finds what stored the value, and which condition decided, by interpreting the ray's pass once more.
fn explain(
    variant: &Variant,
    data: &SceneData,
    first: &Breach,
    found: &Parity,
    size: [u32; 2],
    difference: &mut Difference,
) -> Option<()> {
    let code = Interpreter::new(variant).ok()?;
    let (stream, layer) = first.component;
    let streams = code.streams().iter().map(|stream| found.before.iter().find(|data| data.stream == *stream));
    let streams = streams.collect::<Option<Vec<_>>>()?;
    let components = streams.iter().flat_map(|data| (0..data.stream.layers()).map(move |layer| (*data, layer)));
    let mut texels: Vec<u32> = components.clone().map(|(data, layer)| data.get(layer, first.ray)).collect();
    let element = Element { texel: difference.pixel, size };
    let recording = match code.record(data, element, &mut texels) {
        Ok(recording) => recording,
        Err(why) => {
            difference.fails = Some(why.to_string());
            return None;
        }
    };
    let noted = code.notes().iter().zip(&recording.noted);
    difference.notes = noted.filter_map(|(note, &noted)| note.told(noted)).collect();
    let component = components.clone().position(|(data, of)| data.stream == stream && of == layer);
    difference.stored = component.and_then(|component| {
        let line = recording.stored.get(component).copied().flatten()?;
        let callers = recording.callers.get(component).into_iter().flatten().copied();
        let places: Vec<Line> = std::iter::once(line).chain(callers).map(|line| place(variant, line + 1)).collect();
        // Where a function of ours has stored it, the user's line is the one that called it.
        let own = places.iter().position(|place| place.line > 0).unwrap_or(0);
        places.into_iter().nth(own)
    });
    let site = recording.deciding.and_then(|index| recording.decisions.get(index)).map(|decision| decision.site)?;
    let about = code.sites().get(site)?;
    let named = |line: usize| {
        let place = variant.replaced.as_ref().and_then(|replaced| replaced.place_of_line(line))?;
        Some(format!("{}:{}", place.file, place.line))
    };
    let how = condition::how(&code, &recording, site, named)?;
    let text = text_of(code.source(), about.span.clone());
    difference.decided = Some(Decided { at: Line { text, ..place(variant, about.line + 1) }, how });
    Some(())
}

/// A line of the composed source, from 1, as the user finds it.
fn place(variant: &Variant, line: usize) -> Line {
    let place = variant.replaced.as_ref().and_then(|replaced| replaced.place_of_line(line));
    match place {
        Some(place) => Line { file: place.file, line: place.line, text: place.text.trim().to_owned() },
        None => {
            let text = variant.source.lines().nth(line.saturating_sub(1)).unwrap_or_default().trim().to_owned();
            Line { file: variant.named_line(line), line: 0, text }
        }
    }
}
