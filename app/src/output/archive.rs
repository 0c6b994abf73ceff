//! ZIP files of bundles.

use std::io::{Cursor, Write as _};

use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use crate::error::Error;

/// The bytes of a ZIP file with these files, given by path and contents. Scripts can be run.
pub(crate) fn zipped<'a>(files: impl IntoIterator<Item = (&'a str, &'a [u8])>) -> Result<Vec<u8>, Error> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let cannot = |e: &dyn std::fmt::Display| Error::failed(format!("--bundle: cannot compress: {e}"));
    for (path, bytes) in files {
        let mode = if path.ends_with(".sh") { 0o755 } else { 0o644 };
        zip.start_file(path, SimpleFileOptions::default().unix_permissions(mode)).map_err(|e| cannot(&e))?;
        zip.write_all(bytes).map_err(|e| cannot(&e))?;
    }
    Ok(zip.finish().map_err(|e| cannot(&e))?.into_inner())
}
