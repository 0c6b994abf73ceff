//! Runs futures on the worker's thread, a slice at a time, so that frames and events come in between.

use std::cell::{Cell, RefCell};
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Wake, Waker};

use raystep_kernels::Gpu;

use crate::shell;

/// Length of a slice, milliseconds: with it, a display's frame of 16 ms has time left for drawing.
const SLICE_MS: f64 = 8.0;

struct Task {
    woken: Arc<Woken>,
    future: Pin<Box<dyn Future<Output = ()>>>,
}

struct Woken(AtomicBool);

impl Wake for Woken {
    fn wake(self: Arc<Self>) {
        self.wake_by_ref();
    }

    fn wake_by_ref(self: &Arc<Self>) {
        self.0.store(true, Ordering::Relaxed);
        schedule();
    }
}

thread_local! {
    /// The device to poll.
    static POLLED: RefCell<Option<Arc<Gpu>>> = const { RefCell::new(None) };
    static TASKS: RefCell<Vec<Task>> = const { RefCell::new(Vec::new()) };
    /// A slice is coming, or has begun.
    static IS_SCHEDULED: Cell<bool> = const { Cell::new(false) };
}

fn schedule() {
    if !IS_SCHEDULED.replace(true) {
        shell::later();
    }
}

/// Runs a future to its end. It makes progress in [`work`].
pub(crate) fn spawn(future: impl Future<Output = ()> + 'static) {
    let task = Task { woken: Arc::new(Woken(true.into())), future: Box::pin(future) };
    TASKS.with_borrow_mut(|tasks| tasks.push(task));
    schedule();
}

/// Polls a device of WebGL from now on while a task waits for it, once a slice: it tells of what it has done only when
/// asked, and nothing new before the next event.
pub(crate) fn poll(gpu: &Arc<Gpu>) {
    if !gpu.computes {
        POLLED.set(Some(gpu.clone()));
    }
}

/// The device to poll, if a task waits for it.
fn awaited() -> Option<Arc<Gpu>> {
    POLLED.with_borrow(|polled| polled.clone().filter(|gpu| gpu.is_awaited()))
}

/// A slice of work.
pub(crate) fn work() {
    let begin = shell::now();
    if let Some(gpu) = awaited() {
        // What fails is told by the device.
        drop(gpu.device.poll(wgpu::PollType::Poll));
    }
    loop {
        // While it is polled, a task may spawn others.
        let mut tasks = TASKS.take();
        let mut has_worked = false;
        tasks.retain_mut(|task| {
            if !task.woken.0.swap(false, Ordering::Relaxed) {
                return true;
            }
            has_worked = true;
            let waker = Waker::from(task.woken.clone());
            task.future.as_mut().poll(&mut Context::from_waker(&waker)).is_pending()
        });
        TASKS.with_borrow_mut(|spawned| {
            tasks.append(spawned);
            *spawned = tasks;
        });
        if !has_worked && awaited().is_none() {
            IS_SCHEDULED.set(false);
            return;
        }
        if !has_worked || shell::now() - begin > SLICE_MS {
            shell::later();
            return;
        }
    }
}
