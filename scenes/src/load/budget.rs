//! Limits what is decoded, so that a small file cannot exhaust memory.

use super::LoadError;
use std::cell::Cell;

/// The number of bytes that may still be decoded.
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

    /// Takes `needed` bytes for the value at `path`.
    pub(super) fn take(&self, needed: u64, path: &str) -> Result<(), LoadError> {
        let left = self.left.get();
        match left.checked_sub(needed) {
            Some(rest) => self.left.set(rest),
            None => return Err(LoadError::TooLarge { path: path.to_owned(), needed, left, limit: self.limit }),
        }
        Ok(())
    }

    /// Takes `needed` bytes while `work` runs. Use it only if something else limits the time: memory that is returned
    /// again and again would allow a file to keep a reader busy forever.
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

    /// Takes space for `count` elements and reserves exactly that.
    pub(super) fn vec<T>(&self, count: u64, path: &str) -> Result<Vec<T>, LoadError> {
        self.take(count.saturating_mul(size_of::<T>() as u64), path)?;
        reserve(count, path)
    }

    /// Appends an element to a vector of [`vec`](Self::vec), or a new one. If it is full, takes space for as many
    /// elements again.
    pub(super) fn push<T>(&self, vec: &mut Vec<T>, element: T, path: &str) -> Result<(), LoadError> {
        if vec.len() == vec.capacity() {
            let more = vec.len().max(4);
            let bytes = (more as u64).saturating_mul(size_of::<T>() as u64);
            self.take(bytes, path)?;
            vec.try_reserve_exact(more).map_err(|_| LoadError::OutOfMemory { path: path.to_owned(), bytes })?;
        }
        vec.push(element);
        Ok(())
    }
}

/// Reserves exactly `count` elements, or returns an error if there is not enough memory.
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
