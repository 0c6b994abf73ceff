//! Twin of `count.wgsl`: the CPU executor counts tags as it goes, so there is nothing to do.

use crate::numbers::real::Real;
use crate::scene_data::SceneData;
use crate::tables::texels::Texels;

/// Leaves the ray as it is.
pub fn count<R: Real>(_: &mut Texels<'_, R>, _: &SceneData) {}
