//! Who polls a device while read-backs are pending.
//!
//! A read-back is ready once the device has been polled. A host that polls itself, such as a command line or a window,
//! holds a [`HostPolls`]. Otherwise a thread polls, which sleeps while nothing is pending or a host polls; without the
//! feature `poll-thread`, and in a browser, whose own event loop polls, there is no thread.

#[cfg(not(all(feature = "poll-thread", not(target_arch = "wasm32"))))]
mod host;
#[cfg(all(feature = "poll-thread", not(target_arch = "wasm32")))]
mod thread;

#[cfg(not(all(feature = "poll-thread", not(target_arch = "wasm32"))))]
pub(super) use host::Poller;
#[cfg(all(feature = "poll-thread", not(target_arch = "wasm32")))]
pub(super) use thread::Poller;

/// While this is held, the host polls the device and no thread does: see
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
