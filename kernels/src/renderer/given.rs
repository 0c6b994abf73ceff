//! Input rays, as the streams that `generate` would have written.

use crate::numbers::parallel::{for_chunks, map_ranges};
use crate::options::Ray;
use crate::plan::Plan;
use crate::program::Results;
use crate::scene_data::{SceneData, traced_ray};
use crate::tables::stream::{STATE_TAG, Stream, StreamData};

/// Rays per task.
const RAYS_A_TASK: usize = 1 << 13;

/// Input rays as streams, and the exponent of each ray's t.
pub(super) struct GivenRays {
    pub(super) streams: Vec<StreamData>,
    pub(super) exponents: Vec<i32>,
}

impl GivenRays {
    /// The streams that a program is given without rays, if there are any.
    pub(super) fn inputs(data: &SceneData) -> Option<Self> {
        (!data.inputs.is_empty()).then(|| Self { streams: data.inputs.clone(), exponents: Vec::new() })
    }

    pub(super) fn new(rays: &[Ray], last: &[u32], results: &Results, plan: &Plan, data: &SceneData) -> Self {
        let texels = plan.width as usize * plan.height as usize;
        let rays = &rays[..rays.len().min(texels)];
        let traced = |range: std::ops::Range<usize>| rays[range].iter().map(|ray| traced_ray(ray, data.units));
        let traced = map_ranges(rays.len(), RAYS_A_TASK, |range| traced(range).collect::<Vec<_>>()).concat();
        let unwritten = |stream: Stream| StreamData {
            stream,
            width: plan.width,
            height: plan.height,
            bits: stream.info().unwritten.iter().flat_map(|&b| std::iter::repeat_n(b, texels)).collect(),
        };
        let fill = |stream: &mut StreamData, layer: usize, value: &(dyn Fn(&Ray) -> u32 + Sync)| {
            let layer = &mut stream.bits[layer * texels..][..traced.len()];
            for_chunks(layer, RAYS_A_TASK, |first, part| {
                for (to, (ray, _)) in part.iter_mut().zip(&traced[first..]) {
                    *to = value(ray);
                }
            });
        };
        let [mut origins, mut directions, mut states] =
            [results.origin, results.direction, results.t.stream].map(unwritten);
        for axis in 0..3 {
            fill(&mut origins, axis, &|ray| ray.origin[axis].to_bits());
            fill(&mut directions, axis, &|ray| ray.direction[axis].to_bits());
        }
        let born = plan.program.course().map_or(0, |course| course.born);
        fill(&mut states, STATE_TAG, &|_| born);
        if data.features.any_hit {
            // The first hit found before the ray's end is the result, so its t needs no place of its own.
            fill(&mut states, results.t.layer, &|ray| ray.t_max.to_bits());
        }
        let mut streams = vec![origins, directions, states];
        if data.features.intervals {
            let mut intervals = unwritten(results.interval);
            fill(&mut intervals, 0, &|ray| data.features.begin(ray).to_bits());
            fill(&mut intervals, 1, &|ray| ray.t_max.to_bits());
            streams.push(intervals);
        }
        if data.features.all_hits {
            let mut surfaces = unwritten(results.last);
            let count = last.len().min(texels);
            surfaces.bits[..count].copy_from_slice(&last[..count]);
            streams.push(surfaces);
        }
        Self { streams, exponents: traced.iter().map(|(_, exponent)| *exponent).collect() }
    }
}
