//! An output that is written piece by piece: a file under a temporary name until it is complete, a pipe, or standard
//! output.

use std::fs::File;
use std::io::{self, Seek as _, SeekFrom, Write as _};

use tempfile::NamedTempFile;

use super::Target;
use crate::error::{Error, reason};
use crate::interrupt::Temporary;

/// Where it goes.
enum Place {
    File(Target, Temporary<NamedTempFile>),
    Special(Target, File),
    Standard(io::Stdout),
}

/// An output in progress.
pub(crate) struct Stream(Place);

impl Stream {
    /// Opens it; without a target, standard output.
    pub(crate) fn new(target: Option<Target>) -> Result<Self, Error> {
        Ok(Self(match target {
            None => Place::Standard(io::stdout()),
            Some(target) if target.is_special => {
                let file = File::options().write(true).open(&target.place).map_err(|e| target.cannot(&e))?;
                Place::Special(target, file)
            }
            Some(target) => {
                let temporary = target.temporary()?;
                Place::File(target, temporary)
            }
        }))
    }

    /// Appends bytes; false if the reader of a pipe has closed it.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> Result<bool, Error> {
        let written = match &mut self.0 {
            Place::File(_, temporary) => temporary.inner.write_all(bytes),
            Place::Special(_, file) => file.write_all(bytes),
            Place::Standard(out) => out.write_all(bytes).and_then(|()| out.flush()),
        };
        match written {
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(false),
            written => written.map(|()| true).map_err(|error| self.cannot(&error)),
        }
    }

    /// Whether its begin can be replaced.
    pub(crate) fn can_rewind(&self) -> bool {
        matches!(self.0, Place::File(..))
    }

    /// Replaces its begin, if it can, and appends nothing afterwards.
    pub(crate) fn replace_begin(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let Place::File(_, temporary) = &mut self.0 else { return Ok(()) };
        let file = &mut temporary.inner;
        let written = file.seek(SeekFrom::Start(0)).and_then(|_| file.write_all(bytes));
        written.map_err(|error| self.cannot(&error))
    }

    /// Gives a file its name.
    pub(crate) fn finish(self) -> Result<(), Error> {
        let Place::File(target, temporary) = self.0 else { return Ok(()) };
        // A full disk may only be reported when data reaches it.
        if let Err(error) = temporary.inner.as_file().sync_all() {
            temporary.finish(drop);
            return Err(target.cannot(&error));
        }
        temporary.finish(|file| file.persist(&target.place)).map_err(|e| target.cannot(&e.error))?;
        Ok(())
    }

    /// Removes what was written, as far as it can.
    pub(crate) fn abandon(self) {
        if let Place::File(_, temporary) = self.0 {
            temporary.finish(drop);
        }
    }

    fn cannot(&self, error: &io::Error) -> Error {
        match &self.0 {
            Place::File(target, _) | Place::Special(target, _) => target.cannot(error),
            Place::Standard(_) => Error::failed(format!("cannot write to standard output: {}", reason(error))),
        }
    }
}
