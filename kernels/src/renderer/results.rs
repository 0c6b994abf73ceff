//! What a run has found so far: streams as they are, and the image and hits that are in them.

use super::{Executor, RenderError, Renderer};
use crate::image::Image;
use crate::shared::constants::{INF, NO_TRIANGLE};
use crate::stream::{HIT_TRIANGLE, STATE_T, Stream, StreamData};
use crate::units::exp2;

/// What one ray hit, in scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// Parameter along the ray's direction as it was given.
    pub t: f64,
    /// Weight of vertex 1.
    pub u: f32,
    /// Weight of vertex 2.
    pub v: f32,
    /// The triangle's id.
    pub triangle: u32,
}

impl Renderer {
    /// A stream's own texture, where passes run on a GPU.
    #[must_use]
    pub fn texture(&self, stream: Stream) -> Option<&wgpu::Texture> {
        self.gpu()?.texture(stream)
    }

    /// A stream's values after the last pass.
    ///
    /// # Errors
    /// Where the plan left it out, or the device fails.
    pub async fn values(&self, stream: Stream) -> Result<StreamData, RenderError> {
        let data = match &self.executor {
            Executor::Gpu(e) => e.read(stream).await?,
            Executor::Cpu(e) => e.read(stream),
            Executor::CpuF64(e) => e.read(stream),
        };
        data.ok_or(RenderError::NoStream(stream.name()))
    }

    /// One ray's texel after the last pass, one word a layer.
    ///
    /// # Errors
    /// Where the plan left the stream out, the image has no such pixel, or the device fails.
    pub async fn texel(&self, stream: Stream, x: u32, y: u32) -> Result<Vec<u32>, RenderError> {
        let texel = match &self.executor {
            Executor::Gpu(e) => e.read_texel(stream, x, y).await?,
            Executor::Cpu(e) => e.read_texel(stream, x, y),
            Executor::CpuF64(e) => e.read_texel(stream, x, y),
        };
        texel.ok_or(RenderError::NoStream(stream.name()))
    }

    /// The image so far, linear; alpha is 1 where a ray hit something.
    ///
    /// # Errors
    /// Where the run does not shade, or the device fails.
    pub async fn image(&self) -> Result<Image, RenderError> {
        let color = self.values(Stream::Color).await?;
        let hit = self.values(Stream::Hit).await?;
        Ok(Image::from_streams(&color, &hit))
    }

    /// What t of ray `index` (y * width + x) in a stream is to be multiplied by to get the t of the ray in
    /// scene units: the traced unit's size, and for a given ray also the power of two that its direction
    /// was scaled by.
    #[must_use]
    pub fn t_scale(&self, index: usize) -> f64 {
        let given = self.given.as_ref().and_then(|g| g.exponents.get(index));
        given.map_or_else(|| self.data.units.scene_units_per_stream_unit(), |&exponent| exp2(exponent))
    }

    /// What every ray hit so far, in scene units.
    ///
    /// # Errors
    /// Where the device fails.
    pub async fn hits(&self) -> Result<Vec<Option<RayHit>>, RenderError> {
        let hit = self.values(Stream::Hit).await?;
        let state = self.values(Stream::State).await?;
        let hit_of = |i: usize| {
            let (t, triangle) = (state.get_f32(STATE_T, i), hit.get(HIT_TRIANGLE, i));
            let scale = self.t_scale(i);
            (triangle != NO_TRIANGLE && t < INF).then(|| RayHit {
                t: f64::from(t) * scale,
                u: hit.get_f32(0, i),
                v: hit.get_f32(1, i),
                triangle,
            })
        };
        Ok((0..self.plan.rays as usize).map(hit_of).collect())
    }
}
