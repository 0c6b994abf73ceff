//! How a program orders the runs of a benchmark from `raystep bench SCENE… --serve`, one by one: a line of text for each
//! request on standard input, a line of JSON for each answer on standard output.
//!
//! | request | answer |
//! |---|---|
//! | none: at the start | `{"hello":{"protocol":1,"raystep_version":"…"}}` |
//! | `build full` or `build brief` | `{"ready":{"configurations":[{"name":"…","row":{…}},…],"notes":["…",…]}}`: everything is built and was run once; `row` is one of `summary.csv` without times. If brief, work is not counted and passes are not timed |
//! | `run N` | `{"run":{…}}`: configuration N, from 0, was run; a row of `runs.csv` |
//! | end of input | none: the program ends |
//!
//! After an error the program ends, with one line on standard error. A program that does not start with this `hello` is
//! another version.

use raystep_lab::bench::{Announced, RunRow};
use serde::{Deserialize, Serialize};

/// Version of the protocol; it rises when a request or an answer changes its meaning.
pub(super) const PROTOCOL: u32 = 1;

/// A request, as a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Request {
    /// Builds everything; not counting and timing passes if brief.
    Build { is_brief: bool },
    /// Runs a configuration.
    Run(usize),
}

/// An answer, as a line of JSON.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Answer {
    Hello { protocol: u32, raystep_version: String },
    Ready { configurations: Vec<Announced>, notes: Vec<String> },
    Run(RunRow),
}

impl Request {
    /// Its line, without a line feed.
    pub(super) fn line(self) -> String {
        match self {
            Self::Build { is_brief: false } => "build full".into(),
            Self::Build { is_brief: true } => "build brief".into(),
            Self::Run(place) => format!("run {place}"),
        }
    }

    /// Reads a line; `None` if it is not a request.
    pub(super) fn read(line: &str) -> Option<Self> {
        match line.trim_end() {
            "build full" => Some(Self::Build { is_brief: false }),
            "build brief" => Some(Self::Build { is_brief: true }),
            other => other.strip_prefix("run ")?.parse().ok().map(Self::Run),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_and_answers_are_read_as_they_were_written() {
        for request in [Request::Build { is_brief: true }, Request::Build { is_brief: false }, Request::Run(17)] {
            assert_eq!(Request::read(&format!("{}\n", request.line())), Some(request));
        }
        assert_eq!((Request::read("run x"), Request::read("stop")), (None, None));
        let hello = Answer::Hello { protocol: PROTOCOL, raystep_version: "1".into() };
        let line = serde_json::to_string(&hello).expect("JSON");
        assert_eq!(line, r#"{"hello":{"protocol":1,"raystep_version":"1"}}"#);
        let run = Answer::Run(RunRow { clock: "host".into(), time_ns: Some(u64::MAX), ..RunRow::default() });
        let text = serde_json::to_string(&run).expect("JSON");
        assert_eq!(serde_json::from_str::<Answer>(&text).expect("an answer"), run);
    }
}
