//! One adapter for all tests of this binary, and a function to wait for it.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};

use raystep_kernels::{AdapterChoice, Gpu};
use raystep_lab::block_on_shared;
use raystep_lab::machine::now_ns;

/// The adapter for all tracing and drawing.
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

/// A separate device, for tests that lose it.
pub(crate) fn own_gpu() -> Arc<Gpu> {
    let gpu =
        pollster::block_on(Gpu::new(&AdapterChoice::Best)).expect("an adapter, if only software (Mesa's lavapipe)");
    // Checked with a real clock; the stage's clock, which makes snapshots reproducible, only counts calls.
    block_on(&gpu, gpu.check_clock(now_ns)).expect("a device");
    gpu
}

/// Waits for a future; the library's futures become ready only while the device is polled.
pub(crate) fn block_on<T>(gpu: &Gpu, future: impl Future<Output = T>) -> T {
    block_on_shared(gpu, &AtomicBool::new(false), future).expect("nobody ends it before it is done")
}
