//! Other witnesses than the interpreter: a second device, and an array of the results.

use raystep_kernels::scene_data::SceneData;
use raystep_kernels::tables::elements::Size;
use raystep_kernels::{Options, Plan, RenderError, Renderer, Stream, StreamData};

use super::{Outcome, Wanted, compare, difference, known};
use crate::Machine;

/// Runs a program on two devices, each with its own plan, and compares the streams after passes. Both go on from their own
/// values, so a difference may be what an earlier one, within the tolerance, has grown to. `progress` is told the passes that
/// have run, and returns whether to go on.
///
/// # Errors
/// If a device fails, or `progress` stops it.
pub fn check_on(
    [one, other]: [(&Machine, (Plan, SceneData)); 2],
    options: &Options,
    wanted: Wanted,
    mut progress: impl FnMut(usize) -> bool,
) -> Result<Outcome, RenderError> {
    let begin = |(machine, (plan, data)): (&Machine, (Plan, SceneData))| {
        machine.wait(Renderer::from_plan(plan, data, options, &machine.device))
    };
    let machines = [one.0, other.0];
    let (mut one, mut other) = (begin(one)?, begin(other)?);
    let plan = one.shared_plan();
    let mut left: Vec<usize> = vec![wanted.passes; plan.program.kernels.len()];
    let (mut passes, mut values, mut apart) = (0, 0, 0.0f32);
    while let Some(kernel) = one.next_kernel() {
        let index = one.pass_count();
        if !progress(index) {
            return Err(RenderError::Cancelled { passes: index });
        }
        let theirs = other.next_kernel().map(|kernel| kernel.name());
        if theirs != Some(kernel.name()) {
            let message = format!("{} is next, and {} on the other device", kernel.name(), theirs.unwrap_or("no pass"));
            return Ok(Outcome::Fails { pass: index, message });
        }
        machines[0].wait(one.step())?;
        machines[1].wait(other.step())?;
        if left[kernel.index()] == 0 {
            continue;
        }
        left[kernel.index()] -= 1;
        passes += 1;
        let written: Vec<Stream> =
            plan.variant(kernel).into_iter().flat_map(|variant| variant.written_streams()).collect();
        for stream in written {
            let ours = machines[0].wait(known(&one, stream))?;
            let theirs = match other.plan().program.stream(stream.name()) {
                Some(theirs) => machines[1].wait(known(&other, theirs))?,
                None => None,
            };
            let (Some(ours), Some(theirs)) = (ours, theirs) else { continue };
            for layer in 0..stream.layers() {
                let compared = compare(&ours, &theirs, layer, wanted.tolerance);
                values += ours.layer(layer).len() as u64;
                apart = apart.max(compared.apart);
                if let Some(at) = compared.first {
                    let found = difference(index, kernel, [&ours, &theirs], layer, at, compared.count);
                    return Ok(Outcome::Differs(Box::new(found)));
                }
            }
        }
    }
    if let Some(kernel) = other.next_kernel() {
        let message = format!("the run has ended, and {} is next on the other device", kernel.name());
        return Ok(Outcome::Fails { pass: one.pass_count(), message });
    }
    Ok(Outcome::Same { passes, of: one.pass_count(), values, apart })
}

/// Runs a program to its end, and compares a stream with an array, of its size, that `read` makes.
///
/// # Errors
/// If the device fails, `progress` stops it, or the array cannot be read: in the inner result, why.
pub async fn check_result(
    mut renderer: Renderer,
    stream: Stream,
    tolerance: f32,
    read: impl FnOnce(Size) -> Result<StreamData, String>,
    mut progress: impl FnMut(usize) -> bool,
) -> Result<Result<Outcome, String>, RenderError> {
    while let Some(pass) = renderer.step().await? {
        if !progress(pass.index + 1) {
            return Err(RenderError::Cancelled { passes: pass.index + 1 });
        }
    }
    let Some(last) = renderer.last_pass() else { return Ok(Err("the run has no passes".into())) };
    let Some(size) = renderer.size(stream.info().elements) else {
        return Ok(Err(format!("the elements of {} were not counted", stream.name())));
    };
    let ours = renderer.values(stream).await?;
    let mut theirs = match read(size) {
        Ok(theirs) => theirs,
        Err(why) => return Ok(Err(why)),
    };
    // Texels behind the last element have no value.
    let (texels, count) = (size.texels() as usize, size.count as usize);
    for (ours, theirs) in ours.bits.chunks(texels.max(1)).zip(theirs.bits.chunks_mut(texels.max(1))) {
        if let (Some(ours), Some(theirs)) = (ours.get(count..), theirs.get_mut(count..)) {
            theirs.copy_from_slice(ours);
        }
    }
    let mut apart = 0.0f32;
    for layer in 0..stream.layers() {
        let compared = compare(&ours, &theirs, layer, tolerance);
        apart = apart.max(compared.apart);
        if let Some(at) = compared.first {
            let found = difference(last.index, last.kernel, [&ours, &theirs], layer, at, compared.count);
            return Ok(Ok(Outcome::Differs(Box::new(found))));
        }
    }
    let passes = renderer.pass_count();
    Ok(Ok(Outcome::Same { passes: 1, of: passes, values: ours.bits.len() as u64, apart }))
}
