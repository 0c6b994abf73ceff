//! A user's program on a device beside the interpreter: the first element whose values differ.
//!
//! The interpreter starts every pass from the device's streams, so a difference is that of one pass, however chaotic the
//! program is.

mod witness;

use raystep_kernels::executor::cpu::{CpuError, CpuExecutor};
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::tables::elements::Count;
use raystep_kernels::{Device, Kernel, Options, Plan, RenderError, Renderer, Stream, StreamData};
use serde::Serialize;
pub use witness::{check_on, check_result};

/// What is compared.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// Passes of each kernel: the first ones.
    pub passes: usize,
    /// How far floats may be apart, in parts of the largest magnitude in their layer.
    pub tolerance: f32,
}

/// As many passes as a person waits for: the interpreter takes about a second for a million elements' statements.
pub const PASSES: usize = 5;

/// A device may contract products and sums, divide by a reciprocal and add in another order: in sums of a thousand terms, some
/// hundred roundings.
pub const TOLERANCE: f32 = 1.0 / 65_536.0;

/// The first value that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// The pass, from 0.
    pub pass: usize,
    /// Its kernel.
    pub kernel: &'static str,
    /// Column and row, or in a set without rows the element's number.
    pub element: Vec<u32>,
    /// Its set.
    pub of: &'static str,
    /// The stream.
    pub stream: &'static str,
    /// The layer.
    pub layer: &'static str,
    /// The device's value.
    pub value: String,
    /// That of the interpreter, or of another witness.
    pub expected: String,
    /// Values of this layer that differ.
    pub values: u64,
}

/// What was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "verdict", rename_all = "snake_case")]
pub enum Outcome {
    /// The same values after every pass that was compared.
    Same {
        /// Passes that were compared.
        passes: usize,
        /// Passes of the run.
        of: usize,
        /// Values that were compared.
        values: u64,
        /// How far floats were apart at most, in parts of the largest magnitude in their layer.
        apart: f32,
    },
    /// Other values.
    Differs(Box<Difference>),
    /// A kernel fails, interpreted.
    Fails {
        /// The pass, from 0.
        pass: usize,
        /// How, and where.
        message: String,
    },
}

/// Why a check failed.
#[derive(Debug, thiserror::Error)]
pub enum CheckError {
    /// The device failed.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The interpreter cannot run.
    #[error(transparent)]
    Cpu(#[from] CpuError),
}

/// Runs a program on a device, and some of its passes in the interpreter as well. `progress` is told the passes that have run,
/// and returns whether to go on.
///
/// # Errors
/// If the device fails, there is not enough memory, or `progress` stops it.
pub async fn check(
    device: &Device,
    (plan, data): (Plan, SceneData),
    options: &Options,
    wanted: Wanted,
    mut progress: impl FnMut(usize) -> bool,
) -> Result<Outcome, CheckError> {
    let mut renderer = Renderer::from_plan(plan, data, options, device).await?;
    let plan = renderer.shared_plan();
    let mut interpreted = CpuExecutor::<f32>::new(&plan, None).map_err(CpuError::from)?;
    let mut left: Vec<usize> = vec![wanted.passes; plan.program.kernels.len()];
    let (mut passes, mut values, mut apart) = (0, 0, 0.0f32);
    while let Some(kernel) = renderer.next_kernel() {
        if !progress(renderer.pass_count()) {
            return Err(RenderError::Cancelled { passes: renderer.pass_count() }.into());
        }
        let is_compared = left[kernel.index()] > 0;
        if is_compared {
            for planned in &plan.streams {
                if let Some(before) = known(&renderer, planned.what).await? {
                    interpreted.write(&before);
                }
            }
        }
        let Some(pass) = renderer.step().await? else { break };
        if !is_compared {
            continue;
        }
        left[kernel.index()] -= 1;
        passes += 1;
        match interpreted.run(pass.call(), renderer.data()) {
            Ok(_) => {}
            Err(CpuError::Failed(why)) => return Ok(Outcome::Fails { pass: pass.index, message: why.to_string() }),
            Err(other) => return Err(other.into()),
        }
        if let Some(found) = interpreted.race() {
            let message = format!("{}: {}", found.place, found.race);
            return Ok(Outcome::Fails { pass: pass.index, message });
        }
        let written = plan.variant(kernel).into_iter().flat_map(|variant| variant.written_streams());
        for stream in written.collect::<Vec<_>>() {
            let (Some(ours), Some(theirs)) = (known(&renderer, stream).await?, interpreted.read(stream)) else {
                continue;
            };
            for layer in 0..stream.layers() {
                let compared = compare(&ours, &theirs, layer, wanted.tolerance);
                values += ours.layer(layer).len() as u64;
                apart = apart.max(compared.apart);
                if let Some(at) = compared.first {
                    return Ok(Outcome::Differs(Box::new(difference(
                        pass.index,
                        kernel,
                        [&ours, &theirs],
                        layer,
                        at,
                        compared.count,
                    ))));
                }
            }
        }
    }
    Ok(Outcome::Same { passes, of: renderer.pass_count(), values, apart })
}

/// The values of a stream, if its elements have been counted.
async fn known(renderer: &Renderer, stream: Stream) -> Result<Option<StreamData>, RenderError> {
    match renderer.size(stream.info().elements) {
        Some(_) => renderer.values(stream).await.map(Some),
        None => Ok(None),
    }
}

struct Compared {
    /// The first texel that differs.
    first: Option<usize>,
    count: u64,
    apart: f32,
}

fn compare(ours: &StreamData, theirs: &StreamData, layer: usize, tolerance: f32) -> Compared {
    let pairs = || ours.layer(layer).iter().zip(theirs.layer(layer));
    let mut found = Compared { first: None, count: 0, apart: 0.0 };
    let is_float = ours.stream.is_float_layer(layer);
    let magnitude = |bits: &u32| f32::from_bits(*bits).abs();
    let largest = if is_float {
        pairs().map(|(a, b)| magnitude(a).max(magnitude(b))).filter(|m| m.is_finite()).fold(0.0, f32::max)
    } else {
        0.0
    };
    for (at, (&a, &b)) in pairs().enumerate() {
        let floats = [a, b].map(f32::from_bits);
        let is_same = a == b || is_float && (floats[0] == floats[1] || floats.iter().all(|f| f.is_nan()));
        let by = if is_float && largest > 0.0 { (floats[0] - floats[1]).abs() / largest } else { f32::INFINITY };
        if is_same {
            continue;
        }
        // A NaN on one side alone is not below anything.
        if by <= tolerance {
            found.apart = found.apart.max(by);
            continue;
        }
        found.first = found.first.or(Some(at));
        found.count += 1;
    }
    found
}

fn difference(
    pass: usize,
    kernel: Kernel,
    [ours, theirs]: [&StreamData; 2],
    layer: usize,
    at: usize,
    values: u64,
) -> Difference {
    let stream = ours.stream;
    let info = stream.info();
    let text = |data: &StreamData| match stream.is_float_layer(layer) {
        true => data.get_f32(layer, at).to_string(),
        false => data.get(layer, at).to_string(),
    };
    let width = ours.width.max(1);
    let is_image = info.elements.count == Count::Image;
    let element = if is_image { vec![at as u32 % width, at as u32 / width] } else { vec![at as u32] };
    Difference {
        pass,
        kernel: kernel.name(),
        element,
        of: info.elements.name,
        stream: info.name,
        layer: info.layers[layer],
        value: text(ours),
        expected: text(theirs),
        values,
    }
}
