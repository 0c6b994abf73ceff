//! A thread for a task that waits for messages and for the GPU, and takes no time while it waits.

use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Wake, Waker};
use std::thread::{self, Thread};
use std::time::Duration;

use raystep_kernels::Gpu;

/// Between two looks at a GPU that works.
const WHILE_BUSY: Duration = Duration::from_micros(200);

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

/// Runs a task to its end. The device is only looked at, never waited for: a wait would hold up whoever draws.
pub(super) fn run(gpu: &Gpu, task: impl Future<Output = ()>) {
    let unpark = Arc::new(Unpark { thread: thread::current(), is_woken: AtomicBool::new(false) });
    let waker = Waker::from(unpark.clone());
    let mut task = pin!(task);
    let mut context = Context::from_waker(&waker);
    while task.as_mut().poll(&mut context).is_pending() {
        while !unpark.is_woken.swap(false, Ordering::Acquire) {
            match gpu.device.poll(wgpu::PollType::Poll) {
                Ok(status) if status.is_queue_empty() => thread::park_timeout(Duration::from_millis(20)),
                // A lost device wakes the task with its error, or at the latest when it is asked again.
                Ok(_) => thread::park_timeout(WHILE_BUSY),
                Err(_) => {
                    thread::park_timeout(Duration::from_millis(20));
                    break;
                }
            }
        }
    }
}
