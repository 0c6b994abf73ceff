//! CSV files of rows.

use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

/// Writes the rows with a header.
pub(crate) fn write<T: Serialize>(path: &Path, rows: &[T]) -> Result<(), String> {
    let wrong = |e: csv::Error| format!("{}: {e}", path.display());
    let mut writer = csv::Writer::from_path(path).map_err(wrong)?;
    rows.iter().try_for_each(|row| writer.serialize(row)).map_err(wrong)?;
    writer.flush().map_err(|e| format!("{}: {e}", path.display()))
}

/// Reads the rows; none if the section was not measured.
pub(crate) fn read<T: DeserializeOwned>(path: &Path) -> Result<Vec<T>, String> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let wrong = |e: csv::Error| format!("{}: {e}", path.display());
    csv::Reader::from_path(path).map_err(wrong)?.deserialize().collect::<Result<_, _>>().map_err(wrong)
}
