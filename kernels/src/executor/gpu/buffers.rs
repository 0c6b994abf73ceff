//! Buffers of scene data, and those of the executors themselves.

use std::mem::offset_of;

use crate::plan::Plan;
use crate::scene_data::SceneData;
use crate::shared::scene::SceneInfo;

/// The buffers of scene data that a plan has, with their contents; those that another run has `uploaded` are shared.
pub(super) fn scene_buffers<'a>(
    device: &wgpu::Device,
    plan: &Plan,
    data: &SceneData,
    uploaded: impl Fn(&str) -> Option<&'a wgpu::Buffer>,
) -> Vec<(&'static str, wgpu::Buffer)> {
    let mut buffers = Vec::new();
    for planned in &plan.buffers {
        let Some(info) = plan.program.buffer(planned.what) else { continue };
        // Two runs may look at the scene from different places.
        if let Some(uploaded) = uploaded(planned.what).filter(|_| !info.is_of_view) {
            buffers.push((planned.what, uploaded.clone()));
            continue;
        }
        let contents = info.contents(data);
        let kind = if info.is_uniform { wgpu::BufferUsages::UNIFORM } else { wgpu::BufferUsages::STORAGE };
        let usage = kind | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        buffers.push((planned.what, filled_buffer(device, &plan.label(planned.what), contents, usage)));
    }
    buffers
}

/// Uploads what depends on the camera.
pub(super) fn upload_view(
    queue: &wgpu::Queue,
    plan: &Plan,
    buffers: &[(&'static str, wgpu::Buffer)],
    data: &SceneData,
) {
    for (name, buffer) in buffers {
        if let Some(info) = plan.program.buffer(name).filter(|info| info.is_of_view) {
            queue.write_buffer(buffer, 0, info.contents(data));
        }
    }
    upload_size(queue, plan, buffers);
}

/// Uploads the size of the streams, which differs from the data's if runs of several sizes share them.
pub(super) fn upload_size(queue: &wgpu::Queue, plan: &Plan, buffers: &[(&'static str, wgpu::Buffer)]) {
    if let Some((_, scene)) = buffers.iter().find(|(name, _)| *name == "scene") {
        let size = [plan.width, plan.height];
        queue.write_buffer(scene, offset_of!(SceneInfo, size) as u64, bytemuck::bytes_of(&size));
    }
}

/// A buffer of the executor's own, of the size that the plan has for it; `None` if the run needs none.
pub(super) fn own_buffer(
    device: &wgpu::Device,
    plan: &Plan,
    name: &'static str,
    usage: wgpu::BufferUsages,
) -> Option<wgpu::Buffer> {
    let planned = plan.buffers.iter().find(|planned| planned.what == name)?;
    Some(labelled_buffer(device, &plan.label(name), planned.bytes, usage))
}

/// A buffer with contents. If the device is lost or has no memory for it, that is reported as an error of the device:
/// wgpu's `create_buffer_init` would panic.
pub(super) fn filled_buffer(
    device: &wgpu::Device,
    label: &str,
    contents: &[u8],
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    let size = contents.len().next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT as usize) as u64;
    let mapped_at_creation = !contents.is_empty();
    let buffer = device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation });
    if mapped_at_creation && let Ok(mut range) = buffer.get_mapped_range_mut(..) {
        range.slice(..contents.len()).copy_from_slice(contents);
        drop(range);
        buffer.unmap();
    }
    buffer
}

/// An empty buffer.
pub(super) fn labelled_buffer(
    device: &wgpu::Device,
    label: &str,
    size: u64,
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
}
