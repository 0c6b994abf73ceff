//! Runs a job: a child process, whose results appear in the job's folder when they are complete.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::file::What;
use super::owner::Owner;
use super::plan::{Job, version};
use crate::commands::json_text;
use crate::error::{Error, reason};
use crate::interrupt;
use crate::output::TargetFolder;
use crate::process::{last_error, this_program};
use crate::scene_file::{bytes_of, read_file};

/// The file that says how a job ended. A folder with it is complete.
pub(super) const FILE: &str = "job.json";
/// A render's summary.
pub(super) const SUMMARY: &str = "summary.json";

/// Most bytes of a job's file.
const MOST_BYTES: u64 = 1 << 20;

/// How a job ended.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Done {
    kind: String,
    schema_version: u32,
    pub(super) name: String,
    command_line: Vec<String>,
    input_hash: String,
    version: String,
    /// Name of the machine.
    pub(super) host: String,
    /// Whether something else ran on the machine at the same time; `null` if nothing was timed.
    pub(super) is_shared: Option<bool>,
    /// Seconds of the child process.
    pub(super) job_s: f64,
    /// How often it ran.
    pub(super) attempts: u64,
    /// Why the command failed although it wrote its results, as a check that found errors.
    pub(super) verdict: Option<String>,
}

impl Done {
    /// How the job ended whose folder this is; `None` if it is another job's, or incomplete.
    pub(super) fn read(folder: &Path, job: &Job) -> Option<Self> {
        let done: Self = serde_json::from_slice(&read_file(&folder.join(FILE), MOST_BYTES).ok()?).ok()?;
        let is_same = done.command_line == job.command_line
            && done.input_hash == job.input_hash
            && done.version == job.version
            && done.name == job.name;
        is_same.then_some(done)
    }
}

/// Runs a job into its folder, which must not exist. Failures are tried again.
pub(super) fn run(job: &Job, target: &Path) -> Result<Done, Error> {
    if job.version != version() {
        return Err(Error::failed(format!(
            "the sweep was planned by raystep {}, but this machine has {}: install the same build everywhere",
            job.version,
            version()
        )));
    }
    if job.hash_inputs()? != job.input_hash {
        return Err(Error::failed("its input files have changed since the sweep started: run the sweep again"));
    }
    let mut attempt = 1;
    loop {
        let folder = TargetFolder::new(target, false)?;
        let done = folder.fill(&[], |folder| {
            let done = attempt_at(job, folder.place(), attempt)?;
            let text = json_text(&done)?;
            folder.write(FILE, |out| out.write_all(text.as_bytes()))?;
            Ok(done)
        });
        match done {
            Ok(done) => return Ok(done),
            Err(_) if attempt <= job.retries => attempt += 1,
            Err(error) => return Err(error),
        }
    }
}

fn attempt_at(job: &Job, folder: &Path, attempt: u64) -> Result<Done, Error> {
    let owner = job.is_timed.then(|| Owner::wait(Duration::from_secs(job.wait_s)));
    let mut words = job.words();
    let (output, known_by) = match job.what() {
        Some(What::Render) if job.part_of.is_none() => {
            words.extend(["--summary-json".into(), folder.join(SUMMARY).into()]);
            let image = folder.join(format!("image.{}", job.format));
            (image.clone(), image)
        }
        // Its files have names that only the merge needs to know.
        Some(What::Render) => (folder.join("part"), folder.join("part")),
        Some(What::Bench) => (folder.to_owned(), folder.join("summary.csv")),
        Some(What::Stability) => (folder.to_owned(), folder.join("stability.csv")),
        Some(What::Report) => (folder.to_owned(), folder.join("index.html")),
        None => return Err(Error::failed("it has no command")),
    };
    words.extend(["-o".into(), output.into(), "--quiet".into()]);
    let begin = Instant::now();
    let failed = child(&words, owner.as_ref().and_then(Owner::handle)).err();
    let job_s = begin.elapsed().as_secs_f64();
    // A command that judges its results may fail with them. A part does not, and its folder is there from the start.
    let verdict = match failed {
        Some(error) if job.part_of.is_some() || !known_by.exists() => return Err(error),
        Some(error) => Some(error.message),
        None if !known_by.exists() => return Err(Error::failed("it wrote no results")),
        None => None,
    };
    Ok(Done {
        kind: "raystep sweep job".into(),
        schema_version: 1,
        name: job.name.clone(),
        command_line: job.command_line.clone(),
        input_hash: job.input_hash.clone(),
        version: job.version.clone(),
        host: gethostname::gethostname().to_string_lossy().into_owned(),
        is_shared: owner.map(|owner| owner.was_shared() || job.is_shared),
        job_s,
        attempts: attempt,
        verdict,
    })
}

/// Runs this program with other words. Its error is the last line that it wrote.
pub(super) fn child(words: &[OsString], lock: Option<File>) -> Result<(), Error> {
    let cannot = |e: std::io::Error| Error::failed(format!("cannot start a process: {}", reason(&e)));
    let program = this_program()?;
    let mut errors = tempfile::tempfile().map_err(cannot)?;
    let mut command = Command::new(program.first().map_or_else(OsString::new, Clone::clone));
    command.args(program.iter().skip(1)).args(words).stdout(Stdio::null());
    command.stdin(lock.map_or_else(Stdio::null, Stdio::from)).stderr(errors.try_clone().map_err(cannot)?);
    let status = interrupt::run(&mut command).map_err(cannot)?;
    if status.success() {
        return Ok(());
    }
    let last = last_error(&mut errors);
    Err(Error::failed(if last.is_empty() { format!("it ended with {status}") } else { last }))
}

/// Runs a job of another process: `file` has it as JSON. Ends when that process does.
pub(super) fn run_file(file: &Path, target: &Path) -> Result<(), Error> {
    let bytes = bytes_of(file, MOST_BYTES)?;
    let job = serde_json::from_slice(&bytes).map_err(|e| Error::at(file, format!("it is not a job: {e}")))?;
    std::thread::spawn(|| {
        // The pipe closes when its writer has ended, however it ended.
        let _ = std::io::copy(&mut std::io::stdin(), &mut std::io::sink());
        interrupt::end(i32::from(crate::error::FAILED));
    });
    run(&job, target).map(drop)
}

/// Removes a folder that is no longer wanted.
pub(super) fn remove(folder: &Path) -> Result<(), Error> {
    match fs::remove_dir_all(folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(Error::failed(format!("cannot replace {}: {}", folder.display(), reason(&error))))
        }
        _ => Ok(()),
    }
}
