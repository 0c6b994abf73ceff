//! A thread that polls while read-backs are on their way.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Read-backs of a device, who polls for them, and the thread that does where nobody else does.
#[derive(Default)]
pub(crate) struct Poller(Arc<Shared>);

/// What the device's owner and the thread share.
#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    on_their_way: usize,
    /// Hosts that poll.
    hosts: usize,
    is_over: bool,
    thread: Option<JoinHandle<()>>,
}

/// A read-back on its way. It has arrived, or was forgotten, when this is dropped.
pub(crate) struct Expected(Arc<Shared>);

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// Whether it is the thread that has to poll.
    fn needs_thread(&self) -> bool {
        self.on_their_way > 0 && self.hosts == 0
    }
}

impl Poller {
    /// A read-back starts: somebody polls until it has arrived.
    pub(crate) fn expect(&self, device: &wgpu::Device) -> Expected {
        let mut state = self.0.state();
        state.on_their_way += 1;
        self.wake(state, device);
        Expected(self.0.clone())
    }

    /// One host more polls.
    pub(crate) fn host_begins(&self) {
        self.0.state().hosts += 1;
    }

    /// One host fewer polls: what it leaves on its way is the thread's.
    pub(crate) fn host_ends(&self, device: &wgpu::Device) {
        let mut state = self.0.state();
        state.hosts -= 1;
        self.wake(state, device);
    }

    /// Has the thread poll, if it must.
    fn wake(&self, mut state: MutexGuard<'_, State>, device: &wgpu::Device) {
        if !state.needs_thread() {
            return;
        }
        if state.thread.is_none() {
            let (shared, device) = (self.0.clone(), device.clone());
            // Where the system has no thread left, it is the host's to poll after all.
            let builder = std::thread::Builder::new().name("raystep poll".into());
            state.thread = builder.spawn(move || poll(&shared, &device)).ok();
        }
        self.0.changed.notify_one();
    }
}

fn poll(shared: &Shared, device: &wgpu::Device) {
    // Long enough to sleep, short enough to notice that the host polls, or that the device is gone.
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

impl Drop for Poller {
    fn drop(&mut self) {
        let thread = {
            let mut state = self.0.state();
            state.is_over = true;
            state.thread.take()
        };
        self.0.changed.notify_one();
        // It holds the device: were it the last to drop it, it might unload the driver while the process ends, which
        // the driver's exit handlers do not survive. It looks up every few milliseconds.
        if let Some(thread) = thread.filter(|thread| thread.thread().id() != std::thread::current().id()) {
            // A panic of its own is no reason for another.
            let _ = thread.join();
        }
    }
}

impl Drop for Expected {
    fn drop(&mut self) {
        self.0.state().on_their_way -= 1;
    }
}
