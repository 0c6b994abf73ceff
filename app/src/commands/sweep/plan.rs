//! The jobs of a sweep: a command line each.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::Parser as _;
use raystep_lab::Hash;
use serde::{Deserialize, Serialize};

use super::file::{Definition, FILES, Setting, What};
use crate::args::DeviceKind;
use crate::cli::{Cli, Command};
use crate::error::Error;
use crate::scene_file::{self, file_of, hashed, is_known};
use crate::usage;

/// Most jobs: each has a folder.
const MOST_JOBS: usize = 100_000;
/// Longest name of a job, in bytes: file systems allow 255.
const MOST_NAME: usize = 120;

/// A file that a command line names. It may lie elsewhere on another machine.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Named {
    /// Index of the word.
    word: usize,
    /// What is before the name in the word.
    before: String,
    /// The file.
    path: PathBuf,
}

/// A job. Workers get it as JSON.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Job {
    /// Name of its folder.
    pub(super) name: String,
    /// The words that determine its results, with names as in the sweep's file.
    pub(super) command_line: Vec<String>,
    pub(super) named: Vec<Named>,
    /// All files that it reads.
    pub(super) inputs: Vec<PathBuf>,
    /// Hash of these files, as `scene_hash` in the tables of the commands if it reads nothing but a scene.
    pub(super) input_hash: String,
    /// Name of the scene; empty without one.
    pub(super) scene: String,
    /// Its values of the options under `[each]`.
    pub(super) each: Vec<(String, String)>,
    /// Ending of its image.
    pub(super) format: String,
    /// The image that it is a part of.
    pub(super) part_of: Option<String>,
    /// Whether it may use a GPU.
    pub(super) needs_gpu: bool,
    /// Whether it measures times.
    pub(super) is_timed: bool,
    /// Whether others use its machine at the same time, as far as its sender knows.
    #[serde(default)]
    pub(super) is_shared: bool,
    pub(super) retries: u64,
    pub(super) wait_s: u64,
    /// The version that it is planned by.
    pub(super) version: String,
}

/// The version of results: those of other builds are not mixed.
pub(super) fn version() -> String {
    format!("{} {}", env!("CARGO_PKG_VERSION"), env!("RAYSTEP_COMMIT"))
}

impl Job {
    /// Its command.
    pub(super) fn what(&self) -> Option<What> {
        What::of(self.command_line.first()?)
    }

    /// Its words, with files where they lie here.
    pub(super) fn words(&self) -> Vec<OsString> {
        let mut words: Vec<OsString> = self.command_line.iter().map(OsString::from).collect();
        for Named { word, before, path } in &self.named {
            if let Some(word) = words.get_mut(*word) {
                *word = before.into();
                word.push(path);
            }
        }
        words
    }

    /// Hash of the files as they are now.
    pub(super) fn hash_inputs(&self) -> Result<String, Error> {
        hashed(Hash::default(), &self.inputs, u64::MAX).map(|hash| hash.to_string())
    }
}

/// A scene of the sweep.
struct Scene {
    /// As the sweep's file names it.
    given: String,
    path: PathBuf,
}

/// All jobs, in order. Every command line is checked, and every scene is read once.
pub(super) fn jobs(sweep: &Definition) -> Result<Vec<Job>, Error> {
    let at = sweep.file.display();
    let folder = sweep.folder()?;
    let scenes = match sweep.what {
        What::Stability => vec![None],
        _ => scenes(sweep, &folder)?.into_iter().map(Some).collect(),
    };
    let combinations = sweep.each.iter().try_fold(1_usize, |n, values| n.checked_mul(values.len()));
    let parts = sweep.parts.max(1) as usize;
    let count = combinations.and_then(|n| n.checked_mul(scenes.len())?.checked_mul(parts));
    let combinations = combinations.filter(|_| count.is_some_and(|count| count <= MOST_JOBS));
    let combinations = combinations
        .ok_or_else(|| Error::failed(format!("{at}: more than {MOST_JOBS} jobs: divide the sweep into several")))?;
    let (mut jobs, mut names, mut known) = (Vec::new(), BTreeSet::new(), BTreeMap::new());
    for scene in &scenes {
        for combination in 0..combinations {
            let each = chosen(&sweep.each, combination);
            let name = name(scene.as_ref(), &each, &mut names);
            for part in 1..=parts {
                let part = (sweep.parts > 0).then_some((part, parts));
                jobs.push(job(sweep, &folder, scene.as_ref(), &each, &name, part, &mut known)?);
            }
        }
    }
    Ok(jobs)
}

/// The scenes that the patterns match, each once.
fn scenes(sweep: &Definition, folder: &Path) -> Result<Vec<Scene>, Error> {
    let at = sweep.file.display();
    let not_utf8 = |path: &Path| Error::failed(format!("{at}: scenes: the name of {} is not UTF-8", path.display()));
    let here = glob::Pattern::escape(folder.to_str().ok_or_else(|| not_utf8(folder))?);
    let mut scenes: Vec<Scene> = Vec::new();
    for pattern in &sweep.scenes {
        let wrong = |why: &dyn std::fmt::Display| Error::failed(format!("{at}: scenes: \"{pattern}\" {why}"));
        let whole = if Path::new(pattern).is_absolute() { pattern.clone() } else { format!("{here}/{pattern}") };
        // One that is installed, unless there is such a file.
        if is_known(Path::new(pattern)) && !folder.join(pattern).exists() {
            let path = file_of(Path::new(pattern))?;
            if !scenes.iter().any(|scene| scene.path == path) {
                scenes.push(Scene { given: pattern.clone(), path });
            }
            continue;
        }
        // A file's name may have the characters of patterns.
        let file = folder.join(pattern);
        let whole =
            if file.is_file() { glob::Pattern::escape(file.to_str().ok_or_else(|| not_utf8(&file))?) } else { whole };
        let found = glob::glob(&whole).map_err(|e| wrong(&format!("is not a pattern: {}", e.msg)))?;
        let before = scenes.len();
        let mut matches = 0;
        for path in found {
            let path = path.map_err(|e| wrong(&format!("cannot be searched for: {e}")))?;
            matches += 1;
            let given = path.strip_prefix(folder).unwrap_or(&path);
            let given = given.to_str().ok_or_else(|| not_utf8(&path))?.to_owned();
            if !scenes[..before].iter().any(|scene| scene.path == path) {
                scenes.push(Scene { given, path });
            }
        }
        if matches == 0 {
            return Err(wrong(&format!("matches no file in {}", folder.display())));
        }
    }
    Ok(scenes)
}

/// A combination of values, the last option's changing first.
fn chosen(each: &[Vec<Setting>], combination: usize) -> Vec<&Setting> {
    let mut rest = combination;
    let mut chosen: Vec<&Setting> = each
        .iter()
        .rev()
        .filter_map(|values| {
            let value = values.get(rest % values.len());
            rest /= values.len();
            value
        })
        .collect();
    chosen.reverse();
    chosen
}

/// A name that says what the job is, and that no other has, even where case does not count.
fn name(scene: Option<&Scene>, each: &[&Setting], names: &mut BTreeSet<String>) -> String {
    let stem = scene.and_then(|scene| scene.path.file_stem()?.to_str()).unwrap_or("stability");
    let mut name = stem.to_owned();
    for Setting { option, value, .. } in each {
        name += &format!("-{option}-{value}");
    }
    let may_stay = |c: char| c.is_alphanumeric() || matches!(c, '-' | '.');
    let mut name: String = name.chars().map(|c| if may_stay(c) { c } else { '_' }).collect();
    if name.starts_with('.') {
        name.insert(0, '_');
    }
    while name.len() > MOST_NAME {
        name.pop();
    }
    let unique = (1..).map(|n| if n == 1 { name.clone() } else { format!("{name}-{n}") });
    unique.into_iter().find(|name| names.insert(name.to_lowercase())).unwrap_or_default()
}

fn job(
    sweep: &Definition,
    folder: &Path,
    scene: Option<&Scene>,
    each: &[&Setting],
    image: &str,
    part: Option<(usize, usize)>,
    known: &mut BTreeMap<String, (Vec<PathBuf>, Hash)>,
) -> Result<Job, Error> {
    let name = part.map_or_else(|| image.to_owned(), |(part, of)| format!("{image}-part-{part}-of-{of}"));
    let (mut words, mut named) = (vec![sweep.what.name().to_owned()], Vec::new());
    if let Some(scene) = scene {
        named.push(Named { word: 1, before: String::new(), path: scene.path.clone() });
        words.push(scene.given.clone());
    }
    for setting in sweep.options.iter().chain(each.iter().copied()) {
        if FILES.contains(&setting.option.as_str()) {
            let (before, path) = (format!("--{}=", setting.option), folder.join(&setting.value));
            named.push(Named { word: words.len(), before, path });
        }
        words.extend(setting.words.iter().cloned());
    }
    words.extend(part.map(|(part, of)| format!("--shard={part}/{of}")));
    let mut job = Job {
        name,
        command_line: words,
        named,
        inputs: Vec::new(),
        input_hash: String::new(),
        scene: scene.and_then(|s| s.path.file_stem()?.to_str()).unwrap_or_default().to_owned(),
        each: each.iter().map(|setting| (setting.option.clone(), setting.value.clone())).collect(),
        format: sweep.format.to_owned(),
        part_of: part.map(|_| image.to_owned()),
        needs_gpu: true,
        is_timed: false,
        is_shared: false,
        retries: sweep.retries,
        wait_s: sweep.wait_s,
        version: version(),
    };
    let at = |e: Error| Error { message: format!("{}: job {}: {}", sweep.file.display(), job.name, e.message), ..e };
    let command = parse(&job).map_err(at)?;
    (job.needs_gpu, job.is_timed) = match &command {
        Command::Bench(args) => (args.device().device != DeviceKind::Cpu, true),
        Command::Report(args) => (args.device.device != DeviceKind::Cpu, true),
        Command::Render(args) => (args.run.device.device != DeviceKind::Cpu, false),
        Command::Stability(args) => (args.uses_gpu(), args.cost),
        _ => (true, false),
    };
    if let Command::Render(args) = &command {
        let blocks = u64::from(args.view.samples.values.samples.blocks());
        if blocks < sweep.parts {
            let why = format!("parts = {}: expected at most {blocks}, the number of blocks of 16 samples", sweep.parts);
            return Err(at(Error::failed(why)));
        }
    }
    let scene_args = scene.and_then(|scene| match &command {
        Command::Bench(args) => Some(args.file(&scene.path)),
        Command::Report(args) => Some(args.file(&scene.path)),
        Command::Render(args) => {
            let read = args.scene.read;
            Some(crate::args::SceneArgs { scene: scene.path.clone(), scene_index: args.scene.scene_index, read })
        }
        _ => None,
    });
    let (mut inputs, mut hash) = (Vec::new(), Hash::default());
    if let Some(args) = scene_args {
        let key = format!("{args:?}");
        (inputs, hash) = match known.get(&key) {
            Some(read) => read.clone(),
            None => {
                let files = scene_file::read(&args).map_err(at)?.files;
                let read = (files.clone(), hashed(Hash::default(), &files, u64::MAX).map_err(at)?);
                known.entry(key).or_insert(read).clone()
            }
        };
    }
    if let (Some(scene), Some(file)) = (job.named.first_mut().filter(|_| scene.is_some()), inputs.first()) {
        // As its other files are named, so that all of them can be moved together.
        scene.path.clone_from(file);
    }
    let others: Vec<PathBuf> = job.named.iter().skip(inputs.len().min(1)).map(|named| named.path.clone()).collect();
    job.input_hash = hashed(hash, &others, u64::MAX).map_err(at)?.to_string();
    inputs.extend(others);
    job.inputs = inputs;
    Ok(job)
}

/// The command that a job runs.
fn parse(job: &Job) -> Result<Command, Error> {
    let output = if job.what() == Some(What::Render) { format!("x.{}", job.format) } else { "x".into() };
    let words = ["raystep".into()].into_iter().chain(job.words());
    let words: Vec<OsString> = words.chain(["-o".into(), output.into()]).collect();
    match Cli::try_parse_from(&words) {
        Ok(Cli { command: Some(command) }) => Ok(command),
        Ok(Cli { command: None }) => Err(Error::usage("it has no command")),
        Err(error) => Err(Error::usage(usage::message(&error, &words))),
    }
}
