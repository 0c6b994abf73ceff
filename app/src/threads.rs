//! The threads that may call a device, and the devices themselves: they end before the process does.
//!
//! Drivers tear themselves down in exit handlers of the process. A thread that calls a driver meanwhile crashes, and a
//! thread that drops a device last unloads the driver under those handlers. So both have one owner: threads are told to
//! end and joined, then devices are dropped, on the thread that ends the program. A driver that does not return must not
//! keep the program from ending: after [`PATIENCE`], it ends without exit handlers.
//!
//! A signal needs none of this, since [`interrupt`] never runs exit handlers.

use std::mem;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use raystep_inspector::session::engine::EngineTask;
use raystep_kernels::Gpu;
use raystep_lab::block_on_shared;

use crate::interrupt;
use crate::terminal::say;

/// How long to wait for threads that were told to end.
const PATIENCE: Duration = Duration::from_secs(2);

/// All of this process.
static THREADS: Threads = Threads::new();

/// Keeps a device open until the program ends.
pub(crate) fn keep(gpu: &Arc<Gpu>) {
    let mut owned = THREADS.owned();
    if !owned.devices.iter().any(|kept| Arc::ptr_eq(kept, gpu)) {
        owned.devices.push(gpu.clone());
    }
}

/// Runs a task in a thread of its own, which polls this device.
pub(crate) fn spawn(gpu: Arc<Gpu>, task: EngineTask) {
    THREADS.spawn(move |is_over| {
        block_on_shared(&gpu, is_over, task);
    });
}

/// Tells all threads to end, waits for them, and drops the devices. `false` if a thread or a device goes on.
#[must_use]
pub(crate) fn end() -> bool {
    THREADS.end(PATIENCE)
}

/// Ends the threads when the program returns, also if it panics.
pub(crate) struct Ending {
    /// The exit code, should the process have to end here.
    pub(crate) code: u8,
}

impl Drop for Ending {
    fn drop(&mut self) {
        if !end() {
            let seconds = PATIENCE.as_secs();
            say(format_args!("note: work that was told to end has not ended after {seconds} s: exiting without it"));
            interrupt::leave(self.code.into());
        }
    }
}

struct Threads {
    /// Whether they were told to end.
    is_over: AtomicBool,
    owned: Mutex<Owned>,
}

struct Owned {
    threads: Vec<JoinHandle<()>>,
    devices: Vec<Arc<Gpu>>,
}

impl Owned {
    const NOTHING: Self = Self { threads: Vec::new(), devices: Vec::new() };
}

impl Threads {
    const fn new() -> Self {
        Self { is_over: AtomicBool::new(false), owned: Mutex::new(Owned::NOTHING) }
    }

    fn owned(&self) -> MutexGuard<'_, Owned> {
        self.owned.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// `work` ends soon after the flag that it gets was set. Once threads were told to end, none begins.
    fn spawn(&'static self, work: impl FnOnce(&AtomicBool) + Send + 'static) {
        let mut owned = self.owned();
        if self.is_over.load(Ordering::Acquire) {
            return;
        }
        owned.threads.retain(|thread| !thread.is_finished());
        match thread::Builder::new().name("raystep engine".into()).spawn(move || work(&self.is_over)) {
            Ok(thread) => owned.threads.push(thread),
            Err(error) => say(format_args!("error: cannot start a thread: {error}")),
        }
    }

    fn end(&self, patience: Duration) -> bool {
        let Owned { threads, devices } = {
            let mut owned = self.owned();
            self.is_over.store(true, Ordering::Release);
            mem::replace(&mut *owned, Owned::NOTHING)
        };
        let until = Instant::now() + patience;
        let left = || until.saturating_duration_since(Instant::now());
        threads.iter().for_each(|thread| thread.thread().unpark());
        let mut have_ended = true;
        for thread in threads {
            while !thread.is_finished() && !left().is_zero() {
                thread::sleep(Duration::from_millis(1));
            }
            if thread.is_finished() {
                // If it panicked, it has said so itself.
                let _ = thread.join();
            } else {
                have_ended = false;
            }
        }
        for gpu in &devices {
            have_ended &= gpu.end_polling(left());
            // A device that is dropped waits for its work, perhaps forever.
            let done = wgpu::PollType::Wait { submission_index: None, timeout: Some(left()) };
            have_ended &= have_ended && !matches!(gpu.device.poll(done), Err(wgpu::PollError::Timeout));
        }
        if !have_ended {
            mem::forget(devices);
        }
        have_ended
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn threads() -> &'static Threads {
        Box::leak(Box::new(Threads::new()))
    }

    /// Marks its end.
    fn work_until_told(ended: &Arc<AtomicBool>) -> impl FnOnce(&AtomicBool) + Send + use<> {
        let ended = ended.clone();
        move |is_over| {
            while !is_over.load(Ordering::Acquire) {
                thread::park_timeout(Duration::from_millis(20));
            }
            // Longer than a thread takes to be told.
            thread::sleep(Duration::from_millis(50));
            ended.store(true, Ordering::Release);
        }
    }

    #[test]
    fn every_thread_has_ended_when_the_program_does() {
        let threads = threads();
        let ended = [(); 3].map(|()| Arc::<AtomicBool>::default());
        ended.iter().for_each(|ended| threads.spawn(work_until_told(ended)));
        assert!(threads.end(PATIENCE));
        assert!(ended.iter().all(|ended| ended.load(Ordering::Acquire)));
        let late = Arc::<AtomicBool>::default();
        threads.spawn(work_until_told(&late));
        assert!(threads.end(PATIENCE));
        assert_eq!(Arc::strong_count(&late), 1, "none begins after the end");
    }

    #[test]
    fn a_thread_that_does_not_end_is_left_after_a_while() {
        let threads = threads();
        let release = Arc::<AtomicBool>::default();
        let held = release.clone();
        threads.spawn(move |_| {
            while !held.load(Ordering::Acquire) {
                thread::sleep(Duration::from_millis(1));
            }
        });
        let begin = Instant::now();
        assert!(!threads.end(Duration::from_millis(100)));
        // Far more than the 100 ms, for a busy machine, and far less than forever.
        assert!(begin.elapsed() < Duration::from_secs(20));
        release.store(true, Ordering::Release);
    }

    #[test]
    fn a_thread_that_panics_does_not_keep_the_program() {
        let threads = threads();
        threads.spawn(|_| panic!("on purpose"));
        assert!(threads.end(PATIENCE));
    }
}
