//! Why the bytes of a scene cannot be prepared.

use crate::structures::bvh::BvhError;
use crate::structures::grid::GridError;

/// The buffers of a scene cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum SceneDataError {
    /// This machine's memory does not hold one of them.
    #[error("{bytes} bytes of memory for {name} are not to be had")]
    OutOfMemory {
        /// The buffer.
        name: &'static str,
        /// Its size.
        bytes: u64,
    },
    /// The grid cannot be built.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// The tree cannot be built.
    #[error(transparent)]
    Bvh(#[from] BvhError),
}

/// An empty list with room for `count` elements of the buffer `name`.
///
/// # Errors
/// Where there is no memory for it.
pub(super) fn reserve<T>(name: &'static str, count: usize) -> Result<Vec<T>, SceneDataError> {
    let mut list = Vec::new();
    let bytes = (count as u64).saturating_mul(size_of::<T>() as u64);
    list.try_reserve_exact(count).map_err(|_| SceneDataError::OutOfMemory { name, bytes })?;
    Ok(list)
}
