//! Runs the jobs of a sweep that are not finished, here or by others, and keeps their results.

use std::ffi::OsStr;
use std::fs::{self, File, TryLockError};
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::mpsc::{Sender, channel};
use std::time::Duration;

use serde::Deserialize;
use serde_json::{Value, json};

use super::file::{Definition, IDENTITY};
use super::job::{self, Done};
use super::plan::Job;
use crate::commands::json_text;
use crate::error::{Error, reason};
use crate::output::{self, Folder, Target};
use crate::scene_file::read_file;
use crate::terminal::Progress;

/// The file that says which sweep a folder is of.
const FILE: &str = "sweep.json";
/// The start of that file.
const KIND: &str = "raystep sweep";
/// The file that is locked while a program works on the folder.
const LOCK: &str = "sweep.lock";
/// The folder of the jobs' folders.
const JOBS: &str = "jobs";
/// Most bytes of that file.
const MOST_BYTES: u64 = 1 << 24;

/// The output folder of a sweep. No other process works on it as long as this exists.
pub(super) struct Place {
    /// As the user wrote it.
    pub(super) path: PathBuf,
    _lock: File,
}

/// A job that failed.
#[derive(Clone, Debug)]
pub(super) struct Failure {
    pub(super) name: String,
    pub(super) message: String,
}

/// Whether a file or folder of this name is one that was not completed.
fn is_temporary(name: &str) -> bool {
    name.starts_with(".raystep-") && name.ends_with(".part")
}

/// What happened.
enum Event {
    Started(String),
    Ended(String, Result<Done, String>),
}

/// A line from the process that distributes jobs.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum Line {
    Done { name: String, folder: PathBuf },
    Failed { name: String, message: String },
}

impl Place {
    /// Opens a folder that is new, empty, or of this sweep.
    pub(super) fn open(path: &Path, sweep: &Definition) -> Result<Self, Error> {
        let at = path.display();
        let cannot = |e: std::io::Error| Error::cannot_write(path, &e);
        let text = json_text(&json!({ "kind": KIND, "schema_version": 1, "sweep": sweep.identity }))?;
        Self::expect_free(path, sweep, &text)?;
        match fs::create_dir(path) {
            Err(error) if error.kind() != ErrorKind::AlreadyExists => return Err(cannot(error)),
            _ => {}
        }
        let lock = File::options().write(true).create(true).truncate(false).open(path.join(LOCK)).map_err(cannot)?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(Error::failed(format!("{at} is in use by another 'raystep sweep': wait until that ends")));
            }
            Err(TryLockError::Error(error)) => return Err(cannot(error)),
        }
        // Another sweep may have begun before it was locked.
        Self::expect_free(path, sweep, &text)?;
        output::write(vec![(Target::new(&path.join(FILE))?, text.into_bytes())])?;
        fs::create_dir_all(path.join(JOBS)).map_err(cannot)?;
        let place = Self { path: path.to_owned(), _lock: lock };
        place.sweep_up();
        Ok(place)
    }

    /// Refuses a folder with anything else than this sweep, whose description is `text`.
    fn expect_free(path: &Path, sweep: &Definition, text: &str) -> Result<(), Error> {
        let at = path.display();
        let cannot = |e: std::io::Error| Error::cannot_write(path, &e);
        if Folder::find(path)? != Folder::Full {
            return Ok(());
        }
        let about = |bytes: &[u8]| serde_json::from_slice::<Value>(bytes).ok().filter(|about| about["kind"] == KIND);
        let Some(theirs) = read_file(&path.join(FILE), MOST_BYTES).ok().and_then(|bytes| about(&bytes)) else {
            // A sweep that ended before it could describe itself.
            let is_ours = |name: &OsStr| name == LOCK || name.to_str().is_some_and(is_temporary);
            let names: Result<Vec<_>, _> = fs::read_dir(path).map_err(cannot)?.collect();
            if names.map_err(cannot)?.iter().all(|entry| is_ours(&entry.file_name())) {
                return Ok(());
            }
            return Err(Error::failed(format!(
                "{at} is not empty and contains no sweep: choose a new or empty folder"
            )));
        };
        // Numbers of both are read from text, in which their last bits may be lost.
        let ours = about(text.as_bytes()).unwrap_or_default();
        match IDENTITY.iter().find(|key| ours["sweep"].get(key) != theirs["sweep"].get(key)) {
            Some(key) => Err(Error::failed(format!(
                "{at} contains a sweep with another value of '{key}' than {}: choose another folder",
                sweep.file.display()
            ))),
            None => Ok(()),
        }
    }

    /// Removes what killed processes have left.
    fn sweep_up(&self) {
        for entry in fs::read_dir(self.path.join(JOBS)).into_iter().flatten().flatten() {
            let name = entry.file_name();
            if name.to_str().is_some_and(is_temporary) {
                // What stays is in nobody's way.
                let path = entry.path();
                let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
            }
        }
    }

    /// A job's folder.
    pub(super) fn folder(&self, job: &str) -> PathBuf {
        self.path.join(JOBS).join(job)
    }

    /// How a job ended, if it is finished.
    pub(super) fn done(&self, job: &Job) -> Option<Done> {
        Done::read(&self.folder(&job.name), job)
    }

    /// Runs jobs here, some side by side; calls `ended` after each that has results.
    pub(super) fn run(
        &self,
        all: &[Job],
        side_by_side: usize,
        ended: &mut dyn FnMut(&str),
        progress: &Progress,
    ) -> Vec<Failure> {
        let pending: Vec<&Job> = all.iter().filter(|job| self.done(job).is_none()).collect();
        let next = Mutex::new(pending.iter());
        let (events, arrived) = channel();
        std::thread::scope(|scope| {
            for _ in 0..side_by_side.min(pending.len()) {
                let (events, next) = (events.clone(), &next);
                scope.spawn(move || {
                    while let Some(job) = { next.lock().ok().and_then(|mut next| next.next()) } {
                        // The receiver lives as long as this scope.
                        let _ = events.send(Event::Started(job.name.clone()));
                        let folder = self.folder(&job.name);
                        let result = job::remove(&folder).and_then(|()| job::run(job, &folder));
                        let _ = events.send(Event::Ended(job.name.clone(), result.map_err(|e| e.message)));
                    }
                });
            }
            drop(events);
            show(arrived, all.len(), pending.len(), ended, progress)
        })
    }

    /// Lets another process run jobs: tells it those that are not finished, as a line of JSON, and reads from it what
    /// becomes of them, a line each; calls `ended` after each that has results.
    pub(super) fn serve(
        &self,
        all: &[Job],
        ended: &mut dyn FnMut(&str),
        progress: &Progress,
    ) -> Result<Vec<Failure>, Error> {
        let pending: Vec<&Job> = all.iter().filter(|job| self.done(job).is_none()).collect();
        let hello = json!({ "jobs": pending, "folder": self.path.join(JOBS) });
        let mut out = std::io::stdout();
        writeln!(out, "{hello}").and_then(|()| out.flush()).map_err(Error::failed)?;
        let (events, arrived) = channel();
        Ok(std::thread::scope(|scope| {
            let pending_jobs = &pending;
            scope.spawn(move || {
                for line in std::io::stdin().lines().map_while(Result::ok) {
                    self.take(&line, pending_jobs, &events);
                }
            });
            show(arrived, all.len(), pending.len(), ended, progress)
        }))
    }

    /// What a line says.
    fn take(&self, line: &str, jobs: &[&Job], events: &Sender<Event>) {
        let event = match serde_json::from_str(line) {
            Ok(Line::Failed { name, message }) => Event::Ended(name, Err(message)),
            Ok(Line::Done { name, folder }) => {
                let placed = jobs.iter().find(|job| job.name == name).map(|job| self.place(job, &folder));
                Event::Ended(name, placed.unwrap_or_else(|| Err("it is not of this sweep".into())))
            }
            Err(error) => Event::Ended("?".into(), Err(format!("a line that is not of the protocol: {error}"))),
        };
        let _ = events.send(event);
    }

    /// Makes a folder on the same file system the job's own.
    fn place(&self, job: &Job, folder: &Path) -> Result<Done, String> {
        let done = Done::read(folder, job).ok_or("its results are incomplete or belong to another job")?;
        let target = self.folder(&job.name);
        job::remove(&target).map_err(|e| e.message)?;
        fs::rename(folder, &target).map_err(|e| format!("cannot write {}: {}", target.display(), reason(&e)))?;
        Ok(done)
    }
}

/// Shows what happens, until nothing more can. Returns the failures.
fn show(
    arrived: std::sync::mpsc::Receiver<Event>,
    all: usize,
    pending: usize,
    ended: &mut dyn FnMut(&str),
    progress: &Progress,
) -> Vec<Failure> {
    let mut done = all - pending;
    if done > 0 {
        progress.say(format_args!("{done} of {all} jobs are finished already"));
    }
    let mut failures: Vec<Failure> = Vec::new();
    for event in arrived {
        match event {
            Event::Started(name) => progress.job(&name, done as u64, all as u64, failures.len()),
            Event::Ended(name, Ok(result)) => {
                done += 1;
                let time = Duration::from_secs_f64(result.job_s.clamp(0.0, 1e9));
                let again = if result.attempts > 1 { format!(", attempt {}", result.attempts) } else { String::new() };
                progress.job("", done as u64, all as u64, failures.len());
                progress.say(format_args!("{done} of {all}: {name}, {:.1} s{again}", time.as_secs_f64()));
                ended(&name);
            }
            Event::Ended(name, Err(message)) => {
                progress.say(format_args!("failed: {name}: {message}"));
                failures.push(Failure { name, message });
                progress.job("", done as u64, all as u64, failures.len());
            }
        }
    }
    failures
}
