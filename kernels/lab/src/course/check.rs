//! A student's kernel in one view.

use std::ops::ControlFlow;
use std::sync::Arc;

use raystep_kernels::export::program::ExportError;
use raystep_kernels::options::folder::FolderError;
use raystep_kernels::options::replacement::Replacement;
use raystep_kernels::shared::constants::NO_TRIANGLE;
use raystep_kernels::{Device, Options, RenderError, Renderer};
use raystep_scenes::Scene;

use super::{Task, Verdict, View, ViewError};
use crate::check_kernel::{Outcome, check, mistake};
use crate::parity::ParityError;

/// What a check of one view has found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Found {
    /// Nothing wrong, for so many rays, summed over the passes.
    Right(u64),
    /// What is wrong.
    Wrong(Verdict),
}

/// Why a check has failed, which is not the student's fault.
#[derive(Debug, thiserror::Error)]
pub enum CheckError {
    /// The view cannot be made.
    #[error(transparent)]
    View(#[from] ViewError),
    /// The comparison has failed.
    #[error(transparent)]
    Parity(#[from] ParityError),
    /// A run has failed.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The program cannot be written.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// The files are no program.
    #[error(transparent)]
    Folder(#[from] FolderError),
}

/// Compares a student's kernel with the one that it replaces, in a view: in the interpreter, or on a GPU.
///
/// # Errors
/// If the view cannot be made, or the device fails.
pub(super) async fn check_kernel(
    task: &Task,
    view: &View,
    by: &Arc<Replacement>,
    device: &Device,
) -> Result<Found, CheckError> {
    let (scene, own) = task.run(view)?;
    let options = Options { replaced: vec![by.clone()], ..own.clone() };
    let outcome = match check(&scene, &options, device, task.may_round || device.is_gpu()).await {
        Ok(outcome) => outcome,
        Err(error) => {
            let Some(mistake) = mistake(&error) else { return Err(error.into()) };
            let (line, column) = (mistake.place.line, mistake.place.column);
            return Ok(Found::Wrong(Verdict::Mistake { message: mistake.message.clone(), line, column }));
        }
    };
    let rays = match outcome {
        Outcome::Same { rays, .. } => rays,
        Outcome::Differs(mut difference) => {
            // Lines of a module are not the student's, and may be the answer.
            difference.stored.iter_mut().filter(|line| line.line == 0).for_each(|line| line.text.clear());
            difference.decided.take_if(|decided| decided.at.line == 0);
            return Ok(Found::Wrong(Verdict::Differs(difference)));
        }
        Outcome::Miscounts { pass, states } => return Ok(Found::Wrong(Verdict::Miscounts { pass, states })),
        Outcome::Fails { message } => return Ok(Found::Wrong(Verdict::Fails { message })),
        Outcome::Idle => {
            let message = format!("no ray came to {}", task.kernel);
            return Ok(Found::Wrong(Verdict::Fails { message }));
        }
    };
    if task.is_watertight {
        let (theirs, ours) = (triangles(&scene, &options, device).await?, triangles(&scene, &own, device).await?);
        let leaks: Vec<usize> = (0..theirs.len().min(ours.len()))
            .filter(|&ray| theirs[ray] == NO_TRIANGLE && ours[ray] != NO_TRIANGLE)
            .collect();
        if let Some(&first) = leaks.first() {
            let (x, y) = (first as u32 % view.size.width, first as u32 / view.size.width);
            return Ok(Found::Wrong(Verdict::Leaks { pixel: [x, y], rays: leaks.len() }));
        }
    }
    Ok(Found::Right(rays))
}

/// The triangle that each ray hits.
async fn triangles(scene: &Scene, options: &Options, device: &Device) -> Result<Vec<u32>, RenderError> {
    let mut renderer = Renderer::new(scene, options, device).await?;
    renderer.run(|_| ControlFlow::Continue(())).await?;
    let triangle = renderer.results()?.triangle;
    Ok(renderer.values(triangle.stream).await?.layer(triangle.layer).to_vec())
}
