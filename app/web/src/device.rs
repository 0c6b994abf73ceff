//! Opens a device: WebGPU, or WebGL 2, on which kernels are fragment programs.

use std::sync::Arc;

use raystep_kernels::{AdapterChoice, Gpu};
use web_sys::OffscreenCanvas;

/// A device, and the surface that it draws on.
pub(crate) struct Opened {
    pub(crate) gpu: Arc<Gpu>,
    pub(crate) surface: wgpu::Surface<'static>,
    pub(crate) adapter: wgpu::Adapter,
    /// Why there is no WebGPU, if there is none.
    pub(crate) why_not: Option<String>,
}

/// Opens the best device there is.
pub(crate) async fn open(canvas: &OffscreenCanvas) -> Result<Opened, String> {
    let target = || wgpu::SurfaceTarget::OffscreenCanvas(canvas.clone());
    let why_not = match Gpu::new(&AdapterChoice::Best).await {
        Ok(gpu) => {
            let source = gpu.source.clone().ok_or("the device has another owner")?;
            let surface = source.instance.create_surface(target()).map_err(|e| e.to_string())?;
            return Ok(Opened { gpu, surface, adapter: source.adapter, why_not: None });
        }
        Err(error) => error.to_string(),
    };
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: wgpu::Backends::GL,
        flags: wgpu::InstanceFlags::empty(),
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let missing = |what: String| format!("{why_not}; WebGL 2: {what}");
    let surface = instance.create_surface(target()).map_err(|e| missing(e.to_string()))?;
    let options = wgpu::RequestAdapterOptions { compatible_surface: Some(&surface), ..Default::default() };
    let adapter = instance.request_adapter(&options).await.map_err(|e| missing(e.to_string()))?;
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("raystep"),
        required_limits: wgpu::Limits::downlevel_webgl2_defaults().using_resolution(adapter.limits()),
        ..Default::default()
    };
    let (device, queue) = adapter.request_device(&descriptor).await.map_err(|e| missing(e.to_string()))?;
    let gpu = Gpu::for_drawing(device, queue, adapter.get_info());
    Ok(Opened { gpu, surface, adapter, why_not: Some(why_not) })
}
