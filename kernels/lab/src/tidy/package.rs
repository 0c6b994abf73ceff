//! `datapackage.json`: the schema of a folder of CSV files, for programs (Frictionless Data Package 1.0 and Table
//! Schema 1.0, <https://specs.frictionlessdata.io>).

use serde_json::{Value, json};

use super::columns::{Kind, column};

/// File name of the schema.
pub const FILE: &str = "datapackage.json";

/// A CSV file to describe.
#[derive(Clone, Copy, Debug)]
pub struct Resource<'a> {
    /// File name.
    pub file: &'a str,
    /// What a row is.
    pub what: &'a str,
    /// Its columns.
    pub columns: &'a [&'a str],
}

/// A file that does not match its schema.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Mismatch {
    /// The schema is not one.
    #[error("{FILE} is not a data package: {0}")]
    Package(String),
    /// A file is not there.
    #[error("{0} is listed in {FILE}, and missing")]
    Missing(String),
    /// Not CSV.
    #[error("{file}: {reason}")]
    Csv {
        /// The file.
        file: String,
        /// Why it cannot be read.
        reason: String,
    },
    /// Other columns.
    #[error("{file}: its columns are not those of {FILE}")]
    Columns {
        /// The file.
        file: String,
    },
    /// A field of another type.
    #[error("{file}, row {row}: {column} is not of type {kind}: {field:?}")]
    Field {
        /// The file.
        file: String,
        /// Row, from 1, not counting the names.
        row: usize,
        /// The column.
        column: String,
        /// The expected type.
        kind: &'static str,
        /// What is there.
        field: String,
    },
}

/// The schema of some files. `name` identifies the package: lowercase letters and hyphens.
#[must_use]
pub fn describe(name: &str, title: &str, resources: &[Resource<'_>]) -> Value {
    let field = |name: &&str| match column(name) {
        Some(column) => json!({ "name": name, "type": column.kind.name(), "description": column.what }),
        None => json!({ "name": name, "type": "string" }),
    };
    let resource = |resource: &Resource<'_>| {
        let stem = resource.file.strip_suffix(".csv").unwrap_or(resource.file).replace('_', "-");
        json!({
            "name": stem,
            "path": resource.file,
            "profile": "tabular-data-resource",
            "title": resource.what,
            "format": "csv",
            "mediatype": "text/csv",
            "encoding": "utf-8",
            "dialect": { "delimiter": ",", "lineTerminator": "\r\n", "doubleQuote": true, "header": true },
            "schema": {
                "fields": resource.columns.iter().map(field).collect::<Vec<_>>(),
                "missingValues": [""],
            },
        })
    };
    json!({
        "profile": "tabular-data-package",
        "name": name,
        "title": title,
        "resources": resources.iter().map(resource).collect::<Vec<_>>(),
    })
}

/// Checks files against their schema: all of them are there, with these columns, and every field has its type. `read`
/// returns a file's bytes by its name.
///
/// # Errors
/// The first mismatch.
pub fn check(package: &[u8], read: impl Fn(&str) -> Option<Vec<u8>>) -> Result<(), Mismatch> {
    let wrong = |what: &str| Mismatch::Package(what.to_owned());
    let package: Value = serde_json::from_slice(package).map_err(|e| wrong(&e.to_string()))?;
    let resources = package["resources"].as_array().ok_or_else(|| wrong("it has no resources"))?;
    for resource in resources {
        let file = resource["path"].as_str().ok_or_else(|| wrong("a resource has no path"))?;
        let fields = resource["schema"]["fields"].as_array().ok_or_else(|| wrong("a resource has no fields"))?;
        let bytes = read(file).ok_or_else(|| Mismatch::Missing(file.to_owned()))?;
        check_file(file, fields, &bytes)?;
    }
    Ok(())
}

fn check_file(file: &str, fields: &[Value], bytes: &[u8]) -> Result<(), Mismatch> {
    let unreadable = |e: ::csv::Error| Mismatch::Csv { file: file.to_owned(), reason: e.to_string() };
    let mut reader = ::csv::Reader::from_reader(bytes);
    let names = reader.headers().map_err(unreadable)?.clone();
    let expected: Vec<&str> = fields.iter().filter_map(|field| field["name"].as_str()).collect();
    if !names.iter().eq(expected.iter().copied()) {
        return Err(Mismatch::Columns { file: file.to_owned() });
    }
    let kind = |field: &Value| match field["type"].as_str() {
        Some("integer") => Kind::Integer,
        Some("number") => Kind::Number,
        Some("boolean") => Kind::Boolean,
        _ => Kind::Text,
    };
    let kinds: Vec<Kind> = fields.iter().map(kind).collect();
    for (row, record) in (1..).zip(reader.records()) {
        let record = record.map_err(unreadable)?;
        let wrong = record.iter().zip(&kinds).position(|(field, kind)| !kind.holds(field));
        if let Some(at) = wrong {
            return Err(Mismatch::Field {
                file: file.to_owned(),
                row,
                column: expected[at].to_owned(),
                kind: kinds[at].name(),
                field: record[at].to_owned(),
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_match_their_schema_or_the_mismatch_is_told() {
        let columns = ["run_id", "rays", "median_ns", "own"];
        let package = describe("test", "Test", &[Resource { file: "a.csv", what: "a row", columns: &columns }]);
        let fields = &package["resources"][0]["schema"]["fields"];
        assert_eq!((&fields[1]["type"], &fields[3]["type"]), (&json!("integer"), &json!("string")));
        let package = package.to_string();
        let of = |text: &'static str| {
            check(package.as_bytes(), move |name| (name == "a.csv").then(|| text.as_bytes().to_vec()))
        };
        assert_eq!(of("run_id,rays,median_ns,own\r\nx,1,2.5,\r\ny,,,z\r\n"), Ok(()));
        assert_eq!(of("run_id,rays,median,own\r\n"), Err(Mismatch::Columns { file: "a.csv".into() }));
        let wrong = of("run_id,rays,median_ns,own\r\nx,1.5,2.5,\r\n").expect_err("not an integer");
        assert_eq!(wrong.to_string(), "a.csv, row 1: rays is not of type integer: \"1.5\"");
        assert!(matches!(of("run_id,rays,median_ns,own\r\nx,1\r\n"), Err(Mismatch::Csv { .. })));
        let missing = check(package.as_bytes(), |_| None);
        assert_eq!(missing, Err(Mismatch::Missing("a.csv".into())));
        assert!(matches!(check(b"[]", |_| None), Err(Mismatch::Package(_))));
    }
}
