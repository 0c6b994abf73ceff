//! Another process that answers lines with lines: it may crash or hang, and this program goes on.

use std::ffi::OsString;
use std::fmt;
use std::fs::File;
use std::io::{self, BufRead as _, BufReader, Read as _, Seek as _, Write as _};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use crate::error::{Error, reason};

/// How this program is called, as a JSON list of words, where it is not an executable of its own.
const COMMAND: &str = "RAYSTEP_COMMAND";

/// How this program is called.
pub(crate) fn this_program() -> Result<Vec<OsString>, Error> {
    if let Some(command) = std::env::var_os(COMMAND) {
        let words: Option<Vec<String>> = command.to_str().and_then(|text| serde_json::from_str(text).ok());
        return match words.filter(|words| !words.is_empty()) {
            Some(words) => Ok(words.into_iter().map(OsString::from).collect()),
            None => Err(Error::usage(format!("{COMMAND}: expected a JSON list of words, such as [\"raystep\"]"))),
        };
    }
    let program = std::env::current_exe().map_err(|e| Error::failed(format!("the program cannot be found: {e}")))?;
    Ok(vec![program.into()])
}

/// A running process. It ends when this is dropped.
pub(crate) struct Process {
    child: Child,
    requests: Option<ChildStdin>,
    answers: Receiver<String>,
    errors: File,
}

/// Why there is no answer.
#[derive(Debug)]
pub(crate) enum Silence {
    /// Not in time.
    Waited(Duration),
    /// The process has ended.
    Ended {
        /// Its exit status.
        how: String,
        /// The last line that it wrote to standard error; empty if there is none.
        last_error: String,
    },
}

impl fmt::Display for Silence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Waited(patience) => write!(f, "no answer in {patience:?}: it is too slow, or hangs"),
            Self::Ended { how, last_error } if last_error.is_empty() => write!(f, "the process ended ({how})"),
            Self::Ended { how, last_error } => write!(f, "the process ended ({how}): {last_error}"),
        }
    }
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
    /// Starts it.
    pub(crate) fn start(command: &mut Command) -> io::Result<Self> {
        let errors = tempfile::tempfile()?;
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(errors.try_clone()?).spawn()?;
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
        Ok(Self { child, requests, answers, errors })
    }

    /// Sends a line and waits for one.
    pub(crate) fn ask(&mut self, line: &str, patience: Duration) -> Result<String, Silence> {
        if let Some(requests) = &mut self.requests
            && writeln!(requests, "{line}").and_then(|()| requests.flush()).is_err()
        {
            return Err(self.ended());
        }
        self.hear(patience)
    }

    /// Waits for a line.
    pub(crate) fn hear(&mut self, patience: Duration) -> Result<String, Silence> {
        match self.answers.recv_timeout(patience) {
            Ok(line) => Ok(line),
            Err(RecvTimeoutError::Timeout) => Err(Silence::Waited(patience)),
            Err(RecvTimeoutError::Disconnected) => Err(self.ended()),
        }
    }

    fn ended(&mut self) -> Silence {
        let how = self.child.wait().map_or_else(|e| reason(&e), |status| status.to_string());
        let last_error = last_error(&mut self.errors);
        Silence::Ended { how, last_error }
    }
}

/// The last line that a process wrote to this file, its standard error; empty if there is none.
pub(crate) fn last_error(errors: &mut File) -> String {
    const MOST_BYTES: u64 = 1 << 20;
    let mut bytes = Vec::new();
    // What cannot be read is not shown.
    let _ = errors.rewind().and_then(|()| errors.take(MOST_BYTES).read_to_end(&mut bytes));
    let text = String::from_utf8_lossy(&bytes);
    let last = text.lines().rfind(|line| !line.trim().is_empty()).unwrap_or("");
    last.strip_prefix("error: ").unwrap_or(last).to_owned()
}
