//! `--lesson`, and `--check`

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use raystep_inspector::lesson::built_in::{self, PREFIX};
use raystep_inspector::lesson::{Lesson, LessonError, MOST_BYTES, Wrong};
use raystep_inspector::link::{Link, LinkDevice};
use raystep_kernels::Gpu;
use raystep_lab::text::{counted, visible};
use raystep_scenes::FileError;

use super::{InspectArgs, WindowArgs};
use crate::args::{DeviceArgs, DeviceKind, ReadArgs};
use crate::error::Error;
use crate::scene_file;
use crate::terminal::print;
use crate::usage::did_you_mean;
use crate::window::{self, Start};

/// The window with the lesson of a file.
pub(super) fn start(file: &Path, args: &InspectArgs) -> Result<(WindowArgs, Start), Error> {
    let InspectArgs { link, step, screenshot, window, scale, commands, run, .. } = args;
    let lesson = read(file, link.read, &run.device)?;
    let steps = lesson.steps.len();
    let step = step.unwrap_or(1);
    if step > steps {
        return Err(Error::usage(format!("--step {step}: the lesson has {}", counted(steps, "step"))));
    }
    let start = Start { lesson: Some((lesson, step - 1)), read: link.read, size: window.0, ..Start::default() };
    let device = DeviceArgs { device: run.device.device, adapter: run.device.adapter.clone() };
    let window = WindowArgs { screenshot: screenshot.clone(), scale: *scale, commands: commands.clone(), device };
    Ok((window, start))
}

/// The text of a lesson: of a file, or of one in the program if there is no file of that name.
fn text(file: &Path, name: &str) -> Result<String, Error> {
    if let Some((_, text)) = built_in::lesson(name).filter(|_| !file.exists()).and_then(|i| built_in::LESSONS.get(i)) {
        return Ok((*text).to_owned());
    }
    if !file.exists() && file.extension().is_none() {
        let names: Vec<&str> = built_in::lessons().collect();
        let near = did_you_mean(name, &names);
        let names = names.join(", ");
        return Err(Error::failed(format!("{name}: no such file, and no lesson of that name; {near}lessons: {names}")));
    }
    let wrong = |wrong| Error::failed(LessonError { file: name.to_owned(), line: 1, wrong });
    let bytes = scene_file::read_file(file, MOST_BYTES as u64).map_err(|error| match error {
        FileError::TooLarge { bytes } => wrong(Wrong::TooLong(usize::try_from(bytes).unwrap_or(usize::MAX))),
        other => Error::failed(format!("{name}: {other}")),
    })?;
    String::from_utf8(bytes).map_err(|_| wrong(Wrong::NotUtf8))
}

/// Reads a lesson, and finds its scenes.
fn read(file: &Path, read: ReadArgs, device: &DeviceArgs) -> Result<Lesson, Error> {
    let name = file.display().to_string();
    let wrong = |line, wrong| Error::failed(LessonError { file: name.clone(), line, wrong });
    let text = text(file, &name)?;
    let mut lesson = Lesson::parse(&name, &text).map_err(Error::failed)?;
    for (line, link) in lesson.links_mut() {
        find_scene(file, link, read).map_err(|why| wrong(line, Wrong::Argument("open", why)))?;
        if link.device == LinkDevice::Auto && link.adapter.is_none() {
            link.device = match device.device {
                DeviceKind::Auto | DeviceKind::GpuFirst => LinkDevice::Auto,
                DeviceKind::Gpu => LinkDevice::Gpu,
                DeviceKind::Cpu => LinkDevice::Cpu,
            };
            link.adapter.clone_from(&device.adapter);
        }
    }
    Ok(lesson)
}

/// Makes a scene's path one that does not depend on the lesson's.
fn find_scene(file: &Path, link: &mut Link, read: ReadArgs) -> Result<(), String> {
    let Some(scene) = link.scene.as_mut().filter(|scene| !scene.starts_with(PREFIX)) else { return Ok(()) };
    let path = scene_file::beside(file, scene, read)?;
    scene_file::expect_scene(&path).map_err(|error| error.message().to_owned())?;
    *scene = path.to_str().ok_or("its path is not UTF-8")?.to_owned();
    Ok(())
}

/// A reader should not wait longer than this for a step.
const LONG: Duration = Duration::from_secs(3);

/// Checks the lesson, and prints a line for each step: what was checked, and how long it takes to set up.
pub(super) fn check(gpu: &Arc<Gpu>, start: Start) -> Result<(), Error> {
    let mut problems: Vec<LessonError> = Vec::new();
    window::check_lesson(gpu, start, |step, waited| {
        let result = match step.problems.len() {
            0 => format!("{} checked", counted(step.checked, "thing")),
            wrong => format!("{wrong} wrong"),
        };
        let long = if waited > LONG { ", too long for a reader: measure less, or in a smaller scene" } else { "" };
        let (title, seconds) = (visible(&step.title), waited.as_secs_f64());
        print(&format!("step {}, {title}: {result}, ready after {seconds:.1} s{long}\n", step.step + 1))?;
        problems.extend(step.problems.iter().cloned());
        Ok(())
    })?;
    match problems.split_first() {
        None => Ok(()),
        Some((only, [])) => Err(Error::failed(only)),
        Some((first, others)) => {
            let others: Vec<String> = others.iter().map(ToString::to_string).collect();
            Err(Error::failed(format!("{first}; {}", others.join("; "))))
        }
    }
}
