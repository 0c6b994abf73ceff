//! Results of a long measurement that was interrupted: two files beside its output folder, to which finished rows are
//! appended, and which the same command continues from.

use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use raystep_lab::Machine;
use raystep_lab::stiff::{self, Kept, Start};

use crate::error::Error;
use crate::output::folder_of;
use crate::scene_file::read_file;
use crate::terminal::Progress;

/// Far more than all families have.
const MOST_BYTES: u64 = 1 << 28;

/// Both files.
pub(crate) struct Unfinished {
    rows: PathBuf,
    runs: PathBuf,
}

impl Unfinished {
    /// Those of an output folder. Nothing is read or written yet.
    pub(crate) fn beside(folder: &Path) -> Result<Self, Error> {
        let place = fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned());
        let Some(name) = place.file_name() else {
            return Err(Error::usage(format!("--output {}: it has no name; use a folder with one", folder.display())));
        };
        let beside = |file: &str| {
            let mut name = name.to_owned();
            name.push(format!(".{file}.part"));
            folder_of(&place).join(name)
        };
        Ok(Self { rows: beside(stiff::CSV), runs: beside(stiff::RUNS) })
    }

    /// A measurement that continues from these files, and appends to them.
    pub(crate) fn start(&self, wanted: stiff::Wanted, machine: &Machine, progress: &Progress) -> Result<Start, Error> {
        let read = |path: &Path| if path.exists() { read_file(path, MOST_BYTES) } else { Ok(Vec::new()) };
        let cannot = |error: &dyn std::fmt::Display| {
            let at = self.rows.display();
            Error::failed(format!(
                "{at} is of an unfinished measurement that cannot be continued: {error}; use the same options, or delete \
                 the file"
            ))
        };
        let (rows, runs) = (read(&self.rows).map_err(|e| cannot(&e))?, read(&self.runs).map_err(|e| cannot(&e))?);
        let kept = Kept::read(&rows, &runs, &wanted, machine).map_err(|e| cannot(&e))?;
        if kept.count() > 0 {
            progress.say(format_args!("continuing: {} results are in {}", kept.count(), self.rows.display()));
        }
        // Without what was cut off.
        let [rows, runs] = kept.files().map_err(Error::failed)?;
        let mut files = [(&self.rows, rows), (&self.runs, runs)].map(|(path, bytes)| replaced(path, &bytes));
        for (file, path) in files.iter_mut().zip([&self.rows, &self.runs]) {
            if let Err(error) = file {
                return Err(Error::cannot_write(path, error));
            }
        }
        let [rows, runs] = files;
        let (mut rows, mut runs) = (rows.map_err(Error::failed)?, runs.map_err(Error::failed)?);
        Ok(Start::new(wanted, kept, move |name, lines| {
            let file = if name == stiff::CSV { &mut rows } else { &mut runs };
            file.write_all(lines)
        }))
    }

    /// Removes the files of a finished measurement.
    pub(crate) fn remove(&self) {
        for path in [&self.rows, &self.runs] {
            // What remains is refused or continued from, never mistaken for something else.
            let _ = fs::remove_file(path);
        }
    }
}

/// A file with these contents, to append to.
fn replaced(path: &Path, contents: &[u8]) -> io::Result<File> {
    let temporary = path.with_added_extension("new");
    let mut file = File::create(&temporary)?;
    file.write_all(contents)?;
    fs::rename(temporary, path)?;
    Ok(file)
}
