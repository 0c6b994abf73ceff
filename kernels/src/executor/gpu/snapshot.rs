//! Copies of streams and lists after some pass, kept on the GPU: nothing is read back to the host.

use std::collections::BTreeMap;
use std::sync::{Arc, Weak};

use super::books::KeptLists;
use super::stream_texture::bytes;
use super::{GpuError, GpuExecutor, StreamTexture, stream_format};
use crate::executor::sizes::Sizes;
use crate::program::Kernel;
use crate::tables::state::StateCounts;
use crate::tables::stream::Stream;

/// A copy of streams and lists after some pass.
pub(crate) struct Snapshot {
    gpu: Arc<super::Gpu>,
    streams: Vec<(Stream, Arc<wgpu::Texture>)>,
    lists: KeptLists,
    sizes: Sizes,
    device_ns: Option<u64>,
    host_ns: Option<u64>,
}

/// Copies that are still up to date. A stream that no pass has written since is not copied again.
#[derive(Default)]
pub(super) struct Copies(BTreeMap<Stream, Weak<wgpu::Texture>>);

impl Copies {
    /// Marks a stream as changed.
    pub(super) fn forget(&mut self, stream: Stream) {
        self.0.remove(&stream);
    }

    /// Marks every stream as changed.
    pub(super) fn forget_all(&mut self) {
        self.0.clear();
    }

    pub(super) fn of(&self, stream: Stream) -> Option<Arc<wgpu::Texture>> {
        self.0.get(&stream)?.upgrade()
    }

    /// Copies that are up to date now.
    pub(super) fn new(streams: &[(Stream, Arc<wgpu::Texture>)]) -> Self {
        Self(streams.iter().map(|(stream, copy)| (*stream, Arc::downgrade(copy))).collect())
    }
}

impl Snapshot {
    /// The identity and size in bytes of everything it holds. Two snapshots may share parts.
    pub(crate) fn parts(&self) -> impl Iterator<Item = (usize, u64)> + '_ {
        let streams = self.streams.iter().map(|(_, texture)| (Arc::as_ptr(texture).addr(), bytes(texture.size())));
        streams.chain(std::iter::once((std::ptr::from_ref(self).addr(), self.lists.bytes())))
    }

    /// Whether it was made on this device.
    pub(crate) fn is_on(&self, gpu: &Arc<super::Gpu>) -> bool {
        Arc::ptr_eq(&self.gpu, gpu)
    }
}

impl GpuExecutor {
    /// Copies streams and lists as they are now. `counts` are the rays in each state.
    ///
    /// # Errors
    /// If there is no memory for it, or the device is lost.
    pub(crate) async fn snapshot(&mut self, counts: &StateCounts) -> Result<Snapshot, GpuError> {
        self.gpu.health()?;
        let scopes = self.gpu.push_scopes();
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let keep = |(stream, texture): &(Stream, StreamTexture)| {
            let copy = self.copies.of(*stream).unwrap_or_else(|| {
                let copy = self.room_for(*stream, texture);
                encoder.copy_texture_to_texture(texture.as_image_copy(), copy.as_image_copy(), texture.size());
                Arc::new(copy)
            });
            (*stream, copy)
        };
        let streams: Vec<_> = self.streams.iter().map(keep).collect();
        let lists = self.books.keep(&self.gpu.device, &mut encoder, counts);
        self.gpu.submit([encoder.finish()]);
        self.gpu.pop_scopes(scopes).await?;
        self.copies = Copies::new(&streams);
        let Self { device_ns, host_ns, .. } = *self;
        Ok(Snapshot { gpu: self.gpu.clone(), streams, lists, sizes: self.sizes.clone(), device_ns, host_ns })
    }

    /// A texture for a copy of a stream.
    pub(super) fn room_for(&self, stream: Stream, texture: &StreamTexture) -> wgpu::Texture {
        self.gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(&format!("{}.{}, kept", self.plan.program.name, stream.name())),
            size: texture.size(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: stream_format(stream),
            usage: wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        })
    }

    /// Restores streams and lists. The snapshot must be of the same plan and on the same device.
    pub(crate) fn restore(&mut self, snapshot: &Snapshot) -> Result<(), GpuError> {
        self.resize(snapshot.sizes.clone())?;
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        for (stream, copy) in &snapshot.streams {
            let is_there = self.copies.of(*stream).is_some_and(|there| Arc::ptr_eq(&there, copy));
            if let Some(texture) = self.texture(*stream).filter(|_| !is_there) {
                encoder.copy_texture_to_texture(copy.as_image_copy(), texture.as_image_copy(), copy.size());
            }
        }
        self.books.restore(&mut encoder, &snapshot.lists);
        self.gpu.submit([encoder.finish()]);
        self.copies = Copies::new(&snapshot.streams);
        (self.device_ns, self.host_ns) = (snapshot.device_ns, snapshot.host_ns);
        Ok(())
    }

    /// Marks the streams as changed that passes of these kernels are about to write.
    pub(super) fn forget_written(&mut self, passes: &[Kernel]) {
        for kernel in passes {
            for &stream in self.pipelines.get(*kernel).map_or(&[][..], |pipeline| &pipeline.writes) {
                self.copies.forget(stream);
            }
            kernel.instance().copies.iter().for_each(|(copy, _)| self.copies.forget(*copy));
        }
    }
}
