//! A build of raystep that runs on request, as a process of its own.

use std::ffi::OsString;
use std::fs::File;
use std::io::{BufRead as _, BufReader, Read as _, Seek as _, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use raystep_lab::bench::{Announced, RunRow};

use super::protocol::{Answer, PROTOCOL, Request};
use crate::error::Error;
use crate::output::reason;

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
    child: Child,
    requests: Option<ChildStdin>,
    answers: Receiver<String>,
    errors: File,
    patience: Patience,
}

impl Drop for Process {
    fn drop(&mut self) {
        self.requests = None;
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Process {
    /// Starts it, and checks that it speaks the protocol.
    pub(super) fn start(binary: &Path, arguments: &[OsString], patience: Patience) -> Result<Self, Error> {
        let name = binary.display().to_string();
        let cannot = |e: &std::io::Error| Error::failed(format!("cannot start {name}: {}", reason(e)));
        // A name without a folder would be searched for among the system's programs.
        let path = std::fs::canonicalize(binary).map_err(|e| cannot(&e))?;
        let errors = tempfile::tempfile().map_err(|e| cannot(&e))?;
        let mut child = Command::new(path)
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(errors.try_clone().map_err(|e| cannot(&e))?)
            .spawn()
            .map_err(|e| cannot(&e))?;
        let (requests, out) = (child.stdin.take(), child.stdout.take());
        let (lines, answers) = channel();
        // Reading blocks, and a process may never answer. The thread ends with the process.
        std::thread::spawn(move || {
            let lines_of = out.into_iter().flat_map(|out| BufReader::new(out).lines());
            for line in lines_of.map_while(Result::ok) {
                if lines.send(line).is_err() {
                    break;
                }
            }
        });
        let mut process = Self { name, child, requests, answers, errors, patience };
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
        match self.answers.recv_timeout(self.patience.hello) {
            Ok(line) => match serde_json::from_str(&line) {
                Ok(Answer::Hello { protocol: PROTOCOL, .. }) => Ok(()),
                Ok(Answer::Hello { protocol, .. }) => Err(other(&format!(", but version {protocol}"))),
                _ => Err(other("")),
            },
            Err(RecvTimeoutError::Timeout) => Err(other(&format!(" (no answer in {:?})", self.patience.hello))),
            Err(RecvTimeoutError::Disconnected) => {
                let last = self.last_error();
                let last = last.strip_prefix("error: ").unwrap_or(&last);
                Err(other(&if last.is_empty() { String::new() } else { format!(" ({last})") }))
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
        if let Some(requests) = &mut self.requests
            && writeln!(requests, "{}", request.line()).and_then(|()| requests.flush()).is_err()
        {
            return Err(self.ended(request));
        }
        match self.answers.recv_timeout(patience) {
            Ok(line) => serde_json::from_str(&line).map_err(|_| self.confused()),
            Err(RecvTimeoutError::Timeout) => Err(Error::failed(format!(
                "{} has not answered \"{}\" in {patience:?}: it is too slow, or hangs",
                self.name,
                request.line()
            ))),
            Err(RecvTimeoutError::Disconnected) => Err(self.ended(request)),
        }
    }

    fn confused(&self) -> Error {
        Error::failed(format!("{} gave an answer that is not of the protocol of 'bench --against'", self.name))
    }

    /// The error of a process that has ended.
    fn ended(&mut self, request: Request) -> Error {
        let how = self.child.wait().map_or_else(|e| reason(&e), |status| status.to_string());
        let last = self.last_error();
        let last = last.strip_prefix("error: ").map_or(last.as_str(), |last| last);
        let why = if last.is_empty() { String::new() } else { format!(": {last}") };
        Error::failed(format!("{} ended at \"{}\" ({how}){why}", self.name, request.line()))
    }

    /// The last line that it wrote to standard error; empty if there is none.
    fn last_error(&mut self) -> String {
        const MOST_BYTES: u64 = 1 << 16;
        let mut bytes = Vec::new();
        // What cannot be read is not shown.
        let _ = self.errors.rewind().and_then(|()| (&self.errors).take(MOST_BYTES).read_to_end(&mut bytes));
        String::from_utf8_lossy(&bytes).lines().rfind(|line| !line.trim().is_empty()).unwrap_or("").to_owned()
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
