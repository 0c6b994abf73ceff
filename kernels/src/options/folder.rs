//! A user's program: the files of its folder.

use std::collections::BTreeMap;
use std::fmt;

/// The files of a program's folder, `program.toml` among them, by their paths in it.
#[derive(Clone, PartialEq, Eq)]
pub struct Folder {
    /// What the program is called: the folder's name.
    pub name: String,
    /// Where it is, for messages: what comes before a file's path.
    pub place: String,
    files: BTreeMap<String, Vec<u8>>,
    /// npy files that streams begin with, in place of what `program.toml` says.
    starts: BTreeMap<String, Vec<u8>>,
}

/// Why files are no program.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FolderError {
    /// No such file.
    #[error("no program.toml: 'raystep new NAME' makes a folder with one")]
    NoManifest,
    /// Too many.
    #[error("{0} files are too many for a program: at most {most}", most = Folder::MOST_FILES)]
    Files(usize),
    /// Too large.
    #[error("{0} bytes are too many for a program: at most {most}", most = Folder::MOST_BYTES)]
    Bytes(u64),
    /// Not a path inside of the folder.
    #[error("{0:?} is not the path of a file in the folder")]
    Path(String),
}

impl Folder {
    /// The file that says what the program is.
    pub const MANIFEST: &str = "program.toml";
    /// Most files of a program.
    pub const MOST_FILES: usize = 256;
    /// Most bytes of all files together.
    pub const MOST_BYTES: u64 = 1 << 28;

    /// From files by their paths, with `/` between folders.
    ///
    /// # Errors
    /// If there are too many bytes or files, one is not inside of the folder, or `program.toml` is missing.
    pub fn new(name: String, place: String, files: BTreeMap<String, Vec<u8>>) -> Result<Self, FolderError> {
        if files.len() > Self::MOST_FILES {
            return Err(FolderError::Files(files.len()));
        }
        let bytes: u64 = files.values().map(|file| file.len() as u64).sum();
        if bytes > Self::MOST_BYTES {
            return Err(FolderError::Bytes(bytes));
        }
        if let Some(path) = files.keys().find(|path| !Self::is_inside(path)) {
            return Err(FolderError::Path(path.clone()));
        }
        if !files.contains_key(Self::MANIFEST) {
            return Err(FolderError::NoManifest);
        }
        Ok(Self { name, place, files, starts: BTreeMap::new() })
    }

    /// Whether a path is one of a file inside of the folder.
    #[must_use]
    pub fn is_inside(path: &str) -> bool {
        let is_name = |part: &str| !matches!(part, "" | "." | "..") && !part.contains(['\\', ':', '\0']);
        path.split('/').all(is_name)
    }

    /// A file's bytes.
    #[must_use]
    pub fn file(&self, path: &str) -> Option<&[u8]> {
        self.files.get(path).map(Vec::as_slice)
    }

    /// The paths of its files and their bytes.
    pub fn files(&self) -> impl Iterator<Item = (&str, &[u8])> {
        self.files.iter().map(|(path, bytes)| (path.as_str(), bytes.as_slice()))
    }

    /// The same with another content of a file.
    ///
    /// # Errors
    /// If it is too large.
    pub fn with(&self, path: &str, bytes: Vec<u8>) -> Result<Self, FolderError> {
        let mut files = self.files.clone();
        files.insert(path.to_owned(), bytes);
        let with = Self::new(self.name.clone(), self.place.clone(), files)?;
        Ok(Self { starts: self.starts.clone(), ..with })
    }

    /// The same with streams that begin with other values: npy files by the streams' names.
    #[must_use]
    pub fn starting_with(self, starts: BTreeMap<String, Vec<u8>>) -> Self {
        Self { starts, ..self }
    }

    /// The npy files that streams begin with, in place of what `program.toml` says.
    pub fn starts(&self) -> impl Iterator<Item = (&str, &[u8])> {
        self.starts.iter().map(|(stream, bytes)| (stream.as_str(), bytes.as_slice()))
    }

    /// The path in the folder of a file that has this name in messages, if it is one of the program's.
    #[must_use]
    pub fn path_of<'a>(&self, named: &'a str) -> Option<&'a str> {
        let path = if self.place.is_empty() { named } else { named.strip_prefix(&self.place)?.strip_prefix('/')? };
        self.files.contains_key(path).then_some(path)
    }

    /// What a file is called in messages.
    #[must_use]
    pub fn named(&self, path: &str) -> String {
        if self.place.is_empty() { path.to_owned() } else { format!("{}/{path}", self.place) }
    }
}

impl fmt::Debug for Folder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({} files)", self.name, self.files.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(paths: &[(&str, usize)]) -> Result<Folder, FolderError> {
        let files = paths.iter().map(|(path, bytes)| ((*path).to_owned(), vec![0; *bytes])).collect();
        Folder::new("a".into(), "b/a".into(), files)
    }

    #[test]
    fn a_program_has_a_manifest_and_files_inside_of_its_folder() {
        let folder = of(&[("program.toml", 3), ("data/start.npy", 1)]).expect("a folder");
        assert_eq!(folder.file("data/start.npy"), Some(&[0][..]));
        assert_eq!(folder.named("step.wgsl"), "b/a/step.wgsl");
        assert_eq!(of(&[("other.toml", 1)]), Err(FolderError::NoManifest));
        for path in ["../x", "/etc/passwd", "a/../b", "a//b", "C:x", "a\\b", "", "."] {
            assert_eq!(of(&[("program.toml", 1), (path, 1)]), Err(FolderError::Path(path.into())), "{path}");
        }
        let many: BTreeMap<_, _> = (0..=Folder::MOST_FILES).map(|i| (i.to_string(), Vec::new())).collect();
        assert_eq!(Folder::new("a".into(), String::new(), many), Err(FolderError::Files(Folder::MOST_FILES + 1)));
    }
}
