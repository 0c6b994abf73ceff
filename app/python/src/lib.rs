//! The extension module `raystep._raystep`: scenes, casts, runs, and the program. What Python sees is in
//! `python/raystep`.

mod border;
mod compare;
mod device;
mod display;
mod error;
mod renderer;
mod scene;
mod travel;

use std::ffi::OsString;
use std::path::PathBuf;

use pyo3::prelude::*;
use raystep_inspector::link::{Link, VERSION};

use crate::error::OptionError;

/// Runs the program with a command line, the program's name first, and returns its exit code.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| raystep_app::main(arguments))
}

/// Ends the threads that call devices; called when the interpreter exits.
#[pyfunction]
fn end(py: Python<'_>) {
    if !border::is_forked() {
        py.detach(raystep_app::api::end);
    }
}

/// Names the folder of the scenes that open by name.
#[pyfunction]
fn set_scenes(folder: PathBuf) {
    raystep_app::set_scenes(&folder);
}

/// A link, or parts of one, as a link to a scene of this name.
#[pyfunction]
fn link_to(scene: String, link: &str) -> PyResult<String> {
    let text = link.rsplit_once('#').map_or(link, |(_, fragment)| fragment);
    let text = if text.starts_with("raystep:") { text.to_owned() } else { format!("raystep:{VERSION}?{text}") };
    let link: Link = text.parse().map_err(|error| OptionError::new_err(format!("link {link:?}: {error}")))?;
    Ok(Link { scene: Some(scene), scene_index: None, scene_hash: None, ..link }.to_string())
}

#[pymodule(gil_used = false)]
fn _raystep(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<renderer::Renderer>()?;
    module.add_class::<scene::Scene>()?;
    module.add_function(wrap_pyfunction!(compare::compare, module)?)?;
    module.add_function(wrap_pyfunction!(display::draw_component, module)?)?;
    module.add_function(wrap_pyfunction!(display::png_of_image, module)?)?;
    module.add_function(wrap_pyfunction!(border::after_fork, module)?)?;
    module.add_function(wrap_pyfunction!(end, module)?)?;
    module.add_function(wrap_pyfunction!(link_to, module)?)?;
    module.add_function(wrap_pyfunction!(main, module)?)?;
    module.add_function(wrap_pyfunction!(set_scenes, module)?)?;
    error::add(module)
}
