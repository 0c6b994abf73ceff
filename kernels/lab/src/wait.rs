//! Waiting for a device.

use std::pin::pin;
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use raystep_kernels::Gpu;

/// Runs a future to its end on this thread. Those of `raystep_kernels` become ready only while the device is polled,
/// so this polls `gpu` whenever the future waits; without one it looks again every millisecond.
///
/// Blocks: for a command line, tests and threads of one's own, not for a user interface.
pub fn block_on<T>(gpu: Option<&Gpu>, future: impl Future<Output = T>) -> T {
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(value) = future.as_mut().poll(&mut context) {
            return value;
        }
        let wait = wgpu::PollType::Wait { submission_index: None, timeout: Some(Duration::from_secs(1)) };
        // An error here is a lost device or a long pass; the future itself says which.
        if gpu.is_none_or(|gpu| gpu.device.poll(wait).is_err()) {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}
