//! `--verify`: makes a bundled report again from its inputs, and compares the results.

use std::fs::{self, File};
use std::io::Read as _;
use std::path::{Path, PathBuf};

use raystep_lab::tidy::is_of_time;
use zip::ZipArchive;

use super::ReportArgs;
use super::bundle::{About, Entry, KIND, MANIFEST, Manifest, SCHEMA_VERSION, sha256};
use crate::cli::{Command, Request, parse};
use crate::error::Error;
use crate::interrupt::Temporary;
use crate::terminal::{Progress, print};

/// Most files in a bundle.
const MOST_FILES: usize = 100_000;
/// Most bytes of its manifest.
const MOST_MANIFEST: u64 = 64 << 20;

type Records = Vec<csv::StringRecord>;

/// Compares a bundle with the same report made now. It is an error if anything other than times differs on a machine
/// that computes alike.
pub(super) fn run(bundle: &Path, max_memory: u64, progress: &Progress) -> Result<(), Error> {
    let at = bundle.display();
    let cannot = |reason: &dyn std::fmt::Display| Error::failed(format!("--verify {at}: {reason}"));
    progress.stage("checking the bundle");
    let file = File::open(bundle).map_err(|e| cannot(&crate::error::reason(&e)))?;
    let mut zip = ZipArchive::new(file).map_err(|e| cannot(&format!("it is not a bundle of a report: {e}")))?;
    if zip.len() > MOST_FILES {
        return Err(cannot(&format!("it has more than {MOST_FILES} files")));
    }
    let manifest = read(&mut zip, MANIFEST, MOST_MANIFEST).map_err(|e| cannot(&e))?;
    let manifest: Manifest = serde_json::from_slice(&manifest).map_err(|e| cannot(&format!("{MANIFEST}: {e}")))?;
    if manifest.kind != KIND || manifest.schema_version != SCHEMA_VERSION {
        return Err(cannot(&format!("it is not a {KIND} of version {SCHEMA_VERSION}")));
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix("raystep-verify-");
    let folder = Temporary::create(|| builder.tempdir(), tempfile::TempDir::path).map_err(|e| cannot(&e))?;
    let result = compare(&manifest, &mut zip, folder.inner.path(), max_memory, progress, &cannot);
    folder.finish(drop);
    let (text, differing) = result?;
    progress.finish();
    print(&text)?;
    match differing {
        0 => Ok(()),
        1 => Err(cannot(&"1 field that does not depend on time differs")),
        n => Err(cannot(&format!("{n} fields that do not depend on time differ"))),
    }
}

fn compare(
    manifest: &Manifest,
    zip: &mut ZipArchive<File>,
    folder: &Path,
    max_memory: u64,
    progress: &Progress,
    cannot: &dyn Fn(&dyn std::fmt::Display) -> Error,
) -> Result<(String, usize), Error> {
    extract(manifest, zip, folder, max_memory).map_err(|e| cannot(&e))?;
    let scenes: Vec<PathBuf> = manifest.scenes.iter().map(|scene| folder.join(scene)).collect();
    if scenes.is_empty() || !scenes.iter().all(|scene| scene.starts_with(folder) && scene.is_file()) {
        return Err(cannot(&"a scene is not in it"));
    }
    let args = arguments(manifest, &scenes, folder).map_err(|e| cannot(&e.message()))?;
    let (machine, _) = super::report(&args, progress)?;
    let now = About::of(&machine);
    let alike = manifest.machine.computes_like(&now);
    let mut text = format!(
        "made by raystep {} (commit {}), now {} (commit {})\n",
        manifest.raystep_version,
        manifest.commit,
        env!("CARGO_PKG_VERSION"),
        env!("RAYSTEP_COMMIT")
    );
    text += &match alike {
        true => "this machine computes alike: everything but times must be the same\n".to_owned(),
        false => format!(
            "measured on {} {}, now on {} {}: errors are compared, not judged\n",
            manifest.machine.device, manifest.machine.adapter, now.device, now.adapter
        ),
    };
    let mut all = 0;
    for Entry { path, .. } in &manifest.files {
        let Some(name) = path.strip_prefix("report/").filter(|name| name.ends_with(".csv")) else { continue };
        // Every run is a new one, and facts of the command differ.
        if matches!(name, "runs.csv" | "about.csv") {
            continue;
        }
        let then = records(&folder.join(path)).map_err(|e| cannot(&e))?;
        let now = records(&folder.join("redone").join(name)).map_err(|e| cannot(&e))?;
        let (line, differing) = compared(name, &then, &now);
        text += &line;
        all += differing;
    }
    text += &times(&folder.join("report"), &folder.join("redone")).map_err(|e| cannot(&e))?;
    Ok((text, if alike { all } else { 0 }))
}

/// The arguments of the bundled report, with the bundle's scenes.
fn arguments(manifest: &Manifest, scenes: &[PathBuf], folder: &Path) -> Result<ReportArgs, Error> {
    let words = ["raystep", "report"].map(Into::into).into_iter();
    let scenes = scenes.iter().map(|scene| scene.clone().into_os_string());
    let rest = manifest.arguments.iter().map(Into::into);
    let output = ["-o".into(), folder.join("redone").into()];
    let files = manifest.options.iter().flat_map(|(option, path)| [option.into(), folder.join(path).into()]);
    match parse(words.chain(rest).chain(files).chain(output).chain(["--".into()]).chain(scenes))? {
        Request::Run(Command::Report(args)) if args.bundle.is_none() && args.verify.is_none() => Ok(*args),
        _ => Err(Error::failed(format!("{MANIFEST}: arguments are not those of a report"))),
    }
}

/// Extracts all listed files, each of which must be as it is listed.
fn extract(manifest: &Manifest, zip: &mut ZipArchive<File>, folder: &Path, max_memory: u64) -> Result<(), String> {
    let mut left = max_memory;
    for Entry { path, bytes, sha256: expected } in &manifest.files {
        let relative = Path::new(path);
        let is_inside = relative.components().all(|part| matches!(part, std::path::Component::Normal(_)));
        if !is_inside {
            return Err(format!("{path} lies outside the bundle"));
        }
        left = left.checked_sub(*bytes).ok_or("its files are larger than --max-memory allows")?;
        let contents = read(zip, path, *bytes)?;
        if sha256(&contents) != *expected {
            return Err(format!("{path} was changed: its SHA-256 is not the one in {MANIFEST}"));
        }
        let target = folder.join(relative);
        let parent = crate::output::folder_of(&target);
        let written = fs::create_dir_all(parent).and_then(|()| fs::write(&target, contents));
        written.map_err(|e| format!("cannot extract {path}: {}", crate::error::reason(&e)))?;
    }
    Ok(())
}

/// The bytes of a file, of which there must not be more than these.
fn read(zip: &mut ZipArchive<File>, name: &str, most: u64) -> Result<Vec<u8>, String> {
    let file = zip.by_name(name).map_err(|e| format!("{name}: {e}"))?;
    let mut bytes = Vec::new();
    file.take(most + 1).read_to_end(&mut bytes).map_err(|e| format!("{name}: {e}"))?;
    if bytes.len() as u64 > most { Err(format!("{name} is larger than {MANIFEST} says")) } else { Ok(bytes) }
}

/// Names and rows of a CSV file, ordered by what they are about.
fn records(path: &Path) -> Result<(csv::StringRecord, Records), String> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let wrong = |e: csv::Error| format!("{name}: {e}");
    let mut reader = csv::Reader::from_path(path).map_err(wrong)?;
    let names = reader.headers().map_err(wrong)?.clone();
    let mut rows: Records = reader.records().collect::<Result<_, _>>().map_err(wrong)?;
    // Some files are ordered by times.
    let keys: Vec<usize> = ["scene_hash", "configuration", "item", "stratum"]
        .iter()
        .filter_map(|key| names.iter().position(|name| name == *key))
        .collect();
    rows.sort_by(|a, b| keys.iter().map(|&k| &a[k]).cmp(keys.iter().map(|&k| &b[k])));
    Ok((names, rows))
}

/// One line on a file, and the number of fields that differ and should not.
fn compared(
    name: &str,
    (columns, then): &(csv::StringRecord, Records),
    (columns_now, now): &(csv::StringRecord, Records),
) -> (String, usize) {
    if columns != columns_now || then.len() != now.len() {
        return (format!("{name}: {} rows, now {}, or other columns\n", then.len(), now.len()), 1);
    }
    let kept: Vec<usize> = (0..columns.len()).filter(|&c| !is_of_time(&columns[c])).collect();
    let differs = |row: usize, c: usize| then[row][c] != now[row][c];
    let all: Vec<(usize, usize)> = (0..then.len())
        .flat_map(|row| kept.iter().map(move |&c| (row, c)))
        .filter(|&(row, c)| differs(row, c))
        .collect();
    let first = all.first().map_or(String::new(), |&(row, c)| {
        format!("; the first in row {}: {} was {:?}, is {:?}", row + 1, &columns[c], &then[row][c], &now[row][c])
    });
    let fields = then.len() * kept.len();
    let line = match all.len() {
        0 => format!("{name}: {fields} fields, all the same\n"),
        n => format!("{name}: {n} of {fields} fields differ{first}\n"),
    };
    (line, all.len())
}

/// Times of the choices, then and now.
fn times(then: &Path, now: &Path) -> Result<String, String> {
    let name = "choices.csv";
    if !then.join(name).exists() || !now.join(name).exists() {
        return Ok(String::new());
    }
    let ((columns, then), (_, now)) = (records(&then.join(name))?, records(&now.join(name))?);
    let place = |wanted: &str| columns.iter().position(|c| c == wanted);
    let (Some(id), Some(ns)) = (place("configuration"), place("ns_per_ray")) else { return Ok(String::new()) };
    let mut lines = vec![["configuration", "ns per ray, then", "now"].map(str::to_owned).to_vec()];
    for (then, now) in then.iter().zip(&now) {
        lines.push(vec![then[id].to_owned(), then[ns].to_owned(), now[ns].to_owned()]);
    }
    Ok("times, which are not judged:\n".to_owned() + &raystep_lab::text::aligned(&lines, 1).concat())
}
