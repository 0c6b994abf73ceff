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
    /// Whether it is good only for kernels as fragment programs, with the scene in textures.
    pub only_draws: bool,
    /// How it handles long loops; `None` if that was not measured.
    pub loops: Option<Loops>,
}

/// An instance without debug layers, unless the environment asks for them (`WGPU_DEBUG=1` passes the names of all GPU
/// objects to the driver, for RenderDoc and Nsight), and without validation of indirect dispatches: that takes a pass
/// of its own, and the lists that kernels append to have room for every ray.
pub(super) fn instance(backends: wgpu::Backends) -> wgpu::Instance {
    wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        flags: wgpu::InstanceFlags::empty().with_env(),
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    })
}

/// The adapters on this machine that compute, or those that only draw.
pub(super) async fn enumerate(backends: wgpu::Backends) -> (wgpu::Instance, Vec<wgpu::Adapter>) {
    let instance = instance(backends);
    // A browser lists its adapter whatever it is asked for.
    let mut adapters = if backends.is_empty() { Vec::new() } else { instance.enumerate_adapters(backends).await };
    adapters.sort_by_key(|a| rank(&a.get_info()));
    (instance, adapters)
}

/// Every adapter on this machine.
pub async fn adapters() -> Vec<AdapterSummary> {
    let mut summaries = Vec::new();
    let (_, computing) = enumerate(wgpu::Backends::PRIMARY).await;
    let (_, drawing) = enumerate(DRAWING).await;
    for adapter in computing.into_iter().chain(drawing) {
        let loops = if computes(&adapter) { probe_loops(&adapter).await } else { None };
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
    let only_draws = only_draws(adapter);
    AdapterSummary {
        info: named(adapter.get_info()),
        limits: if only_draws { drawing_limits(adapter) } else { adapter.limits() },
        has_timestamps: !only_draws && adapter.features().contains(wgpu::Features::TIMESTAMP_QUERY),
        is_usable: computes(adapter),
        only_draws: only_draws && is_usable(adapter),
        loops,
    }
}

/// The backend of adapters that only draw: OpenGL, even where it has compute shaders, as those of OpenGL ES 3.0 and WebGL 2
/// do not.
pub(super) const DRAWING: wgpu::Backends =
    if cfg!(target_arch = "wasm32") { wgpu::Backends::empty() } else { wgpu::Backends::GL };

/// Whether it only draws.
pub(super) fn only_draws(adapter: &wgpu::Adapter) -> bool {
    adapter.get_info().backend == wgpu::Backend::Gl
}

/// What a device is asked for that only draws: what WebGL 2 has, but textures as large as they can be.
pub(super) fn drawing_limits(adapter: &wgpu::Adapter) -> wgpu::Limits {
    wgpu::Limits::downlevel_webgl2_defaults().using_resolution(adapter.limits())
}

/// What it does not have of core WebGPU limits, and of compute shaders that read and write r32 textures; or of what it takes
/// to draw.
pub(super) fn lacks(adapter: &wgpu::Adapter) -> Vec<String> {
    let mut lacks = Vec::new();
    if only_draws(adapter) {
        drawing_limits(adapter).check_limits_with_fail_fn(&adapter.limits(), false, |name, wanted, has| {
            lacks.push(format!("{name} {wanted} (it has {has})"));
        });
        return lacks;
    }
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

/// Whether it has all of that, compute shaders too.
fn computes(adapter: &wgpu::Adapter) -> bool {
    !only_draws(adapter) && is_usable(adapter)
}

/// Its name, and what it lacks.
pub(super) fn told(adapter: &wgpu::Adapter) -> String {
    let (name, lacks) = (named(adapter.get_info()).name, lacks(adapter));
    if lacks.is_empty() { name } else { format!("{name}, which lacks {}", lacks.join(" and ")) }
}

/// A browser may keep the adapter's name to itself. A GPU may be two adapters, of which one only draws.
pub(super) fn named(mut info: wgpu::AdapterInfo) -> wgpu::AdapterInfo {
    if info.name.is_empty() {
        info.name = if info.backend == wgpu::Backend::BrowserWebGpu { "WebGPU" } else { "no name" }.into();
    }
    if info.backend == wgpu::Backend::Gl {
        info.name += if cfg!(target_arch = "wasm32") { ", WebGL 2" } else { ", OpenGL" };
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
