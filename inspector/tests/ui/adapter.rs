//! One adapter for all tests of this binary, and waiting for it.

use std::pin::{Pin, pin};
use std::sync::{Arc, OnceLock};
use std::task::{Context, Poll, Wake, Waker};
use std::thread::Thread;
use std::time::{Duration, Instant};

use raystep_kernels::{AdapterChoice, Gpu};

/// The adapter that everything is traced and drawn with.
pub(crate) fn gpu() -> Arc<Gpu> {
    static GPU: OnceLock<Arc<Gpu>> = OnceLock::new();
    GPU.get_or_init(|| {
        let gpu = own_gpu();
        let wgpu::AdapterInfo { name, driver, driver_info, backend, .. } = &gpu.info;
        println!("adapter: {name}, {driver} {driver_info}, {backend:?}");
        gpu
    })
    .clone()
}

/// A device that nobody else has, to be lost.
pub(crate) fn own_gpu() -> Arc<Gpu> {
    let gpu =
        pollster::block_on(Gpu::new(&AdapterChoice::Best)).expect("an adapter, if only software (Mesa's lavapipe)");
    // By a true clock: that of the stage, by which pictures are the same each time, counts calls.
    block_on(&gpu, gpu.check_clock(now_ns)).expect("a device");
    gpu
}

/// Nanoseconds since the first call.
fn now_ns() -> u64 {
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_nanos() as u64
}

struct Unpark(Thread);

impl Wake for Unpark {
    fn wake(self: Arc<Self>) {
        self.0.unpark();
    }
}

/// Waits for a future; those of the library become ready only while the device is polled.
pub(crate) fn block_on<T>(gpu: &Gpu, future: impl Future<Output = T>) -> T {
    let waker = Waker::from(Arc::new(Unpark(std::thread::current())));
    let mut context = Context::from_waker(&waker);
    let mut future: Pin<&mut _> = pin!(future);
    loop {
        if let Poll::Ready(value) = future.as_mut().poll(&mut context) {
            return value;
        }
        // A lost device is said by the future itself.
        let is_idle = gpu.device.poll(wgpu::PollType::Poll).is_ok_and(|status| status.is_queue_empty());
        std::thread::park_timeout(if is_idle { Duration::from_millis(5) } else { Duration::from_micros(200) });
    }
}
