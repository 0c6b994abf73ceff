//! RFC 4180, as spreadsheets read it without harm.

use std::io::Write;

/// A writer of RFC 4180; lines end with CRLF. A text that a spreadsheet would run as a formula, such as the name of a
/// scene that begins with `=`, gets an apostrophe before it, which makes it text there.
pub struct Writer<W: Write> {
    inner: ::csv::Writer<W>,
    /// Whether it has the names of columns, of rows that are [serialized](Self::serialize).
    has_names: bool,
}

/// A [`Writer`] to `out`.
#[must_use]
pub fn writer<W: Write>(out: W) -> Writer<W> {
    let inner = ::csv::WriterBuilder::new().terminator(::csv::Terminator::CRLF).from_writer(out);
    Writer { inner, has_names: false }
}

impl<W: Write> Writer<W> {
    /// Writes a row.
    ///
    /// # Errors
    /// If `out` fails, or the row has another number of fields than the one before.
    pub fn write_record<T: AsRef<[u8]>>(&mut self, fields: impl IntoIterator<Item = T>) -> Result<(), ::csv::Error> {
        for field in fields {
            let field = field.as_ref();
            match is_formula(field) {
                true => self.inner.write_field([b"'", field].concat())?,
                false => self.inner.write_field(field)?,
            }
        }
        self.inner.write_record(None::<&[u8]>)
    }

    /// Writes a row whose columns are the fields of a struct; before the first, their names.
    ///
    /// # Errors
    /// If `out` fails, or the row has fields that are no texts or numbers.
    pub fn serialize(&mut self, row: impl serde::Serialize) -> Result<(), ::csv::Error> {
        let has_names = std::mem::replace(&mut self.has_names, true);
        let mut plain = ::csv::WriterBuilder::new().has_headers(!has_names).from_writer(Vec::new());
        plain.serialize(row)?;
        let lines = plain.into_inner().map_err(|error| error.into_error())?;
        for record in ::csv::ReaderBuilder::new().has_headers(false).from_reader(&lines[..]).byte_records() {
            self.write_record(&record?)?;
        }
        Ok(())
    }

    /// Writes what is held back.
    ///
    /// # Errors
    /// If `out` fails.
    pub fn flush(&mut self) -> std::io::Result<()> {
        self.inner.flush()
    }
}

/// Whether a spreadsheet would take a field as a formula: it begins like one, and is no number.
fn is_formula(field: &[u8]) -> bool {
    let begins = matches!(field, [b'=' | b'+' | b'-' | b'@' | b'\t' | b'\r', _, ..]);
    begins && str::from_utf8(field).ok().and_then(|text| text.parse::<f64>().ok()).is_none()
}

/// Writes a whole file: the column names, and rows with as many fields.
///
/// # Errors
/// If `out` fails.
pub fn write_file<'a>(
    out: impl Write,
    columns: &[&str],
    rows: impl IntoIterator<Item = &'a [String]>,
) -> std::io::Result<()> {
    let mut writer = writer(out);
    writer.write_record(columns)?;
    for row in rows {
        writer.write_record(row)?;
    }
    writer.flush()
}

/// A field; an unknown value is empty.
#[must_use]
pub fn known(value: Option<impl ToString>) -> String {
    value.map(|v| v.to_string()).unwrap_or_default()
}
