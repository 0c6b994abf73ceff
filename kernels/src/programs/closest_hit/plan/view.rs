//! A plan for another camera or image size, through the same structure.

use raystep_scenes::Scene;

use super::features::features;
use crate::options::{Options, RaySource};
use crate::plan::{Limits, Plan, PlanError, check_rays, image_size};
use crate::scene_data::{SceneData, origins};
use crate::structures::grid;

impl Plan {
    /// Whether the data of this plan serves another camera too, given options that differ only in their rays. A camera
    /// that is much farther away requires larger cells or boxes, and one inside the scene needs no clipping.
    ///
    /// # Errors
    /// If the camera cannot generate rays.
    pub(crate) fn serves(&self, data: &SceneData, scene: &Scene, options: &Options) -> Result<bool, PlanError> {
        let (RaySource::Camera { .. }, true) = (&options.rays, self.program.course().is_some()) else {
            return Ok(false);
        };
        check_rays(options, data.units)?;
        let now = features(scene, options, self.accelerator, data.units);
        let planned = &self.features;
        let is_alike = (now.clip || planned.aside, now.perspective, now.intervals, now.eye_rays)
            == (planned.clip, planned.perspective, planned.intervals, planned.eye_rays);
        let reach = grid::reach(data.bounds, origins(options, data.units));
        let is_grown = planned.grid || planned.irregular || planned.bvh && !planned.ray_padding;
        Ok(is_alike && data.camera.pixel_x > 0.0 && (!is_grown || reach == data.reach))
    }

    /// The same plan for an image of another size.
    ///
    /// # Errors
    /// If it does not fit `limits`.
    pub(crate) fn resized(&self, data: &SceneData, options: &Options, limits: &Limits) -> Result<Self, PlanError> {
        self.sized(image_size(options, limits)?, false, data, limits)
    }
}
