//! The adapters of a machine, and whether they can run kernels.

use super::probe::loops;
use crate::plan::Loops;

/// An adapter as listed by `raystep info`.
#[derive(Clone, Debug)]
pub struct AdapterSummary {
    /// Name, driver, backend, type.
    pub info: wgpu::AdapterInfo,
    /// Its limits.
    pub limits: wgpu::Limits,
    /// Whether it supports timestamps.
    pub has_timestamps: bool,
    /// Whether it supports everything raystep requires.
    pub is_usable: bool,
    /// How it handles long loops; `None` if it gives no device.
    pub loops: Option<Loops>,
}

/// An instance without debug layers, unless the environment asks for them (`WGPU_DEBUG=1` passes the names of all GPU
/// objects to the driver, for RenderDoc and Nsight), and without validation of indirect dispatches: that takes a pass
/// of its own, and the lists that kernels append to have room for every ray.
pub(super) fn instance() -> wgpu::Instance {
    wgpu::Instance::new(wgpu::InstanceDescriptor {
        flags: wgpu::InstanceFlags::empty().with_env(),
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    })
}

/// Every adapter on this machine.
pub async fn adapters() -> Vec<AdapterSummary> {
    let mut summaries = Vec::new();
    for adapter in instance().enumerate_adapters(wgpu::Backends::PRIMARY).await {
        let loops = if is_usable(&adapter) { probe_loops(&adapter).await } else { None };
        summaries.push(summary(&adapter, loops));
    }
    summaries
}

/// Opens a device temporarily to test long loops.
async fn probe_loops(adapter: &wgpu::Adapter) -> Option<Loops> {
    let (device, queue) = adapter.request_device(&wgpu::DeviceDescriptor::default()).await.ok()?;
    loops(&device, &queue).await.ok()
}

fn summary(adapter: &wgpu::Adapter, loops: Option<Loops>) -> AdapterSummary {
    AdapterSummary {
        info: adapter.get_info(),
        limits: adapter.limits(),
        has_timestamps: adapter.features().contains(wgpu::Features::TIMESTAMP_QUERY),
        is_usable: is_usable(adapter),
        loops,
    }
}

/// What it does not have of core WebGPU limits, and of compute shaders that read and write r32 textures.
pub(super) fn lacks(adapter: &wgpu::Adapter) -> Vec<String> {
    let mut lacks = Vec::new();
    if !adapter.get_downlevel_capabilities().flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS) {
        lacks.push("compute shaders".to_owned());
    }
    wgpu::Limits::default().check_limits_with_fail_fn(&adapter.limits(), false, |name, wanted, has| {
        lacks.push(format!("{name} {wanted} (it has {has})"));
    });
    for format in [wgpu::TextureFormat::R32Float, wgpu::TextureFormat::R32Uint] {
        let flags = adapter.get_texture_format_features(format).flags;
        if !flags.contains(wgpu::TextureFormatFeatureFlags::STORAGE_READ_WRITE) {
            lacks.push(format!("{format:?} textures that shaders read and write"));
        }
    }
    lacks
}

/// Whether it has all of that.
pub(super) fn is_usable(adapter: &wgpu::Adapter) -> bool {
    lacks(adapter).is_empty()
}

/// Its name, and what it lacks.
pub(super) fn told(adapter: &wgpu::Adapter) -> String {
    let (name, lacks) = (named(adapter.get_info()).name, lacks(adapter));
    if lacks.is_empty() { name } else { format!("{name}, which lacks {}", lacks.join(" and ")) }
}

/// A browser may keep the adapter's name to itself.
pub(super) fn named(mut info: wgpu::AdapterInfo) -> wgpu::AdapterInfo {
    if info.name.is_empty() {
        info.name = if info.backend == wgpu::Backend::BrowserWebGpu { "WebGPU" } else { "no name" }.into();
    }
    info
}

/// Lower is better.
pub(super) fn rank(info: &wgpu::AdapterInfo) -> (u8, u8) {
    let kind = match info.device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    };
    (kind, u8::from(info.backend == wgpu::Backend::Gl))
}
