//! The formats of hits.

use std::fs::File;
use std::io::{self, Read as _, Seek as _, Write};

use raystep_kernels::export::npy::{HIT_FIELDS, Hits, HitsArray, RAY_FIELD};
use raystep_kernels::{AllHits, named};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use crate::error::{Error, reason};
use crate::output::Stream;

/// `--output-format`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum HitsFormat {
    /// An npy array of records.
    Structured,
    /// An npy array of numbers, one row per hit.
    Plain,
    /// A zip of an npy array for each field.
    Npz,
}

named!(HitsFormat, "structured, plain or npz", Structured "structured", Plain "plain", Npz "npz");

/// Writes hits in the order of their rays.
pub(super) struct HitsWriter {
    stream: Stream,
    /// The number of hits, if it is known before the end.
    total: Option<u64>,
    written: u64,
    /// All hits of rays are written, with the numbers of these.
    is_all: bool,
    kind: Kind,
}

enum Kind {
    /// One array, and whether its header is written.
    Array(HitsArray, bool),
    /// The fields of all hits so far, in temporary files: their sizes come before them.
    Fields(Vec<FieldFile>),
}

/// A field of the hits so far.
struct FieldFile {
    /// Its name, and NumPy's type.
    field: (&'static str, &'static str),
    array: HitsArray,
    file: File,
}

impl HitsWriter {
    /// `total`: the number of hits, if it is known.
    pub(super) fn new(stream: Stream, format: HitsFormat, total: Option<u64>, is_all: bool) -> Result<Self, Error> {
        let kind = match format {
            HitsFormat::Structured => Kind::Array(HitsArray::Structured, false),
            HitsFormat::Plain => Kind::Array(HitsArray::Plain, false),
            HitsFormat::Npz => {
                let rays = is_all.then_some((RAY_FIELD, HitsArray::Rays));
                let fields = HIT_FIELDS.into_iter().zip((0..).map(HitsArray::Field));
                let with_file = |(field, array)| {
                    let file = tempfile::tempfile().map_err(temporary)?;
                    Ok(FieldFile { field, array, file })
                };
                Kind::Fields(rays.into_iter().chain(fields).map(with_file).collect::<Result<_, Error>>()?)
            }
        };
        Ok(Self { stream, total, written: 0, is_all, kind })
    }

    /// Whether the number of hits has to be known before the first.
    pub(super) fn needs_total(&self) -> bool {
        matches!(self.kind, Kind::Array(..)) && !self.stream.can_rewind()
    }

    /// Appends hits; nothing is written before the first call. `false` if the reader of a pipe has closed it. `bytes` is
    /// scratch space.
    pub(super) fn write(&mut self, hits: &AllHits, bytes: &mut Vec<u8>) -> Result<bool, Error> {
        self.written += hits.hits.len() as u64;
        let hits = if self.is_all { Hits::All(hits) } else { Hits::Each(&hits.hits) };
        bytes.clear();
        match &mut self.kind {
            Kind::Array(array, has_header) => {
                if !std::mem::replace(has_header, true) {
                    bytes.extend(array.header(self.total.unwrap_or(0), self.is_all));
                }
                array.write(bytes, hits);
                self.stream.write(bytes)
            }
            Kind::Fields(files) => {
                for FieldFile { array, file, .. } in files {
                    bytes.clear();
                    array.write(bytes, hits);
                    file.write_all(bytes).map_err(temporary)?;
                }
                Ok(true)
            }
        }
    }

    /// Completes the output.
    pub(super) fn finish(mut self) -> Result<(), Error> {
        match self.kind {
            Kind::Array(array, _) => {
                if self.total.is_none() {
                    self.stream.replace_begin(&array.header(self.written, self.is_all))?;
                }
            }
            Kind::Fields(files) => zip_fields(&mut self.stream, files, self.written)?,
        }
        self.stream.finish()
    }

    /// Removes what was written, as far as it can.
    pub(super) fn abandon(self) {
        self.stream.abandon();
    }
}

fn temporary(error: io::Error) -> Error {
    Error::failed(format!("cannot write a temporary file: {}", reason(&error)))
}

/// An npz file, as numpy.savez writes it: nothing is compressed.
fn zip_fields(stream: &mut Stream, files: Vec<FieldFile>, hits: u64) -> Result<(), Error> {
    let mut out = Sink { stream, failure: None };
    let written = zip_into(&mut out, files, hits);
    match (out.failure, written) {
        (Some(failure), _) => Err(failure),
        (None, Err(error)) => Err(Error::failed(format!("cannot write npz: {error}"))),
        (None, Ok(())) => Ok(()),
    }
}

fn zip_into(out: &mut Sink<'_>, files: Vec<FieldFile>, hits: u64) -> Result<(), zip::result::ZipError> {
    let mut zip = ZipWriter::new_stream(out);
    let options = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored).large_file(true);
    for FieldFile { field: (name, kind), array, mut file } in files {
        zip.start_file(format!("{name}.npy"), options)?;
        zip.write_all(&array.header(hits, true))?;
        file.rewind()?;
        let bytes = if kind.ends_with('8') { 8 } else { 4 };
        io::copy(&mut file.take(bytes * hits), &mut zip)?;
    }
    zip.finish()?;
    Ok(())
}

/// Bytes for a stream, with what went wrong there. Whether a pipe was closed no longer matters: this is the end.
struct Sink<'a> {
    stream: &'a mut Stream,
    failure: Option<Error>,
}

impl Write for Sink<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self.stream.write(bytes) {
            Ok(_) => Ok(bytes.len()),
            Err(error) => {
                self.failure = Some(error);
                Err(io::Error::other("the output failed"))
            }
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
