//! The results as data and as text, without anything about the user.

use std::path::Path;

use raystep_lab::self_test::{Done, Outcome, Row, Totals, Verdict};
use serde::Serialize;
use serde_json::{Value, json};

use super::drive::Tested;
use crate::error::Error;

/// Version of `self-test.json`.
const SCHEMA_VERSION: u32 = 1;

/// `self-test.json`
#[derive(Serialize)]
pub(super) struct Report<'a> {
    schema_version: u32,
    run_id: &'a str,
    #[serde(flatten)]
    about: Value,
    seconds: f64,
    totals: Totals,
    checks: Vec<Row>,
    steps: &'a [Done],
}

impl<'a> Report<'a> {
    pub(super) fn new(run_id: &'a str, tested: &'a Tested) -> Self {
        let results = &tested.results;
        Self {
            schema_version: SCHEMA_VERSION,
            run_id,
            about: about(tested.about.as_ref()),
            seconds: tested.seconds,
            totals: results.totals(),
            checks: results.rows(),
            steps: results.steps(),
        }
    }

    /// What was tested.
    pub(super) fn about(&self) -> &Value {
        &self.about
    }

    /// The same as lines above the table.
    pub(super) fn heading(&self) -> String {
        let text = |path: &str| self.about.pointer(path).and_then(Value::as_str).unwrap_or("unknown").to_owned();
        let adapter = match self.about.get("adapter") {
            Some(Value::Object(_)) => format!(
                "{}\n{}, {}, {}\n",
                text("/adapter/name"),
                text("/adapter/kind"),
                text("/adapter/backend"),
                text("/adapter/driver")
            ),
            _ => "no device\n".into(),
        };
        let commit: String = text("/commit").chars().take(12).collect();
        format!(
            "{adapter}raystep {} ({commit}), {}, {}\n\n",
            text("/raystep_version"),
            text("/system"),
            text("/architecture")
        )
    }

    fn wrong(&self) -> impl Iterator<Item = &Row> {
        self.checks.iter().filter(|row| row.verdict == Verdict::Wrong)
    }

    /// What it comes to, if nothing is wrong or left out.
    pub(super) fn conclusion(&self) -> &'static str {
        let is_all = self.totals.wrong == 0 && self.totals.not_run == 0;
        if is_all { "raystep works on this adapter.\n" } else { "" }
    }

    /// An error if anything is wrong, with what to do.
    pub(super) fn verdict(&self, bundle: Option<&Path>) -> Result<(), Error> {
        if self.totals.wrong == 0 {
            return Ok(());
        }
        if let (Some(Value::Null), Some(row)) = (self.about.get("adapter"), self.wrong().next()) {
            return Err(Error::failed(&row.says));
        }
        let names: Vec<&str> = self.wrong().map(|row| row.name).collect();
        let send = match bundle {
            Some(path) => format!("send us {}", path.display()),
            None => "run it again with --bundle self-test.zip, and send us the file".into(),
        };
        Err(Error::failed(format!(
            "{} of {} checks are wrong ({}): please {send}, in an issue of the repository from which you have raystep",
            self.totals.wrong,
            self.totals.checks,
            names.join(", ")
        )))
    }
}

/// Program, system and adapter.
fn about(adapter: Option<&Value>) -> Value {
    let mut about = json!({
        "raystep_version": env!("CARGO_PKG_VERSION"),
        "commit": env!("RAYSTEP_COMMIT"),
        "system": system(),
        "architecture": std::env::consts::ARCH,
        "cores": std::thread::available_parallelism().map_or(1, usize::from),
        "adapter": null,
    });
    if let (Some(all), Some(Value::Object(adapter))) = (about.as_object_mut(), adapter) {
        all.extend(adapter.clone());
    }
    about
}

/// The system's name, and its version where a file tells it.
fn system() -> String {
    let named = |text: String| {
        let value = text.lines().find_map(|line| line.strip_prefix("PRETTY_NAME="))?;
        Some(value.trim_matches('"').to_owned())
    };
    let release = std::fs::read_to_string("/etc/os-release").ok().and_then(named);
    release.unwrap_or_else(|| std::env::consts::OS.into())
}

/// Names of this user and machine, which a driver's message may contain.
pub(super) struct Private(Vec<String>);

impl Private {
    pub(super) fn new() -> Self {
        let variable = |name: &str| std::env::var(name).ok();
        let path = |path: std::io::Result<std::path::PathBuf>| path.ok().map(|path| path.display().to_string());
        let mut all: Vec<String> = [
            variable("HOME"),
            variable("USERPROFILE"),
            path(std::env::current_dir()),
            path(std::env::current_exe()),
            Some(std::env::temp_dir().display().to_string()),
            variable("USER"),
            variable("USERNAME"),
            variable("LOGNAME"),
            Some(gethostname::gethostname().to_string_lossy().into_owned()),
        ]
        .into_iter()
        .flatten()
        .filter(|name| name.len() > 2)
        .collect();
        // A path before those that it begins with.
        all.sort_by_key(|name| std::cmp::Reverse(name.len()));
        Self(all)
    }

    /// A text without them.
    pub(super) fn cleaned(&self, text: &str) -> String {
        self.0.iter().fold(text.to_owned(), |text, name| without(&text, name))
    }

    /// An outcome without them.
    pub(super) fn clean(&self, outcome: &mut Outcome) {
        for finding in &mut outcome.findings {
            finding.says = self.cleaned(&finding.says);
            finding.details.iter_mut().for_each(|line| *line = self.cleaned(line));
        }
    }
}

/// Replaces a name wherever it stands alone, and not as a part of a word.
fn without(text: &str, name: &str) -> String {
    let is_word = |c: Option<char>| c.is_some_and(char::is_alphanumeric);
    let (mut out, mut rest) = (String::new(), text);
    while let Some(at) = rest.find(name) {
        let (before, after) = (&rest[..at], &rest[at + name.len()..]);
        let is_alone =
            !is_word(before.chars().next_back().or(out.chars().next_back())) && !is_word(after.chars().next());
        out += before;
        out += if is_alone { "…" } else { name };
        rest = after;
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_private_is_left_out_of_messages_and_words_stay_whole() {
        let private = Private(["/home/anna/a", "/home/anna", "anna"].map(str::to_owned).to_vec());
        let told = private.cleaned("/home/anna/a/b.spv: no memory for anna's hosanna in /home/anna");
        assert_eq!(told, "…/b.spv: no memory for …'s hosanna in …");
        assert_eq!(private.cleaned("annals of anna"), "annals of …");
        assert!(!Private::new().0.is_empty());
    }
}
