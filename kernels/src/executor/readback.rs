//! From the GPU to the host without blocking: a future that is ready once the device has been polled
//! often enough, or, in a browser, by itself.

use std::sync::Arc;

use futures_channel::oneshot;

use super::gpu::{Gpu, GpuError};

/// Bytes on their way. Dropped before they arrive, it gives the buffer back.
pub(crate) struct Readback {
    gpu: Arc<Gpu>,
    buffer: wgpu::Buffer,
    mapped: oneshot::Receiver<Result<(), wgpu::BufferAsyncError>>,
}

impl Readback {
    /// Starts mapping `bytes` of `buffer`, after everything submitted so far.
    pub(crate) fn start(gpu: &Arc<Gpu>, buffer: wgpu::Buffer, bytes: u64) -> Self {
        let (sender, mapped) = oneshot::channel();
        buffer.map_async(wgpu::MapMode::Read, 0..bytes, move |result| {
            // The receiver is gone where the caller lost interest.
            let _ = sender.send(result);
        });
        Self { gpu: gpu.clone(), buffer, mapped }
    }

    /// Waits for the bytes, hands them to `read` and unmaps the buffer.
    pub(crate) async fn finish<T>(mut self, bytes: u64, read: impl FnOnce(&[u8]) -> T) -> Result<T, GpuError> {
        let problem = match (&mut self.mapped).await {
            Ok(Ok(())) => None,
            Ok(Err(e)) => Some(e.to_string()),
            Err(_) => Some("the device dropped the request".into()),
        };
        if problem.is_some() {
            // A lost device fails the mapping first and reports its loss at the next poll.
            drop(self.gpu.device.poll(wgpu::PollType::Poll));
        }
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

impl Drop for Readback {
    fn drop(&mut self) {
        // Ends the mapping, or cancels it where it is still pending: the buffer can be copied to again.
        self.buffer.unmap();
    }
}
