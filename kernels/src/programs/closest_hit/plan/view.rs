//! A plan for another camera or image size, through the same structure.

use raystep_scenes::Scene;

use super::features::features;
use crate::options::{Options, RaySource};
use crate::plan::allocated::Allocated;
use crate::plan::{Limits, Plan, PlanError, bound_by, check_buffer, check_rays, image_size};
use crate::program::live::{LIVE_RAYS, live_bytes};
use crate::scene_data::{SceneData, origins};
use crate::structures::grid;
use crate::tables::elements::Size;

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
        let (width, height, rays) = image_size(options, limits)?;
        let size = Size { width, height, count: rays as u32 };
        if self.features.live_lists {
            check_buffer(LIVE_RAYS, live_bytes(self.program, size.texels()), limits)?;
        }
        let bound = bound_by(&self.variants);
        let Allocated { sets, streams, buffers } =
            Allocated::new(self.program, &bound, data, size, false, limits, self.drawn.as_ref())?;
        Ok(Self { sets, streams, buffers, width, height, rays, ..self.clone() })
    }
}
