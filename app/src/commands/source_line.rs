//! A line of a kernel's file, as `--at` and breakpoints name it.

use std::str::FromStr;

use raystep_kernels::Kernel;
use raystep_kernels::plan::Plan;
use raystep_kernels::shader::{FileLine, Sourced};
use raystep_lab::passed::{Code, Failure};
use raystep_lab::stops::{Outcome, StopsError, statement};

use crate::error::Error;
use crate::usage::{did_you_mean, or};

/// `NAME:LINE`
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SourceLine {
    /// A kernel or a file.
    pub(super) name: String,
    /// From 1.
    line: usize,
}

impl FromStr for SourceLine {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let wrong = "expected a kernel or its file, and a line, such as intersect.wgsl:34";
        let (name, line) = text.rsplit_once(':').ok_or(wrong)?;
        let line = line.parse().ok().filter(|&line| line > 0).ok_or(wrong)?;
        if name.is_empty() { Err(wrong) } else { Ok(Self { name: name.to_owned(), line }) }
    }
}

/// The kernel of a plan with this name.
pub(crate) fn kernel_of(plan: &Plan, name: &str) -> Result<Kernel, Error> {
    let kernels: Vec<Kernel> = plan.variants.iter().map(|variant| variant.kernel).collect();
    kernels.iter().copied().find(|kernel| kernel.name() == name).ok_or_else(|| {
        let names: Vec<&str> = kernels.iter().map(|kernel| kernel.name()).collect();
        let hint = did_you_mean(name, &names);
        Error::usage(format!("{name}: the run has no such kernel; {hint}its kernels are {}", names.join(", ")))
    })
}

/// A kernel's text with the places of its lines.
pub(crate) fn sourced(plan: &Plan, kernel: Kernel) -> Result<Sourced, Error> {
    let none = || Error::failed(format!("{} is not part of the run", kernel.name()));
    plan.sourced(kernel).map_err(Error::failed)?.ok_or_else(none)
}

/// A kernel for the interpreter.
pub(crate) fn code(plan: &Plan, of: &Sourced, variant: &raystep_kernels::shader::Variant) -> Result<Code, Error> {
    use raystep_kernels::interpret::InterpretError;
    Code::new(variant, plan.turns).map_err(|why| match why {
        InterpretError::Unsupported { what, line } if line > 0 => {
            Error::failed(format!("{}: {what} is not supported by the interpreter", of.named_line(line)))
        }
        why => Error::failed(format!("{}: {why}", of.variant.kernel.name())),
    })
}

impl SourceLine {
    /// The kernel that it is in, and the statement that begins there; `kernel` chooses if there are several.
    pub(crate) fn find(&self, plan: &Plan, kernel: Option<&str>) -> Result<(Sourced, FileLine, usize), Error> {
        let wanted = kernel.map(|name| kernel_of(plan, name)).transpose()?;
        let mut found = Vec::new();
        let mut names: Vec<String> = Vec::new();
        for variant in &plan.variants {
            let kernel = variant.kernel;
            if wanted.is_some_and(|wanted| wanted != kernel) {
                continue;
            }
            let of = sourced(plan, kernel)?;
            let is_kernel = kernel.name() == self.name;
            let file = match is_kernel {
                true => Some(0),
                false => of.files.iter().position(|file| file.is_called(&self.name)),
            };
            names.extend(of.files.iter().map(|file| file.name.clone()));
            if let Some(file) = file {
                found.push((of, FileLine { file, line: self.line }, is_kernel));
            }
        }
        // The kernel itself comes before what others import under its name, and a file with the line before others.
        if found.iter().any(|(.., is_kernel)| *is_kernel) {
            found.retain(|(.., is_kernel)| *is_kernel);
        }
        if found.iter().any(|(of, at, _)| of.statement(*at).is_some()) {
            found.retain(|(of, at, _)| of.statement(*at).is_some());
        }
        match found.as_slice() {
            [] => {
                names.sort_unstable();
                names.dedup();
                let hint = did_you_mean(&self.name, &names);
                Err(Error::usage(format!(
                    "--at {}: no kernel of the run has this file; {hint}files: {}",
                    self.name,
                    names.join(", ")
                )))
            }
            [_] => {
                let (of, at, _) = found.remove(0);
                let statement = statement(&of, at).map_err(|error| Error::usage(format!("--at {error}")))?;
                Ok((of, at, statement))
            }
            several => {
                let kernels: Vec<_> = several.iter().map(|(of, ..)| of.variant.kernel.name()).collect();
                Err(Error::usage(format!(
                    "--at {}: several kernels have this file: choose {} with --for",
                    self.name,
                    or(&kernels)
                )))
            }
        }
    }
}

/// What is wrong with an element, with its place.
pub(crate) fn failed(of: &Sourced, pass: usize, failure: &Failure) -> Error {
    let Failure { why, texel: [x, y], lines } = failure;
    let place = lines.first().map_or_else(|| of.variant.kernel.name().to_owned(), |&line| of.named_line(line));
    Error::failed(format!("pass {pass}, {place}: {why}, for the element at {x},{y}"))
}

/// An error of the interpreter or the device.
pub(crate) fn of_stops(of: &Sourced, error: StopsError) -> Error {
    match error {
        StopsError::Render(error) => Error::from(error),
        StopsError::Failed { pass, failure } => failed(of, pass, &failure),
    }
}

/// Why a pass is not the kernel's.
pub(crate) fn no_pass(of: &Sourced, pass: Option<usize>, outcome: &Outcome) -> Error {
    let (kernel, pass) = (of.variant.kernel.name(), pass.unwrap_or_default());
    match outcome {
        Outcome::Other(other) => Error::usage(format!("--pass {pass}: this is a pass of {other}, not of {kernel}")),
        Outcome::Ended(count) => {
            Error::usage(format!("--pass {pass}: the run has {count} passes, 0 to {}", count.saturating_sub(1)))
        }
        _ => Error::failed(format!("{kernel} has no pass {pass}")),
    }
}
