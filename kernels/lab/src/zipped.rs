//! A user's program in a zip file: one file to hand on, and what a link in the web can name.

use std::collections::BTreeMap;
use std::io::{Cursor, Read as _};

use raystep_kernels::options::folder::{Folder, FolderError};
use zip::ZipArchive;
use zip::result::ZipError;

/// Why a zip file is no program.
#[derive(Debug, thiserror::Error)]
pub enum ZippedError {
    /// It does not begin as a zip file does.
    #[error("not a zip file")]
    NotZip,
    /// It cannot be read.
    #[error("the zip file cannot be read: {0}")]
    Zip(#[from] ZipError),
    /// A file in it cannot be read.
    #[error("{0}: {1}")]
    File(String, std::io::Error),
    /// A name in it is of no file in a folder.
    #[error("{0:?} is not the path of a file in the folder")]
    Path(String),
    /// Two of its files have the same path.
    #[error("{0} is in it twice")]
    Twice(String),
    /// Its files are no program.
    #[error(transparent)]
    Folder(#[from] FolderError),
}

/// Whether bytes are those of a zip file.
#[must_use]
pub fn is_zip(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04")
}

/// The program in a zip file; `place` is what it is called in messages. Its files may be in a folder of their own.
///
/// No more memory is taken than a program's files may have, whatever the zip file says of their sizes.
///
/// # Errors
/// If it cannot be read, or is no program.
pub fn folder(place: &str, bytes: &[u8]) -> Result<Folder, ZippedError> {
    // Other bytes may come before the first file, as in one that unpacks itself.
    let opened = ZipArchive::new(Cursor::new(bytes));
    let mut zip = opened.map_err(|error| if is_zip(bytes) { ZippedError::Zip(error) } else { ZippedError::NotZip })?;
    if zip.len() > 2 * Folder::MOST_FILES {
        return Err(FolderError::Files(zip.len()).into());
    }
    let mut files = BTreeMap::new();
    let mut left = Folder::MOST_BYTES;
    for index in 0..zip.len() {
        let file = zip.by_index(index)?;
        if !file.is_file() {
            continue;
        }
        let name = file.name()?.into_owned();
        if !Folder::is_inside(&name) {
            return Err(ZippedError::Path(name));
        }
        let mut content = Vec::new();
        // One more byte shows that there is more than may be.
        file.take(left + 1).read_to_end(&mut content).map_err(|error| ZippedError::File(name.clone(), error))?;
        left = left.checked_sub(content.len() as u64).ok_or(FolderError::Bytes(Folder::MOST_BYTES + 1))?;
        if files.insert(name.clone(), content).is_some() {
            return Err(ZippedError::Twice(name));
        }
    }
    let top = top_of(&files);
    let inside = |(name, content): (String, Vec<u8>)| Some((name.strip_prefix(&top)?.to_owned(), content));
    let files = files.into_iter().filter_map(inside).collect();
    let name = place.rsplit(['/', '\\']).next().unwrap_or(place);
    let name = name.strip_suffix(".zip").unwrap_or(name).to_owned();
    Ok(Folder::new(name, place.to_owned(), files)?)
}

/// The folder of `program.toml`, with a slash behind it, if it is in one: that with the shortest path.
fn top_of(files: &BTreeMap<String, Vec<u8>>) -> String {
    let tops = files.keys().filter_map(|name| name.strip_suffix(Folder::MANIFEST));
    tops.filter(|top| top.is_empty() || top.ends_with('/')).min_by_key(|top| top.len()).unwrap_or("").to_owned()
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use zip::write::{SimpleFileOptions, ZipWriter};

    use super::*;

    fn zip(files: &[(&str, &[u8])]) -> Vec<u8> {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        for (name, content) in files {
            zip.start_file(*name, SimpleFileOptions::default()).expect("a file");
            zip.write_all(content).expect("bytes");
        }
        zip.finish().expect("a zip file").into_inner()
    }

    #[test]
    fn a_program_is_read_with_or_without_a_folder_around_it() {
        for top in ["", "life/"] {
            let names = ["program.toml", "rule.wgsl", "data/start.npy"].map(|name| format!("{top}{name}"));
            let files: Vec<(&str, &[u8])> = names.iter().map(|name| (name.as_str(), name.as_bytes())).collect();
            let folder = folder("some/life.zip", &zip(&files)).expect("a program");
            assert_eq!(folder.name, "life");
            let found: Vec<&str> = folder.files().map(|(name, _)| name).collect();
            assert_eq!(found, ["data/start.npy", "program.toml", "rule.wgsl"]);
            assert_eq!(folder.file("rule.wgsl"), Some(names[1].as_bytes()));
        }
    }

    #[test]
    fn tricks_are_refused() {
        let told = |bytes: &[u8]| folder("a.zip", bytes).expect_err("refused").to_string();
        assert!(told(b"PK\x03\x04 and nothing else").starts_with("the zip file cannot be read: "), "{}", told(b"PK"));
        assert_eq!(told(b"something else"), "not a zip file");
        assert_eq!(told(&zip(&[("other", b"")])), "no program.toml: 'raystep new NAME' makes a folder with one");
        for path in ["../program.toml", "/etc/program.toml", "a/../../program.toml", "C:\\program.toml"] {
            assert!(told(&zip(&[(path, b"")])).contains("is not the path of a file"), "{path}");
        }
        // A name that the directory has twice.
        let mut twice = zip(&[("program.toml", b"a"), ("program.tomk", b"b")]);
        let at: Vec<usize> = (0..twice.len() - 12).filter(|&at| &twice[at..at + 12] == b"program.tomk").collect();
        at.iter().for_each(|&at| twice[at + 11] = b'l');
        assert!(
            folder("a.zip", &twice).is_ok_and(|folder| folder.files().count() == 1) || told(&twice).contains("twice")
        );
        // A file that unpacks to more than a program may have: 300 MB of zeros take 300 KB.
        let zeros = vec![0; 300 << 20];
        assert!(told(&zip(&[("program.toml", &zeros)])).contains("bytes are too many"));
        let many: Vec<String> = (0..2 * Folder::MOST_FILES + 1).map(|index| index.to_string()).collect();
        let many: Vec<(&str, &[u8])> = many.iter().map(|name| (name.as_str(), &[][..])).collect();
        assert!(told(&zip(&many)).contains("files are too many"));
    }

    /// Any bytes are a program or an error.
    #[test]
    fn damaged_files_are_refused() {
        let whole = zip(&[("program.toml", b"summary = \"a\""), ("a.wgsl", &[b'a'; 1000])]);
        let mut random = fastrand::Rng::with_seed(1);
        for _ in 0..20_000 {
            let mut bytes = whole.clone();
            for _ in 0..random.usize(1..4) {
                let at = random.usize(..bytes.len());
                bytes[at] = random.u8(..);
            }
            bytes.truncate(if random.bool() { bytes.len() } else { random.usize(..bytes.len()) });
            let _ = folder("a.zip", &bytes);
        }
    }
}
