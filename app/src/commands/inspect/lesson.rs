//! `--lesson`, and `--check`

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use raystep_inspector::lesson::built_in::PREFIX;
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

/// Reads a lesson, and finds its scenes.
fn read(file: &Path, read: ReadArgs, device: &DeviceArgs) -> Result<Lesson, Error> {
    let name = file.display().to_string();
    let wrong = |line, wrong| Error::failed(LessonError { file: name.clone(), line, wrong });
    let bytes = scene_file::read_file(file, MOST_BYTES as u64).map_err(|error| match error {
        FileError::TooLarge { bytes } => wrong(1, Wrong::TooLong(usize::try_from(bytes).unwrap_or(usize::MAX))),
        other => Error::failed(format!("{name}: {other}")),
    })?;
    let text = String::from_utf8(bytes).map_err(|_| wrong(1, Wrong::NotUtf8))?;
    let mut lesson = Lesson::parse(&name, &text).map_err(Error::failed)?;
    for (line, link) in lesson.links_mut() {
        find_scene(file, link, read).map_err(|why| wrong(line, Wrong::Argument("open", why)))?;
        if link.device == LinkDevice::Auto && link.adapter.is_none() {
            link.device = match device.device {
                DeviceKind::Auto => LinkDevice::Auto,
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
