//! One adapter for all tests of this binary, and waiting for it.

use std::sync::{Arc, OnceLock};

use raystep_kernels::{AdapterChoice, Gpu};
use raystep_lab::block_on_shared;
use raystep_lab::machine::now_ns;

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

/// Waits for a future; those of the library become ready only while the device is polled.
pub(crate) fn block_on<T>(gpu: &Gpu, future: impl Future<Output = T>) -> T {
    block_on_shared(gpu, future)
}
