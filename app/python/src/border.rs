//! The border between Python and Rust: other threads run while Rust works, a panic becomes an exception, and Ctrl-C ends
//! a run between two passes.

use std::any::Any;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{ThreadId, current, panicking};
use std::time::{Duration, Instant};

use parking_lot::Mutex;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use raystep_kernels::{Progress, RenderError, Renderer};

use crate::error::{DeviceError, of_request};

/// Whether this process has worked, and so may have threads.
static HAS_WORKED: AtomicBool = AtomicBool::new(false);

/// Whether it was forked from one that had: it lacks those threads, and would wait for them forever.
static IS_FORKED: AtomicBool = AtomicBool::new(false);

/// Called in a process that was forked.
#[pyfunction]
pub(crate) fn after_fork() {
    IS_FORKED.store(HAS_WORKED.load(Ordering::Relaxed), Ordering::Relaxed);
}

/// Whether this process lacks threads that it had before it was forked.
pub(crate) fn is_forked() -> bool {
    IS_FORKED.load(Ordering::Relaxed)
}

/// Refuses to work in a process that lacks threads.
pub(crate) fn expect_unforked() -> PyResult<()> {
    if is_forked() {
        return Err(DeviceError::new_err(
            "this process was forked from one that had used raystep, whose threads it lacks: start it with 'spawn', as \
             multiprocessing.get_context('spawn') does",
        ));
    }
    HAS_WORKED.store(true, Ordering::Relaxed);
    Ok(())
}

/// Works without the interpreter's lock.
pub(crate) fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> PyResult<T> + Send) -> PyResult<T> {
    expect_unforked()?;
    let result = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
    result.unwrap_or_else(|panic| Err(PyRuntimeError::new_err(format!("a defect of raystep: {}", text_of(&*panic)))))
}

fn text_of(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    text.unwrap_or("no message").replace('\n', " ")
}

/// A value that threads use in turns.
pub(crate) struct Turns<T> {
    value: Mutex<T>,
    /// The thread whose turn it is.
    owner: Mutex<Option<ThreadId>>,
    /// Whether a turn has panicked.
    is_broken: AtomicBool,
}

/// Ends a turn, also if it panics.
struct Turn<'a> {
    owner: &'a Mutex<Option<ThreadId>>,
    is_broken: &'a AtomicBool,
}

impl<'a> Turn<'a> {
    fn begin(owner: &'a Mutex<Option<ThreadId>>, is_broken: &'a AtomicBool) -> Self {
        *owner.lock() = Some(current().id());
        Self { owner, is_broken }
    }
}

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        *self.owner.lock() = None;
        if panicking() {
            self.is_broken.store(true, Ordering::Relaxed);
        }
    }
}

impl<T: Send> Turns<T> {
    pub(crate) fn new(value: T) -> Self {
        Self { value: Mutex::new(value), owner: Mutex::new(None), is_broken: AtomicBool::new(false) }
    }

    /// Waits for its turn without the interpreter's lock, unless it is interrupted, and works.
    pub(crate) fn take<R: Send>(&self, py: Python<'_>, work: impl FnOnce(&mut T) -> PyResult<R> + Send) -> PyResult<R> {
        if *self.owner.lock() == Some(current().id()) {
            return Err(PyRuntimeError::new_err("a progress callback cannot use the renderer that calls it"));
        }
        detached(py, || {
            let mut value = loop {
                match self.value.try_lock_for(INTERVAL) {
                    Some(value) => break value,
                    None => Python::attach(|py| py.check_signals())?,
                }
            };
            if self.is_broken.load(Ordering::Relaxed) {
                return Err(DeviceError::new_err("the renderer has failed before: make a new one"));
            }
            let _turn = Turn::begin(&self.owner, &self.is_broken);
            work(&mut value)
        })
    }
}

/// How often Python is asked and told.
const INTERVAL: Duration = Duration::from_millis(50);

/// Tells a callback about progress, and stops a run at an exception, Ctrl-C included.
pub(crate) struct Watcher {
    callback: Option<Py<PyAny>>,
    last: Instant,
    raised: Option<PyErr>,
}

impl Watcher {
    /// The callback gets passes, rays decided, rays, samples, and samples at the end.
    pub(crate) fn new(callback: Option<Py<PyAny>>) -> Self {
        Self { callback, last: Instant::now(), raised: None }
    }

    pub(crate) fn tell(&mut self, progress: &Progress) -> ControlFlow<()> {
        if self.has_raised() {
            return ControlFlow::Break(());
        }
        let is_end = progress.samples == progress.samples_wanted;
        if self.last.elapsed() < INTERVAL && !is_end {
            return ControlFlow::Continue(());
        }
        let Progress { passes, rays_decided, rays, samples, samples_wanted, .. } = *progress;
        let asked = Python::attach(|py| {
            py.check_signals()?;
            let callback = self.callback.as_ref();
            callback
                .map_or(Ok(()), |call| call.call1(py, (passes, rays_decided, rays, samples, samples_wanted)).map(drop))
        });
        self.last = Instant::now();
        match asked {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.raised = Some(error);
                ControlFlow::Break(())
            }
        }
    }

    /// As [`tell`](Self::tell), for work that has no progress to tell.
    pub(crate) fn ask(&mut self) -> ControlFlow<()> {
        if self.has_raised() {
            return ControlFlow::Break(());
        }
        if self.last.elapsed() < INTERVAL {
            return ControlFlow::Continue(());
        }
        self.last = Instant::now();
        self.raised = Python::attach(|py| py.check_signals()).err();
        if self.has_raised() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Ends work with several runs, or several ends of one: a run that is stopped where it would have ended anyway goes on.
    pub(crate) fn expect_calm(&self, run: &Renderer) -> Result<(), RenderError> {
        if self.has_raised() { Err(RenderError::Cancelled { passes: run.pass_count() }) } else { Ok(()) }
    }

    fn has_raised(&self) -> bool {
        self.raised.is_some()
    }

    /// What a run came to.
    pub(crate) fn finish<T>(self, result: Result<T, RenderError>) -> PyResult<T> {
        match self.raised {
            Some(error) => Err(error),
            None => result.map_err(|error| of_request(&error)),
        }
    }
}
