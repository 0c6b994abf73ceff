//! Texels of a copied stream around the cursor, read when they are needed.

use std::sync::Arc;

use raystep_kernels::executor::gpu::{StreamTexture, stream_format};
use raystep_kernels::{Gpu, Stream};

use crate::session::request::{Job, Request, answered, job};
use crate::session::{Model, Pinned};

/// The engine's job, named while it runs.
const READING: &str = "reading a copy of a stream";
/// Texels along a side of a tile.
const SIDE: u32 = 64;

/// A tile's copy and its place in it, in tiles.
type Key = (StreamTexture, [u32; 2]);

/// A tile's texels.
struct Tile {
    key: Key,
    width: u32,
    height: u32,
    /// Layers in order, rows from the top.
    bits: Vec<u32>,
}

/// The tile under the cursor.
#[derive(Default)]
pub(super) struct Tiles {
    tile: Option<Tile>,
    asked: Option<Key>,
}

impl Tiles {
    /// The texel's components, once they have been read.
    pub(super) fn texel(
        &mut self,
        model: &mut Model,
        gpu: &Arc<Gpu>,
        pinned: &Pinned,
        [x, y]: [u32; 2],
    ) -> Option<Vec<u32>> {
        let key = (pinned.texture.clone(), [x / SIDE, y / SIDE]);
        if let Some(tile) = model.take_answer::<Tile>(READING) {
            if self.asked.as_ref() == Some(&tile.key) {
                self.tile = Some(*tile);
            } else if tile.key.0 != pinned.texture {
                // Another view's.
                model.answers.push((READING, tile));
            }
        }
        let [column, row] = [x % SIDE, y % SIDE];
        if let Some(tile) = self.tile.as_ref().filter(|tile| tile.key == key) {
            let layer = (tile.width * tile.height) as usize;
            let at = (row * tile.width + column) as usize;
            return (0..pinned.stream.layers()).map(|i| tile.bits.get(i * layer + at).copied()).collect();
        }
        // At most one request at a time.
        if self.asked.as_ref() != Some(&key) && !model.is_busy() {
            let is_asked = model.ask(Request::Job(READING, read(gpu.clone(), pinned.stream, key.clone())));
            self.asked = is_asked.then_some(key);
        }
        None
    }
}

/// Reads a tile: its layers are copied below one another into a small texture.
fn read(gpu: Arc<Gpu>, stream: Stream, key: Key) -> Job {
    job!(_, {
        let (texture, [x, y]) = &key;
        let [x, y] = [x * SIDE, y * SIDE];
        let width = texture.width().saturating_sub(x).min(SIDE);
        let height = texture.height().saturating_sub(y).min(SIDE);
        if width == 0 || height == 0 {
            return Err("the copy has no such texel".into());
        }
        let layers = stream.layers() as u32;
        let small = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("tile of a stream"),
            size: wgpu::Extent3d { width, height: height * layers, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: stream_format(stream),
            usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        for z in 0..layers {
            let to = wgpu::Origin3d { x: 0, y: z * height, z: 0 };
            encoder.copy_texture_to_texture(
                texture.copy_at(x, y, z),
                wgpu::TexelCopyTextureInfo { origin: to, ..small.as_image_copy() },
                wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            );
        }
        gpu.submit([encoder.finish()]);
        // Components of all streams have four bytes.
        let bytes = gpu.read_rgba8(&small).await.map_err(|e| e.to_string())?;
        let word = |bytes: &[u8]| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        let bits = bytes.chunks_exact(4).map(word).collect();
        answered(Tile { key, width, height, bits })
    })
}
