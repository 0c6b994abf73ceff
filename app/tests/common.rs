//! Runs the binary in a temporary folder.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use tempfile::TempDir;

/// A scene file of this repository.
pub(crate) fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(name)
}

/// The result of a run.
#[derive(Debug)]
pub(crate) struct Outcome {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

/// An empty folder in which the binary runs.
pub(crate) struct Place {
    folder: TempDir,
}

impl Place {
    pub(crate) fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a temporary folder") }
    }

    pub(crate) fn path(&self, name: impl AsRef<OsStr>) -> PathBuf {
        self.folder.path().join(name.as_ref())
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Sorted names of the files in the folder, including hidden ones.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).expect("the folder");
        let mut names: Vec<_> =
            entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// The binary.
    pub(crate) fn command(&self, arguments: &[&OsStr]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_raystep"));
        command.current_dir(self.folder.path()).args(arguments).stdin(Stdio::null());
        // As on a machine without a desktop, where libraries of the desktop would complain on stderr.
        for name in ["XDG_RUNTIME_DIR", "DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
            command.env_remove(name);
        }
        command
    }

    pub(crate) fn run(&self, arguments: &[&str]) -> Outcome {
        let arguments: Vec<&OsStr> = arguments.iter().map(OsStr::new).collect();
        outcome(&mut self.command(&arguments))
    }

    /// Runs a line of a shell, with this binary as `raystep`, and without a display. Examples' scripts run without Python.
    #[cfg(unix)]
    pub(crate) fn shell(&self, line: &str) -> Outcome {
        let python = "python() { if [ \"$1\" = make_rays.py ]; then cat rays.npy; else cat > hits.npy; fi; }";
        let script = format!("raystep() {{ '{}' \"$@\"; }}\n{python}\n{line}", env!("CARGO_BIN_EXE_raystep"));
        let mut shell = Command::new("sh");
        for name in ["XDG_RUNTIME_DIR", "DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
            shell.env_remove(name);
        }
        let home = self.path("");
        outcome(shell.args(["-c", &script]).env("HOME", &home).current_dir(&home))
    }

    /// Runs, and requires exit code 0.
    pub(crate) fn ok(&self, arguments: &[&str]) -> Outcome {
        let outcome = self.run(arguments);
        assert_eq!(outcome.code, Some(0), "{arguments:?}: {outcome:?}");
        outcome
    }

    /// Runs, and requires this exit code, a one-line error that contains `wanted`, and no new files.
    pub(crate) fn fails(&self, code: i32, wanted: &str, arguments: &[&str]) {
        let before = self.names();
        let outcome = self.run(arguments);
        assert_error(&outcome, code, wanted, &format!("{arguments:?}"));
        assert_eq!(self.names(), before, "{arguments:?} left files behind");
    }
}

pub(crate) fn assert_error(outcome: &Outcome, code: i32, wanted: &str, what: &str) {
    assert_eq!(outcome.code, Some(code), "{what}: {outcome:?}");
    assert_eq!(outcome.stdout, "", "{what}");
    let is_aside = |line: &&str| ["note: ", "progress: "].iter().any(|begin| line.starts_with(begin));
    let errors: Vec<_> = outcome.stderr.lines().filter(|line| !is_aside(line)).collect();
    assert_eq!(errors.len(), 1, "{what}: expected one line: {outcome:?}");
    assert!(errors[0].starts_with("error: ") && errors[0].contains(wanted), "{what}: {:?} in {errors:?}", wanted);
}

pub(crate) fn outcome(command: &mut Command) -> Outcome {
    let output = command.output().expect("the binary starts");
    Outcome {
        code: output.status.code(),
        stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
        stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}
