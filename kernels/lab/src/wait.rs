//! Waiting for a device on this thread: for a command line, tests, and threads of one's own.

use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll, Wake, Waker};
use std::thread::{self, Thread};
use std::time::Duration;

use raystep_kernels::Gpu;

/// Between two looks at a GPU that works.
const WHILE_BUSY: Duration = Duration::from_micros(200);

/// Between two looks at one that does not.
const WHILE_IDLE: Duration = Duration::from_millis(20);

/// Runs a future to its end. Those of `raystep_kernels` become ready only while the device is polled, so this polls `gpu`
/// whenever the future waits; without one it looks again every millisecond. Meanwhile no
/// thread of the device's own polls it.
pub fn block_on<T>(gpu: Option<&Gpu>, future: impl Future<Output = T>) -> T {
    let _host = gpu.map(Gpu::leave_polling_to_host);
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(value) = future.as_mut().poll(&mut context) {
            return value;
        }
        let wait = wgpu::PollType::Wait { submission_index: None, timeout: Some(Duration::from_secs(1)) };
        // An error here is a lost device or a long pass; the future itself says which.
        if gpu.is_none_or(|gpu| gpu.device.poll(wait).is_err()) {
            thread::sleep(Duration::from_millis(1));
        }
    }
}

struct Unpark {
    thread: Thread,
    is_woken: AtomicBool,
}

impl Wake for Unpark {
    fn wake(self: Arc<Self>) {
        self.is_woken.store(true, Ordering::Release);
        self.thread.unpark();
    }
}

/// The same for a device that another thread draws with, and for a future that waits for messages too. The device is only
/// looked at, never waited for: a wait would hold up whoever draws.
pub fn block_on_shared<T>(gpu: &Gpu, future: impl Future<Output = T>) -> T {
    let _host = gpu.leave_polling_to_host();
    let unpark = Arc::new(Unpark { thread: thread::current(), is_woken: AtomicBool::new(false) });
    let waker = Waker::from(unpark.clone());
    let mut future = pin!(future);
    let mut context = Context::from_waker(&waker);
    loop {
        if let Poll::Ready(value) = future.as_mut().poll(&mut context) {
            return value;
        }
        while !unpark.is_woken.swap(false, Ordering::Acquire) {
            match gpu.device.poll(wgpu::PollType::Poll) {
                Ok(status) if status.is_queue_empty() => thread::park_timeout(WHILE_IDLE),
                // A lost device wakes the task with its error, or at the latest when it is asked again.
                Ok(_) => thread::park_timeout(WHILE_BUSY),
                Err(_) => {
                    thread::park_timeout(WHILE_IDLE);
                    break;
                }
            }
        }
    }
}
