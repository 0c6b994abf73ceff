//! Input rays, as the streams that `generate` would have written.

use crate::numbers::units::exp2;
use crate::options::Ray;
use crate::plan::Plan;
use crate::program::Results;
use crate::scene_data::{SceneData, traced_ray};
use crate::shared::constants::INF;
use crate::tables::stream::{Stream, StreamData};

/// Input rays as streams, and the exponent of each ray's t.
pub(super) struct GivenRays {
    pub(super) streams: [StreamData; 3],
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
        let mut streams = [results.origin, results.direction, results.t.stream].map(unwritten);
        let any_hit = data.features.any_hit;
        let mut exponents = Vec::with_capacity(rays.len());
        for (i, ray) in rays.iter().take(texels).enumerate() {
            let (ray, exponent) = traced_ray(ray, data.units);
            for axis in 0..3 {
                streams[0].bits[axis * texels + i] = ray.origin[axis].to_bits();
                streams[1].bits[axis * texels + i] = ray.direction[axis].to_bits();
            }
            streams[2].bits[i] = plan.program.course.map_or(0, |course| course.born);
            if any_hit {
                // Hits beyond the ray's end at t = 1 do not count.
                streams[2].bits[results.t.layer * texels + i] = (exp2(-exponent) as f32).min(INF).to_bits();
            }
            exponents.push(exponent);
        }
        Self { streams, exponents }
    }
}
