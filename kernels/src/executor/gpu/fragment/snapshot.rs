//! Copies of streams after some pass, kept on the GPU.

use std::sync::Arc;

use super::FragmentExecutor;
use super::streams::texture;
use crate::executor::gpu::snapshot::Copies;
use crate::executor::gpu::{Gpu, GpuError};
use crate::fragment::TEXEL_BYTES;
use crate::tables::stream::Stream;

/// A copy of all streams after some pass.
pub(crate) struct Snapshot {
    gpu: Arc<Gpu>,
    streams: Vec<(Stream, Arc<wgpu::Texture>)>,
    device_ns: Option<u64>,
    host_ns: Option<u64>,
}

impl Snapshot {
    /// The identity and size in bytes of everything it holds. Two snapshots may share parts.
    pub(crate) fn parts(&self) -> impl Iterator<Item = (usize, u64)> + '_ {
        let bytes = |texture: &wgpu::Texture| TEXEL_BYTES * u64::from(texture.width()) * u64::from(texture.height());
        self.streams.iter().map(move |(_, texture)| (Arc::as_ptr(texture).addr(), bytes(texture)))
    }

    /// Whether it was made on this device.
    pub(crate) fn is_on(&self, gpu: &Arc<Gpu>) -> bool {
        Arc::ptr_eq(&self.gpu, gpu)
    }
}

impl FragmentExecutor {
    /// Copies all streams as they are now.
    ///
    /// # Errors
    /// If there is no memory for it, or the device is lost.
    pub(crate) async fn snapshot(&mut self) -> Result<Snapshot, GpuError> {
        self.gpu.health()?;
        let scopes = self.gpu.push_scopes();
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let (width, height) = (self.plan.width, self.plan.height);
        let streams: Vec<_> = self
            .streams
            .iter()
            .map(|textures| {
                let kept = self.copies.of(textures.stream).unwrap_or_else(|| {
                    let label = format!("{}, kept", self.plan.label(textures.stream.name()));
                    let copy = texture(&self.gpu.device, &label, width, height);
                    let from = textures.current();
                    encoder.copy_texture_to_texture(from.as_image_copy(), copy.as_image_copy(), from.size());
                    Arc::new(copy)
                });
                (textures.stream, kept)
            })
            .collect();
        self.gpu.submit([encoder.finish()]);
        self.gpu.pop_scopes(scopes).await?;
        self.copies = Copies::new(&streams);
        let Self { device_ns, host_ns, .. } = *self;
        Ok(Snapshot { gpu: self.gpu.clone(), streams, device_ns, host_ns })
    }

    /// Restores the streams. The snapshot must be of the same plan and on the same device.
    pub(crate) fn restore(&mut self, snapshot: &Snapshot) {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        for (stream, copy) in &snapshot.streams {
            if let Some(textures) = self.streams.get(*stream) {
                let to = textures.current();
                encoder.copy_texture_to_texture(copy.as_image_copy(), to.as_image_copy(), copy.size());
            }
        }
        self.gpu.submit([encoder.finish()]);
        self.copies = Copies::new(&snapshot.streams);
        (self.device_ns, self.host_ns) = (snapshot.device_ns, snapshot.host_ns);
    }
}
