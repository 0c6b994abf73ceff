//! What became of the rays of a run: what they hit against what they should have hit, by f64 brute force with exact
//! predicates ([`crate::reference`]).
//!
//! [`check_rays`] judges every ray and keeps nothing. Every triangle against every ray is too much for a large scene, or
//! for many runs of the same rays: a [`Judge`] works truth out for a [`sample`] of them, and keeps it for the runs that
//! follow.
//!
//! Judged is what the executor computed. The f64 twins ([`Device::CpuF64`](raystep_kernels::Device::CpuF64)) are judged
//! by their own t, not by what is left of it once a stream rounds it to f32: a hit that is right in f64 is not wrong for
//! being stored.

mod passes;
mod report;

use std::ops::ControlFlow;

use raystep_kernels::numbers::parallel::map_ranges;
use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::programs::closest_hit::streams::STATE_T;
use raystep_kernels::renderer::{RenderError, Renderer, found};
use raystep_kernels::tables::stream::{STATE_TAG, Stream, StreamData};

use crate::Hash;
use crate::rays::Random;
use crate::reference::{BruteForce, Candidates, Mistake, candidates_of};
pub use passes::{Judgement, WrongRay, judge_passes, why_not};
pub use report::Report;

/// Tests of a triangle against a ray from one look at progress to the next.
const TESTS_A_BATCH: usize = 1 << 24;

/// The rays of a run and what they hit so far.
pub struct Traced<'a> {
    renderer: &'a Renderer,
    /// Origins, directions, states and hits as the run has them; texels beyond the rays are unused.
    pub streams: [StreamData; 4],
}

/// A hit, as precise as the executor has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The triangle's id.
    pub triangle: u32,
    /// Along the ray, in traced units.
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
    /// If the plan left one of them out, or the device fails.
    pub async fn read(renderer: &'a Renderer) -> Result<Self, RenderError> {
        let streams = [
            renderer.values(streams::RAY_ORIGIN).await?,
            renderer.values(streams::RAY_DIRECTION).await?,
            renderer.values(streams::STATE).await?,
            renderer.values(streams::HIT).await?,
        ];
        Ok(Self { renderer, streams })
    }

    /// How many there are.
    #[must_use]
    pub fn rays(&self) -> usize {
        self.renderer.plan().rays as usize
    }

    /// The triangles that they were tested against, nine floats each.
    #[must_use]
    pub fn vertices(&self) -> &'a [f32] {
        &self.renderer.data().vertices
    }

    /// A ray's origin and direction, in traced units.
    #[must_use]
    pub fn ray(&self, ray: usize) -> [[f32; 3]; 2] {
        self.bits(ray).map(|v| v.map(f32::from_bits))
    }

    fn bits(&self, ray: usize) -> [[u32; 3]; 2] {
        [&self.streams[0], &self.streams[1]].map(|s| [0, 1, 2].map(|layer| s.get(layer, ray)))
    }

    /// What a ray hit. The f64 twins' values are taken before they are rounded.
    #[must_use]
    pub fn hit(&self, ray: usize) -> Option<Hit> {
        let [_, _, state, hit] = &self.streams;
        let (triangle, t) = found(state, hit, ray)?;
        let exact = |stream: Stream, layer: usize, rounded: f32| {
            let wide = self.renderer.cpu_f64().and_then(|e| e.component(stream, layer, ray));
            wide.unwrap_or(f64::from(rounded))
        };
        Some(Hit {
            triangle,
            t: exact(streams::STATE, STATE_T, t),
            u: exact(streams::HIT, 0, hit.get_f32(0, ray)),
            v: exact(streams::HIT, 1, hit.get_f32(1, ray)),
        })
    }

    /// Whether a ray will hit nothing else any more.
    #[must_use]
    pub fn is_decided(&self, ray: usize) -> bool {
        self.renderer.plan().program.states.is_decided(self.streams[2].get(STATE_TAG, ray))
    }
}

/// Compares what every ray of a run hit with what it should. `progress` gets rays done and rays in all, and may stop.
pub fn check_rays(traced: &Traced<'_>, mut progress: impl FnMut(u64, u64) -> ControlFlow<()>) -> Report {
    let triangles = BruteForce::new(traced.vertices());
    let (rays, mut report) = (traced.rays(), Report::default());
    let batch = rays_a_batch(triangles.triangles());
    for first in (0..rays).step_by(batch) {
        let count = batch.min(rays - first);
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

/// What became of a ray, and the error of its t as [`Candidates::judge`] has it.
fn judge(triangles: &BruteForce<'_>, traced: &Traced<'_>, ray: usize) -> (Mistake, f64) {
    let [origin, direction] = traced.ray(ray);
    let found = traced.hit(ray).map(|hit| (hit.triangle, hit.t));
    triangles.judge(ray, origin, direction, &triangles.candidates(origin, direction), found)
}

/// How many rays to judge at once, so that each batch takes about as long as any other.
#[must_use]
pub fn rays_a_batch(triangles: usize) -> usize {
    TESTS_A_BATCH.div_ceil(triangles.max(1)).clamp(64, 1 << 16)
}

/// Indices of `count` of `rays` rays, ascending: one at random of each of as many stretches of equal length. All of
/// them where there are no more.
#[must_use]
pub fn sample(rays: usize, count: usize, seed: u32) -> Vec<usize> {
    if count >= rays {
        return (0..rays).collect();
    }
    let begin = |i: usize| (i as u64 * rays as u64 / count as u64) as usize;
    let one = |i: usize| begin(i) + Random::of(i as u32, seed).below(begin(i + 1) - begin(i));
    (0..count).map(one).collect()
}

/// How a ray is judged that passes between two triangles where the surface goes on: f32 cannot tell which of them it
/// hits, but it must hit one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cracks {
    /// It has passed through a crack, and missed.
    Missed,
    /// Each triangle may be missed: a tie.
    Tied,
}

/// What some rays of a run may hit: worked out for the first run, and kept for those that trace the same rays through
/// the same triangles.
#[derive(Clone, Debug, Default)]
pub struct Judge {
    /// Of the triangles' corners.
    scene: Hash,
    sample: Vec<usize>,
    /// Origins and directions, as bits.
    rays: Vec<[[u32; 3]; 2]>,
    candidates: Vec<Candidates>,
}

/// What became of a ray.
#[derive(Clone, Copy, Debug)]
pub struct Judged<'a> {
    /// What it hit.
    pub hit: Option<Hit>,
    /// What it may hit.
    pub candidates: &'a Candidates,
    /// The verdict, with what is exact.
    pub mistake: Mistake,
}

impl Judge {
    /// Works out what each ray of a sample may hit, unless these are the rays and triangles of before.
    pub fn prepare(&mut self, traced: &Traced<'_>, sample: Vec<usize>) {
        let rays: Vec<_> = sample.iter().map(|&ray| traced.bits(ray)).collect();
        let scene = Hash::of_floats(traced.vertices());
        if (self.scene, &self.rays, &self.sample) == (scene, &rays, &sample) {
            return;
        }
        let floats: Vec<_> = rays.iter().map(|ray| ray.map(|v| v.map(f32::from_bits))).collect();
        *self = Self { scene, sample, rays, candidates: candidates_of(traced.vertices(), &floats) };
    }

    /// The rays that are judged, ascending.
    #[must_use]
    pub fn sample(&self) -> &[usize] {
        &self.sample
    }

    /// What each of them may hit.
    #[must_use]
    pub fn candidates(&self) -> &[Candidates] {
        &self.candidates
    }

    /// Origin and direction of a ray of the sample, in traced units.
    #[must_use]
    pub fn ray(&self, place: usize) -> [[f32; 3]; 2] {
        self.rays[place].map(|v| v.map(f32::from_bits))
    }

    /// Judges the rays of the sample as a run has them, which must be those that this was [prepared](Self::prepare)
    /// for.
    #[must_use]
    pub fn of<'b>(&'b self, traced: &'b Traced<'_>, cracks: Cracks) -> Verdicts<'b> {
        Verdicts { judge: self, traced, triangles: BruteForce::new(traced.vertices()), cracks }
    }
}

/// A run before its judge.
pub struct Verdicts<'a> {
    judge: &'a Judge,
    traced: &'a Traced<'a>,
    triangles: BruteForce<'a>,
    cracks: Cracks,
}

impl<'a> Verdicts<'a> {
    /// Judges a ray by its place in the sample, decided or not.
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

    /// Judges all of the sample, in order.
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
        // One triangle fewer; the box, and with it the units and the rays, stays.
        let last = other.triangles.len() - 1;
        other.triangles[last] = other.triangles[0];
        let runs = [run(&scene), run(&other)];
        let [one, two] = runs.each_ref().map(|renderer| pollster::block_on(Traced::read(renderer)).expect("streams"));
        assert!((0..one.rays()).all(|ray| one.ray(ray) == two.ray(ray)), "the rays are the same");
        let all = || (0..one.rays()).collect();
        let (mut kept, mut own) = (Judge::default(), Judge::default());
        kept.prepare(&one, all());
        let of_one = kept.candidates().to_vec();
        kept.prepare(&two, all());
        own.prepare(&two, all());
        assert_ne!(of_one, own.candidates(), "nobody sees the triangle");
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
