//! Tables: the rows of all parts, under one header.

use std::collections::BTreeSet;
use std::fs;
use std::io::Write as _;
use std::path::Path;

use raystep_lab::tidy::package;
use serde_json::{Map, Value};

use super::{MergeArgs, Placed};
use crate::commands::json_text;
use crate::error::{Error, reason};
use crate::output::TargetFolder;
use crate::scene_file::bytes_of;
use crate::shard;
use crate::terminal::Progress;

/// Most bytes of a table of one part.
const MOST_BYTES: u64 = 1 << 32;

/// Writes the folder.
pub(super) fn merge(args: &MergeArgs, parts: &[Placed], progress: &Progress) -> Result<(), Error> {
    let mut names = BTreeSet::new();
    for Placed { folder, .. } in parts {
        let files = fs::read_dir(folder).map_err(|e| Error::at(folder, reason(&e)))?;
        names.extend(files.flatten().filter_map(|file| file.file_name().into_string().ok()));
    }
    names.remove(shard::FILE);
    let written = TargetFolder::new(&args.output, args.force)?.fill(&[], |out| {
        let mut written = Vec::new();
        for name in &names {
            let of: Vec<&Placed> = parts.iter().filter(|placed| placed.folder.join(name).is_file()).collect();
            progress.stage(&format!("merging {name}"));
            let extension = Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or_default();
            match extension {
                "csv" => {
                    let bytes = csv(&of, name)?;
                    out.write(name, |file| file.write_all(&bytes))?;
                }
                "json" => {
                    let text = json_text(&json(&of, name)?)?;
                    out.write(name, |file| file.write_all(text.as_bytes()))?;
                }
                "html" => {
                    for placed in &of {
                        let bytes = bytes_of(&placed.folder.join(name), MOST_BYTES)?;
                        let stem = name.trim_end_matches(".html");
                        let name = format!("{stem}-{}-of-{}.html", placed.part.shard.index, placed.part.shard.of);
                        out.write(&name, |file| file.write_all(&bytes))?;
                        written.push(name);
                    }
                    continue;
                }
                // Not ours.
                _ => continue,
            }
            written.push(name.clone());
        }
        Ok(written)
    })?;
    progress.finish();
    progress.say(format_args!("wrote {} to {}", written.join(", "), args.output.display()));
    Ok(())
}

/// The rows of all parts in their order. Records end in CR LF (RFC 4180), and no header has a line break.
fn csv(of: &[&Placed], name: &str) -> Result<Vec<u8>, Error> {
    let mut all: Vec<u8> = Vec::new();
    let mut header_of: Option<(Vec<u8>, &Path)> = None;
    for placed in of {
        let path = placed.folder.join(name);
        let bytes = bytes_of(&path, MOST_BYTES)?;
        let end = bytes.windows(2).position(|pair| pair == b"\r\n").map_or(bytes.len(), |at| at + 2);
        let (header, rows) = bytes.split_at(end);
        match &header_of {
            None => {
                all.extend_from_slice(header);
                header_of = Some((header.to_vec(), &placed.folder));
            }
            Some((first, _)) if first == header => {}
            Some((_, first)) => {
                let (a, b) = (first.join(name), path);
                let (a, b) = (a.display(), b.display());
                return Err(Error::failed(format!("{a} and {b} have different columns: expected parts of one run")));
            }
        }
        all.extend_from_slice(rows);
    }
    Ok(all)
}

/// A description of all parts: `datapackage.json` has every table once; any other file has the parts' contents one after
/// the other.
fn json(of: &[&Placed], name: &str) -> Result<Value, Error> {
    let mut values = Vec::new();
    for placed in of {
        let path = placed.folder.join(name);
        let wrong = |e| Error::failed(format!("{}: not valid JSON: {e}", path.display()));
        values.push(serde_json::from_slice::<Value>(&bytes_of(&path, MOST_BYTES)?).map_err(wrong)?);
    }
    if name != package::FILE {
        let mut all = values.first().cloned().unwrap_or_default();
        if let Some(all) = all.as_object_mut() {
            // What is of the whole, from the first; what differs is in the parts.
            all.retain(|key, value| values.iter().all(|other| other[key.as_str()] == *value));
            all.insert("parts".into(), Value::Array(values));
        }
        return Ok(all);
    }
    let (mut all, mut tables) = (Map::new(), Vec::<Value>::new());
    for (value, placed) in values.into_iter().zip(of) {
        let Value::Object(mut about) = value else {
            let at = placed.folder.join(name);
            return Err(Error::failed(format!("{}: expected a description of tables, an object", at.display())));
        };
        if let Some(Value::Array(more)) = about.remove("resources") {
            for table in more {
                if !tables.iter().any(|known| known["path"] == table["path"]) {
                    tables.push(table);
                }
            }
        }
        if all.is_empty() {
            all = about;
        }
    }
    all.insert("resources".into(), tables.into());
    Ok(all.into())
}
