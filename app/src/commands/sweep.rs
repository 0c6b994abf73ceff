//! `raystep sweep`

mod drive;
mod file;
mod gather;
mod job;
mod owner;
mod page;
mod plan;

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::args::{QuietArgs, whole};
use crate::error::Error;
use crate::terminal::{Progress, say};
use drive::{Failure, Place};
use file::Definition;

/// Run a command for many scenes and options
///
/// SWEEP.toml has the keys: what = "bench", "stability", "report" or "render"; scenes, a list of files or patterns such
/// as "scenes/*.glb", relative to the file; under [options], the options of all jobs, by long name without the leading "--";
/// under [each], options with a list of values each. There is a job for every scene and combination of these values. For
/// bench, the lists accelerators, schedules, mappings, traversals and integrators belong under [options], because one job
/// compares them with each other. For render: format = "png" or "exr", and parts = N to divide the samples of each image among N jobs.
///
/// Each job runs as a process of its own; its results are in DIR/jobs/NAME. A job that fails is retried once, or retries =
/// N times; other jobs continue. After an interruption, the same command continues with the jobs that are not finished.
/// Timed jobs run one at a time on a machine: a job waits up to wait_s = 300 seconds for the one before it. If it then
/// starts anyway, or if other programs use the CPU while it runs, its rows have is_shared = true and are not ranked.
///
/// DIR/results.csv has the rows of all jobs, DIR/datapackage.json its columns; DIR/index.html shows them for every
/// machine and adapter.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  printf 'what = \"render\"\\nscenes = [\"scenes/teapot.glb\"]\\n' > sweep.toml
  printf '[options]\\nsize = \"64x64\"\\n' >> sweep.toml
  printf '[each]\\nnumerics = [\"robust\", \"paper\"]\\n' >> sweep.toml
  raystep sweep sweep.toml -o sweep
  raystep sweep sweep.toml -o sweep --jobs 2   # continues after an interruption")]
pub(crate) struct SweepArgs {
    /// File that describes the sweep
    #[arg(required_unless_present = "run_job", value_name = "SWEEP.toml")]
    file: Option<PathBuf>,
    /// Output folder: new, empty, or of the same sweep
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Number of jobs to run in parallel; must be 1 for jobs that measure times
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u32>(1, 1024), allow_negative_numbers = true)]
    jobs: u32,
    /// Where jobs run
    #[arg(long, value_enum, default_value_t = On::Local)]
    on: On,
    /// Let the process at the other end of standard input and output run the jobs
    #[arg(long, hide = true)]
    serve: bool,
    /// Run the job that this file describes; ends with its standard input
    #[arg(long, hide = true, value_name = "JOB.json", conflicts_with_all = ["file", "serve"])]
    run_job: Option<PathBuf>,
    #[command(flatten)]
    quiet: QuietArgs,
}

/// `--on`
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum On {
    /// This machine
    Local,
    /// A Ray cluster; needs the Python package
    Ray,
}

pub(crate) fn run(args: &SweepArgs) -> Result<(), Error> {
    if args.on == On::Ray {
        return Err(Error::usage(
            "--on ray is only in the Python package's 'raystep': install the raystep wheel and Ray ('pip install ray'), and use that command",
        ));
    }
    if let Some(file) = &args.run_job {
        return job::run_file(file, &args.output);
    }
    let Some(file) = &args.file else { return Err(Error::usage("SWEEP.toml is missing (see --help)")) };
    let progress = Progress::new(args.quiet.quiet);
    progress.stage("reading scenes");
    let sweep = Definition::read(file)?;
    let jobs = plan::jobs(&sweep)?;
    if args.jobs > 1 && jobs.iter().any(|job| job.is_timed) {
        return Err(Error::usage(format!(
            "--jobs {}: the jobs of this sweep measure times and must run one at a time; omit --jobs",
            args.jobs
        )));
    }
    let place = Place::open(&args.output, &sweep)?;
    progress.finish();
    let mut so_far = gather::SoFar::new(&jobs, &place);
    let mut failures = match args.serve {
        true => place.serve(&jobs, &mut |job| so_far.show(job), &progress)?,
        false => place.run(&jobs, args.jobs as usize, &mut |job| so_far.show(job), &progress),
    };
    progress.stage("gathering");
    let gathered = gather::gather(&sweep, &jobs, &place, &failures)?;
    progress.finish();
    failures.extend(gathered.failures);
    let is_complete = gathered.finished == jobs.len();
    let at = args.output.display();
    progress.say(format_args!(
        "wrote {} to {at}: {} of {} jobs",
        gather::NAMES.join(", "),
        gathered.finished,
        jobs.len()
    ));
    end(&failures, is_complete)
}

/// The error for jobs that failed, after a line for each.
fn end(failures: &[Failure], is_complete: bool) -> Result<(), Error> {
    let Some(Failure { name, message }) = failures.first() else {
        return if is_complete {
            Ok(())
        } else {
            Err(Error::failed("not all jobs have run; the same command continues"))
        };
    };
    if let [_] = failures {
        return Err(Error::failed(format!("job {name}: {message}")));
    }
    for Failure { name, message } in failures {
        say(format_args!("fail: {name}: {message}"));
    }
    let again = if is_complete { "" } else { "; the same command runs those without results again" };
    Err(Error::failed(format!("{} jobs failed{again}", failures.len())))
}
