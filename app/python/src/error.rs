//! Exceptions: the command line's one line, by what is wrong.

use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyValueError};
use pyo3::prelude::*;
use raystep_app::api::Failure;
use raystep_kernels::RenderError;

create_exception!(
    raystep,
    SceneError,
    PyException,
    "A scene that cannot be read or traced.

>>> from raystep import Scene, SceneError
>>> try:
...     Scene('missing.glb')
... except SceneError as error:
...     print(error)
missing.glb: No such file or directory
"
);
create_exception!(
    raystep,
    OptionError,
    PyValueError,
    "An argument that is wrong, or does not go with the others.

>>> from raystep import OptionError, Renderer
>>> try:
...     Renderer('cornell-box', size=(0, 1), device='cpu')
... except OptionError as error:
...     print(error)
--size 0x1: expected 1 to 32768 pixels per side
"
);
create_exception!(
    raystep,
    DeviceError,
    PyException,
    "A device that is missing, refuses, or has failed.

>>> from raystep import DeviceError, Scene
>>> try:
...     Scene(triangles=[], device='gpu', adapter='of another machine')
... except DeviceError as error:
...     print('of another machine' in str(error))
True
"
);

/// Adds the exceptions to the module.
pub(crate) fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("SceneError", py.get_type::<SceneError>())?;
    module.add("OptionError", py.get_type::<OptionError>())?;
    module.add("DeviceError", py.get_type::<DeviceError>())
}

/// The exception for an error of a cast.
pub(crate) fn of_run(error: &RenderError) -> PyErr {
    use raystep_kernels::PlanError as Plan;
    let message = error.to_string();
    match error {
        RenderError::Plan(Plan::Ray { .. } | Plan::ImageSize { .. } | Plan::Grid(_) | Plan::Refused(_)) => OptionError::new_err(message),
        RenderError::Plan(_) => SceneError::new_err(message),
        _ => DeviceError::new_err(message),
    }
}

/// The exception for an error of a run, with the command line's words.
pub(crate) fn of_request(error: &RenderError) -> PyErr {
    match (Failure::from(error), error) {
        (Failure::Usage(line), _) => OptionError::new_err(line),
        (Failure::Failed(line), RenderError::NoStream(_) | RenderError::NoPixel { .. } | RenderError::NoRays(_)) => {
            OptionError::new_err(line)
        }
        (Failure::Failed(line), RenderError::Plan(_)) => SceneError::new_err(line),
        (Failure::Failed(line), _) => DeviceError::new_err(line),
    }
}

/// The exception for a failure to open a device.
pub(crate) fn of_device(failure: Failure) -> PyErr {
    match failure {
        Failure::Usage(line) => OptionError::new_err(line),
        Failure::Failed(line) => DeviceError::new_err(line),
    }
}
