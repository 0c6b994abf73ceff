//! Small copies of the rays' states on the way through a run, for thumbnails of passes that were never shown.

use std::sync::Arc;

use futures_channel::mpsc::UnboundedSender;
use raystep_kernels::executor::gpu::{StreamTexture, stream_format};
use raystep_kernels::fragment::TEXEL_BYTES;
use raystep_kernels::tables::stream::STATE_TAG;
use raystep_kernels::{Gpu, RenderError, Renderer, Stream};

use super::copies::copy_of;
use super::request::Update;
use super::sketch::{SIDE, Sketch};
use crate::draw::stream::drawable;

/// Passes between two sketches at first.
const FIRST_STRIDE: usize = 4;
/// Sketches with the same number of passes between them, before that number doubles.
const MOST_OF_A_STRIDE: usize = 24;
/// Bytes of sketches that may wait for the client.
const MOST_BYTES_WAITING: u64 = 64 << 20;

/// Makes sketches when passes run for the first time. The session stays on its way.
pub(super) struct Sketcher {
    gpu: Arc<Gpu>,
    stream: Stream,
    outbox: UnboundedSender<Update>,
    stride: usize,
    /// Sketches with this stride.
    taken: usize,
    waiting: Arc<()>,
}

impl Sketcher {
    /// `None` for a run without states. The client is not woken for a sketch.
    pub(super) fn new(gpu: &Arc<Gpu>, renderer: &Renderer, outbox: &UnboundedSender<Update>) -> Option<Self> {
        let plan = renderer.plan();
        let stream = plan.program.state_stream().filter(|stream| plan.streams.iter().any(|s| s.what == *stream))?;
        let (gpu, outbox) = (gpu.clone(), outbox.clone());
        Some(Self { gpu, stream, outbox, stride: FIRST_STRIDE, taken: 0, waiting: Arc::new(()) })
    }

    /// Sends sketches here from now on.
    pub(super) fn send_to(&mut self, outbox: &UnboundedSender<Update>) {
        self.outbox = outbox.clone();
    }

    /// The next place to sketch after this one.
    pub(super) fn after(&self, place: usize) -> usize {
        (place / self.stride + 1).saturating_mul(self.stride)
    }

    /// Makes a sketch if this is a place for one.
    pub(super) async fn take(&mut self, renderer: &Renderer) -> Result<(), RenderError> {
        let place = renderer.pass_count();
        if !place.is_multiple_of(self.stride) {
            return Ok(());
        }
        // Four bytes a tag, or a whole texel where states are drawn; from the CPU only tags of a thumbnail.
        let bytes = match (renderer.adapter(), &renderer.plan().drawn) {
            (None, _) => 4 * u64::from(SIDE * SIDE),
            (_, None) => 4 * renderer.plan().rays,
            (_, Some(_)) => TEXEL_BYTES * renderer.plan().rays,
        };
        let waiting = Arc::strong_count(&self.waiting).saturating_sub(1) as u64;
        if (waiting + 1).saturating_mul(bytes) > MOST_BYTES_WAITING {
            return Ok(());
        }
        let texture = match (renderer.texture(self.stream), renderer.adapter()) {
            (Some(texture), _) if renderer.plan().drawn.is_some() => copy_of(&self.gpu, "sketch", &texture),
            (Some(texture), _) => self.copy(&texture),
            (None, Some(_)) => return Ok(()),
            (None, None) => {
                let data = renderer.values(self.stream).await?;
                let ([width, height], tags) = thinned(data.layer(STATE_TAG), [data.width, data.height]);
                let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
                let texture = self.texture(size);
                self.gpu.write_texture(texture.as_image_copy(), size, bytemuck::cast_slice(&tags));
                texture
            }
        };
        // The client is gone: the engine's inbox ends next.
        let _ = self.outbox.unbounded_send(Update::Sketched(Sketch {
            stream: self.stream,
            place,
            texture,
            _waiting: self.waiting.clone(),
        }));
        self.taken += 1;
        if self.taken == MOST_OF_A_STRIDE {
            (self.stride, self.taken) = (self.stride.saturating_mul(2), MOST_OF_A_STRIDE / 2);
        }
        Ok(())
    }

    fn texture(&self, size: wgpu::Extent3d) -> StreamTexture {
        drawable(&self.gpu.device, "sketch", stream_format(self.stream), size)
    }

    /// The layer of tags, copied on the GPU after the passes before it.
    fn copy(&self, source: &StreamTexture) -> StreamTexture {
        let size = wgpu::Extent3d { depth_or_array_layers: 1, ..source.size() };
        let texture = self.texture(size);
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_texture(source.copy_at(0, 0, STATE_TAG as u32), texture.as_image_copy(), size);
        self.gpu.submit([encoder.finish()]);
        texture
    }
}

/// Every so many texels along both sides, for at most [`SIDE`] of them; and how many there are along each.
fn thinned(texels: &[u32], [width, height]: [u32; 2]) -> ([u32; 2], Vec<u32>) {
    let every = width.max(height).div_ceil(SIDE).max(1) as usize;
    let rows = texels.chunks_exact(width.max(1) as usize).step_by(every);
    let thin: Vec<u32> = rows.flat_map(|row| row.iter().step_by(every).copied()).collect();
    ([width, height].map(|side| side.div_ceil(every as u32)), thin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_side_has_more_texels_than_a_thumbnail_and_a_small_image_keeps_all() {
        let texels: Vec<u32> = (0..6).collect();
        assert_eq!(thinned(&texels, [3, 2]), ([3, 2], texels));
        for [width, height] in [[300, 7], [7, 300], [128, 129], [1, 1000]] {
            let texels: Vec<u32> = (0..width * height).collect();
            let ([columns, rows], thin) = thinned(&texels, [width, height]);
            assert!(columns.max(rows) <= SIDE && columns > 0 && rows > 0, "{width} × {height}: {columns} × {rows}");
            assert_eq!(thin.len() as u32, columns * rows);
            let every = width.max(height).div_ceil(SIDE);
            let last = (rows - 1) * every * width + (columns - 1) * every;
            assert_eq!((thin.first(), thin.last()), (Some(&0), Some(&last)), "{width} × {height}");
        }
    }
}
