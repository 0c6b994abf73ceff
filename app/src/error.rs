//! Errors of a command: a line for the user and an exit code.

use std::fmt;
use std::io;
use std::path::Path;

use raystep_kernels::plan::Bytes;
use raystep_kernels::shader::{Mistake, ShaderError};
use raystep_kernels::structures::grid::GridError;
use raystep_kernels::{GpuError, Limits, PlanError, RenderError};

/// The work failed.
pub(crate) const FAILED: u8 = 1;
/// Wrong usage.
pub(crate) const USAGE: u8 = 2;

/// A comparison that is too noisy to tell.
pub(crate) const UNDECIDED: u8 = 3;

/// The system's message, without its error number and the temporary name that tempfile adds.
pub(crate) fn reason(error: &io::Error) -> String {
    let text = error.to_string();
    text.split(" (os error").next().unwrap_or(&text).to_owned()
}

/// One line, and the exit code.
#[derive(Debug)]
pub(crate) struct Error {
    /// One line, without the word error before it.
    pub(crate) message: String,
    /// The exit code.
    pub(crate) code: u8,
    /// The line of a user's kernel that it is about, as lines below the message.
    pub(crate) excerpt: Option<String>,
}

impl Error {
    /// The work failed: exit code 1.
    pub(crate) fn failed(message: impl fmt::Display) -> Self {
        Self::new(message, FAILED)
    }

    /// The command line is wrong: exit code 2.
    pub(crate) fn usage(message: impl fmt::Display) -> Self {
        Self::new(message, USAGE)
    }

    /// A comparison has no answer: exit code 3.
    pub(crate) fn undecided(message: impl fmt::Display) -> Self {
        Self::new(message, UNDECIDED)
    }

    /// Something is wrong with a file.
    pub(crate) fn at(path: &Path, why: impl fmt::Display) -> Self {
        Self::failed(format!("{}: {why}", path.display()))
    }

    /// A file or folder cannot be written.
    pub(crate) fn cannot_write(path: &Path, error: &io::Error) -> Self {
        Self::failed(format!("cannot write {}: {}", path.display(), reason(error)))
    }

    /// The message, as part of another line.
    pub(crate) fn message(&self) -> &str {
        &self.message
    }

    fn new(message: impl fmt::Display, code: u8) -> Self {
        // File names and driver messages may contain line feeds.
        let message = message.to_string().split(['\n', '\r']).map(str::trim).collect::<Vec<_>>().join(" ");
        Self { message, code, excerpt: None }
    }
}

impl From<&Mistake> for Error {
    fn from(mistake: &Mistake) -> Self {
        Self { excerpt: mistake.excerpt(), ..Self::failed(mistake) }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = if self.code == UNDECIDED { "undecided" } else { "error" };
        write!(f, "{what}: {}", self.message)?;
        self.excerpt.iter().try_for_each(|excerpt| write!(f, "\n{excerpt}"))
    }
}

impl From<PlanError> for Error {
    fn from(error: PlanError) -> Self {
        Self::from(&error)
    }
}

impl From<&PlanError> for Error {
    fn from(error: &PlanError) -> Self {
        match error {
            PlanError::Shader(ShaderError::Mistake(mistake)) => Self::from(&**mistake),
            PlanError::Grid(GridError::Size(_)) => Self::usage(format!("--grid: {error}")),
            PlanError::Samples { .. } => Self::usage(format!("--spp: {error}")),
            PlanError::Ray { .. } => Self::usage(format!("--ray: {error}")),
            PlanError::ImageSize { width, height, side, rays } => {
                Self::usage(too_large([*width, *height], *side, *rays))
            }
            PlanError::BufferSize { limit, .. } if *limit < Limits::CPU.storage_bytes => {
                let most = Bytes(Limits::CPU.storage_bytes);
                Self::failed(format!("{error}; --device cpu takes up to {most}"))
            }
            _ => Self::failed(error),
        }
    }
}

/// Which part of an image's size is too large: a side, or the total.
fn too_large([width, height]: [u64; 2], side: u32, rays: u64) -> String {
    let image = format!("an image of {width}x{height} pixels");
    if width.max(height) > u64::from(side) {
        return format!("{image} exceeds {side} per side, the limit of this device: choose a smaller size");
    }
    format!("{image} has {}; the limit of this device is {rays}: choose a smaller size", width * height)
}

impl From<GpuError> for Error {
    fn from(error: GpuError) -> Self {
        Self::failed(error)
    }
}

impl From<RenderError> for Error {
    fn from(error: RenderError) -> Self {
        Self::from(&error)
    }
}

impl From<&RenderError> for Error {
    fn from(error: &RenderError) -> Self {
        match error {
            RenderError::Plan(error) => error.into(),
            RenderError::NoElement { .. } => Self::usage(format!("--photon: {error}")),
            _ => Self::failed(error),
        }
    }
}

impl From<raystep_lab::Error> for Error {
    fn from(error: raystep_lab::Error) -> Self {
        Self::from(&error)
    }
}

impl From<&raystep_lab::Error> for Error {
    fn from(error: &raystep_lab::Error) -> Self {
        use raystep_lab::Error::{Case, NoRays, Plan, Render};
        match error {
            Plan(error) => error.into(),
            Render(error) => error.into(),
            Case { name, error } => Self::failed(format!("{name}: {}", Self::from(&**error).message)),
            NoRays => Self::failed("nothing to measure: no pixel has a ray of the kinds in --rays"),
            _ => Self::failed(error),
        }
    }
}
