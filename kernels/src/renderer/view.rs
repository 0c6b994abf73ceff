//! Other views of the same scene, without building or compiling anything again.

use std::sync::Arc;

use raystep_scenes::Scene;

use super::{Device, RenderError, Renderer};
use crate::options::samples::Samples;
use crate::options::{Options, RaySource};
use crate::shared::samples::Sampling;

impl Renderer {
    /// Replaces the camera, and returns to before the first pass. `options` are those of this run with another camera
    /// for an image of the same size. Returns whether it did: a camera of another kind, inside the scene rather than
    /// outside, or much farther away needs a new run.
    ///
    /// # Errors
    /// If the camera cannot generate rays.
    pub fn look(&mut self, scene: &Scene, options: &Options) -> Result<bool, RenderError> {
        let size = (self.plan.width, self.plan.height);
        let is_alike = matches!(options.rays, RaySource::Camera { width, height, .. } if (width, height) == size);
        if !is_alike || self.given.is_some() || !self.plan.serves(&self.data, scene, options)? {
            return Ok(false);
        }
        Arc::make_mut(&mut self.data).set_view(scene, options);
        self.executor.set_view(&self.data);
        self.restart();
        Ok(true)
    }

    /// A run at its start with the same structure and kernels, for another camera or image size. `options` are those of
    /// this run with other rays. `None` where [`look`](Self::look) would return false.
    ///
    /// # Errors
    /// If the camera cannot generate rays, the image does not fit the device, or the device fails.
    pub async fn viewed(&self, scene: &Scene, options: &Options, device: &Device) -> Result<Option<Self>, RenderError> {
        if self.given.is_some() || !self.plan.serves(&self.data, scene, options)? {
            return Ok(None);
        }
        let plan = self.plan.resized(&self.data, options, &device.limits())?;
        let mut data = self.data.clone();
        Arc::make_mut(&mut data).set_view(scene, options);
        Self::start(Arc::new(plan), data, options, device, Some(&self.executor)).await.map(Some)
    }

    /// Replaces which samples the run takes, and returns to before the first pass: another block of a picture, see
    /// [`Samples::part`]. Returns whether it did: not if the run's kernels are those of one sample in the centre, or of
    /// fewer blocks.
    pub fn take_samples(&mut self, samples: Samples) -> bool {
        let features = self.plan.features;
        let fits = features.samples
            && samples.are_spread()
            && features.sampler() == samples.sampler
            && features.blocks == (samples.count > Samples::BLOCK);
        if fits {
            let Samples { count: samples, seed, first, .. } = samples;
            Arc::make_mut(&mut self.data).sampling = Sampling { samples, seed, first };
            self.executor.set_view(&self.data);
            self.restart();
        }
        fits
    }
}
