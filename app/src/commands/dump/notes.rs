//! What a user's kernel prints, as arrays beside the streams: for each note of a pass, its last value of every ray.

use raystep_kernels::interpret::{Interpreter, Many};
use raystep_kernels::shader::Printed;
use raystep_kernels::{Kernel, StreamData};

use crate::error::Error;
use crate::output::TargetFolder;
use crate::session::Running;

/// The streams before a pass whose kernel prints something.
pub(super) struct Before {
    kernel: Kernel,
    code: Interpreter,
    streams: Vec<StreamData>,
}

impl Before {
    /// Reads them, if the next pass is one; `None` if it prints nothing.
    pub(super) fn next_pass(running: &Running) -> Result<Option<Self>, Error> {
        let renderer = &running.renderer;
        let Some(kernel) = renderer.next_kernel() else { return Ok(None) };
        let variant = renderer.plan().variant(kernel).filter(|variant| variant.replaced.is_some());
        let Some(variant) = variant else { return Ok(None) };
        // A kernel that cannot be interpreted prints nothing.
        let Some(code) = Interpreter::new(variant).ok().filter(|code| !code.notes().is_empty()) else {
            return Ok(None);
        };
        let read = |&stream| running.chosen.wait(renderer.values(stream));
        let streams = code.streams().iter().map(read).collect::<Result<Vec<_>, _>>()?;
        Ok(Some(Self { kernel, code: code.limited(renderer.plan().turns), streams }))
    }

    /// Writes `pass-000012.note.LABEL.npy` for each note: (component, row, column). Rays that have not printed it have NaN, or
    /// the largest integer.
    pub(super) fn write(&self, running: &Running, folder: &TargetFolder, pass: usize) -> Result<Vec<String>, Error> {
        let data = self.kernel.reads(running.renderer.data());
        let many = Many { kernel: &self.code, data: &data, streams: &self.streams };
        let [width, height] = many.size();
        let noted = many.noted(0..width as usize * height as usize).map_err(Error::failed)?;
        let mut files = Vec::new();
        for (index, note) in self.code.notes().iter().enumerate().filter(|(_, note)| note.words > 0) {
            let none = if note.is_float() { f32::NAN.to_bits() } else { u32::MAX };
            let value = |component: usize, (values, times): Printed| if times > 0 { values[component] } else { none };
            let components = 0..note.words as usize;
            let bits: Vec<u32> =
                components.flat_map(|c| noted.iter().map(move |of_ray| value(c, of_ray[index]))).collect();
            let label: String = note.label.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
            let name = format!("pass-{pass:06}.note.{label}.npy");
            let shape = [note.words, height, width];
            folder.write(&name, |out| raystep_kernels::export::npy::write_bits(out, note.is_float(), shape, &bits))?;
            files.push(name);
        }
        Ok(files)
    }
}
