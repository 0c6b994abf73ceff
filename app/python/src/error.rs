//! Exceptions: the command line's one line, by what is wrong.

use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyValueError};
use pyo3::prelude::*;
use raystep_kernels::RenderError;

create_exception!(raystep, SceneError, PyException, "A scene that cannot be read or traced.");
create_exception!(raystep, OptionError, PyValueError, "An argument that is wrong, or does not go with the others.");
create_exception!(raystep, DeviceError, PyException, "A device that is missing, refuses, or has failed.");

/// Adds the exceptions to the module.
pub(crate) fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("SceneError", py.get_type::<SceneError>())?;
    module.add("OptionError", py.get_type::<OptionError>())?;
    module.add("DeviceError", py.get_type::<DeviceError>())
}

/// The exception for an error of a run.
pub(crate) fn of_run(error: &RenderError) -> PyErr {
    use raystep_kernels::PlanError as Plan;
    let message = error.to_string();
    match error {
        RenderError::Plan(Plan::Ray { .. } | Plan::ImageSize { .. } | Plan::Grid(_)) => OptionError::new_err(message),
        RenderError::Plan(_) => SceneError::new_err(message),
        _ => DeviceError::new_err(message),
    }
}
