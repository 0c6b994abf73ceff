//! Terminal output: results on stdout, everything else on stderr. A closed pipe is not an error, and control characters
//! in names of scenes, paths and arguments are escaped.

use std::io::{self, ErrorKind, Write as _};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use raystep_lab::reporter::Reporter;
use raystep_lab::text::{visible, visible_lines};

use crate::error::Error;

/// Writes a result to stdout. It is not an error if the reader has closed it, as `head` does.
pub(crate) fn print(text: &str) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    match out.write_all(visible_lines(text).as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::failed(format!("cannot write to standard output: {}", crate::output::reason(&error))))
        }
        _ => Ok(()),
    }
}

/// Writes a line to stderr; ignores failures.
pub(crate) fn say(line: impl std::fmt::Display) {
    let _ = writeln!(io::stderr(), "{}", visible(&line.to_string()));
}

/// Writes lines to stderr.
fn say_lines(text: &str) {
    let _ = writeln!(io::stderr(), "{}", visible_lines(text));
}

/// Progress of a long run: none with `--quiet`, and no animated bar unless stderr is a terminal.
pub(crate) struct Progress {
    bar: ProgressBar,
    is_quiet: bool,
}

impl Progress {
    pub(crate) fn new(is_quiet: bool) -> Self {
        // A target that is not a terminal draws nothing.
        let target = if is_quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        Self { bar: ProgressBar::with_draw_target(None, target), is_quiet }
    }

    /// Begins a stage of unknown length.
    pub(crate) fn stage(&self, name: &str) {
        self.bar.unset_length();
        self.bar.set_style(style("{spinner} {msg}"));
        self.bar.set_message(visible(name).into_owned());
        self.bar.enable_steady_tick(Duration::from_millis(100));
    }

    /// Shows the progress of a run.
    pub(crate) fn rays(&self, progress: &raystep_kernels::Progress) {
        if self.bar.length() != Some(progress.rays) {
            self.bar.set_length(progress.rays);
            self.bar.set_style(style("{msg:<24} [{bar:30}] {human_pos} of {human_len} rays resolved, {elapsed}"));
        }
        if progress.samples_wanted > 1 {
            let sample = (progress.samples + 1).min(progress.samples_wanted);
            self.bar.set_message(format!("sample {sample} of {}", progress.samples_wanted));
        } else {
            self.bar.set_message(format!("pass {}", progress.passes));
        }
        self.bar.set_position(progress.rays_decided);
    }

    /// Shows progress by passes only.
    pub(crate) fn pass(&self, index: usize) {
        self.bar.set_message(format!("pass {index}"));
    }

    /// Shows progress of other work.
    pub(crate) fn part(&self, what: &str, done: u64, of: u64) {
        if self.bar.length() != Some(of) {
            self.bar.set_length(of);
            self.bar.set_style(style("{msg:<24} [{bar:30}] {human_pos} of {human_len}, {elapsed}"));
            self.bar.set_message(visible(what).into_owned());
        }
        self.bar.set_position(done);
    }

    /// Shows how many jobs are done, and one that runs.
    pub(crate) fn job(&self, name: &str, done: u64, of: u64, failed: usize) {
        if self.bar.length() != Some(of) {
            self.bar.set_length(of);
            self.bar.set_style(style("[{bar:30}] {pos} of {len} jobs{prefix}, {elapsed}, {wide_msg}"));
            self.bar.enable_steady_tick(Duration::from_millis(500));
        }
        if failed > 0 {
            self.bar.set_prefix(format!(", {failed} failed"));
        }
        self.bar.set_message(visible(name).into_owned());
        self.bar.set_position(done);
    }

    /// Shows how many rays of other programs are done, of how many if that is known.
    pub(crate) fn cast(&self, done: u64, of: Option<u64>) {
        if done == 0 {
            self.bar.disable_steady_tick();
            match of {
                Some(of) => {
                    self.bar.set_length(of);
                    self.bar.set_style(style("[{bar:30}] {human_pos} of {human_len} rays, {per_sec}, {elapsed}"));
                }
                None => self.bar.set_style(style("{human_pos} rays, {per_sec}, {elapsed}")),
            }
            self.bar.reset();
        }
        self.bar.set_position(done);
    }

    /// Prints a permanent line.
    pub(crate) fn say(&self, line: impl std::fmt::Display) {
        if !self.is_quiet {
            self.bar.suspend(|| say(line));
        }
    }

    /// Prints several permanent lines.
    pub(crate) fn say_lines(&self, text: &str) {
        if !self.is_quiet {
            self.bar.suspend(|| say_lines(text));
        }
    }

    /// Removes the bar.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.finish();
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> ")
}

impl Reporter for Progress {
    fn stage(&self, name: &str) {
        Self::stage(self, name);
    }

    fn part(&self, what: &str, done: u64, of: u64) {
        Self::part(self, what, done, of);
    }

    fn note(&self, text: &str) {
        self.say(format_args!("note: {text}"));
    }

    fn explain(&self, error: &raystep_lab::Error) -> String {
        Error::from(error).message().to_owned()
    }
}
