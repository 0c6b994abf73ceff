//! Which elements of a pass come to a line of a kernel, and for which of them a condition holds there.
//!
//! The interpreter runs all elements of the pass, from the streams before it.

mod told;

use std::ops::ControlFlow;

use raystep_kernels::interpret::Stopped;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::shader::{FileLine, Sourced};
use raystep_kernels::tables::elements::Size;
use raystep_kernels::{RenderError, Renderer};

use crate::passed::{Begun, Code, Failure, step};
pub use told::Told;

/// Passes of the kernel that are interpreted at most.
pub const PASSES: usize = 4096;

/// A pass in which an element stops.
#[derive(Clone, Debug)]
pub struct StoppedPass {
    /// The pass, from 0.
    pub pass: usize,
    /// The size of the kernel's set.
    pub size: Size,
    /// The elements that came to the line, by their place in the set, and what they did there.
    pub elements: Vec<(usize, Stopped)>,
}

/// What was found.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// A pass.
    Stopped(StoppedPass),
    /// No element stopped in the passes that were looked at.
    Never {
        /// Passes of the kernel.
        passes: usize,
        /// Passes of all kernels.
        of: usize,
        /// Elements that came to the line, added over the passes.
        reached: u64,
        /// Whether there may be more passes: as many as allowed were looked at.
        is_cut: bool,
    },
    /// The pass that was asked for is another kernel's, whose name this is.
    Other(&'static str),
    /// The run has only so many passes.
    Ended(usize),
}

/// Why it is not known.
#[derive(Debug, thiserror::Error)]
pub enum StopsError {
    /// The device failed.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// An element cannot be interpreted.
    #[error("pass {pass}: {failure}")]
    Failed {
        /// The pass, from 0.
        pass: usize,
        /// How.
        failure: Failure,
    },
}

impl StoppedPass {
    /// The elements for which the condition held.
    pub fn held(&self) -> impl Iterator<Item = &(usize, Stopped)> {
        self.elements.iter().filter(|(_, stopped)| stopped.held > 0)
    }
}

/// No statement begins in a line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}: no statement of {kernel} begins in this line{}", next.map_or_else(String::new, |next| format!("; the next is in line {next}")))]
pub struct NoStatement {
    /// The file.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// The kernel.
    pub kernel: &'static str,
    /// The nearest line after it in which one begins, or the last of the file.
    pub next: Option<usize>,
}

/// The statement that begins in a line.
///
/// # Errors
/// If none does.
pub fn statement(of: &Sourced, at: FileLine) -> Result<usize, NoStatement> {
    of.statement(at).ok_or_else(|| {
        let lines = of.statement_lines(at.file);
        let next = lines.iter().find(|&&line| line > at.line).or(lines.last()).copied();
        let file = of.files.get(at.file).map_or_else(String::new, |file| file.name.clone());
        NoStatement { file, line: at.line, kernel: of.variant.kernel.name(), next }
    })
}

/// Runs to a pass, and returns what it began with; or why there is none.
///
/// # Errors
/// If the device fails.
pub async fn begun(renderer: &mut Renderer, code: &Code, pass: usize) -> Result<Result<Begun, Outcome>, RenderError> {
    renderer.run_to(pass, |_| ControlFlow::Continue(())).await?;
    if renderer.pass_count() < pass {
        return Ok(Err(Outcome::Ended(renderer.pass_count())));
    }
    match renderer.next_kernel() {
        Some(kernel) if kernel == code.kernel() => {}
        Some(other) => return Ok(Err(Outcome::Other(other.name()))),
        None => return Ok(Err(Outcome::Ended(renderer.pass_count()))),
    }
    let begun = step(renderer, code.streams()).await?;
    Ok(begun.ok_or_else(|| Outcome::Ended(renderer.pass_count())))
}

/// Looks at a pass of a kernel with one stop, or at its passes up to the first in which an element stops. `progress` is told
/// the passes that have run, and returns whether to go on.
///
/// # Errors
/// If the device fails, an element cannot be interpreted, or `progress` stops it.
pub async fn find(
    renderer: &mut Renderer,
    code: &Code,
    pass: Option<usize>,
    most: usize,
    mut progress: impl FnMut(usize) -> bool,
) -> Result<Outcome, StopsError> {
    if let Some(pass) = pass {
        let begun = match begun(renderer, code, pass).await? {
            Ok(begun) => begun,
            Err(outcome) => return Ok(outcome),
        };
        return Ok(Outcome::Stopped(of_pass(code, &begun, renderer.data())?));
    }
    let (mut passes, mut reached) = (0, 0);
    while let Some(kernel) = renderer.next_kernel() {
        if !progress(renderer.pass_count()) {
            return Err(RenderError::Cancelled { passes: renderer.pass_count() }.into());
        }
        if kernel != code.kernel() {
            renderer.step().await?;
            continue;
        }
        if passes >= most {
            return Ok(Outcome::Never { passes, of: renderer.pass_count(), reached, is_cut: true });
        }
        let Some(begun) = step(renderer, code.streams()).await? else { break };
        passes += 1;
        let found = of_pass(code, &begun, renderer.data())?;
        if found.held().next().is_some() {
            return Ok(Outcome::Stopped(found));
        }
        reached += found.elements.len() as u64;
    }
    Ok(Outcome::Never { passes, of: renderer.pass_count(), reached, is_cut: false })
}

/// What elements do at the stop of a kernel in a pass.
///
/// # Errors
/// If an element cannot be interpreted.
pub fn of_pass(code: &Code, begun: &Begun, data: &SceneData) -> Result<StoppedPass, StopsError> {
    let pass = begun.pass.index;
    let found = code.stopped(begun, data).map_err(|failure| StopsError::Failed { pass, failure })?;
    let first = |(element, stopped): (usize, Vec<Stopped>)| {
        stopped.into_iter().next().filter(|stopped| stopped.reached > 0).map(|stopped| (element, stopped))
    };
    Ok(StoppedPass { pass, size: begun.size, elements: found.into_iter().filter_map(first).collect() })
}
