//! Errors of preparing a scene's data.

use crate::numbers::bytes::Bytes;

/// This machine does not have enough memory for a buffer of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not enough memory for {name}, which needs {}", Bytes(*bytes))]
pub struct SceneDataError {
    /// The buffer.
    pub name: &'static str,
    /// Its size.
    pub bytes: u64,
}

/// An empty list with capacity for `count` elements of the buffer `name`.
///
/// # Errors
/// If there is not enough memory.
pub(super) fn reserve<T>(name: &'static str, count: usize) -> Result<Vec<T>, SceneDataError> {
    let mut list = Vec::new();
    let bytes = (count as u64).saturating_mul(size_of::<T>() as u64);
    list.try_reserve_exact(count).map_err(|_| SceneDataError { name, bytes })?;
    Ok(list)
}
