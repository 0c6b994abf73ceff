//! What becomes of an exercise in one view.

use std::sync::Arc;

use raystep_kernels::Device;
use raystep_kernels::options::replacement::Replacement;

use super::check::{CheckError, Found, check_kernel};
use super::check_schedule::check_schedule;
use super::{Task, View};

/// Compares a student's kernel with the one that it replaces, or the results of a schedule with ours, in a view: in the
/// interpreter, or on a GPU.
///
/// # Errors
/// If the view cannot be made, or the device fails.
pub async fn check_view(task: &Task, view: &View, by: &Arc<Replacement>, device: &Device) -> Result<Found, CheckError> {
    match task.is_schedule() {
        true => check_schedule(task, view, by, device).await,
        false => check_kernel(task, view, by, device).await,
    }
}
