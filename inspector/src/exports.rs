//! Exports as bytes; the caller decides where they go.
//!
//! The formats are those of [`raystep_kernels::export`], the same that the command line writes.

use std::io::Cursor;

use raystep_kernels::StreamData;
use raystep_kernels::export::trace::Trace;
use raystep_kernels::export::{Recorded, exr, npy};
use raystep_lab::text::counted;
use serde::Serialize;

/// The name of jobs that answer with an [`Export`].
pub const EXPORTING: &str = "exporting";

/// An exported file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Export {
    /// A proposed name without the extension, valid on every file system.
    pub name: String,
    /// The extension, without a dot.
    pub extension: &'static str,
    /// Its contents.
    pub bytes: Vec<u8>,
    /// Description of the contents: "73 rows".
    pub holds: String,
}

/// An export failed.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// As CSV.
    #[error("cannot write as CSV: {0}")]
    Csv(String),
    /// As JSON.
    #[error("cannot write as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// As a NumPy array.
    #[error("cannot write as npy: {0}")]
    Npy(#[from] std::io::Error),
    /// As OpenEXR.
    #[error("cannot write as EXR: {0}")]
    Exr(#[from] exr::ExrError),
}

impl Export {
    fn new(name: &str, extension: &'static str, bytes: Vec<u8>, holds: String) -> Self {
        // Scene names can contain any characters.
        let name: String =
            name.chars().map(|c| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '-' }).take(100).collect();
        let name = name.trim_matches('.');
        Self { name: if name.is_empty() { "raystep".into() } else { name.into() }, extension, bytes, holds }
    }

    fn json(name: &str, value: &impl Serialize, holds: String) -> Result<Self, ExportError> {
        let mut bytes = serde_json::to_vec_pretty(value)?;
        bytes.push(b'\n');
        Ok(Self::new(name, "json", bytes, holds))
    }

    /// The name with its extension.
    #[must_use]
    pub fn file_name(&self) -> String {
        format!("{}.{}", self.name, self.extension)
    }
}

/// Passes as rows of `passes.csv`, as the command line writes them.
///
/// # Errors
/// [`ExportError::Csv`].
pub fn passes_csv(recorded: &Recorded<'_>) -> Result<Export, ExportError> {
    let bytes = recorded.csv().map_err(|e| ExportError::Csv(e.to_string()))?;
    let name = format!("{}.passes", recorded.run.scene);
    Ok(Export::new(&name, "csv", bytes, counted(recorded.passes.len(), "row")))
}

/// Passes as Chrome trace events, for Perfetto.
///
/// # Errors
/// [`ExportError::Json`].
pub fn passes_trace(recorded: &Recorded<'_>) -> Result<Export, ExportError> {
    let bytes = serde_json::to_vec(&recorded.trace_events())?;
    let name = format!("{}.trace", recorded.run.scene);
    Ok(Export::new(&name, "json", bytes, counted(recorded.passes.len(), "pass")))
}

fn texels(data: &StreamData) -> String {
    let layers = counted(data.stream.layers(), "layer");
    format!("{}, {layers} of {} x {} texels", data.stream.name(), data.width, data.height)
}

/// As `dump` names a stream: after pass `pass`, or before the first.
fn stream_name(data: &StreamData, pass: Option<usize>) -> String {
    let name = data.stream.name();
    pass.map_or_else(|| format!("start.{name}"), |pass| format!("pass-{pass:06}.{name}"))
}

/// A stream as a NumPy array (layer, row, column). `pass` is the one that it was read after, if any.
///
/// # Errors
/// [`ExportError::Npy`].
pub fn stream_npy(data: &StreamData, pass: Option<usize>) -> Result<Export, ExportError> {
    let mut bytes = Vec::new();
    npy::write_stream(&mut bytes, data)?;
    Ok(Export::new(&stream_name(data, pass), "npy", bytes, texels(data)))
}

/// A stream as OpenEXR, a channel a layer. `pass` is the one that it was read after, if any.
///
/// # Errors
/// [`ExportError::Exr`].
pub fn stream_exr(data: &StreamData, pass: Option<usize>) -> Result<Export, ExportError> {
    let mut bytes = Cursor::new(Vec::new());
    exr::write_stream(&mut bytes, data)?;
    Ok(Export::new(&stream_name(data, pass), "exr", bytes.into_inner(), texels(data)))
}

/// The name of a file about a history.
pub(crate) fn ray_name(history: &Trace) -> String {
    let [x, y] = history.pixel;
    history.element.map_or_else(|| format!("ray-{x}-{y}"), |element| format!("{}-{}", element.noun(), element.index))
}

/// A ray's history as rows of CSV, as `trace --format csv` writes it.
///
/// # Errors
/// [`ExportError::Csv`].
pub fn ray_csv(history: &Trace) -> Result<Export, ExportError> {
    let mut bytes = Vec::new();
    history.write_csv(&mut bytes).map_err(|e| ExportError::Csv(e.to_string()))?;
    Ok(Export::new(&ray_name(history), "csv", bytes, counted(history.rows.len(), "row")))
}

/// A ray's history as `trace --format json` writes it.
///
/// # Errors
/// [`ExportError::Json`].
pub fn ray_json(history: &Trace) -> Result<Export, ExportError> {
    Export::json(&ray_name(history), history, counted(history.rows.len(), "row"))
}
