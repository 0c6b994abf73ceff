//! `--buffers`: the scene data that kernels read, which does not change during a run.

use raystep_kernels::export::npy;
use raystep_kernels::plan::Plan;
use raystep_kernels::scene_data::buffer::BufferInfo;
use raystep_kernels::shader::ArrayLayout;
use serde::Serialize;

use super::Wanted;
use crate::error::Error;
use crate::output::TargetFolder;
use crate::session::Running;

/// A buffer in `index.json`.
#[derive(Serialize)]
pub(super) struct BufferFile {
    name: &'static str,
    /// What an element is, and its unit.
    element: &'static str,
    bytes: u64,
    file: String,
}

/// The buffers to write; an error if a named one is not part of the plan.
pub(super) fn chosen<'a>(
    wanted: &[Wanted],
    plan: &'a Plan,
) -> Result<Vec<(&'static BufferInfo, &'a ArrayLayout)>, Error> {
    let layout = |name: &str| plan.variants.iter().flat_map(|variant| &variant.arrays).find(|array| array.name == name);
    let bound = || plan.program.buffers.iter().filter_map(|buffer| Some((buffer, layout(buffer.name)?)));
    let mut chosen = Vec::new();
    for wanted in wanted {
        let Wanted::Named(name) = wanted else { return Ok(bound().collect()) };
        match bound().find(|(buffer, _)| buffer.name == name) {
            Some(found) if chosen.iter().all(|(known, _): &(&BufferInfo, _)| known.name != name) => chosen.push(found),
            Some(_) => {}
            None => {
                let what = format!("buffer {name}");
                let problem = match plan.left_out.iter().find(|item| item.what == what) {
                    Some(item) => format!("this run omits it: {}", item.reason),
                    None => {
                        let names: Vec<_> = bound().map(|(buffer, _)| buffer.name).collect();
                        format!("this run has no such buffer; its buffers are {}, and all", names.join(", "))
                    }
                };
                return Err(Error::usage(format!("--buffers {name}: {problem}")));
            }
        }
    }
    Ok(chosen)
}

/// The name of a buffer's file.
fn file(buffer: &BufferInfo) -> String {
    format!("scene.{}.npy", buffer.name)
}

/// Whether a dump may write a file of this name.
pub(super) fn is_ours(name: &str) -> bool {
    name.starts_with("scene.") && name.ends_with(".npy")
}

/// Writes them.
pub(super) fn write(wanted: &[Wanted], running: &Running, folder: &TargetFolder) -> Result<Vec<BufferFile>, Error> {
    let data = running.renderer.data();
    let mut files = Vec::new();
    for (buffer, layout) in chosen(wanted, running.renderer.plan())? {
        let (bytes, file) = ((buffer.bytes)(data), file(buffer));
        folder.write(&file, |out| npy::write_buffer(out, buffer, layout, bytes))?;
        files.push(BufferFile { name: buffer.name, element: buffer.element, bytes: bytes.len() as u64, file });
    }
    Ok(files)
}
