//! Who polls a device while bytes are on their way from it.
//!
//! A read-back is ready once somebody has polled the device. Where a host does that itself, as a command line or a
//! window does, it says so. Else a thread polls, which sleeps while nothing is on its way; without the feature
//! `poll-thread`, and in a browser, whose own loop polls, there is none.

use std::sync::Arc;
#[cfg(all(feature = "poll-thread", not(target_arch = "wasm32")))]
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// What the device's owner and the thread share.
#[derive(Default)]
struct Shared {
    #[cfg(all(feature = "poll-thread", not(target_arch = "wasm32")))]
    state: Mutex<State>,
    #[cfg(all(feature = "poll-thread", not(target_arch = "wasm32")))]
    changed: Condvar,
}

/// Read-backs of a device, and whether a thread waits for them.
#[derive(Default)]
pub(super) struct Poller(Arc<Shared>);

/// A read-back on its way. It has arrived, or was forgotten, when this is dropped.
pub(super) struct Expected(#[allow(dead_code, reason = "without a thread, nobody counts")] Arc<Shared>);

#[cfg(all(feature = "poll-thread", not(target_arch = "wasm32")))]
#[derive(Default)]
struct State {
    on_their_way: usize,
    is_host_polling: bool,
    is_thread_running: bool,
    is_over: bool,
}

#[cfg(not(all(feature = "poll-thread", not(target_arch = "wasm32"))))]
impl Poller {
    pub(super) fn expect(&self, _device: &wgpu::Device) -> Expected {
        Expected(self.0.clone())
    }

    pub(super) fn leave_to_host(&self) {}
}

#[cfg(all(feature = "poll-thread", not(target_arch = "wasm32")))]
impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(all(feature = "poll-thread", not(target_arch = "wasm32")))]
impl Poller {
    /// A read-back starts: somebody polls until it has arrived.
    pub(super) fn expect(&self, device: &wgpu::Device) -> Expected {
        let mut state = self.0.state();
        state.on_their_way += 1;
        if !state.is_host_polling && !state.is_thread_running {
            let (shared, device) = (self.0.clone(), device.clone());
            let thread = std::thread::Builder::new().name("raystep poll".into());
            // Where the system has no thread left, it is the host's to poll after all.
            state.is_thread_running = thread.spawn(move || poll(&shared, &device)).is_ok();
        }
        self.0.changed.notify_one();
        drop(state);
        Expected(self.0.clone())
    }

    /// From now on the host polls, and no thread does.
    pub(super) fn leave_to_host(&self) {
        self.0.state().is_host_polling = true;
        self.0.changed.notify_one();
    }
}

#[cfg(all(feature = "poll-thread", not(target_arch = "wasm32")))]
fn poll(shared: &Shared, device: &wgpu::Device) {
    // Long enough to sleep, short enough to notice that the host polls, or that the device is gone.
    const WAIT: std::time::Duration = std::time::Duration::from_millis(100);
    loop {
        let mut state = shared.state();
        while state.on_their_way == 0 && !state.is_over && !state.is_host_polling {
            state = shared.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        if state.is_over || state.is_host_polling {
            state.is_thread_running = false;
            return;
        }
        drop(state);
        let polled = device.poll(wgpu::PollType::Wait { submission_index: None, timeout: Some(WAIT) });
        if polled.is_err() {
            // A long pass, or a lost device, whose read-backs fail with the next poll.
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
    }
}

#[cfg(all(feature = "poll-thread", not(target_arch = "wasm32")))]
impl Drop for Poller {
    fn drop(&mut self) {
        self.0.state().is_over = true;
        self.0.changed.notify_one();
    }
}

#[cfg(all(feature = "poll-thread", not(target_arch = "wasm32")))]
impl Drop for Expected {
    fn drop(&mut self) {
        self.0.state().on_their_way -= 1;
    }
}
