//! Buffers of the executors themselves.

use crate::plan::Plan;

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
