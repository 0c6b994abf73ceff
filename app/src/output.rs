//! Atomic output files: written under a temporary name beside the target, then renamed.

mod archive;
mod stream;

use std::fs::{self, File};
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};

use tempfile::{NamedTempFile, TempDir};

use crate::commands::extension;
use crate::error::Error;
use crate::interrupt::{Temporary, create_inside};
use crate::scene_file::read_file;
use crate::usage::or;
pub(crate) use archive::zipped;
pub(crate) use stream::Stream;

/// An output file.
#[derive(Debug)]
pub(crate) struct Target {
    /// As the user wrote it.
    path: PathBuf,
    /// Its path after resolving links.
    place: PathBuf,
    /// A device or pipe: written to, never replaced.
    is_special: bool,
}

impl Target {
    /// Checks, before the work begins, that the folder exists and can be written to.
    pub(crate) fn new(path: &Path) -> Result<Self, Error> {
        let at = path.display();
        // A link is followed: its target is replaced, and the link stays.
        let place = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let is_special = match fs::metadata(&place) {
            Ok(found) if found.is_dir() => return Err(Error::failed(format!("{at} is a folder; name a file in it"))),
            Ok(found) => !found.is_file(),
            Err(_) => false,
        };
        if place.file_name().is_none() {
            return Err(Error::usage(format!("\"{at}\" names no file")));
        }
        let target = Self { path: path.to_owned(), place, is_special };
        if !is_special {
            let folder = target.folder();
            if !folder.is_dir() {
                return Err(Error::failed(format!("cannot write {at}: there is no folder {}", folder.display())));
            }
            target.temporary()?.finish(drop);
        }
        Ok(target)
    }

    /// Whether two names refer to the same file.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        let folder = |t: &Self| fs::canonicalize(t.folder()).ok();
        !self.is_special && folder(self) == folder(other) && self.place.file_name() == other.place.file_name()
    }

    /// Whether it is one of these files, given by canonical names.
    fn is_any_of(&self, files: &[PathBuf]) -> bool {
        !self.is_special && fs::canonicalize(&self.place).is_ok_and(|place| files.contains(&place))
    }

    /// As the user wrote it.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    fn folder(&self) -> &Path {
        folder_of(&self.place)
    }

    fn temporary(&self) -> Result<Temporary<NamedTempFile>, Error> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(".raystep-").suffix(".part");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            // Permissions follow the umask, as for any new file.
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        Temporary::create(|| builder.tempfile_in(self.folder()), NamedTempFile::path).map_err(|e| self.cannot(&e))
    }

    fn cannot(&self, error: &io::Error) -> Error {
        Error::cannot_write(&self.path, error)
    }
}

/// Checks the ending of a name, which determines the format; returns the matching one of `endings`.
pub(crate) fn ending(option: &str, path: &Path, endings: &'static [&'static str]) -> Result<&'static str, Error> {
    let extension = extension(path);
    if let Some(ending) = endings.iter().find(|ending| **ending == extension) {
        return Ok(ending);
    }
    let at = path.display();
    let wanted = or(&endings.iter().map(|ending| format!(".{ending}")).collect::<Vec<_>>());
    let example = format!("out.{}", endings[0]);
    let is_only_ending = path
        .file_name()
        .and_then(|name| name.to_str())
        .is_some_and(|name| name.strip_prefix('.').is_some_and(|rest| endings.contains(&rest.to_lowercase().as_str())));
    let wrong = match fs::metadata(path) {
        Ok(found) if found.is_dir() => {
            format!("it is a folder; name a file in it, such as {}", path.join(example).display())
        }
        Ok(found) if !found.is_file() => {
            format!("its name has no ending, which determines the format; use a name that ends in {wanted}")
        }
        _ if is_only_ending => format!("there is nothing before the ending; use for example {example}"),
        _ => format!("expected a name that ends in {wanted}"),
    };
    Err(Error::usage(format!("{option} {at}: {wrong}")))
}

/// Refuses outputs that would replace an input; `inputs` has canonical names.
pub(crate) fn refuse_inputs(outputs: &[Option<&Target>], inputs: &[PathBuf]) -> Result<(), Error> {
    match outputs.iter().flatten().find(|output| output.is_any_of(inputs)) {
        Some(output) => Err(replaces_input(&output.path)),
        None => Ok(()),
    }
}

/// Refuses a folder that contains files with our `names` unless they are from `origin`, as the file `known_by` shows.
pub(crate) fn refuse_others(
    folder: &Path,
    names: &[&str],
    origin: &str,
    known_by: &str,
    is_ours: impl FnOnce(&[u8]) -> bool,
) -> Result<(), Error> {
    const MOST_BYTES: u64 = 1 << 30;
    let Some(name) = names.iter().find(|name| folder.join(name).exists()) else { return Ok(()) };
    if read_file(&folder.join(known_by), MOST_BYTES).is_ok_and(|bytes| is_ours(&bytes)) {
        return Ok(());
    }
    Err(Error::failed(format!(
        "{} contains a {name} that is not from {origin}: choose another folder",
        folder.display()
    )))
}

fn replaces_input(path: &Path) -> Error {
    Error::usage(format!("{} would be replaced, but the scene is read from it: choose another output", path.display()))
}

/// The folder of `path`.
pub(crate) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Writes all files, then renames all of them: if one cannot be written, none appears.
pub(crate) fn write(files: Vec<(Target, Vec<u8>)>) -> Result<(), Error> {
    let mut written = Vec::new();
    for (target, bytes) in &files {
        if target.is_special {
            let mut out = File::options().write(true).open(&target.place).map_err(|e| target.cannot(&e))?;
            out.write_all(bytes).and_then(|()| out.flush()).map_err(|e| target.cannot(&e))?;
        } else {
            let mut temporary = target.temporary()?;
            let file = &mut temporary.inner;
            // A full disk may only be reported when data reaches it.
            if let Err(error) = file.write_all(bytes).and_then(|()| file.as_file().sync_all()) {
                temporary.finish(drop);
                return Err(target.cannot(&error));
            }
            written.push((target, temporary));
        }
    }
    for (target, temporary) in written {
        temporary.finish(|file| file.persist(&target.place)).map_err(|e| target.cannot(&e.error))?;
    }
    Ok(())
}

/// What there is where an output folder is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Folder {
    /// Nothing, in a folder that exists.
    Missing,
    /// A folder without files.
    Empty,
    /// A folder with files.
    Full,
}

impl Folder {
    /// Looks at a path, which must not be a file's.
    pub(crate) fn find(path: &Path) -> Result<Self, Error> {
        let at = path.display();
        match fs::metadata(path) {
            Ok(found) if !found.is_dir() => Err(Error::failed(format!("{at} is not a folder"))),
            Ok(_) => {
                let mut files = fs::read_dir(path).map_err(|e| Error::cannot_write(path, &e))?;
                Ok(if files.next().is_some() { Self::Full } else { Self::Empty })
            }
            Err(_) if folder_of(path).is_dir() => Ok(Self::Missing),
            Err(_) => {
                let folder = folder_of(path).display();
                Err(Error::failed(format!("cannot write {at}: there is no folder {folder}")))
            }
        }
    }
}

/// An output folder that appears once all its files are complete.
pub(crate) struct TargetFolder {
    /// As the user wrote it.
    path: PathBuf,
    staging: Temporary<TempDir>,
    /// Whether the folder existed before: then files are moved into it.
    exists: bool,
}

impl TargetFolder {
    /// Creates the folder under a temporary name. An existing folder must be empty, unless files in it may be replaced.
    pub(crate) fn new(path: &Path, may_replace: bool) -> Result<Self, Error> {
        let at = path.display();
        let cannot = |e: &io::Error| Error::cannot_write(path, e);
        let found = Folder::find(path)?;
        if found == Folder::Full && !may_replace {
            return Err(Error::failed(format!(
                "{at} is not empty: choose another folder, or use --force to replace files in it"
            )));
        }
        let exists = found != Folder::Missing;
        // Renaming requires the same file system.
        let beside = if exists { path } else { folder_of(path) };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".raystep-").suffix(".part");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            // Permissions follow the umask, as for any new folder.
            builder.permissions(fs::Permissions::from_mode(0o777));
        }
        let staging = Temporary::create(|| builder.tempdir_in(beside), TempDir::path).map_err(|e| cannot(&e))?;
        Ok(Self { path: path.to_owned(), staging, exists })
    }

    /// The location of its files until all are complete, on the target's file system.
    pub(crate) fn place(&self) -> &Path {
        self.staging.inner.path()
    }

    /// Refuses to replace an input file by one of its own files, which `is_ours` recognises.
    pub(crate) fn refuse_inputs(&self, inputs: &[PathBuf], is_ours: impl Fn(&str) -> bool) -> Result<(), Error> {
        let Ok(folder) = fs::canonicalize(&self.path) else { return Ok(()) };
        let name = |input: &PathBuf| Some(input.file_name()?.to_str()?.to_owned());
        let mut names = inputs.iter().filter(|input| input.parent() == Some(&folder)).filter_map(name);
        names.find(|name| is_ours(name)).map_or(Ok(()), |name| Err(replaces_input(&self.path.join(name))))
    }

    /// Writes a file into it.
    pub(crate) fn write(
        &self,
        name: &str,
        fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> Result<(), Error> {
        let path = self.place().join(name);
        let written = create_inside(|| File::create_new(path)).and_then(|file| {
            let mut out = BufWriter::new(file);
            fill(&mut out)?;
            out.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()
        });
        written.map_err(|e| Error::cannot_write(&self.path.join(name), &e))
    }

    /// Renames the folder once `fill` has written its files; removes everything if that fails. Earlier files in `stale`
    /// are deleted.
    pub(crate) fn fill<T>(self, stale: &[String], fill: impl FnOnce(&Self) -> Result<T, Error>) -> Result<T, Error> {
        match fill(&self) {
            Ok(filled) => self.finish(stale).map(|()| filled),
            Err(error) => {
                self.staging.finish(drop);
                Err(error)
            }
        }
    }

    fn finish(self, stale: &[String]) -> Result<(), Error> {
        let Self { path, staging, exists } = self;
        staging
            .finish(|staging| {
                if !exists {
                    fs::rename(staging.path(), &path)?;
                    // It no longer exists, so there is nothing to remove.
                    let _ = staging.keep();
                    return Ok(());
                }
                for name in stale {
                    match fs::remove_file(path.join(name)) {
                        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                        _ => {}
                    }
                }
                for file in fs::read_dir(staging.path())? {
                    let file = file?;
                    fs::rename(file.path(), path.join(file.file_name()))?;
                }
                staging.close()
            })
            .map_err(|e: io::Error| Error::cannot_write(&path, &e))
    }
}
