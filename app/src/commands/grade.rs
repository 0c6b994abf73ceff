//! `raystep grade`

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use raystep_kernels::Device;
use raystep_lab::course::exercises::EXERCISES;
use raystep_lab::course::{Exercise, Found, SCHEDULE, Task, Verdict, View, check_view};
use raystep_lab::text::{aligned, counted};
use raystep_lab::{Machine, block_on};
use serde::Serialize;

use super::check_kernel::{INTERPRETED, differs, machines, miscounts, ran};
use crate::args::kernel::KernelFile;
use crate::args::{DeviceArgs, QuietArgs};
use crate::error::Error;
use crate::terminal::{Progress, print};

/// Check the exercises of a course in a folder
///
/// Every kernel is compared with the one that it replaces, in several views: interpreted, and then on a GPU, if there is one.
/// Prints what became of each exercise, and the first ray that your kernel treats otherwise, with a hint. Exit code 0: all
/// exercises passed; 1: not all.
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  raystep course my-course
  raystep grade my-course
  raystep grade my-course --json --device cpu")]
pub(crate) struct GradeArgs {
    /// The folder that 'raystep course' has written, with what you have completed
    folder: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    quiet: QuietArgs,
    #[command(flatten)]
    device: DeviceArgs,
}

/// All of a folder.
#[derive(Serialize)]
struct Report {
    folder: String,
    /// Exercises that are passed.
    passed: usize,
    /// Exercises that are checked.
    of: usize,
    exercises: Vec<Row>,
}

/// What became of an exercise.
#[derive(Serialize)]
struct Row {
    number: u8,
    title: &'static str,
    kernel: &'static str,
    file: String,
    #[serde(flatten)]
    verdict: Verdict,
    /// What it was checked with when something was wrong.
    #[serde(skip_serializing_if = "Option::is_none")]
    view: Option<Seen>,
    #[serde(skip_serializing_if = "Option::is_none")]
    hint: Option<&'static str>,
    /// The mistake's line, for a reader.
    #[serde(skip)]
    excerpt: Option<String>,
}

/// A view in which something is wrong.
#[derive(Serialize)]
struct Seen {
    /// "interpreted", or the adapter that the kernel ran on.
    device: String,
    /// Arguments of a command that shows the same.
    arguments: String,
    /// What is particular about it.
    why: &'static str,
}

pub(crate) fn run(args: &GradeArgs) -> Result<(), Error> {
    let at = args.folder.display();
    if !args.folder.is_dir() {
        return Err(Error::failed(format!("{at}: no such folder; 'raystep course {at}' makes one with the exercises")));
    }
    let progress = Progress::new(args.quiet.quiet);
    let machines = machines(&args.device)?;
    let rows = EXERCISES.iter().map(|exercise| row(args, exercise, &exercise.task, &machines, &progress));
    let exercises = rows.collect::<Result<Vec<_>, _>>()?;
    progress.finish();
    let passed = exercises.iter().filter(|row| matches!(row.verdict, Verdict::Passed { .. })).count();
    let report = Report { folder: at.to_string(), passed, of: exercises.len(), exercises };
    print(&if args.json { super::json_text(&report)? } else { told(&report) })?;
    if passed == report.of {
        return Ok(());
    }
    Err(Error::failed(format!("{passed} of {} passed", counted(report.of as u64, "exercise"))))
}

fn row(
    args: &GradeArgs,
    exercise: &'static Exercise,
    task: &'static Task,
    machines: &[Option<Machine>],
    progress: &Progress,
) -> Result<Row, Error> {
    let path = args.folder.join(exercise.file());
    let (verdict, view, excerpt) = verdict(&path, exercise, task, machines, progress)?;
    Ok(Row {
        number: exercise.number,
        title: exercise.title,
        kernel: task.kernel,
        file: path.display().to_string(),
        hint: task.hint(&verdict),
        verdict,
        view,
        excerpt,
    })
}

type Judged = (Verdict, Option<Seen>, Option<String>);

fn verdict(
    path: &Path,
    exercise: &'static Exercise,
    task: &'static Task,
    machines: &[Option<Machine>],
    progress: &Progress,
) -> Result<Judged, Error> {
    let bytes = match KernelFile::new(None, path.to_owned()).bytes() {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok((Verdict::Missing, None, None)),
        Err(error) => return Err(Error::at(path, crate::error::reason(&error))),
    };
    let by = match task.read(path.display().to_string(), bytes) {
        Ok(by) => Arc::new(by),
        Err(verdict) => return Ok((verdict, None, None)),
    };
    let mut rays = 0;
    for machine in machines {
        let name = machine.as_ref().map_or_else(|| INTERPRETED.to_owned(), Machine::name);
        rays = 0;
        for (i, view) in task.views.iter().enumerate() {
            let (number, views) = (exercise.number, task.views.len());
            progress.stage(&format!("exercise {number}, {}, view {} of {views}", ran(&name), i + 1));
            let device = machine.as_ref().map_or(Device::Cpu(None), |machine| machine.device.clone());
            let found = match machine {
                Some(machine) => machine.wait(check_view(task, view, &by, &device)),
                None => block_on(None, check_view(task, view, &by, &device)),
            };
            match found.map_err(Error::failed)? {
                Found::Right(of_view) => rays += of_view,
                Found::Wrong(verdict) => {
                    let excerpt = match &verdict {
                        Verdict::Mistake { line, .. } => by.source.lines().nth(line.wrapping_sub(1)).map(str::to_owned),
                        _ => None,
                    };
                    return Ok((verdict, Some(seen(task, view, name)), excerpt));
                }
            }
        }
    }
    Ok((Verdict::Passed { views: task.views.len(), rays }, None, None))
}

fn seen(task: &Task, view: &View, device: String) -> Seen {
    Seen { device, arguments: task.arguments(view), why: view.why }
}

/// A table, and what is wrong below it.
fn told(report: &Report) -> String {
    let row = |row: &Row| {
        let more = match &row.verdict {
            Verdict::Passed { views, rays } => format!("{rays} rays in {}", counted(*views as u64, "view")),
            Verdict::Missing => format!("there is no file {}", row.file),
            Verdict::Untouched => format!("{} is as it was", row.file),
            _ => String::new(),
        };
        [format!("{} {}", row.number, row.title), row.verdict.name().to_owned(), more]
    };
    let rows: Vec<_> = report.exercises.iter().map(row).collect();
    let mut text = String::new();
    aligned(&rows, 3).iter().for_each(|line| text += &format!("{}\n", line.trim_end()));
    report.exercises.iter().filter_map(wrong).for_each(|wrong| text += &format!("\n{wrong}"));
    text
}

/// What is wrong with a kernel that was checked, in lines.
fn wrong(row: &Row) -> Option<String> {
    let Row { file, kernel, verdict, view, hint, excerpt, .. } = row;
    let device = ran(view.as_ref().map_or(INTERPRETED, |view| &view.device));
    let mut pixel_of = None;
    let mut text = match verdict {
        Verdict::Passed { .. } | Verdict::Untouched | Verdict::Missing => return None,
        Verdict::Differs(difference) => {
            pixel_of = Some(difference.pixel);
            differs(file, kernel, &device, difference)
        }
        Verdict::Leaks { pixel: [x, y], rays } => {
            pixel_of = Some([*x, *y]);
            let rays = counted(*rays as u64, "ray");
            format!(
                "{file} leaks, {device}: {rays} passed between triangles and hit nothing, the first of them that of pixel \
                 {x},{y}\n"
            )
        }
        Verdict::Slow { passes, enough } => {
            format!("{file} is slow, {device}: it takes {passes} passes, and {enough} are enough\n")
        }
        Verdict::Miscounts { pass, states } => miscounts(file, kernel, &device, *pass, states),
        Verdict::Fails { message } => format!("{file} fails, {device}: {message}\n"),
        Verdict::Mistake { message, line: 0, .. } => format!("{file}: {message}\n"),
        Verdict::Mistake { message, line, column } => {
            let line_text = excerpt.as_deref().map(|line| format!("    {}\n", line.trim())).unwrap_or_default();
            format!("{file}:{line}:{column}: {message}\n{line_text}")
        }
    };
    if let Some(hint) = hint {
        text += &format!("  hint: {hint}\n");
    }
    if let Some(Seen { arguments, why, .. }) = view.as_ref().filter(|_| !matches!(verdict, Verdict::Mistake { .. })) {
        text += &format!("  view: {why}\n");
        if *kernel == SCHEDULE {
            text += &format!("  the passes of the first schedule: raystep inspect {arguments} --schedule first\n");
            return Some(text);
        }
        text += &format!("  your picture: raystep render {arguments} --kernel {file} -o mine.png\n");
        if let Some([x, y]) = pixel_of {
            text += &format!("  the ray as it should be: raystep trace {arguments} --pixel {x},{y}\n");
        }
    }
    Some(text)
}
