//! Terminal output: results on stdout, everything else on stderr. A closed pipe is not an error, and control characters
//! in names of scenes, paths and arguments are escaped.

mod log;

use std::fmt;
use std::io::{self, ErrorKind, IsTerminal as _, Write as _};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use raystep_lab::reporter::Reporter;
use raystep_lab::text::{visible, visible_lines};

use crate::error::Error;
use log::Log;

/// Time between two lines of progress in a log.
const LOG_EVERY: Duration = Duration::from_secs(10);

/// Writes a result to stdout. It is not an error if the reader has closed it, as `head` does.
pub(crate) fn print(text: &str) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    match out.write_all(visible_lines(text).as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::failed(format!("cannot write to standard output: {}", crate::error::reason(&error))))
        }
        _ => Ok(()),
    }
}

/// Writes a line to stderr; ignores failures.
pub(crate) fn say(line: impl std::fmt::Display) {
    let _ = writeln!(io::stderr(), "{}", visible(&line.to_string()));
}

/// Writes lines to stderr; ignores failures.
pub(crate) fn say_lines(text: &str) {
    let _ = writeln!(io::stderr(), "{}", visible_lines(text));
}

/// Progress of a long run: none with `--quiet`; an animated bar if stderr is a terminal, otherwise a line at intervals.
pub(crate) struct Progress {
    bar: ProgressBar,
    is_quiet: bool,
    is_log: bool,
}

impl Progress {
    pub(crate) fn new(is_quiet: bool) -> Self {
        let is_log = !io::stderr().is_terminal();
        let target = match is_log {
            _ if is_quiet => ProgressDrawTarget::hidden(),
            true => log_target(Log::new(io::stderr(), LOG_EVERY)),
            false => ProgressDrawTarget::stderr(),
        };
        Self::on(target, is_quiet, is_log)
    }

    fn on(target: ProgressDrawTarget, is_quiet: bool, is_log: bool) -> Self {
        Self { bar: ProgressBar::with_draw_target(None, target), is_quiet, is_log }
    }

    /// Sets what is shown. What only moves, or only fits a terminal, is left out of a log.
    fn style(&self, template: &str) {
        let template = match self.is_log {
            true => {
                template.replace("{spinner} ", "").replace("[{bar:30}] ", "").replace("{msg:<24}", "{msg}:")
                    + if template.contains("{elapsed}") { "" } else { ", {elapsed}" }
            }
            false => template.to_owned(),
        };
        let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
        self.bar.set_style(style.progress_chars("=> ").with_key("elapsed", elapsed));
    }

    /// Begins a stage of unknown length.
    pub(crate) fn stage(&self, name: &str) {
        self.bar.unset_length();
        self.style("{spinner} {msg}");
        self.bar.set_message(visible(name).into_owned());
        self.bar.enable_steady_tick(Duration::from_millis(100));
    }

    /// Shows the progress of a run.
    pub(crate) fn rays(&self, progress: &raystep_kernels::Progress) {
        if self.bar.length() != Some(progress.rays) {
            self.bar.set_length(progress.rays);
            self.style("{msg:<24} [{bar:30}] {human_pos} of {human_len} rays resolved, {elapsed}");
        }
        let place = if progress.samples_wanted > 1 {
            let sample = (progress.samples + 1).min(progress.samples_wanted);
            format!("sample {sample} of {}", progress.samples_wanted)
        } else {
            format!("pass {}", progress.passes)
        };
        // No ray is resolved meanwhile.
        let others = progress.others.map(|name| format!(", {}", name.replace('_', " ")));
        self.bar.set_message(place + &others.unwrap_or_default());
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
            self.style("{msg:<24} [{bar:30}] {human_pos} of {human_len}, {elapsed}");
        }
        // It may say how much time is left.
        self.bar.set_message(visible(what).into_owned());
        self.bar.set_position(done);
    }

    /// Shows how many jobs are done, and one that runs.
    pub(crate) fn job(&self, name: &str, done: u64, of: u64, failed: usize) {
        if self.bar.length() != Some(of) {
            self.bar.set_length(of);
            self.style("[{bar:30}] {pos} of {len} jobs{prefix}, {elapsed}, {wide_msg}");
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
            // A log tells that the work goes on, even if no ray comes.
            if !self.is_log {
                self.bar.disable_steady_tick();
            }
            match of {
                Some(of) => {
                    self.bar.set_length(of);
                    self.style("[{bar:30}] {human_pos} of {human_len} rays, {per_sec}, {elapsed}");
                }
                None => self.style("{human_pos} rays, {per_sec}, {elapsed}"),
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

fn elapsed(state: &ProgressState, out: &mut dyn fmt::Write) {
    // The bar ignores what cannot be written, too.
    let _ = out.write_str(&in_words(state.elapsed()));
}

/// A time to the second: 2m10s. Lines of a log that only say minutes look as if nothing went on.
fn in_words(time: Duration) -> String {
    let seconds = time.as_secs();
    match (seconds / 3600, seconds / 60 % 60, seconds % 60) {
        (0, 0, seconds) => format!("{seconds}s"),
        (0, minutes, seconds) => format!("{minutes}m{seconds:02}s"),
        (hours, minutes, seconds) => format!("{hours}h{minutes:02}m{seconds:02}s"),
    }
}

/// A target that draws as often as bars tick.
fn log_target(log: Log<impl io::Write + std::fmt::Debug + Send + 'static>) -> ProgressDrawTarget {
    ProgressDrawTarget::term_like_with_hz(Box::new(log), 10)
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

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::*;

    /// What was written.
    #[derive(Clone, Debug, Default)]
    struct Written(Arc<Mutex<Vec<u8>>>);

    impl io::Write for Written {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().expect("a lock").write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    /// The lines of some work, of which one is due after this time.
    fn lines(every: Duration, work: impl FnOnce(&Progress)) -> Vec<String> {
        let written = Written::default();
        let progress = Progress::on(log_target(Log::new(written.clone(), every)), false, true);
        work(&progress);
        drop(progress);
        let bytes = written.0.lock().expect("a lock").clone();
        String::from_utf8(bytes).expect("UTF-8").lines().map(str::to_owned).collect()
    }

    #[test]
    fn a_log_has_a_line_at_intervals_even_while_nothing_is_reported() {
        let every = Duration::from_millis(250);
        let lines = lines(every, |progress| {
            progress.stage("building");
            // Longer than the work of the thread that ticks may be delayed.
            std::thread::sleep(12 * every);
        });
        assert!((2..=12).contains(&lines.len()), "{lines:?}");
        assert!(lines.iter().all(|line| line.starts_with("progress: building, ")), "{lines:?}");
    }

    #[test]
    fn a_log_has_numbers_without_a_bar() {
        let lines = lines(Duration::ZERO, |progress| progress.part("measuring", 1_234, 20_000));
        assert!(lines.iter().any(|line| line.starts_with("progress: measuring: 1,234 of 20,000, ")), "{lines:?}");
        assert!(lines.iter().all(|line| !line.contains('[') && line.trim_end() == line), "{lines:?}");
    }

    #[test]
    fn what_a_run_works_on_beside_rays_is_told() {
        let at = |passes, others| {
            let (rays_decided, rays, samples, samples_wanted) = (0, 64, 0, 1);
            raystep_kernels::Progress { passes, rays_decided, rays, samples, samples_wanted, others }
        };
        let lines = lines(Duration::ZERO, |progress| {
            progress.rays(&at(7, Some("map_cells")));
            progress.rays(&at(8, None));
        });
        assert!(lines.iter().any(|line| line.contains("pass 7, map cells: 0 of 64 rays resolved")), "{lines:?}");
        assert!(lines.iter().any(|line| line.contains("pass 8: 0 of 64 rays resolved")), "{lines:?}");
    }

    #[test]
    fn what_is_done_may_change_with_every_part() {
        let lines = lines(Duration::ZERO, |progress| {
            progress.part("10 s to go", 1, 3);
            progress.part("5 s to go", 2, 3);
        });
        assert!(lines.iter().any(|line| line.starts_with("progress: 5 s to go: 2 of 3, ")), "{lines:?}");
    }

    #[test]
    fn times_are_told_to_the_second() {
        let times = [0, 59, 60, 130, 3_725].map(|seconds| in_words(Duration::from_secs(seconds)));
        assert_eq!(times, ["0s", "59s", "1m00s", "2m10s", "1h02m05s"]);
    }

    #[test]
    fn short_work_leaves_no_line_in_a_log() {
        let lines = lines(LOG_EVERY, |progress| {
            progress.stage("building");
            progress.part("measuring", 1, 2);
        });
        assert!(lines.is_empty(), "{lines:?}");
    }
}
