//! Who polls a device while bytes are on their way from it.
//!
//! A read-back is ready once somebody has polled the device. Where a host does that itself, as a command line or a
//! window does, it says so. Else a thread polls, which sleeps while nothing is on its way; without the feature
//! `poll-thread`, and in a browser, whose own loop polls, there is none.

#[cfg(not(all(feature = "poll-thread", not(target_arch = "wasm32"))))]
mod host;
#[cfg(all(feature = "poll-thread", not(target_arch = "wasm32")))]
mod thread;

#[cfg(not(all(feature = "poll-thread", not(target_arch = "wasm32"))))]
pub(super) use host::Poller;
#[cfg(all(feature = "poll-thread", not(target_arch = "wasm32")))]
pub(super) use thread::Poller;
