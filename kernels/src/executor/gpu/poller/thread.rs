//! A thread that polls while read-backs are pending.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Counts a device's pending read-backs and polling hosts, and owns the thread that polls if no host does.
#[derive(Default)]
pub(crate) struct Poller(Arc<Shared>);

/// State shared by the device's owner and the thread.
#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    on_their_way: usize,
    /// Number of hosts that poll.
    hosts: usize,
    is_over: bool,
    thread: Option<JoinHandle<()>>,
}

/// A pending read-back. Dropped when it has arrived or was cancelled.
pub(crate) struct Expected(Arc<Shared>);

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// Whether the thread has to poll.
    fn needs_thread(&self) -> bool {
        self.on_their_way > 0 && self.hosts == 0
    }
}

impl Poller {
    /// Registers a read-back: somebody polls until it has arrived.
    pub(crate) fn expect(&self, device: &wgpu::Device) -> Expected {
        let mut state = self.0.state();
        state.on_their_way += 1;
        self.wake(state, device);
        Expected(self.0.clone())
    }

    /// Whether a read-back is pending.
    pub(crate) fn is_expecting(&self) -> bool {
        self.0.state().on_their_way > 0
    }

    /// Registers a polling host.
    pub(crate) fn host_begins(&self) {
        self.0.state().hosts += 1;
    }

    /// Unregisters a polling host: the thread takes over pending read-backs.
    pub(crate) fn host_ends(&self, device: &wgpu::Device) {
        let mut state = self.0.state();
        state.hosts -= 1;
        self.wake(state, device);
    }

    /// Starts or wakes the thread if it has to poll.
    fn wake(&self, mut state: MutexGuard<'_, State>, device: &wgpu::Device) {
        if !state.needs_thread() || state.is_over {
            return;
        }
        if state.thread.is_none() {
            let (shared, device) = (self.0.clone(), device.clone());
            // If the system cannot start a thread, the host has to poll after all.
            let builder = std::thread::Builder::new().name("raystep poll".into());
            state.thread = builder.spawn(move || poll(&shared, &device)).ok();
        }
        self.0.changed.notify_one();
    }
}

fn poll(shared: &Shared, device: &wgpu::Device) {
    // Long enough to save CPU time, short enough to notice that the host polls, or that the device is gone.
    const WAIT: Duration = Duration::from_millis(20);
    loop {
        let mut state = shared.state();
        while !state.needs_thread() && !state.is_over {
            state = shared.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        if state.is_over {
            return;
        }
        drop(state);
        if device.poll(wgpu::PollType::Wait { submission_index: None, timeout: Some(WAIT) }).is_err() {
            // A long pass, or a lost device, whose read-backs fail with the next poll.
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

impl Poller {
    /// Tells the thread to end, and waits up to this long for it: whether it has ended. No other begins.
    pub(crate) fn end(&self, patience: Duration) -> bool {
        const STEP: Duration = Duration::from_millis(1);
        let thread = {
            let mut state = self.0.state();
            state.is_over = true;
            state.thread.take()
        };
        self.0.changed.notify_one();
        let Some(thread) = thread.filter(|thread| thread.thread().id() != std::thread::current().id()) else {
            return true;
        };
        let mut waited = Duration::ZERO;
        while !thread.is_finished() {
            if waited >= patience {
                self.0.state().thread = Some(thread);
                return false;
            }
            std::thread::sleep(STEP);
            waited += STEP;
        }
        // If the thread panicked, do not panic again.
        let _ = thread.join();
        true
    }
}

impl Drop for Poller {
    fn drop(&mut self) {
        /// A driver may not return from a lost device. The thread holds the device: if it were the last to drop it, it
        /// might unload the driver while the process ends, which the driver's exit handlers do not survive.
        const PATIENCE: Duration = Duration::from_secs(2);
        self.end(PATIENCE);
    }
}

impl Drop for Expected {
    fn drop(&mut self) {
        self.0.state().on_their_way -= 1;
    }
}
