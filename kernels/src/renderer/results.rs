//! Results of a run so far: the streams, and the image and hits that they contain.

use super::{RenderError, Renderer};
use crate::numbers::units::exp2;
use crate::program::Results;
use crate::renderer::image::Image;
use crate::tables::elements::Size;
use crate::tables::stream::{Region, Stream, StreamData};

/// A ray's hit, in scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// Parameter along the ray's direction as the caller gave it.
    pub t: f64,
    /// Weight of vertex 1.
    pub u: f32,
    /// Weight of vertex 2.
    pub v: f32,
    /// The triangle's id.
    pub triangle: u32,
}

impl Renderer {
    /// The streams that the results of rays are in.
    ///
    /// # Errors
    /// If the program traces no rays.
    pub fn results(&self) -> Result<Results, RenderError> {
        self.plan.program.results.ok_or(RenderError::NoRays(self.plan.program.name))
    }

    /// Where a stream is after the latest pass, if passes run on a GPU: in a 2D array with one layer per component; or, if
    /// they are drawn, in `rgba32uint` with a component in each, which may be another texture after the next pass.
    #[cfg(feature = "gpu")]
    #[must_use]
    pub fn texture(&self, stream: Stream) -> Option<crate::executor::gpu::StreamTexture> {
        use super::device::Executor;
        match &self.executor {
            Executor::Gpu(executor) => executor.texture(stream).cloned(),
            Executor::Fragment(executor) => {
                executor.texture(stream).cloned().map(crate::executor::gpu::StreamTexture::whole)
            }
            Executor::Cpu(_) | Executor::CpuF64(_) => None,
        }
    }

    /// The GPU that passes run on, if they do.
    #[cfg(feature = "gpu")]
    #[must_use]
    pub fn adapter(&self) -> Option<&std::sync::Arc<crate::Gpu>> {
        use super::device::Executor;
        match &self.executor {
            Executor::Gpu(executor) => Some(executor.gpu()),
            Executor::Fragment(executor) => Some(executor.gpu()),
            Executor::Cpu(_) | Executor::CpuF64(_) => None,
        }
    }

    /// A stream's values after the last pass.
    ///
    /// # Errors
    /// If the plan left it out, or the device fails.
    pub async fn values(&self, stream: Stream) -> Result<StreamData, RenderError> {
        let elements = stream.info().elements;
        if self.plan.has_stream(stream) && self.size(elements).is_none() {
            return Err(RenderError::NotCounted { stream: stream.name(), elements: elements.name });
        }
        self.executor.read(stream).await?.ok_or(RenderError::NoStream(stream.name()))
    }

    /// One ray's texel after the last pass, one word per layer.
    ///
    /// # Errors
    /// If the plan left the stream out, the image has no such pixel, or the device fails.
    pub async fn texel(&self, stream: Stream, x: u32, y: u32) -> Result<Vec<u32>, RenderError> {
        self.texels(&[stream], x, y).await?.pop().ok_or(RenderError::NoStream(stream.name()))
    }

    /// One ray's texels in several streams after the last pass, one word per layer, read with one submission and one
    /// read-back.
    ///
    /// # Errors
    /// If the plan left one of the streams out, the image has no such pixel, or the device fails.
    pub async fn texels(&self, streams: &[Stream], x: u32, y: u32) -> Result<Vec<Vec<u32>>, RenderError> {
        self.check_part(streams, Region { x, y, width: 1, height: 1 })?;
        let texels = self.executor.read_texels(streams, x, y).await?;
        texels.ok_or(RenderError::NoStream(streams.first().map_or("", |s| s.name())))
    }

    /// A region of a stream after the last pass.
    ///
    /// # Errors
    /// If the plan left it out, the image has no such region, or the device fails.
    pub async fn region(&self, stream: Stream, region: Region) -> Result<StreamData, RenderError> {
        self.check_part(&[stream], region)?;
        self.executor.read_region(stream, region).await?.ok_or(RenderError::NoStream(stream.name()))
    }

    pub(super) fn check_part(&self, streams: &[Stream], region: Region) -> Result<(), RenderError> {
        if let Some(missing) = streams.iter().find(|&&s| !self.plan.has_stream(s)) {
            return Err(RenderError::NoStream(missing.name()));
        }
        for &stream in streams {
            let elements = stream.info().elements;
            let not_counted = || RenderError::NotCounted { stream: stream.name(), elements: elements.name };
            let Size { width, height, .. } = self.size(elements).ok_or_else(not_counted)?;
            if !region.is_in(width, height) {
                return Err(RenderError::NoPixel { region, width, height });
            }
        }
        Ok(())
    }

    /// The image so far, linear; alpha is 1 if a ray hit something. With several samples per pixel, the mean over the
    /// complete samples, and the share of them that hit: for every pixel the same number of samples,
    /// [`samples`](Self::samples), between any two passes. Before the first sample is complete, all values are zero.
    ///
    /// # Errors
    /// If the run does not shade, or the device fails.
    pub async fn image(&self) -> Result<Image, RenderError> {
        let results = self.results()?;
        if self.plan.features.samples {
            let latest = self.values(results.mean).await?;
            let blocks = match self.plan.features.blocks {
                true => Some(self.values(results.blocks).await?),
                false => None,
            };
            return Ok(Image::from_means(&latest, blocks.as_ref(), self.samples()));
        }
        let color = self.values(results.color).await?;
        let hit = self.values(results.triangle.stream).await?;
        Ok(Image::from_streams(&color, hit.layer(results.triangle.layer)))
    }

    /// Factor from t of ray `index` (y * width + x) in a stream to t of the ray in scene units: the traced unit's size,
    /// and for an input ray also the power of two by which its direction was scaled.
    #[must_use]
    pub fn t_scale(&self, index: usize) -> f64 {
        let given = self.given.as_ref().and_then(|g| g.exponents.get(index));
        given.map_or_else(|| self.data.units.scene_units_per_stream_unit(), |&exponent| exp2(exponent))
    }

    /// The hits of all rays so far, in scene units; with several samples per pixel, of the latest sample.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn hits(&self) -> Result<Vec<Option<RayHit>>, RenderError> {
        let results = self.results()?;
        let hit = self.values(results.triangle.stream).await?;
        let t = self.values(results.t.stream).await?;
        let hit_of = |i: usize| {
            let (triangle, t) = results.hit(&t, &hit, i)?;
            let [u, v] = results.weights.map(|layer| hit.get_f32(layer, i));
            Some(RayHit { t: f64::from(t) * self.t_scale(i), u, v, triangle })
        };
        Ok((0..self.plan.rays as usize).map(hit_of).collect())
    }

    /// What the surfaces of hits reflect of red, green and blue light; 0 without a hit, and in a run that does not shade.
    ///
    /// # Errors
    /// If the program traces no rays.
    pub fn albedo(&self, hits: &[Option<RayHit>]) -> Result<Vec<[f32; 3]>, RenderError> {
        let albedo = self.results()?.albedo;
        let of = |hit: &Option<RayHit>| match hit {
            Some(hit) if !self.data.materials.is_empty() => albedo(&self.data, hit.triangle, [hit.u, hit.v]),
            _ => [0.0; 3],
        };
        Ok(hits.iter().map(of).collect())
    }
}
