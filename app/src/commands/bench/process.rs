//! A build of raystep that runs on request, as a process of its own.

use std::ffi::OsString;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use raystep_lab::bench::{Announced, RunRow};

use super::protocol::{Answer, PROTOCOL, Request};
use crate::error::{Error, reason};
use crate::process::{self, Silence};

/// How long to wait for answers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patience {
    pub(super) hello: Duration,
    pub(super) build: Duration,
    pub(super) run: Duration,
}

impl Default for Patience {
    fn default() -> Self {
        let seconds = Duration::from_secs;
        Self { hello: seconds(60), build: seconds(3600), run: seconds(600) }
    }
}

/// A running build. It ends when this is dropped.
pub(super) struct Process {
    /// As the user wrote it.
    name: String,
    inner: process::Process,
    patience: Patience,
}

impl Process {
    /// Starts it, and checks that it speaks the protocol.
    pub(super) fn start(binary: &Path, arguments: &[OsString], patience: Patience) -> Result<Self, Error> {
        let name = binary.display().to_string();
        let cannot = |e: &std::io::Error| Error::failed(format!("cannot start {name}: {}", reason(e)));
        // A name without a folder would be searched for among the system's programs.
        let path = std::fs::canonicalize(binary).map_err(|e| cannot(&e))?;
        let inner = process::Process::start(Command::new(path).args(arguments)).map_err(|e| cannot(&e))?;
        let mut process = Self { name, inner, patience };
        process.greet()?;
        Ok(process)
    }

    fn greet(&mut self) -> Result<(), Error> {
        let name = self.name.clone();
        let other = |why: &str| {
            Error::failed(format!(
                "{name} does not speak version {PROTOCOL} of the protocol of 'bench --against'{why}: expected a build \
                 of raystep from the same or a near version"
            ))
        };
        match self.inner.hear(self.patience.hello) {
            Ok(line) => match serde_json::from_str(&line) {
                Ok(Answer::Hello { protocol: PROTOCOL, .. }) => Ok(()),
                Ok(Answer::Hello { protocol, .. }) => Err(other(&format!(", but version {protocol}"))),
                _ => Err(other("")),
            },
            Err(Silence::Waited(patience)) => Err(other(&format!(" (no answer in {patience:?})"))),
            Err(Silence::Ended { last_error, .. }) => {
                Err(other(&if last_error.is_empty() { String::new() } else { format!(" ({last_error})") }))
            }
        }
    }

    /// Builds all configurations; returns them with the notes.
    pub(super) fn build(&mut self, is_brief: bool) -> Result<(Vec<Announced>, Vec<String>), Error> {
        match self.ask(Request::Build { is_brief }, self.patience.build)? {
            Answer::Ready { configurations, notes } => Ok((configurations, notes)),
            _ => Err(self.confused()),
        }
    }

    /// Runs a configuration.
    pub(super) fn run(&mut self, place: usize) -> Result<RunRow, Error> {
        match self.ask(Request::Run(place), self.patience.run)? {
            Answer::Run(run) => Ok(run),
            _ => Err(self.confused()),
        }
    }

    fn ask(&mut self, request: Request, patience: Duration) -> Result<Answer, Error> {
        let (name, line) = (&self.name, request.line());
        match self.inner.ask(&line, patience) {
            Ok(answer) => serde_json::from_str(&answer).map_err(|_| self.confused()),
            Err(Silence::Waited(patience)) => Err(Error::failed(format!(
                "{name} has not answered \"{line}\" in {patience:?}: it is too slow, or hangs"
            ))),
            Err(Silence::Ended { how, last_error }) => {
                let why = if last_error.is_empty() { String::new() } else { format!(": {last_error}") };
                Err(Error::failed(format!("{name} ended at \"{line}\" ({how}){why}")))
            }
        }
    }

    fn confused(&self) -> Error {
        Error::failed(format!("{} gave an answer that is not of the protocol of 'bench --against'", self.name))
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// What a shell script that speaks so answers to `build full` and `run 0`.
    fn error(script: &str) -> String {
        let patience = Patience {
            hello: Duration::from_secs(20),
            build: Duration::from_secs(20),
            run: Duration::from_millis(300),
        };
        let arguments = ["-c", script].map(OsString::from);
        let asked = Process::start(Path::new("/bin/sh"), &arguments, patience).and_then(|mut process| {
            process.build(false)?;
            process.run(0).map(drop)
        });
        asked.expect_err("it is a script").message().to_owned()
    }

    #[test]
    fn every_way_to_fail_is_named() {
        let hello = r#"echo '{"hello":{"protocol":1,"raystep_version":"0"}}'; read x; "#;
        let ready = r#"echo '{"ready":{"configurations":[],"notes":[]}}'; read x; "#;
        let cases = [
            ("exit 1".to_owned(), "/bin/sh does not speak version 1 of the protocol of 'bench --against': expected"),
            ("echo \"error: unexpected argument '--serve'\" >&2; exit 2".to_owned(), "(unexpected argument '--serve')"),
            (r#"echo '{"hello":{"protocol":7,"raystep_version":"9"}}'"#.to_owned(), ", but version 7:"),
            ("echo hello".to_owned(), "does not speak version 1"),
            (
                format!("{hello} echo 'error: no memory' >&2; exit 1"),
                "ended at \"build full\" (exit status: 1): no memory",
            ),
            (format!("{hello} echo nonsense; read x"), "gave an answer that is not of the protocol"),
            (format!("{hello}{ready} kill -9 $$"), "ended at \"run 0\" (signal: 9"),
            (format!("{hello}{ready} exec sleep 1000"), "has not answered \"run 0\" in 300ms"),
        ];
        for (script, wanted) in cases {
            let message = error(&script);
            assert!(message.contains(wanted), "{script}: {message}");
        }
        let missing = Process::start(Path::new("nowhere/raystep"), &[], Patience::default()).err().expect("no file");
        assert!(missing.message().contains("cannot start nowhere/raystep: No such file"), "{missing}");
    }
}
