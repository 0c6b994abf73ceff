//! What a user's kernel prints, as arrays beside the streams: for each note of a pass, its last value of every element.

use raystep_kernels::shader::Printed;
use raystep_lab::passed::{Before as Streams, Code};

use crate::error::Error;
use crate::output::TargetFolder;
use crate::session::Running;

/// The streams before a pass whose kernel prints something.
pub(super) struct Before {
    code: Code,
    streams: Streams,
}

impl Before {
    /// Reads them, if the next pass is one; `None` if it prints nothing.
    pub(super) fn next_pass(running: &Running) -> Result<Option<Self>, Error> {
        let renderer = &running.renderer;
        let Some(kernel) = renderer.next_kernel() else { return Ok(None) };
        let plan = renderer.plan();
        let Some(variant) = plan.variant(kernel).filter(|variant| variant.replaced.is_some()) else { return Ok(None) };
        // A kernel that cannot be interpreted prints nothing.
        let code = Code::new(variant, plan.turns).ok().filter(|code| !code.interpreter().notes().is_empty());
        let Some(code) = code else { return Ok(None) };
        let streams = running.chosen.wait(Streams::read(renderer, code.streams()))?;
        Ok(streams.map(|streams| Self { code, streams }))
    }

    /// Writes `pass-000012.note.LABEL.npy` for each note, after the pass: (component, row, column). Elements that have not
    /// printed it have NaN, or the largest integer.
    pub(super) fn write(self, running: &Running, folder: &TargetFolder, pass: usize) -> Result<Vec<String>, Error> {
        let Self { code, streams } = self;
        let renderer = &running.renderer;
        let Some(begun) = streams.begun(renderer) else { return Ok(Vec::new()) };
        let failed = |why: &dyn std::fmt::Display| {
            Error::failed(format!("notes of pass {pass}, {}: {why}", code.kernel().name()))
        };
        let noted = code.noted(&begun, renderer.data()).map_err(|why| failed(&why))?;
        let mut files = Vec::new();
        for (index, note) in code.interpreter().notes().iter().enumerate().filter(|(_, note)| note.words > 0) {
            let none = if note.is_float() { f32::NAN.to_bits() } else { u32::MAX };
            let value = |component: usize, (values, times): Printed| if times > 0 { values[component] } else { none };
            let components = 0..note.words as usize;
            let bits: Vec<u32> =
                components.flat_map(|c| noted.iter().map(move |element| value(c, element[index]))).collect();
            let label: String = note.label.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
            let name = format!("pass-{pass:06}.note.{label}.npy");
            let shape = [note.words, begun.size.height, begun.size.width];
            folder.write(&name, |out| raystep_kernels::export::npy::write_bits(out, note.is_float(), shape, &bits))?;
            files.push(name);
        }
        Ok(files)
    }
}
