//! `raystep info --self-test`: whether raystep works on an adapter.
//!
//! The device is opened by another process, which does one step at a time. If the driver crashes or hangs, that is what
//! the step has found, and a new process goes on with the next.

mod drive;
mod report;
mod serve;

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use raystep_lab::self_test::{details, text};

use self::drive::Tested;
use self::report::Report;
use crate::args::{QuietArgs, whole};
use crate::error::Error;
use crate::output::{Target, ending, write, zipped};
use crate::session::run_id;
use crate::terminal::{Progress, print};

#[derive(Args, Debug)]
#[command(next_help_heading = "Self-test")]
pub(super) struct SelfTestArgs {
    /// Test whether raystep works on the best adapter
    #[arg(long, conflicts_with = "scene")]
    self_test: bool,
    /// Name of the GPU adapter to test, or part of it
    #[arg(long, value_name = "NAME", requires = "self_test")]
    adapter: Option<String>,
    /// Write all results into a ZIP file, to send to us
    #[arg(long, value_name = "F.zip", requires = "self_test")]
    bundle: Option<PathBuf>,
    /// Time limit in seconds; checks that do not fit are listed as not run
    #[arg(long, value_name = "N", default_value_t = 60, requires = "self_test", value_parser = whole::<u32>(1, 86_400),
          allow_negative_numbers = true)]
    seconds: u32,
    /// Answer the process that started this one; for its own use
    #[arg(long, value_name = "RUN", requires = "self_test", hide = true)]
    serve: Option<String>,
    #[command(flatten)]
    quiet: QuietArgs,
}

impl SelfTestArgs {
    pub(super) fn is_wanted(&self) -> bool {
        self.self_test
    }
}

/// The files of a bundle that are not CSV.
const DATA: &str = "self-test.json";
const ADAPTER: &str = "info.json";
const TABLE: &str = "self-test.txt";
const DETAILS: &str = "details.txt";

pub(super) fn run(args: &SelfTestArgs, is_json: bool) -> Result<(), Error> {
    if let Some(run_id) = &args.serve {
        return serve::serve(args.adapter.as_deref(), run_id);
    }
    let target = match &args.bundle {
        Some(path) => {
            ending("--bundle", path, &["zip"])?;
            Some(Target::new(path)?)
        }
        None => None,
    };
    let progress = Progress::new(args.quiet.quiet);
    let run_id = run_id();
    let words = serve::words(args.adapter.as_deref(), &run_id)?;
    let tested = Tested::new(&words, Duration::from_secs(args.seconds.into()), &progress);
    progress.finish();
    let report = Report::new(&run_id, &tested);
    let data = crate::commands::json_text(&report)?;
    let table = report.heading() + &text(&tested.results) + report.conclusion();
    if let Some(target) = target {
        let (info, details) = (crate::commands::json_text(&report.about())?, details(&tested.results));
        let own = [(DATA, &data), (ADAPTER, &info), (TABLE, &table), (DETAILS, &details)];
        let files = own.into_iter().chain(tested.results.files().iter().map(|(name, file)| (name.as_str(), file)));
        let zip = zipped(files.map(|(name, file)| (name, file.as_bytes())))?;
        let path = target.path().display().to_string();
        write(vec![(target, zip)])?;
        progress.say(format_args!("wrote {path}"));
    }
    print(if is_json { &data } else { &table })?;
    report.verdict(args.bundle.as_deref())
}
