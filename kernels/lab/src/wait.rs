//! Waiting for a device on the current thread: for a command line, tests, and background threads.

use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll, Wake, Waker};
use std::thread::{self, Thread};
use std::time::Duration;

use raystep_kernels::Gpu;

/// Interval between polls of a busy GPU.
const WHILE_BUSY: Duration = Duration::from_micros(200);

/// Interval between polls of an idle GPU.
const WHILE_IDLE: Duration = Duration::from_millis(20);

/// Time limit of one wait for a GPU, far longer than its work takes. wgpu panics if a wait ends by its time limit while
/// another thread finds that the work is over, so that must not happen on a slow machine.
const LONGEST_WAIT: Duration = Duration::from_secs(60);

/// Runs a future to completion. Futures of `raystep_kernels` become ready only while the device is polled, so this
/// polls `gpu` whenever the future waits; without a GPU it polls the future every millisecond. No other thread polls
/// the device meanwhile.
pub fn block_on<T>(gpu: Option<&Gpu>, future: impl Future<Output = T>) -> T {
    let _host = gpu.map(Gpu::leave_polling_to_host);
    let unpark = Arc::new(Unpark { thread: thread::current(), is_woken: AtomicBool::new(false) });
    let waker = Waker::from(unpark.clone());
    let mut future = pin!(future);
    let mut context = Context::from_waker(&waker);
    loop {
        if let Poll::Ready(value) = future.as_mut().poll(&mut context) {
            return value;
        }
        // It only let others run.
        if unpark.is_woken.swap(false, Ordering::Acquire) {
            continue;
        }
        let wait = wgpu::PollType::Wait { submission_index: None, timeout: Some(LONGEST_WAIT) };
        // An error here is a lost device or a long pass; the future itself reports which.
        if gpu.is_none_or(|gpu| gpu.device.poll(wait).is_err()) {
            thread::park_timeout(Duration::from_millis(1));
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

/// The same for a device that another thread draws with, and for futures that also wait for messages. The device is
/// only polled, never waited for: waiting would block the drawing thread. `None` if `is_over` was set before the future
/// was complete: it is dropped where it waited next, within some 20 ms after that.
pub fn block_on_shared<T>(gpu: &Gpu, is_over: &AtomicBool, future: impl Future<Output = T>) -> Option<T> {
    let _host = gpu.leave_polling_to_host();
    let unpark = Arc::new(Unpark { thread: thread::current(), is_woken: AtomicBool::new(false) });
    let waker = Waker::from(unpark.clone());
    let mut future = pin!(future);
    let mut context = Context::from_waker(&waker);
    while !is_over.load(Ordering::Acquire) {
        if let Poll::Ready(value) = future.as_mut().poll(&mut context) {
            return Some(value);
        }
        while !unpark.is_woken.swap(false, Ordering::Acquire) && !is_over.load(Ordering::Acquire) {
            match gpu.device.poll(wgpu::PollType::Poll) {
                Ok(status) if status.is_queue_empty() => thread::park_timeout(WHILE_IDLE),
                // A lost device wakes the task with its error, at the latest when polled again.
                Ok(_) => thread::park_timeout(WHILE_BUSY),
                Err(_) => {
                    thread::park_timeout(WHILE_IDLE);
                    break;
                }
            }
        }
    }
    None
}
