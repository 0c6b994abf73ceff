//! Counts what is decoded, so that a small file cannot ask for a large machine.

use super::LoadError;
use std::cell::Cell;

/// The bytes that may still be decoded.
pub(super) struct Budget {
    limit: u64,
    left: Cell<u64>,
}

impl Budget {
    pub(super) fn new(limit: u64) -> Self {
        Self { limit, left: Cell::new(limit) }
    }

    /// Bytes left.
    pub(super) fn left(&self) -> u64 {
        self.left.get()
    }

    /// Takes `needed` bytes for what stands at `path`.
    pub(super) fn take(&self, needed: u64, path: &str) -> Result<(), LoadError> {
        let left = self.left.get();
        match left.checked_sub(needed) {
            Some(rest) => self.left.set(rest),
            None => return Err(LoadError::TooLarge { path: path.to_owned(), needed, left, limit: self.limit }),
        }
        Ok(())
    }

    /// Takes `needed` bytes while `work` runs. Only for what something else bounds in time: whoever could have
    /// memory back again and again could also keep a reader busy without end.
    pub(super) fn hold<T>(
        &self,
        needed: u64,
        path: &str,
        work: impl FnOnce() -> Result<T, LoadError>,
    ) -> Result<T, LoadError> {
        self.take(needed, path)?;
        let done = work();
        self.left.set(self.left.get().saturating_add(needed));
        done
    }

    /// Takes room for `count` elements and reserves exactly that.
    pub(super) fn vec<T>(&self, count: u64, path: &str) -> Result<Vec<T>, LoadError> {
        self.take(count.saturating_mul(size_of::<T>() as u64), path)?;
        reserve(count, path)
    }
}

/// Reserves exactly `count` elements, or says that the memory is not there.
pub(super) fn reserve<T>(count: u64, path: &str) -> Result<Vec<T>, LoadError> {
    let mut vec = Vec::new();
    let reserved = usize::try_from(count).ok().and_then(|count| vec.try_reserve_exact(count).ok());
    match reserved {
        Some(()) => Ok(vec),
        None => {
            let bytes = count.saturating_mul(size_of::<T>() as u64);
            Err(LoadError::OutOfMemory { path: path.to_owned(), bytes })
        }
    }
}
