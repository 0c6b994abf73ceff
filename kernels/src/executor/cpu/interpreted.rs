//! A pass of a user's kernel whose elements read each other, by the interpreter.

use super::guest::{By, Failed, Interpreted};
use super::{CpuExecutor, from_stream_bits};
use crate::interpret::InterpretError;
use crate::interpret::pass::{Given, PassError, Race};
use crate::program::Kernel;
use crate::program::kernel::Precision;
use crate::program::schedule::Call;
use crate::scene_data::SceneData;
use crate::tables::stream::StreamData;

/// What a pass of a user's kernel does depends on the order of its threads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RaceFound {
    /// The kernel.
    pub kernel: Kernel,
    /// File and line of the store.
    pub place: String,
    /// The first of the pass.
    pub race: Race,
}

impl<R: Precision> CpuExecutor<R> {
    /// The first data race of the passes so far.
    #[must_use]
    pub fn race(&self) -> Option<&RaceFound> {
        self.race.as_ref()
    }

    /// Runs a pass of a user's kernel, which reads the streams as they were before it. Returns the number of its elements.
    pub(super) fn run_interpreted(&mut self, call: Call, scene: &SceneData) -> Result<u64, Failed> {
        let kernel = call.kernel;
        let interpreted = self.interpreted.clone();
        let Some(size) = self.size(kernel.instance().over) else { return Ok(0) };
        let Some(own) = Interpreted::find(&interpreted, kernel) else { return Ok(0) };
        let code = match &own.code {
            Ok(By::Pass(code)) => code,
            Ok(By::Element(_)) => return Ok(0),
            Err(why) => return Err(own.failed(&[], [0; 2], why.clone())),
        };
        let failed = |PassError { why, texel, lines }: PassError| own.failed(&lines, texel, why);
        let missing = |name| own.failed(&[], [0; 2], InterpretError::Missing(name));
        let read = |&stream| self.read(stream).ok_or_else(|| missing(stream.name()));
        let streams = code.streams().iter().map(read).collect::<Result<Vec<_>, _>>()?;
        let given = Given { data: scene, size, parameter: call.parameter, streams: &streams };
        let passed = code.run(&given).map_err(failed)?;
        if let (Some(race), None) = (passed.race, &self.race) {
            self.race = Some(RaceFound { kernel, place: own.named_line(race.line), race });
        }
        for after in &passed.streams {
            let before = streams.iter().find(|before| before.stream == after.stream);
            before.into_iter().for_each(|before| self.put_changes(before, after));
        }
        Ok(size.count.into())
    }

    /// Replaces the components of a stream that differ: what is left alone keeps its precision.
    fn put_changes(&mut self, before: &StreamData, after: &StreamData) {
        let stream = after.stream;
        let Some((rows, first)) = self.rows_of_mut(stream) else { return };
        let (stride, texels) = (rows.layout.stride, after.width as usize * after.height as usize);
        let mut is_other = false;
        for (at, (&bits, _)) in after.bits.iter().zip(&before.bits).enumerate().filter(|(_, (a, b))| a != b) {
            let (layer, element) = (at / texels.max(1), at % texels.max(1));
            if let Some(texel) = rows.texels.get_mut(element * stride + first + layer) {
                *texel = from_stream_bits::<R>(stream, layer, bits);
                is_other = true;
            }
        }
        if is_other && self.plan.program.has_states(stream) {
            self.count();
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
