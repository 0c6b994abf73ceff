//! A plan once more, for other rays through the same structure.

use super::allocated::{Allocated, live_texels, sets_of};
use super::check::{check_buffer, given_size};
use super::{Limits, Plan, PlanError, bound_by, fit_bindings, variants};
use crate::program::live::{LIVE_RAYS, live_bytes};
use crate::scene_data::SceneData;
use crate::tables::elements::Size;

impl Plan {
    /// The plan of a run of input rays for another number of them.
    ///
    /// # Errors
    /// If they do not fit `limits`.
    pub(crate) fn for_rays(&self, rays: u64, data: &SceneData, limits: &Limits) -> Result<Self, PlanError> {
        let (width, height) = given_size(rays, limits)?;
        self.sized((width, height, rays), true, data, limits)
    }

    /// The same plan for another number of rays, which fill a texture of this width and height and are given by the caller
    /// or not.
    ///
    /// # Errors
    /// If they do not fit `limits`.
    pub(crate) fn sized(
        &self,
        (width, height, rays): (u32, u32, u64),
        given: bool,
        data: &SceneData,
        limits: &Limits,
    ) -> Result<Self, PlanError> {
        let size = Size { width, height, count: rays as u32 };
        let others: Vec<_> = self.sets.iter().filter_map(|set| Some((set.what, set.size?))).collect();
        let sets = sets_of(self.program, size, &others, limits.image_side)?;
        if self.features.live_lists {
            check_buffer(LIVE_RAYS, live_bytes(self.program, live_texels(self.program, &sets)), limits)?;
        }
        let sharing =
            fit_bindings(self.program, &self.variants, self.drawn.as_ref(), self.features.scene_data, limits)?;
        let bound = bound_by(&self.variants);
        let Allocated { sets, streams, buffers } =
            Allocated::new(self.program, sets, &bound, data, given, limits, self.drawn.as_ref())?;
        Ok(Self { sets, sharing, streams, buffers, width, height, rays, ..self.clone() })
    }

    /// Makes the kernels read the intervals of rays, from now on. [`for_rays`](Self::for_rays) allocates them.
    ///
    /// # Errors
    /// If a kernel is invalid, which is a bug.
    pub(crate) fn read_intervals(&mut self, data: &mut SceneData) -> Result<(), PlanError> {
        self.features.intervals = true;
        data.features.intervals = true;
        self.variants = variants(self.program, &self.schedule, &self.features, &self.replaced())?;
        self.left_out.retain(|item| item.what != "stream ray_interval");
        Ok(())
    }
}
