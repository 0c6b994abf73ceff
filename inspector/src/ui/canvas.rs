//! Pictures drawn on the GPU and shown by egui.

use crate::exports::Export;
use crate::session::request::{Job, answered, job};
use std::collections::BTreeSet;
use std::sync::Arc;

use egui::mutex::{Mutex, RwLock};
use egui::{Color32, Pos2, Rect, Ui, pos2};
use raystep_kernels::executor::gpu::StreamTexture;
use raystep_kernels::{Gpu, Stream};

use crate::draw::picture::picture;
use crate::draw::stream::StreamPainter;

/// Draws pictures and makes them available to egui.
pub struct Canvas {
    /// The device.
    pub gpu: Arc<Gpu>,
    /// egui's own renderer.
    pub renderer: Arc<RwLock<egui_wgpu::Renderer>>,
    /// Draws streams.
    pub streams: StreamPainter,
    /// The pictures that were drawn again since someone asked.
    redrawn: Mutex<BTreeSet<egui::TextureId>>,
}

impl Canvas {
    /// A canvas on this device, for this egui renderer.
    #[must_use]
    pub fn new(gpu: Arc<Gpu>, renderer: Arc<RwLock<egui_wgpu::Renderer>>) -> Self {
        let streams = StreamPainter::new(&gpu.device, &gpu.queue);
        Self { gpu, renderer, streams, redrawn: Mutex::default() }
    }

    /// The pictures that were drawn again since this was last asked: what egui draws of them differs, though their
    /// names are the same.
    #[must_use]
    pub fn take_redrawn(&self) -> BTreeSet<egui::TextureId> {
        std::mem::take(&mut *self.redrawn.lock())
    }

    /// The largest side of a picture.
    #[must_use]
    pub fn most_side(&self) -> u32 {
        self.gpu.device.limits().max_texture_dimension_2d
    }
}

/// A picture of a certain size, kept between frames.
#[derive(Default)]
pub struct Picture {
    kept: Option<Kept>,
}

struct Kept {
    canvas: Arc<Canvas>,
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    id: egui::TextureId,
}

/// All of a texture, in its own coordinates.
pub const WHOLE: Rect = Rect { min: Pos2::ZERO, max: pos2(1.0, 1.0) };

impl Picture {
    /// The pixels of a rectangle on the screen.
    #[must_use]
    pub fn pixels(ui: &Ui, rect: Rect) -> [u32; 2] {
        [rect.width(), rect.height()].map(|side| (side * ui.pixels_per_point()).round().max(1.0) as u32)
    }

    /// Shows it, once it was drawn.
    pub fn show(&self, ui: &Ui, rect: Rect) {
        if let Some(id) = self.id() {
            ui.painter().image(id, rect, WHOLE, Color32::WHITE);
        }
    }

    /// The view to draw into, of exactly this many pixels, if it is to show something else than before, or is new and
    /// thus empty.
    pub fn target(&mut self, canvas: &Arc<Canvas>, size: [u32; 2], is_changed: bool) -> Option<&wgpu::TextureView> {
        let [width, height] = size.map(|side| side.clamp(1, canvas.most_side()));
        let fits = self.kept.as_ref().is_some_and(|k| (k.texture.width(), k.texture.height()) == (width, height));
        if !fits {
            self.kept = None;
        }
        let kept = self.kept.get_or_insert_with(|| Kept::new(canvas, width, height));
        (is_changed || !fits).then(|| {
            canvas.redrawn.lock().insert(kept.id);
            &kept.view
        })
    }

    /// The name by which egui shows it; `None` before it was drawn.
    #[must_use]
    pub fn id(&self) -> Option<egui::TextureId> {
        self.kept.as_ref().map(|k| k.id)
    }

    /// The texture, for reading it back.
    #[must_use]
    pub fn texture(&self) -> Option<&wgpu::Texture> {
        self.kept.as_ref().map(|k| &k.texture)
    }
}

impl Kept {
    fn new(canvas: &Arc<Canvas>, width: u32, height: u32) -> Self {
        let texture = picture(&canvas.gpu.device, [width, height]);
        let view = texture.create_view(&Default::default());
        let id = canvas.renderer.write().register_native_texture(&canvas.gpu.device, &view, wgpu::FilterMode::Nearest);
        Self { canvas: canvas.clone(), texture, view, id }
    }
}

impl Drop for Kept {
    fn drop(&mut self) {
        self.canvas.redrawn.lock().remove(&self.id);
        self.canvas.renderer.write().free_texture(&self.id);
    }
}

/// Which run, and after how many passes.
pub type Moment = (u64, usize);

/// A snapshot of a stream, which can be drawn at any zoom while the run goes elsewhere.
#[derive(Default)]
pub struct Still {
    kept: Option<(Moment, Stream, StreamTexture)>,
}

impl Still {
    /// Copies a stream's texture, unless there is a copy of this moment already.
    pub fn take(&mut self, canvas: &Canvas, moment: Moment, stream: Stream, source: &StreamTexture) {
        if self.kept.as_ref().is_some_and(|(m, s, _)| (*m, *s) == (moment, stream)) {
            return;
        }
        let fits = |t: &StreamTexture| (t.size(), t.format()) == (source.size(), source.format());
        let old = self.kept.take().map(|(.., texture)| texture).filter(fits);
        let texture = old.unwrap_or_else(|| {
            StreamTexture::whole(canvas.gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("stream snapshot"),
                size: source.size(),
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: source.format(),
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            }))
        });
        let mut encoder = canvas.gpu.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_texture(source.as_image_copy(), texture.as_image_copy(), source.size());
        canvas.gpu.submit([encoder.finish()]);
        self.kept = Some((moment, stream, texture));
    }

    /// The copy of a stream, and the moment it was taken.
    #[must_use]
    pub fn of(&self, stream: Stream) -> Option<(Moment, &StreamTexture)> {
        self.kept.as_ref().filter(|(_, s, _)| *s == stream).map(|(moment, _, texture)| (*moment, texture))
    }
}

/// Reads an image back, and writes it as PNG.
pub(super) fn png(canvas: &Canvas, texture: &wgpu::Texture, name: String) -> Job {
    let (gpu, texture) = (canvas.gpu.clone(), texture.clone());
    job!(_, {
        let texels = gpu.read_rgba8(&texture).await.map_err(|e| e.to_string())?;
        let image = image::RgbaImage::from_raw(texture.width(), texture.height(), texels);
        let image = image.ok_or("the image was returned in another size")?;
        let mut bytes = Vec::new();
        let encoder = image::codecs::png::PngEncoder::new(&mut bytes);
        image.write_with_encoder(encoder).map_err(|e| e.to_string())?;
        let holds = format!("an image of {} x {} pixels", texture.width(), texture.height());
        let export = Export { name: name.replace(' ', "-"), extension: "png", bytes, holds };
        answered(export)
    })
}
