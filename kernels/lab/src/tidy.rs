//! CSV files in memory: one row an observation, one name for one thing in all files ([`columns`]), raw numbers with
//! their unit in the column's name, unknown values empty. [`package`] describes a folder of them for programs.

pub mod columns;
pub mod fill;
mod of_time;
pub mod package;

use std::io::{self, Write};

use raystep_kernels::export::csv;
use serde::Serialize;
use serde_json::Value;

use crate::Hash;
use crate::configuration::Configuration;
use crate::statistics::interval::Interval;
pub use of_time::is_of_time;

/// Schema version of all files; it rises when the meaning of a column changes.
pub const SCHEMA_VERSION: u32 = 2;

/// The number of columns in groups of columns.
#[must_use]
pub const fn count(groups: &[&[&str]]) -> usize {
    let (mut sum, mut group) = (0, 0);
    while group < groups.len() {
        sum += groups[group].len();
        group += 1;
    }
    sum
}

/// Groups of columns as one: `&joined::<{ count(GROUPS) }>(GROUPS)`.
#[must_use]
pub const fn joined<const N: usize>(groups: &[&[&'static str]]) -> [&'static str; N] {
    let mut all = [""; N];
    let (mut at, mut group) = (0, 0);
    while group < groups.len() {
        let mut column = 0;
        while column < groups[group].len() {
            all[at] = groups[group][column];
            at += 1;
            column += 1;
        }
        group += 1;
    }
    all
}

/// Names of columns: `columns![accelerator schedule]`.
#[macro_export]
macro_rules! columns {
    ($($name:ident)*) => { &[$(stringify!($name)),*] };
}

/// A struct whose fields are the columns of a CSV file: `COLUMNS` has their names.
macro_rules! csv_row {
    ($(#[$of_row:meta])* pub struct $Row:ident { $($(#[$of_field:meta])* pub $name:ident: $Type:ty,)* }) => {
        $(#[$of_row])*
        #[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
        #[allow(missing_docs)]
        pub struct $Row { $($(#[$of_field])* pub $name: $Type,)* }

        impl $Row {
            /// The columns.
            pub const COLUMNS: &'static [&'static str] = &[$(stringify!($name)),*];
        }
    };
}

/// Columns that identify what a row is about.
pub const KEYS: &[&str] = columns![schema_version run_id scene scene_hash adapter configuration];

/// Columns of times.
pub const TIMES: &[&str] =
    columns![runs invalid_runs median_ns low_ns high_ns min_ns max_ns interval_method interval_level clock];

/// Columns of a ratio of times.
pub const RATIO: &[&str] = columns![ratio_to time_ratio time_ratio_low time_ratio_high];

/// Columns of verdicts on rays.
pub const VERDICTS: &[&str] = columns![
    judged_rays missed false_hits wrong_hits undecided wrong_rays
    wrong_per_million wrong_per_million_low wrong_per_million_high at_bound
];

/// The rows of one file.
#[derive(Clone, Debug)]
pub struct Table {
    /// Its columns.
    pub columns: &'static [&'static str],
    /// Its rows.
    pub rows: Vec<Row>,
}

/// A row: one field per column, empty if unknown.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    columns: &'static [&'static str],
    fields: Vec<String>,
}

/// Types that a field can hold.
pub trait Field {
    /// As it is written.
    fn text(&self) -> String;
}

macro_rules! displayed {
    ($($type:ty),*) => { $(impl Field for $type { fn text(&self) -> String { self.to_string() } })* };
}
displayed!(u32, u64, usize, i32, i64, bool, &str, String, Hash);

impl Field for f64 {
    /// Six digits, more than any measurement here needs; NaN and infinity are empty.
    fn text(&self) -> String {
        let rounded: f64 = format!("{self:.5e}").parse().unwrap_or(*self);
        match rounded.abs() {
            m if !m.is_finite() => String::new(),
            0.0 => "0".into(),
            m if !(1e-5..1e15).contains(&m) => format!("{rounded:e}"),
            _ => rounded.to_string(),
        }
    }
}

impl<T: Field> Field for Option<T> {
    fn text(&self) -> String {
        self.as_ref().map(Field::text).unwrap_or_default()
    }
}

impl Table {
    /// Without rows.
    #[must_use]
    pub fn new(columns: &'static [&'static str]) -> Self {
        Self { columns, rows: Vec::new() }
    }

    /// Reads what [`write`](Self::write) has written; `None` if the columns are others or a row is cut off.
    #[must_use]
    pub fn read(columns: &'static [&'static str], file: &[u8]) -> Option<Self> {
        let mut reader = ::csv::Reader::from_reader(file);
        if !reader.headers().ok()?.iter().eq(columns.iter().copied()) {
            return None;
        }
        let row = |record: ::csv::StringRecord| Row { columns, fields: record.iter().map(str::to_owned).collect() };
        let rows = reader.records().map(|record| record.map(row)).collect::<Result<_, _>>().ok()?;
        Some(Self { columns, rows })
    }

    /// The rows from an index on, as lines without the names.
    pub(crate) fn lines(&self, from: usize) -> io::Result<Vec<u8>> {
        let mut lines = Vec::new();
        let mut writer = csv::writer(&mut lines);
        self.rows[from.min(self.rows.len())..].iter().try_for_each(|row| writer.write_record(&row.fields))?;
        writer.flush()?;
        drop(writer);
        Ok(lines)
    }

    /// Writes RFC 4180.
    ///
    /// # Errors
    /// If `out` fails.
    pub fn write(&self, out: impl Write) -> io::Result<()> {
        let mut writer = csv::writer(out);
        writer.write_record(self.columns)?;
        for row in &self.rows {
            writer.write_record(&row.fields)?;
        }
        writer.flush()
    }

    /// The file in memory.
    pub(crate) fn csv(&self) -> io::Result<Vec<u8>> {
        let mut file = Vec::new();
        self.write(&mut file)?;
        Ok(file)
    }
}

impl Row {
    /// An empty row with these columns.
    #[must_use]
    pub fn new(columns: &'static [&'static str]) -> Self {
        Self { columns, fields: vec![String::new(); columns.len()] }.set("schema_version", SCHEMA_VERSION)
    }

    /// The names of its columns.
    #[must_use]
    pub fn columns(&self) -> &'static [&'static str] {
        self.columns
    }

    fn position(&self, column: &str) -> Option<usize> {
        self.columns.iter().position(|&c| c == column)
    }

    fn place(&self, column: &str) -> Option<usize> {
        let place = self.position(column);
        debug_assert!(place.is_some(), "there is no column {column}");
        place
    }

    /// Fills a field.
    #[must_use]
    pub fn set(mut self, column: &str, value: impl Field) -> Self {
        if let Some(place) = self.place(column) {
            self.fields[place] = value.text();
        }
        self
    }

    /// Fills the columns that have the names of the value's fields.
    #[must_use]
    pub fn with(mut self, value: &impl Serialize) -> Self {
        let value = serde_json::to_value(value);
        debug_assert!(matches!(value, Ok(Value::Object(_))), "no struct: {value:?}");
        let Ok(Value::Object(fields)) = value else { return self };
        for (column, value) in fields {
            let Some(place) = self.position(&column) else { continue };
            self.fields[place] = match value {
                Value::Null => String::new(),
                Value::String(text) => text,
                Value::Number(number) if number.is_f64() => number.as_f64().text(),
                other => other.to_string(),
            };
        }
        self
    }

    /// Fills the columns that another row has.
    pub(crate) fn like(mut self, other: &Self) -> Self {
        for (column, field) in other.columns.iter().zip(&other.fields) {
            if let Some(place) = self.position(column) {
                self.fields[place].clone_from(field);
            }
        }
        self
    }

    /// Fills the columns of how the scene is traced, those that there are.
    pub(crate) fn configured(mut self, configuration: &Configuration) -> Self {
        for (column, field) in configuration.fields() {
            if let Some(place) = self.position(column) {
                self.fields[place] = field;
            }
        }
        self
    }

    /// Fills the columns of both ends of an interval: the column's name with `_low` and `_high`.
    pub(crate) fn ends(self, column: &str, ends: Option<[f64; 2]>) -> Self {
        self.set(&format!("{column}_low"), ends.map(|[low, _]| low))
            .set(&format!("{column}_high"), ends.map(|[_, high]| high))
    }

    /// Fills a column and those of its interval: a median with its interval, if there are enough values.
    pub(crate) fn median(self, column: &str, median: Option<(f64, Option<Interval>)>) -> Self {
        let interval = median.and_then(|(_, interval)| interval);
        self.set(column, median.map(|(median, _)| median)).ends(column, interval.map(|i| [i.low, i.high]))
    }

    /// Fills the columns of how an interval was found.
    pub(crate) fn method(self, interval: Option<Interval>) -> Self {
        self.set("interval_method", interval.map(|i| i.method.name())).set("interval_level", interval.map(|i| i.level))
    }

    /// A field as it is written.
    #[must_use]
    pub fn get(&self, column: &str) -> &str {
        self.place(column).map_or("", |place| &self.fields[place])
    }

    /// A field as a number; `None` if it is unknown.
    #[must_use]
    pub fn number(&self, column: &str) -> Option<f64> {
        self.get(column).parse().ok()
    }

    /// Whether each of these columns has this value.
    #[must_use]
    pub fn is(&self, wanted: &[(&str, &str)]) -> bool {
        wanted.iter().all(|(column, value)| self.get(column) == *value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_raw_numbers_and_empty_where_nothing_is_known() {
        let texts = [0.0, 1.0, 0.1 + 0.2, 1234567.0, 1e-20, 1e20, f64::NAN, f64::INFINITY, -2.5].map(|v| v.text());
        assert_eq!(texts, ["0", "1", "0.3", "1234570", "1e-20", "1e20", "", "", "-2.5"]);
        const COLUMNS: &[&str] = &["schema_version", "a", "b"];
        let row = Row::new(COLUMNS).set("b", "x, \"y\"").set("a", None::<u64>);
        assert_eq!((row.get("a"), row.number("a"), row.number("schema_version")), ("", None, Some(2.0)));
        assert!(row.is(&[("b", "x, \"y\""), ("a", "")]));
        let (mut file, table) = (Vec::new(), Table { columns: COLUMNS, rows: vec![row] });
        table.write(&mut file).expect("memory");
        assert_eq!(String::from_utf8_lossy(&file), "schema_version,a,b\r\n2,,\"x, \"\"y\"\"\"\r\n");
        let read = Table::read(COLUMNS, &file).expect("the same columns");
        assert_eq!((&read.rows, &read.lines(0).expect("memory")[..]), (&table.rows, &file[20..]));
        assert!(Table::read(COLUMNS, &file[..22]).is_none() && Table::read(&["a"], &file).is_none());
    }
}
