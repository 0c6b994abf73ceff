//! What is debugged: a kernel, a pass, and an element of it.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::Parser;
use raystep_kernels::Kernel;
use raystep_kernels::interpret::{Followed, View};
use raystep_kernels::shader::{Sourced, Stop, StopError};
use raystep_lab::passed::{Begun, Code, Failure, step};
use raystep_lab::stops::begun;
use serde_json::Value;

use super::reply::{Refused, text, whole};
use crate::args::choices::{ChoiceArgs, What};
use crate::args::{RunArgs, SceneArgs, ViewArgs};
use crate::commands::source_line::{code, kernel_of, no_pass, sourced};
use crate::error::Error;
use crate::session::{Running, Session};
use crate::terminal::Progress;

/// What a launch request names, as a command line.
#[derive(Parser, Debug)]
#[command(name = "args", disable_help_flag = true, disable_version_flag = true)]
struct Words {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    program: ChoiceArgs<What>,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    run: RunArgs,
}

/// A pass of a run, and one of its elements.
pub(super) struct Target {
    running: Running,
    /// The kernel's text.
    pub(super) of: Sourced,
    /// The kernel without conditions, each statement a step.
    plain: Code,
    pub(super) begun: Begun,
    /// Column and row of the element.
    pub(super) texel: [u32; 2],
    /// The files by their full names; none for ours.
    pub(super) paths: Vec<Option<PathBuf>>,
}

impl Target {
    /// Runs to the pass that a launch request names.
    pub(super) fn launch(arguments: &Value) -> Result<Self, Refused> {
        let program = text(arguments, "program").ok_or("launch needs \"program\": a program's folder, or a scene")?;
        let mut words: Vec<OsString> = vec!["args".into(), program.into()];
        match arguments.get("kernelFile") {
            Some(Value::String(file)) => words.extend(["--kernel".into(), file.into()]),
            Some(Value::Array(files)) => {
                let files = files.iter().filter_map(Value::as_str);
                files.for_each(|file| words.extend(["--kernel".into(), file.into()]));
            }
            _ => {}
        }
        if let Some(Value::Array(more)) = arguments.get("args") {
            words.extend(more.iter().filter_map(Value::as_str).map(OsString::from));
        }
        let parsed =
            Words::try_parse_from(&words).map_err(|error| Error::usage(crate::usage::message(&error, &words)))?;
        let Words { scene, program, view, run } = &parsed;
        let progress = Progress::new(true);
        let session = Session::stepped(scene, program, view, run, &progress)?;
        let wanted = text(arguments, "kernel").map(|name| kernel_of(&session.plan, name)).transpose()?;
        let mut running = session.start(&progress)?;
        let pass = whole(arguments, "pass");
        let kernel = match (wanted, pass) {
            (Some(kernel), _) => kernel,
            (None, pass) => next_kernel(&mut running, pass.unwrap_or(0))?,
        };
        let of = sourced(running.renderer.plan(), kernel)?;
        let traced = of.stopping(&[], true).map_err(|error| error.message)?;
        let plain = code(running.renderer.plan(), &of, &traced.variant)?;
        let element = arguments.get("element").cloned().unwrap_or(Value::Null);
        let begun = match pass {
            Some(pass) => {
                let found = running.chosen.wait(begun(&mut running.renderer, &plain, pass)).map_err(Error::from)?;
                found.map_err(|outcome| no_pass(&of, Some(pass), &outcome))?
            }
            None => first_pass(&mut running, &plain, &element)?,
        };
        let paths = of.files.iter().map(|file| file.is_own.then(|| full(Path::new(&file.name)))).collect();
        let texel = texel(&element, &begun)?;
        Ok(Self { running, of, plain, begun, texel, paths })
    }

    /// Chooses another element of the pass.
    pub(super) fn choose(&mut self, element: &Value) -> Result<(), Refused> {
        self.texel = texel(element, &self.begun)?;
        Ok(())
    }

    /// The element's steps, and those at which a condition holds.
    pub(super) fn follow(&self, stops: &[Stop]) -> Result<Followed, Refused> {
        let data = self.running.renderer.data();
        let traced;
        let code = match stops {
            [] => &self.plain,
            stops => {
                let stopping = self.of.stopping(stops, true).map_err(|error| error.message)?;
                traced = code(self.running.renderer.plan(), &self.of, &stopping.variant)?;
                &traced
            }
        };
        code.follow(&self.begun, data, self.texel).map_err(|failure| self.told(&failure))
    }

    /// What a condition has wrong; `None` if it can be used.
    pub(super) fn fault(&self, stop: &Stop) -> Option<StopError> {
        self.of.stopping(std::slice::from_ref(stop), true).err()
    }

    /// The variables at a step.
    pub(super) fn view(&self, step: usize) -> Result<View, Refused> {
        let data = self.running.renderer.data();
        self.plain.view(&self.begun, data, self.texel, step).map_err(|failure| self.told(&failure))
    }

    /// The variables at a step, with the value of an expression before its statement.
    pub(super) fn evaluate(&self, step: usize, statement: usize, expression: &str) -> Result<View, Refused> {
        let variant = self.of.evaluating(statement, expression);
        let variant = variant.map_err(|error| format!("column {}: {}", error.column, error.message))?;
        let code = code(self.running.renderer.plan(), &self.of, &variant)?;
        let data = self.running.renderer.data();
        code.view(&self.begun, data, self.texel, step).map_err(|failure| Refused(failure.why.to_string()))
    }

    fn told(&self, failure: &Failure) -> Refused {
        let [x, y] = failure.texel;
        let place = failure.lines.first().map_or_else(String::new, |&line| format!("{}: ", self.of.named_line(line)));
        Refused(format!("{place}{}, for the element at {x},{y}", failure.why))
    }

    /// The file that a client means.
    pub(super) fn file(&self, source: &Value) -> Option<usize> {
        if let Some(reference) = whole(source, "sourceReference").filter(|&reference| reference > 0) {
            return Some(reference - 1).filter(|&file| file < self.of.files.len());
        }
        let path = text(source, "path").or(text(source, "name"))?;
        let wanted = full(Path::new(path));
        let is_it = |own: &Option<PathBuf>| own.as_ref() == Some(&wanted);
        self.paths.iter().position(is_it).or_else(|| {
            let files = self.of.files.iter();
            files.zip(&self.paths).position(|(file, own)| own.is_none() && file.name == path)
        })
    }
}

/// A path that two names of a file have together.
fn full(path: &Path) -> PathBuf {
    std::fs::canonicalize(path).or_else(|_| std::path::absolute(path)).unwrap_or_else(|_| path.to_owned())
}

/// The kernel of a pass.
fn next_kernel(running: &mut Running, pass: usize) -> Result<Kernel, Refused> {
    let go_on = |_: &raystep_kernels::Progress| std::ops::ControlFlow::Continue(());
    running.chosen.wait(running.renderer.run_to(pass, go_on)).map_err(Error::from)?;
    let count = running.renderer.pass_count();
    running.renderer.next_kernel().ok_or_else(|| Refused(format!("pass {pass}: the run has {count} passes")))
}

/// The first pass of a kernel that works on an element.
fn first_pass(running: &mut Running, code: &Code, element: &Value) -> Result<Begun, Refused> {
    let mut first = None;
    while let Some(kernel) = running.renderer.next_kernel() {
        if kernel != code.kernel() {
            running.chosen.wait(running.renderer.step()).map_err(Error::from)?;
            continue;
        }
        let Some(begun) = running.chosen.wait(step(&mut running.renderer, code.streams())).map_err(Error::from)? else {
            break;
        };
        if code.works_on(&begun, texel(element, &begun)?) {
            return Ok(begun);
        }
        first = first.or(Some(begun));
    }
    first.ok_or_else(|| Refused(format!("the run has no pass of {}", code.kernel().name())))
}

/// Column and row of an element: `[x, y]`, or its place in its set.
fn texel(element: &Value, begun: &Begun) -> Result<[u32; 2], Refused> {
    let size = begun.size;
    let number = |value: &Value| value.as_u64().and_then(|number| u32::try_from(number).ok());
    let wrong = || Refused("\"element\" is [x, y], or the element's place in its set".into());
    let texel = match element {
        Value::Null => [0, 0],
        Value::Array(parts) => match parts.as_slice() {
            [x, y] => [number(x).ok_or_else(wrong)?, number(y).ok_or_else(wrong)?],
            _ => return Err(wrong()),
        },
        other => {
            let at = number(other).ok_or_else(wrong)?;
            [at % size.width.max(1), at / size.width.max(1)]
        }
    };
    let [x, y] = texel;
    if x >= size.width || y >= size.height {
        let message = format!("no element at {x},{y}: the pass has {} columns and {} rows", size.width, size.height);
        return Err(Refused(message));
    }
    Ok(texel)
}
