//! Input rays, as the streams that `generate` would have written.

use crate::options::Ray;
use crate::plan::Plan;
use crate::program::Results;
use crate::scene_data::{SceneData, traced_ray};
use crate::tables::stream::{Stream, StreamData};

/// Input rays as streams, and the exponent of each ray's t.
pub(super) struct GivenRays {
    pub(super) streams: Vec<StreamData>,
    pub(super) exponents: Vec<i32>,
}

impl GivenRays {
    pub(super) fn new(rays: &[Ray], results: &Results, plan: &Plan, data: &SceneData) -> Self {
        let texels = plan.width as usize * plan.height as usize;
        let unwritten = |stream: Stream| StreamData {
            stream,
            width: plan.width,
            height: plan.height,
            bits: stream.info().unwritten.iter().flat_map(|&b| std::iter::repeat_n(b, texels)).collect(),
        };
        let [mut origins, mut directions, mut states] =
            [results.origin, results.direction, results.t.stream].map(unwritten);
        let mut intervals = data.features.intervals.then(|| unwritten(results.interval));
        let any_hit = data.features.any_hit;
        let mut exponents = Vec::with_capacity(rays.len());
        for (i, ray) in rays.iter().take(texels).enumerate() {
            let (ray, exponent) = traced_ray(ray, data.units);
            for axis in 0..3 {
                origins.bits[axis * texels + i] = ray.origin[axis].to_bits();
                directions.bits[axis * texels + i] = ray.direction[axis].to_bits();
            }
            if let Some(intervals) = &mut intervals {
                intervals.bits[i] = ray.t_min.to_bits();
                intervals.bits[texels + i] = ray.t_max.to_bits();
            }
            states.bits[i] = plan.program.course.map_or(0, |course| course.born);
            if any_hit {
                // The first hit found before the ray's end is the result, so its t needs no place of its own.
                states.bits[results.t.layer * texels + i] = ray.t_max.to_bits();
            }
            exponents.push(exponent);
        }
        Self { streams: [origins, directions, states].into_iter().chain(intervals).collect(), exponents }
    }
}
