//! Reads back from the GPU without blocking: a future that is ready once the device has been polled often enough.
//! `poller.rs` decides who polls.

use std::future::poll_fn;
use std::pin::Pin;
use std::sync::Arc;
use std::task::Poll;

use futures_channel::oneshot;

use super::{Gpu, GpuError};

/// A pending read-back. If dropped before the bytes arrive, it gives the buffer back.
pub(crate) struct Readback {
    gpu: Arc<Gpu>,
    buffer: wgpu::Buffer,
    mapped: oneshot::Receiver<Result<(), wgpu::BufferAsyncError>>,
}

/// How often to ask again for bytes that a healthy device forgot.
const TRIES: usize = 8;

impl Readback {
    /// Starts mapping `bytes` of `buffer`, after everything submitted so far.
    pub(crate) fn start(gpu: &Arc<Gpu>, buffer: wgpu::Buffer, bytes: u64) -> Self {
        let mapped = map(gpu, &buffer, bytes);
        Self { gpu: gpu.clone(), buffer, mapped }
    }

    /// Waits for the bytes, hands them to `read` and unmaps the buffer.
    pub(crate) async fn finish<T>(mut self, bytes: u64, read: impl FnOnce(&[u8]) -> T) -> Result<T, GpuError> {
        let mut tries = TRIES;
        let problem = loop {
            let problem = match (&mut self.mapped).await {
                Ok(Ok(())) => break None,
                Ok(Err(e)) => Some(e.to_string()),
                Err(_) => None,
            };
            self.gpu.health_after_an_error().await?;
            if problem.is_some() {
                break problem;
            }
            // wgpu forgets the request if it fails to configure a window's surface at that moment. The bytes are still
            // there.
            if tries == 0 {
                break Some("the device dropped the request".into());
            }
            tries -= 1;
            self.buffer.unmap();
            self.mapped = map(&self.gpu, &self.buffer, bytes);
        };
        self.gpu.health()?;
        if let Some(problem) = problem {
            return Err(GpuError::Readback(problem));
        }
        let value = {
            let view = self.buffer.get_mapped_range(0..bytes).map_err(|e| GpuError::Readback(e.to_string()))?;
            read(&view)
        };
        Ok(value)
    }
}

/// Requests the bytes.
fn map(gpu: &Gpu, buffer: &wgpu::Buffer, bytes: u64) -> oneshot::Receiver<Result<(), wgpu::BufferAsyncError>> {
    let (sender, mapped) = oneshot::channel();
    let expected = gpu.poller.expect(&gpu.device);
    buffer.map_async(wgpu::MapMode::Read, 0..bytes, move |result| {
        // Dropped at the end of this callback: the read-back has arrived.
        let _expected = expected;
        // The receiver is gone if the caller was dropped.
        let _ = sender.send(result);
    });
    mapped
}

impl Gpu {
    /// Submits commands, and waits for the bytes that they leave at the start of a buffer that can be mapped.
    ///
    /// # Errors
    /// If the device is lost or refuses them.
    pub async fn read_after(
        self: &Arc<Self>,
        commands: wgpu::CommandBuffer,
        buffer: wgpu::Buffer,
        bytes: u64,
    ) -> Result<Vec<u8>, GpuError> {
        self.submit([commands]);
        Readback::start(self, buffer, bytes).finish(bytes, <[u8]>::to_vec).await
    }

    /// Waits until the device has finished everything submitted so far, uploads included. As for read-backs, somebody
    /// must poll the device.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn finish(&self) -> Result<(), GpuError> {
        // Submits what was only uploaded, through the gate.
        self.submit([]);
        let (sender, mut done) = oneshot::channel();
        let expected = self.poller.expect(&self.device);
        self.queue.on_submitted_work_done(move || {
            let _expected = expected;
            // The receiver is gone if the caller was dropped.
            let _ = sender.send(());
        });
        // A device that is lost meanwhile may never call back.
        poll_fn(|context| match self.health() {
            Ok(()) => Pin::new(&mut done).poll(context).map(drop),
            Err(_) => Poll::Ready(()),
        })
        .await;
        self.health()
    }
}

impl Drop for Readback {
    fn drop(&mut self) {
        // Ends the mapping, or cancels it if it is still pending: the buffer can be copied to again.
        self.buffer.unmap();
    }
}
