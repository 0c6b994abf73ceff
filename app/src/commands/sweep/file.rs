//! The file that describes a sweep.

use std::path::{Path, PathBuf};

use clap::{Arg, ArgAction, CommandFactory as _};
use raystep_kernels::named;
use serde_json::{Map, Value};
use toml::de::{DeTable, DeValue};

use crate::cli::Cli;
use crate::error::Error;
use crate::scene_file::bytes_of;
use crate::usage::{did_you_mean, or};

/// Most bytes of the file.
const MOST_BYTES: u64 = 1 << 20;
/// Most parts of an image, and most retries: more are surely a mistake.
const MOST: u64 = 10_000;
/// Longest time to wait for a machine, seconds.
const MOST_WAIT_S: u64 = 7 * 24 * 3600;

/// Keys of the file.
const KEYS: [&str; 8] = ["what", "scenes", "options", "each", "format", "parts", "retries", "wait_s"];

/// Those that make it this sweep and not another.
pub(super) const IDENTITY: [&str; 6] = ["what", "scenes", "options", "each", "format", "parts"];

/// Options that a sweep sets itself, or that have no place in one: they read or write what is outside of a job.
const TAKEN: [&str; 15] = [
    "output",
    "force",
    "quiet",
    "shard",
    "help",
    "list",
    "against",
    "at-most",
    "baseline",
    "bundle",
    "verify",
    "passes-csv",
    "trace-json",
    "summary-json",
    "count-fragments",
];

/// Lists whose members a benchmark compares with each other.
const COMPARED: [&str; 5] = ["accelerators", "schedules", "mappings", "traversals", "integrators"];

/// Options that name an input file.
pub(super) const FILES: [&str; 3] = ["rays-file", "strata", "methods"];

/// A command that a sweep can run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum What {
    Bench,
    Stability,
    Report,
    Render,
}

named!(What, Bench "bench", Stability "stability", Report "report", Render "render");

impl What {
    pub(super) fn of(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|what| what.name() == name)
    }
}

/// One value of an option.
#[derive(Clone, Debug)]
pub(super) struct Setting {
    /// The option, without hyphens.
    pub(super) option: String,
    /// The value, for names and tables.
    pub(super) value: String,
    /// Words of the command line.
    pub(super) words: Vec<String>,
}

/// A sweep.
#[derive(Debug)]
pub(super) struct Definition {
    /// The file, as the user wrote it.
    pub(super) file: PathBuf,
    pub(super) what: What,
    /// Patterns of scenes' names; none for a command without scenes.
    pub(super) scenes: Vec<String>,
    /// Options of all jobs.
    pub(super) options: Vec<Setting>,
    /// Options of which every combination is a job.
    pub(super) each: Vec<Vec<Setting>>,
    /// Ending of images.
    pub(super) format: &'static str,
    /// Parts of an image; 0 if it is not divided.
    pub(super) parts: u64,
    /// How often a failed job runs again.
    pub(super) retries: u64,
    /// How long a timed job waits for its machine, seconds.
    pub(super) wait_s: u64,
    /// The values of [`IDENTITY`].
    pub(super) identity: Value,
}

impl Definition {
    /// Reads the file.
    pub(super) fn read(path: &Path) -> Result<Self, Error> {
        let at = path.display();
        let bytes = bytes_of(path, MOST_BYTES)?;
        let text = String::from_utf8(bytes).map_err(|_| Error::failed(format!("{at}: it is not UTF-8")))?;
        let table = DeTable::parse(&text).map_err(|e| {
            let before = text.get(..e.span().map_or(0, |span| span.start)).unwrap_or_default();
            Error::failed(format!("{at}, line {}: {}", before.matches('\n').count() + 1, e.message()))
        })?;
        let value = json(&DeValue::Table(table.into_inner()));
        let table = value.as_object().cloned().unwrap_or_default();
        Self::of(path, &table).map_err(|message| Error::failed(format!("{at}: {message}")))
    }

    fn of(path: &Path, table: &Map<String, Value>) -> Result<Self, String> {
        if let Some(key) = table.keys().find(|key| !KEYS.contains(&key.as_str())) {
            return Err(format!("{key}: no such key; {}expected {}", did_you_mean(key, &KEYS), or(&KEYS)));
        }
        let names = What::ALL.map(What::name);
        let what = table.get("what").ok_or_else(|| format!("what is missing: expected {}", or(&names)))?;
        let what =
            what.as_str().and_then(What::of).ok_or_else(|| format!("what = {what}: expected {}", quoted(&names)))?;
        let shared = settings(table, "options")?;
        let all = shared.iter().map(|(name, value)| what.setting("options", name, value));
        let all = all.collect::<Result<Vec<_>, _>>()?;
        let mut each = Vec::new();
        for (name, values) in settings(table, "each")? {
            if shared.iter().any(|(other, _)| *other == name) {
                return Err(format!("{name} is under [options] and under [each]: omit one of them"));
            }
            if what == What::Bench && COMPARED.contains(&name) {
                return Err(format!(
                    "each.{name}: bench compares {name} within one job, so they cannot be divided among jobs; \
                     move the list to [options]"
                ));
            }
            let Some(values) = values.as_array().filter(|values| !values.is_empty()) else {
                return Err(format!("each.{name}: expected a list of values, such as [1, 2]"));
            };
            let values = values.iter().map(|value| what.setting("each", name, value));
            let values = values.collect::<Result<Vec<_>, _>>()?;
            if let Some((_, twice)) =
                values.iter().enumerate().find(|(i, a)| values[..*i].iter().any(|b| a.words == b.words))
            {
                return Err(format!("each.{name}: {} is listed twice: remove one", twice.value));
            }
            each.push(values);
        }
        let scenes = scenes(table, what)?;
        let format = match (table.get("format").map(Value::as_str), what) {
            (None, _) => "png",
            (Some(Some("png")), What::Render) => "png",
            (Some(Some("exr")), What::Render) => "exr",
            (Some(_), What::Render) => return Err("format: expected \"png\" or \"exr\"".into()),
            (Some(_), _) => return Err(format!("format: {} makes no image; omit it", what.name())),
        };
        let parts = whole(table, "parts", 1, MOST)?;
        if parts.is_some() && what != What::Render {
            return Err("parts: only what = \"render\" can be divided into parts; omit it".into());
        }
        let identity = IDENTITY.into_iter().filter_map(|key| Some((key.to_owned(), table.get(key)?.clone())));
        Ok(Self {
            file: path.to_owned(),
            what,
            scenes,
            options: all,
            each,
            format,
            parts: parts.unwrap_or(0),
            retries: whole(table, "retries", 0, MOST)?.unwrap_or(1),
            wait_s: whole(table, "wait_s", 0, MOST_WAIT_S)?.unwrap_or(300),
            identity: Value::Object(identity.collect()),
        })
    }

    /// The folder that names in the file are relative to.
    pub(super) fn folder(&self) -> Result<PathBuf, Error> {
        let path = std::path::absolute(&self.file).map_err(Error::failed)?;
        Ok(path.parent().map(Path::to_owned).unwrap_or_default())
    }
}

/// Patterns of scenes.
fn scenes(table: &Map<String, Value>, what: What) -> Result<Vec<String>, String> {
    let example = "expected a list of files or patterns, such as [\"scenes/*.glb\"]";
    match (table.get("scenes"), what) {
        (None, What::Stability) => Ok(Vec::new()),
        (Some(_), What::Stability) => Err("scenes: stability has cases of its own; omit it".into()),
        (None, _) => Err(format!("scenes is missing: {example}")),
        (Some(scenes), _) => {
            let scenes = scenes.as_array().filter(|scenes| !scenes.is_empty());
            let scenes = scenes.ok_or_else(|| format!("scenes: {example}"))?;
            let name = |scene: &Value| scene.as_str().map(str::to_owned).ok_or_else(|| format!("scenes: {example}"));
            scenes.iter().map(name).collect()
        }
    }
}

/// A table of options.
fn settings<'a>(table: &'a Map<String, Value>, key: &str) -> Result<Vec<(&'a str, &'a Value)>, String> {
    match table.get(key) {
        None => Ok(Vec::new()),
        Some(Value::Object(options)) => Ok(options.iter().map(|(name, value)| (name.as_str(), value)).collect()),
        Some(_) => Err(format!("{key}: expected a table of options, [{key}]")),
    }
}

/// A whole number.
fn whole(table: &Map<String, Value>, key: &str, least: u64, most: u64) -> Result<Option<u64>, String> {
    let Some(value) = table.get(key) else { return Ok(None) };
    let number = value.as_u64().filter(|n| (least..=most).contains(n));
    number.map(Some).ok_or_else(|| format!("{key} = {value}: expected an integer from {least} to {most}"))
}

impl What {
    /// The words for an option of this name and value.
    fn setting(self, table: &str, name: &str, value: &Value) -> Result<Setting, String> {
        let (at, command) = (format!("{table}.{name}"), self.name());
        if matches!(name, "output" | "force" | "quiet" | "shard" | "summary-json") {
            return Err(format!("{at}: a sweep sets --{name} itself; omit it"));
        }
        if TAKEN.contains(&name) {
            return Err(format!("{at}: --{name} cannot be used in a sweep; omit it"));
        }
        let mut cli = Cli::command();
        cli.build();
        let arguments: Vec<Arg> =
            cli.find_subcommand(command).into_iter().flat_map(|c| c.get_arguments().cloned()).collect();
        let arguments: Vec<&Arg> = arguments.iter().filter(|a| a.get_long().is_some() && !a.is_hide_set()).collect();
        let Some(argument) = arguments.iter().find(|a| is_called(a, name)) else {
            let names: Vec<&str> =
                arguments.iter().filter_map(|a| a.get_long()).filter(|n| !TAKEN.contains(n)).collect();
            let tip = did_you_mean(name, &names);
            return Err(format!("{at}: raystep {command} has no option --{name}; {tip}see 'raystep {command} --help'"));
        };
        let is_list = matches!(argument.get_action(), ArgAction::Append);
        // Such as X,Y,Z.
        let is_vector = argument.get_value_names().is_some_and(|names| names.iter().any(|name| name.contains(',')));
        let (value, words) = match (argument.get_action().takes_values(), value) {
            (false, Value::Bool(is_set)) => {
                (is_set.to_string(), if *is_set { vec![format!("--{name}")] } else { Vec::new() })
            }
            (false, _) => return Err(format!("{at}: --{name} has no value; expected true or false")),
            (true, Value::Array(values)) if is_list && !values.is_empty() => {
                let values: Option<Vec<String>> = values.iter().map(text).collect();
                let values = values.ok_or_else(|| format!("{at}: expected a list of values"))?;
                let joined = values.join(",");
                let words = match argument.get_value_delimiter() {
                    Some(_) => vec![format!("--{name}={joined}")],
                    None => values.iter().map(|value| format!("--{name}={value}")).collect(),
                };
                (joined, words)
            }
            (true, Value::Array(values)) if is_vector => {
                let values: Option<Vec<String>> = values.iter().map(text).collect();
                let value = values.ok_or_else(|| format!("{at}: expected a list of numbers"))?.join(",");
                (value.clone(), vec![format!("--{name}={value}")])
            }
            (true, Value::Array(_)) => {
                return Err(format!("{at}: --{name} takes one value; to run a job with each of several, use [each]"));
            }
            (true, value) => {
                let value = text(value).ok_or_else(|| format!("{at}: expected the value of --{name}"))?;
                let words = vec![format!("--{name}={value}")];
                (value, words)
            }
        };
        Ok(Setting { option: name.to_owned(), value, words })
    }
}

/// Whether this is the option's name, or another one that it also has.
fn is_called(argument: &Arg, name: &str) -> bool {
    argument.get_long() == Some(name) || argument.get_all_aliases().is_some_and(|names| names.contains(&name))
}

/// The text of a value on a command line; `None` if it has none.
fn text(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    }
}

fn quoted(names: &[&str]) -> String {
    or(&names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>())
}

/// TOML as JSON, which has no dates: they become text.
fn json(value: &DeValue<'_>) -> Value {
    match value {
        DeValue::String(text) => Value::String(text.to_string()),
        DeValue::Integer(integer) => match i64::from_str_radix(integer.as_str(), integer.radix()) {
            Ok(integer) => integer.into(),
            Err(_) => Value::String(integer.as_str().to_owned()),
        },
        DeValue::Float(float) => match float.as_str().parse::<f64>() {
            Ok(float) if float.is_finite() => float.into(),
            _ => Value::String(float.as_str().to_owned()),
        },
        DeValue::Boolean(is_set) => Value::Bool(*is_set),
        DeValue::Datetime(date) => Value::String(date.to_string()),
        DeValue::Array(values) => values.iter().map(|value| json(value.get_ref())).collect(),
        DeValue::Table(table) => {
            Value::Object(table.iter().map(|(key, value)| (key.get_ref().to_string(), json(value.get_ref()))).collect())
        }
    }
}
