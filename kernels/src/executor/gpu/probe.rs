//! Tests behaviour of an adapter that its limits do not tell, with a small dispatch when a device is opened.

use std::future::poll_fn;
use std::task::Poll;

use futures_channel::oneshot;

use super::buffers::filled_buffer;
use super::error::GpuError;
use crate::plan::Loops;

/// Iterations that the loop is told to run.
const TURNS: u32 = 1 << 18;

/// Each iteration depends on the one before, so that no compiler can predict the loop's end.
const SOURCE: &str = "
@group(0) @binding(0) var<storage, read_write> told: array<u32, 3>;

@compute @workgroup_size(1)
fn turns() {
    var value = told[1];
    var turn = 0u;
    while (turn < told[0]) {
        value = value * 747796405u + 2891336453u;
        turn += 1u;
    }
    told[1] = value;
    told[2] = turn;
}
";

/// Counts the iterations that a loop runs on the device.
pub(super) async fn loops(device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Loops, GpuError> {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("probe of loops"),
        source: wgpu::ShaderSource::Wgsl(SOURCE.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("probe of loops"),
        layout: None,
        module: &module,
        entry_point: Some("turns"),
        compilation_options: Default::default(),
        cache: None,
    });
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
    let told = filled_buffer(device, "probe of loops", bytemuck::cast_slice(&[TURNS, 1, 0]), usage);
    let copy = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("probe of loops, read back"),
        size: told.size(),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("probe of loops"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: told.as_entire_binding() }],
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(1, 1, 1);
    }
    encoder.copy_buffer_to_buffer(&told, 0, &copy, 0, told.size());
    #[expect(clippy::disallowed_methods, reason = "nobody else has the device yet")]
    queue.submit([encoder.finish()]);
    mapped(device, &copy).await?;
    let turns = {
        let view = copy.get_mapped_range(..).map_err(|e| GpuError::Readback(e.to_string()))?;
        view.get(8..12).and_then(|bytes| bytes.try_into().ok()).map_or(0, u32::from_le_bytes)
    };
    copy.unmap();
    match turns {
        0 => Err(GpuError::Readback("a loop of the adapter took no turn".into())),
        TURNS => Ok(Loops::Unlimited),
        turns => Ok(Loops::EndAfter(turns)),
    }
}

/// Maps a buffer for reading. Polls the device itself: nobody else does while it is being opened.
async fn mapped(device: &wgpu::Device, buffer: &wgpu::Buffer) -> Result<(), GpuError> {
    let (sender, mut receiver) = oneshot::channel();
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        // The receiver is gone if the caller was dropped.
        let _ = sender.send(result);
    });
    let result = poll_fn(|context| {
        // A lost device fails the mapping.
        drop(device.poll(wgpu::PollType::Poll));
        match Future::poll(std::pin::Pin::new(&mut receiver), context) {
            Poll::Ready(result) => Poll::Ready(result),
            Poll::Pending => {
                // A browser polls by itself, but only while this task yields.
                if !cfg!(target_arch = "wasm32") {
                    context.waker().wake_by_ref();
                }
                Poll::Pending
            }
        }
    })
    .await;
    match result {
        Ok(Ok(())) => Ok(()),
        Ok(Err(error)) => Err(GpuError::Readback(error.to_string())),
        Err(_) => Err(GpuError::Readback("the device dropped the request".into())),
    }
}
