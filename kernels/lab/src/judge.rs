//! Judges the hits of a run: compares what its rays hit with f64 and exact predicates ([`crate::reference`]).
//!
//! [`check_rays`] judges every ray and keeps nothing. For many runs of the same rays, a [`Judge`] computes the correct
//! hits of a [`sample`] once and keeps them for later runs.
//!
//! What is judged is what the executor computed. The f64 twins ([`Device::CpuF64`](raystep_kernels::Device::CpuF64))
//! are judged by their own t, before a stream rounds it to f32: a correct f64 hit does not become wrong by being
//! stored.

mod passes;
mod report;

use std::ops::ControlFlow;
use std::sync::Arc;

use raystep_kernels::numbers::parallel::map_ranges;
use raystep_kernels::program::Results;
use raystep_kernels::renderer::{RenderError, Renderer};
use raystep_kernels::tables::stream::{Component, STATE_TAG, StreamData};

use crate::Hash;
use crate::portions::map_in_portions;
use crate::rays::Random;
use crate::reference::{Candidates, Mistake, Tree, Triangles};
pub use passes::{Judgement, WrongRay, judge_passes, why_not};
pub use report::Report;

/// How many rays to judge between two progress reports.
pub const RAYS_A_BATCH: usize = 1 << 12;

/// Fewest rays of a sample.
const FEWEST_RAYS: usize = 64;

/// The rays of a run and their hits so far.
pub struct Traced<'a> {
    renderer: &'a Renderer,
    results: Results,
    /// Origins, directions, states and hits from the run's streams; texels beyond the last ray are unused.
    pub streams: [StreamData; 4],
    /// The t between which each ray's hits count, if the run's rays have intervals.
    intervals: Option<StreamData>,
}

/// A hit, in the executor's precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The triangle's id.
    pub triangle: u32,
    /// t along the ray, in traced units.
    pub t: f64,
    /// Weight of vertex 1.
    pub u: f64,
    /// Weight of vertex 2.
    pub v: f64,
}

impl<'a> Traced<'a> {
    /// Reads a run's streams.
    ///
    /// # Errors
    /// If the plan omits one of them, or the device fails.
    pub async fn read(renderer: &'a Renderer) -> Result<Self, RenderError> {
        let results = renderer.results()?;
        let streams = [
            renderer.values(results.origin).await?,
            renderer.values(results.direction).await?,
            renderer.values(results.t.stream).await?,
            renderer.values(results.triangle.stream).await?,
        ];
        let has_intervals = renderer.plan().has_stream(results.interval);
        let intervals = if has_intervals { Some(renderer.values(results.interval).await?) } else { None };
        Ok(Self { renderer, results, streams, intervals })
    }

    /// The number of rays.
    #[must_use]
    pub fn rays(&self) -> usize {
        self.renderer.plan().rays as usize
    }

    /// The triangles they were traced against, nine floats each.
    #[must_use]
    pub fn vertices(&self) -> &'a [f32] {
        &self.renderer.data().vertices
    }

    /// A ray's origin and direction, in traced units.
    #[must_use]
    pub fn ray(&self, ray: usize) -> [[f32; 3]; 2] {
        self.bits(ray).map(|v| v.map(f32::from_bits))
    }

    /// The t between which a ray's hits count, in traced units; `None` if no ray of the run has an interval.
    #[must_use]
    pub fn interval(&self, ray: usize) -> Option<[f32; 2]> {
        self.intervals.as_ref().map(|s| [0, 1].map(|layer| s.get_f32(layer, ray)))
    }

    /// What a ray may hit.
    fn candidates(&self, triangles: &Triangles<'_>, ray: usize) -> Candidates {
        let [origin, direction] = self.ray(ray);
        within(triangles.candidates(origin, direction), self.interval(ray))
    }

    fn bits(&self, ray: usize) -> [[u32; 3]; 2] {
        [&self.streams[0], &self.streams[1]].map(|s| [0, 1, 2].map(|layer| s.get(layer, ray)))
    }

    /// What a ray hit. Values of the f64 twins are taken before rounding.
    #[must_use]
    pub fn hit(&self, ray: usize) -> Option<Hit> {
        let [_, _, state, hit] = &self.streams;
        let (triangle, t) = self.results.hit(state, hit, ray)?;
        let exact = |Component { stream, layer }: Component, rounded: f32| {
            let wide = self.renderer.cpu_f64().and_then(|e| e.component(stream, layer, ray));
            wide.unwrap_or(f64::from(rounded))
        };
        let weight = |layer| exact(Component { stream: hit.stream, layer }, hit.get_f32(layer, ray));
        let [u, v] = self.results.weights.map(weight);
        Some(Hit { triangle, t: exact(self.results.t, t), u, v })
    }

    /// Whether a ray's hit, or lack of one, is final.
    #[must_use]
    pub fn is_decided(&self, ray: usize) -> bool {
        self.renderer.plan().program.states.is_decided(self.streams[2].get(STATE_TAG, ray))
    }
}

/// Judges every ray of a run. `progress` gets the rays done and their total, and may stop.
pub fn check_rays(traced: &Traced<'_>, mut progress: impl FnMut(u64, u64) -> ControlFlow<()>) -> Report {
    let triangles = Triangles::new(traced.vertices());
    let (rays, mut report) = (traced.rays(), Report::default());
    for first in (0..rays).step_by(RAYS_A_BATCH) {
        let count = RAYS_A_BATCH.min(rays - first);
        let parts = map_ranges(count, 64, |range| {
            let mut part = Report::default();
            for i in range {
                let (mistake, t_ulp) = judge(&triangles, traced, first + i);
                part.add(mistake, t_ulp);
            }
            part
        });
        parts.into_iter().for_each(|part| report.merge(part));
        if progress((first + count) as u64, rays as u64).is_break() {
            report.is_partial = first + count < rays;
            break;
        }
    }
    report
}

/// The verdict on a ray, and the error of its t, see [`Candidates::judge`].
fn judge(triangles: &Triangles<'_>, traced: &Traced<'_>, ray: usize) -> (Mistake, f64) {
    let [origin, direction] = traced.ray(ray);
    let found = traced.hit(ray).map(|hit| (hit.triangle, hit.t));
    triangles.judge(ray, origin, direction, &traced.candidates(triangles, ray), found)
}

/// What is left within a ray's interval, if it has one.
fn within(candidates: Candidates, interval: Option<[f32; 2]>) -> Candidates {
    match interval {
        Some(interval) => candidates.within(interval.map(f64::from)),
        None => candidates,
    }
}

/// How many of a run's rays can be judged with this much work: boxes, spheres and triangles that the judge looks at, by
/// the time they take. Estimated from a few rays, by counting: the same on every machine.
#[must_use]
pub fn affordable(triangles: &Triangles<'_>, traced: &Traced<'_>, work: u64, seed: u32) -> usize {
    let tried = sample(traced.rays(), FEWEST_RAYS, seed);
    let work_of = |&ray: &usize| {
        let [origin, direction] = traced.ray(ray);
        triangles.work(origin, direction)
    };
    let a_ray = tried.iter().map(work_of).sum::<u64>() / tried.len().max(1) as u64;
    ((work / a_ray.max(1)) as usize).max(FEWEST_RAYS)
}

/// Indices of `count` of `rays` rays, ascending: one random ray from each of `count` intervals of equal length. All
/// rays if there are no more than `count`.
#[must_use]
pub fn sample(rays: usize, count: usize, seed: u32) -> Vec<usize> {
    if count >= rays {
        return (0..rays).collect();
    }
    let begin = |i: usize| (i as u64 * rays as u64 / count as u64) as usize;
    let one = |i: usize| begin(i) + Random::of(i as u32, seed).below(begin(i + 1) - begin(i));
    (0..count).map(one).collect()
}

/// How to judge a ray that passes between two triangles of a continuous surface: f32 cannot tell which of them it hits,
/// but it must hit one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cracks {
    /// It passed through a crack, and counts as missed.
    Missed,
    /// Missing either triangle is allowed: a tie.
    Tied,
}

/// The possible hits of a sample of rays: computed for the first run, and kept for runs that trace the same rays
/// through the same triangles.
#[derive(Clone, Debug, Default)]
pub struct Judge {
    /// Hash of the triangles' vertices.
    scene: Hash,
    tree: Arc<Tree>,
    sample: Vec<usize>,
    /// Origins and directions, as bits.
    rays: Vec<[[u32; 3]; 2]>,
    /// The t between which hits count, as bits.
    intervals: Vec<Option<[u32; 2]>>,
    candidates: Vec<Candidates>,
}

/// The verdict on one ray.
#[derive(Clone, Copy, Debug)]
pub struct Judged<'a> {
    /// What it hit.
    pub hit: Option<Hit>,
    /// The triangles it may hit.
    pub candidates: &'a Candidates,
    /// The verdict, with the exact hit.
    pub mistake: Mistake,
}

impl Judge {
    /// The triangles of a run, with the hierarchy of the last run if it is for them.
    fn triangles<'t>(&mut self, traced: &Traced<'t>) -> Triangles<'t> {
        let scene = Hash::of_floats(traced.vertices());
        if scene != self.scene {
            *self = Self { scene, tree: Triangles::new(traced.vertices()).tree(), ..Self::default() };
        }
        self.triangles_of(traced)
    }

    /// The same after [`prepare`](Self::prepare).
    fn triangles_of<'t>(&self, traced: &Traced<'t>) -> Triangles<'t> {
        Triangles::with(traced.vertices(), self.tree.clone())
    }

    /// How many of a run's rays can be judged with this much work, see [`affordable`].
    pub fn affordable(&mut self, traced: &Traced<'_>, work: u64, seed: u32) -> usize {
        affordable(&self.triangles(traced), traced, work, seed)
    }

    /// Computes what each ray of a sample may hit, unless rays and triangles are the same as before. Lets other tasks run
    /// every few milliseconds.
    pub async fn prepare(&mut self, traced: &Traced<'_>, sample: Vec<usize>) {
        let triangles = self.triangles(traced);
        let rays: Vec<_> = sample.iter().map(|&ray| traced.bits(ray)).collect();
        let intervals: Vec<_> = sample.iter().map(|&ray| traced.interval(ray).map(|t| t.map(f32::to_bits))).collect();
        if (&self.rays, &self.intervals, &self.sample) == (&rays, &intervals, &sample) {
            return;
        }
        self.candidates = map_in_portions(sample.len(), |i| traced.candidates(&triangles, sample[i]).near()).await;
        (self.sample, self.rays, self.intervals) = (sample, rays, intervals);
    }

    /// The rays that are judged, ascending.
    #[must_use]
    pub fn sample(&self) -> &[usize] {
        &self.sample
    }

    /// The possible hits of each of them.
    #[must_use]
    pub fn candidates(&self) -> &[Candidates] {
        &self.candidates
    }

    /// Origin and direction of a ray of the sample, in traced units.
    #[must_use]
    pub fn ray(&self, place: usize) -> [[f32; 3]; 2] {
        self.rays[place].map(|v| v.map(f32::from_bits))
    }

    /// Judges the sample in a run, which must trace the rays that this was [prepared](Self::prepare) for.
    #[must_use]
    pub fn of<'b>(&'b self, traced: &'b Traced<'_>, cracks: Cracks) -> Verdicts<'b> {
        Verdicts { judge: self, traced, triangles: self.triangles_of(traced), cracks }
    }
}

/// A run with its judge.
pub struct Verdicts<'a> {
    judge: &'a Judge,
    traced: &'a Traced<'a>,
    triangles: Triangles<'a>,
    cracks: Cracks,
}

impl<'a> Verdicts<'a> {
    /// Judges a ray by its index in the sample, resolved or not.
    #[must_use]
    pub fn judge(&self, place: usize) -> Judged<'a> {
        let (ray, candidates) = (self.judge.sample[place], &self.judge.candidates[place]);
        let hit = self.traced.hit(ray);
        let found = hit.map(|hit| (hit.triangle, hit.t));
        let (mistake, _) = match self.cracks {
            Cracks::Tied => candidates.judge(ray, found),
            Cracks::Missed => {
                let [origin, direction] = self.judge.ray(place);
                self.triangles.judge(ray, origin, direction, candidates, found)
            }
        };
        Judged { hit, candidates, mistake }
    }

    /// Judges the whole sample, in order.
    pub fn all(&self) -> impl Iterator<Item = Judged<'a>> {
        (0..self.judge.sample.len()).map(|place| self.judge(place))
    }
}

#[cfg(test)]
mod tests {
    use raystep_kernels::{Device, Options, RaySource};
    use raystep_scenes::{Scene, generate};

    use super::*;

    fn run(scene: &Scene) -> Renderer {
        let camera = generate::cornell_box().cameras[0].clone();
        let options = Options::new(RaySource::Camera { camera, width: 16, height: 16 });
        let mut renderer = pollster::block_on(Renderer::new(scene, &options, &Device::Cpu(None))).expect("a renderer");
        pollster::block_on(renderer.run(|_| ControlFlow::Continue(()))).expect("a run");
        renderer
    }

    #[test]
    fn truth_is_kept_for_the_same_rays_in_the_same_scene_only() {
        let scene = generate::cornell_box();
        let mut other = scene.clone();
        // One triangle fewer; the bounding box, and with it units and rays, stays the same.
        let last = other.triangles.len() - 1;
        other.triangles[last] = other.triangles[0];
        let runs = [run(&scene), run(&other)];
        let [one, two] = runs.each_ref().map(|renderer| pollster::block_on(Traced::read(renderer)).expect("streams"));
        assert!((0..one.rays()).all(|ray| one.ray(ray) == two.ray(ray)), "the rays are the same");
        let all = || (0..one.rays()).collect();
        let (mut kept, mut own) = (Judge::default(), Judge::default());
        pollster::block_on(kept.prepare(&one, all()));
        let of_one = kept.candidates().to_vec();
        pollster::block_on(kept.prepare(&two, all()));
        pollster::block_on(own.prepare(&two, all()));
        assert_ne!(of_one, own.candidates(), "no ray hits the triangle");
        assert_eq!(kept.candidates(), own.candidates());
        assert_eq!(kept.of(&two, Cracks::Missed).all().filter(|j| j.mistake.verdict.is_error()).count(), 0);
    }

    #[test]
    fn a_sample_is_spread_over_all_rays_and_the_same_again() {
        let some = sample(1000, 100, 7);
        assert_eq!(some, sample(1000, 100, 7));
        assert_ne!(some, sample(1000, 100, 8));
        assert!(some.iter().enumerate().all(|(i, &ray)| (10 * i..10 * i + 10).contains(&ray)), "{some:?}");
        assert_eq!((sample(3, 3, 1), sample(3, 9, 1), sample(0, 9, 1)), (vec![0, 1, 2], vec![0, 1, 2], vec![]));
        assert_eq!(sample(5, 0, 1), Vec::<usize>::new());
    }
}
