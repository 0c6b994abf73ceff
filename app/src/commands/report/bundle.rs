//! `--bundle`: a report with everything needed to repeat it, as a ZIP file.

use std::path::Path;

use raystep_kernels::export::json::AdapterInfo;
use raystep_lab::Machine;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::commands::input::Input;
use crate::error::Error;
use crate::output::zipped;
use crate::scene_file::{bytes_of, file_of, name_in_folder};

/// Describes the bundle; the only file that is not listed in it.
pub(super) const MANIFEST: &str = "manifest.json";

/// `kind` of a manifest.
pub(super) const KIND: &str = "raystep report bundle";

/// Version of the manifest.
pub(super) const SCHEMA_VERSION: u32 = 1;

/// `manifest.json`
#[derive(Debug, Deserialize, Serialize)]
pub(super) struct Manifest {
    pub(super) kind: String,
    pub(super) schema_version: u32,
    pub(super) raystep_version: String,
    /// Git commit of the program, or `unknown`.
    pub(super) commit: String,
    /// SHA-256 of the Cargo.lock that the program was built with.
    pub(super) cargo_lock_sha256: String,
    pub(super) run_id: String,
    pub(super) seed: u32,
    pub(super) machine: About,
    /// Scenes in the bundle, in the order of the command line.
    pub(super) scenes: Vec<String>,
    /// Other files in the bundle, with the options that name them.
    pub(super) options: Vec<(String, String)>,
    /// All other arguments that determine the results.
    pub(super) arguments: Vec<String>,
    pub(super) files: Vec<Entry>,
}

/// The machine that measured.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub(super) struct About {
    pub(super) os: String,
    pub(super) architecture: String,
    pub(super) cores: usize,
    /// `gpu` or `cpu`.
    pub(super) device: String,
    /// The adapter's name and driver; empty for the CPU.
    pub(super) adapter: String,
    pub(super) backend: String,
    pub(super) driver: String,
}

/// A file of the bundle.
#[derive(Debug, Deserialize, Serialize)]
pub(super) struct Entry {
    pub(super) path: String,
    pub(super) bytes: u64,
    pub(super) sha256: String,
}

impl About {
    pub(super) fn of(machine: &Machine) -> Self {
        let info = machine.gpu().map(AdapterInfo::from);
        let of_adapter = |text: fn(&AdapterInfo) -> &String| info.as_ref().map(|i| text(i).clone()).unwrap_or_default();
        Self {
            os: std::env::consts::OS.into(),
            architecture: std::env::consts::ARCH.into(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            device: machine.kind().into(),
            adapter: of_adapter(|i| &i.name),
            backend: of_adapter(|i| &i.backend),
            driver: of_adapter(|i| &i.driver),
        }
    }

    /// Whether errors must be the same bit for bit: the CPU computes the same everywhere, an adapter with its own driver.
    pub(super) fn computes_like(&self, other: &Self) -> bool {
        self.device == other.device
            && (self.device == "cpu"
                || (&self.adapter, &self.backend, &self.driver) == (&other.adapter, &other.backend, &other.driver))
    }
}

/// What a bundle says beside its files.
pub(super) struct Contents<'a> {
    pub(super) run_id: &'a str,
    pub(super) seed: u32,
    pub(super) machine: &'a Machine,
    pub(super) arguments: Vec<String>,
    /// Other input files, with the options that name them.
    pub(super) options: Vec<(&'static str, &'a Path)>,
}

/// SHA-256 in hexadecimal.
pub(super) fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The bytes of the ZIP file.
pub(super) fn zip(
    contents: Contents<'_>,
    inputs: &[Input],
    max_memory: u64,
    report: Vec<(String, Vec<u8>)>,
) -> Result<Vec<u8>, Error> {
    let (mut files, mut scenes) = (Vec::new(), Vec::new());
    for (i, input) in inputs.iter().enumerate() {
        let of_scene = scene_files(i, input, max_memory)?;
        scenes.extend(of_scene.first().map(|(path, _)| path.clone()));
        files.extend(of_scene);
    }
    let mut options = Vec::new();
    for (option, path) in contents.options {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let place = format!("inputs/{}/{name}", option.trim_start_matches('-'));
        let bytes = bytes_of(path, max_memory)?;
        files.push((place.clone(), bytes));
        options.push((option.to_owned(), place));
    }
    files.push(("redo.sh".into(), redo(&scenes, &options, &contents.arguments).into_bytes()));
    files.extend(report.into_iter().map(|(name, bytes)| (format!("report/{name}"), bytes)));
    let manifest = Manifest {
        kind: KIND.into(),
        schema_version: SCHEMA_VERSION,
        raystep_version: env!("CARGO_PKG_VERSION").into(),
        commit: env!("RAYSTEP_COMMIT").into(),
        cargo_lock_sha256: sha256(include_bytes!(concat!(env!("OUT_DIR"), "/Cargo.lock"))),
        run_id: contents.run_id.into(),
        seed: contents.seed,
        machine: About::of(contents.machine),
        scenes,
        options,
        arguments: contents.arguments,
        files: files
            .iter()
            .map(|(path, bytes)| Entry { path: path.clone(), bytes: bytes.len() as u64, sha256: sha256(bytes) })
            .collect(),
    };
    let manifest = crate::commands::json_text(&manifest)?;
    let written = files.iter().map(|(path, bytes)| (path.as_str(), bytes.as_slice()));
    zipped([(MANIFEST, manifest.as_bytes())].into_iter().chain(written))
}

/// A scene's files by their paths in the bundle, the scene itself first.
fn scene_files(index: usize, input: &Input, max_memory: u64) -> Result<Vec<(String, Vec<u8>)>, Error> {
    let path = file_of(&input.path)?;
    let scene = std::fs::canonicalize(&path).unwrap_or(path);
    let root = crate::output::folder_of(&scene);
    let mut all = Vec::new();
    for path in &input.files {
        let outside = || {
            let (at, scene) = (path.display(), input.path.display());
            Error::failed(format!("--bundle: {at} lies outside the folder of {scene}: move it there to bundle it"))
        };
        let within = match path.strip_prefix(root) {
            Ok(within) => with_slashes(within),
            Err(_) if *path == scene => name_in_folder(path),
            Err(_) => return Err(outside()),
        };
        let bytes = bytes_of(path, max_memory)?;
        let entry = (format!("inputs/{index}/{within}"), bytes);
        if *path == scene { all.insert(0, entry) } else { all.push(entry) }
    }
    Ok(all)
}

fn with_slashes(path: &Path) -> String {
    path.components().map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// A script that makes the report again.
fn redo(scenes: &[String], options: &[(String, String)], arguments: &[String]) -> String {
    let quoted = |text: &String| format!("'{}'", text.replace('\'', "'\\''"));
    let words: Vec<String> = scenes
        .iter()
        .chain(options.iter().flat_map(|(option, path)| [option, path]))
        .chain(arguments)
        .map(quoted)
        .collect();
    format!(
        "#!/bin/sh\n# Makes this report again in the folder redone, by raystep {} (commit {}).\n# 'raystep report \
         --verify' on the bundle compares the results.\nset -eu\ncd \"$(dirname \"$0\")\"\nraystep report {} -o \
         redone\n",
        env!("CARGO_PKG_VERSION"),
        env!("RAYSTEP_COMMIT"),
        words.join(" ")
    )
}
