//! The extension module `raystep._raystep`: scenes, casts, and the program. What Python sees is in `python/raystep`.

mod error;
mod scene;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the program with a command line, the program's name first, and returns its exit code.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| raystep_app::main(arguments))
}

#[pymodule(gil_used = false)]
fn _raystep(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<scene::Scene>()?;
    module.add_function(wrap_pyfunction!(main, module)?)?;
    error::add(module)
}
