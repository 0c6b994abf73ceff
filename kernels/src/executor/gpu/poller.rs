//! Who polls a device while bytes are on their way from it.
//!
//! A read-back is ready once somebody has polled the device. While a host does that itself, as a command line or a
//! window does, it holds a [`HostPolls`]. Else a thread polls, which sleeps while nothing is on its way or a host polls;
//! without the feature `poll-thread`, and in a browser, whose own loop polls, there is none.

#[cfg(not(all(feature = "poll-thread", not(target_arch = "wasm32"))))]
mod host;
#[cfg(all(feature = "poll-thread", not(target_arch = "wasm32")))]
mod thread;

#[cfg(not(all(feature = "poll-thread", not(target_arch = "wasm32"))))]
pub(super) use host::Poller;
#[cfg(all(feature = "poll-thread", not(target_arch = "wasm32")))]
pub(super) use thread::Poller;

/// While this is held, the host polls the device, and no thread does: see
/// [`Gpu::leave_polling_to_host`](super::Gpu::leave_polling_to_host).
#[must_use = "the host polls for as long as this is held"]
pub struct HostPolls<'a> {
    poller: &'a Poller,
    device: &'a wgpu::Device,
}

impl<'a> HostPolls<'a> {
    pub(super) fn new(poller: &'a Poller, device: &'a wgpu::Device) -> Self {
        poller.host_begins();
        Self { poller, device }
    }
}

impl Drop for HostPolls<'_> {
    fn drop(&mut self) {
        self.poller.host_ends(self.device);
    }
}
