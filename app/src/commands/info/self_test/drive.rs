//! Orders the steps of the self-test from a process of its own, and goes on if that process crashes or hangs.

use std::collections::VecDeque;
use std::ffi::OsString;
use std::process::Command;
use std::time::{Duration, Instant};

use raystep_lab::self_test::{Group, LIMITS, Outcome, Results, STAYS, Step, Verdict, steps};
use serde_json::Value;

use super::report::Private;
use super::serve::Answer;
use crate::error::reason;
use crate::process::{Process, Silence};
use crate::terminal::Progress;

/// How long a step may take, or a quarter of the whole test if that is more. Systems reset a GPU that hangs after a few
/// seconds, but a driver may take long to compile.
const PATIENCE: Duration = Duration::from_secs(30);

/// Why a step is left out that would take too long.
const NO_TIME: &str = "time; --seconds N gives it more";

/// How often a process may fail in a row before it does its first step.
const STARTS: usize = 2;

/// An adapter that was tested.
pub(super) struct Tested {
    /// What is known.
    pub(super) results: Results,
    /// About the adapter; `None` if no device could be opened.
    pub(super) about: Option<Value>,
    /// How long it took.
    pub(super) seconds: f64,
}

/// Does the steps.
struct Drive<'a> {
    words: &'a [OsString],
    patience: Duration,
    process: Option<Process>,
    tested: Tested,
    private: Private,
    /// Why no further step can be done.
    end: Option<String>,
}

impl Tested {
    /// Tests the adapter that the process with this command line opens, for about so long.
    pub(super) fn new(words: &[OsString], time: Duration, progress: &Progress) -> Self {
        Self::patiently(words, time, PATIENCE.max(time / 4), progress)
    }

    /// The same, with a longest time for a step.
    fn patiently(words: &[OsString], time: Duration, patience: Duration, progress: &Progress) -> Self {
        let (begin, steps) = (Instant::now(), steps());
        let tested = Self { results: Results::new(&steps), about: None, seconds: 0.0 };
        let mut drive = Drive { words, patience, process: None, tested, private: Private::new(), end: None };
        let mut left: VecDeque<usize> = (0..steps.len()).collect();
        while let Some(index) = left.pop_front() {
            let step = &steps[index];
            let done = steps.len() - left.len();
            progress.stage(&format!("step {done} of {}: {}", steps.len(), step.name));
            let usual = drive.tested.results.usual_seconds(step.group).unwrap_or(0.0);
            if begin.elapsed().as_secs_f64() + usual > time.as_secs_f64() {
                drive.tested.results.skip(index, NO_TIME);
            } else if !drive.step(index, step) {
                // Others like it may take as long: first those that are not.
                let (like_it, others): (Vec<usize>, Vec<usize>) =
                    left.into_iter().partition(|&other| steps[other].group == step.group);
                left = others.into_iter().chain(like_it).collect();
            }
        }
        drive.tested.seconds = begin.elapsed().as_secs_f64();
        drive.tested
    }
}

impl Drive<'_> {
    /// Does a step, if that is still possible. `false` if there was no answer in time.
    fn step(&mut self, index: usize, step: &Step) -> bool {
        if self.end.is_none() && self.process.is_none() {
            self.open();
        }
        if let Some(why) = &self.end {
            self.tested.results.skip(index, why);
            return true;
        }
        let Some(process) = &mut self.process else { return true };
        let begin = Instant::now();
        let asked = process.ask(&index.to_string(), self.patience);
        let answer = answered(process, asked, self.patience);
        let failed = |why: &str| Outcome::failed(step, why, begin.elapsed().as_secs_f64());
        let is_answered = !matches!(answer, Err(Silence::Waited(_)));
        let mut outcome = match answer {
            Ok(Answer::Done(outcome)) => *outcome,
            Ok(_) => failed("the process gave another answer"),
            Err(Silence::Waited(patience)) => {
                failed(&format!("no answer in {patience:?}: the driver hangs, or is very slow"))
            }
            Err(ended) => failed(&format!("{ended}: the driver crashes, or raystep does")),
        };
        if outcome.is_device_lost {
            self.process = None;
        }
        self.private.clean(&mut outcome);
        self.tested.results.add(index, outcome);
        is_answered
    }

    /// Starts a process, which opens the device.
    fn open(&mut self) {
        let mut last = String::new();
        for _ in 0..STARTS {
            match self.started() {
                Ok(process) => {
                    self.process = Some(process);
                    return;
                }
                Err(why) => last = self.private.cleaned(&why),
            }
        }
        let (check, end) = match self.tested.about {
            None => (LIMITS, "there is no device"),
            Some(_) => (STAYS, "the device could not be opened again"),
        };
        self.tested.results.note(Group::Adapter, check, Verdict::Wrong, last);
        self.end = Some(end.into());
    }

    fn started(&mut self) -> Result<Process, String> {
        let [program, arguments @ ..] = self.words else { return Err("there is no program".into()) };
        let started = Process::start(Command::new(program).args(arguments));
        let mut process = started.map_err(|e| format!("the process cannot be started: {}", reason(&e)))?;
        let first = process.hear(self.patience);
        match answered(&mut process, first, self.patience) {
            Ok(Answer::Opened(about)) => {
                self.tested.about.get_or_insert(about);
                Ok(process)
            }
            Ok(Answer::Refused(why)) => Err(why),
            Ok(Answer::Done(_)) => Err("the process gave another answer".into()),
            Err(silence) => Err(silence.to_string()),
        }
    }
}

/// The first line that is an answer: a driver may print others.
fn answered(process: &mut Process, first: Result<String, Silence>, patience: Duration) -> Result<Answer, Silence> {
    let (begin, mut line) = (Instant::now(), first);
    loop {
        let text = line?;
        if let Ok(answer) = serde_json::from_str(&text) {
            return Ok(answer);
        }
        line = process.hear(patience.saturating_sub(begin.elapsed()));
    }
}

#[cfg(all(test, unix))]
mod tests {
    use raystep_lab::self_test::{Row, Totals};

    use super::*;

    /// Nothing is wrong in any step.
    const DONE: &str = r#"echo '{"done":{"findings":[],"files":[],"seconds":0,"is_device_lost":false}}'"#;
    /// After a line that is none of the program's.
    const OPENED: &str = r#"echo 'a driver says hello'; echo '{"opened":{"adapter":{"name":"a test"}}}'"#;

    /// What is known of a device whose process is this shell script.
    fn tested(script: &str) -> Tested {
        let words = ["/bin/sh", "-c", script].map(OsString::from);
        let (time, patience) = (Duration::from_secs(60), Duration::from_millis(500));
        Tested::patiently(&words, time, patience, &Progress::new(true))
    }

    fn wrong(tested: &Tested) -> Vec<Row> {
        tested.results.rows().into_iter().filter(|row| row.verdict == Verdict::Wrong).collect()
    }

    #[test]
    fn a_step_in_which_the_driver_crashes_or_hangs_is_wrong_and_the_others_go_on() {
        for (what, told) in [("kill -SEGV $$", "the driver crashes"), ("exec sleep 1000", "the driver hangs")] {
            // Not in the process that goes on: it begins after that step.
            let script = format!("{OPENED}; while read step; do [ $step = 3 ] && {what}; {DONE}; done");
            let tested = tested(&script);
            let wrong = wrong(&tested);
            let name = &steps()[3].name;
            assert_eq!(wrong.len(), 1, "{what}: {wrong:?}");
            assert!(wrong[0].says.starts_with(name.as_str()) && wrong[0].says.contains(told), "{:?}", wrong[0]);
            let Totals { wrong, .. } = tested.results.totals();
            assert_eq!((wrong, tested.results.seconds(Group::Pipelines)), (1, 0.0));
            let left_out = tested.results.rows().into_iter().find(|row| row.says.contains("left out"));
            assert_eq!(left_out, None, "every other step was done");
        }
    }

    #[test]
    fn steps_like_one_that_hangs_come_last() {
        let folder = tempfile::tempdir().expect("a folder");
        let log = folder.path().join("log");
        let steps = steps();
        let of = |group| steps.iter().position(|step| step.group == group).expect("a step");
        let (hanging, last) = (of(Group::Hits), of(Group::Building) - 1);
        let script = format!(
            "{OPENED}; while read step; do echo $step >> {}; [ $step = {hanging} ] && exec sleep 1000; {DONE}; done",
            log.display()
        );
        let tested = tested(&script);
        assert_eq!((wrong(&tested).len(), tested.results.totals().wrong), (1, 1));
        let order = std::fs::read_to_string(log).expect("a log");
        let order: Vec<usize> = order.lines().map(|line| line.parse().expect("a step")).collect();
        assert_eq!((order.len(), order.last()), (steps.len(), Some(&last)));
        let after = order.iter().position(|&step| step == hanging).expect("it was asked for");
        assert_eq!((order[after - 1], order[after + 1]), (hanging - 1, last + 1));
    }

    #[test]
    fn a_device_that_is_lost_is_opened_again_and_if_it_cannot_be_the_rest_is_left_out() {
        let lost = DONE.replace("false", "true");
        let tested_again = tested(&format!("{OPENED}; read step; {lost}"));
        assert_eq!((wrong(&tested_again).len(), tested_again.results.totals().not_run > 10), (0, true));
        let folder = tempfile::tempdir().expect("a folder");
        let mark = folder.path().join("opened").display().to_string();
        let refused = r#"echo '{"refused":"no more devices"}'"#;
        let script = format!("[ -e {mark} ] && {{ {refused}; exit; }}; touch {mark}; {OPENED}; read step; {lost}");
        let tested = tested(&script);
        let wrong = wrong(&tested);
        assert_eq!((wrong.len(), wrong[0].name, wrong[0].says.as_str()), (1, STAYS, "no more devices"));
        let rows = tested.results.rows();
        assert!(rows.iter().any(|row| row.says == "the device could not be opened again"), "{rows:?}");
    }

    #[test]
    fn without_a_device_the_limits_are_wrong_and_nothing_else_is_said() {
        for (script, told) in [
            (r#"echo '{"refused":"no GPU adapter with compute shaders (there are none)"}'"#, "no GPU adapter"),
            ("echo hello", "the process ended (exit status: 0)"),
            ("echo 'error: no such option' >&2; exit 2", "no such option"),
        ] {
            let tested = tested(script);
            let wrong = wrong(&tested);
            assert_eq!((wrong.len(), wrong[0].name), (1, LIMITS), "{script}");
            assert!(wrong[0].says.contains(told) && tested.about.is_none(), "{:?}", wrong[0]);
            assert_eq!(tested.results.totals().not_run, tested.results.totals().checks - 1);
        }
    }

    #[test]
    fn what_does_not_fit_the_time_is_said() {
        let words = ["/bin/sh", "-c", "exec sleep 1000"].map(OsString::from);
        let tested = Tested::new(&words, Duration::ZERO, &Progress::new(true));
        let totals = tested.results.totals();
        assert_eq!((totals.not_run, totals.wrong), (totals.checks, 0));
        assert!(tested.results.rows().iter().all(|row| row.says.contains(NO_TIME)), "{:?}", tested.results.rows());
    }
}
