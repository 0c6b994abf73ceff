//! What became of every ray of a variant.

use raystep_kernels::parallel::map_ranges;
use raystep_kernels::renderer::{RenderError, Renderer};
use raystep_kernels::shared::constants::{INF, NO_TRIANGLE};
use raystep_kernels::stream::{HIT_TRIANGLE, STATE_T, STREAMS, Stream, StreamData};

use crate::reference::{BruteForce, Candidates, Possible, Verdict, is_edge_on};
use crate::stability::Truth;

/// The largest error of a value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Largest {
    /// By the exact value.
    pub relative: Option<f64>,
    /// In f32's units in the last place of what the arithmetic rounds: for t the depth of the triangle's
    /// farthest corner, for u and v the sum of the weights, 1.
    pub ulp: Option<f64>,
}

impl Largest {
    fn add(&mut self, found: f64, exact: f64, scale: f64) {
        let error = (found - exact).abs();
        let most = |so_far: &mut Option<f64>, value: f64| {
            if value.is_finite() {
                *so_far = Some(so_far.map_or(value, |v| v.max(value)));
            }
        };
        if exact != 0.0 {
            most(&mut self.relative, error / exact.abs());
        }
        most(&mut self.ulp, error / (scale * f64::from(f32::EPSILON)));
    }
}

/// All rays of a variant, counted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Score {
    /// What became of each.
    pub verdicts: Vec<Verdict>,
    /// Nothing was hit, and something was there.
    pub missed: u64,
    /// Something was hit, and nothing was there.
    pub false_hits: u64,
    /// Another triangle than the nearest, or its t beyond its bound.
    pub wrong: u64,
    /// Not the exact triangle, but f32 could not tell.
    pub undecided: u64,
    /// Rays for which the error bound leaves a choice at all.
    pub undecidable: u64,
    /// Hits of a triangle that is exactly edge-on or without an area.
    pub edge_on: u64,
    /// Rays with a value in any stream that is not a number or infinite.
    pub non_finite: u64,
    /// Of t, among hits of the exact triangle.
    pub t: Largest,
    /// Of the weight of vertex 1, likewise.
    pub u: Largest,
    /// Of the weight of vertex 2, likewise.
    pub v: Largest,
    /// The first ray with an error, as bits: origin and direction in traced units.
    pub first_error: Option<([f32; 3], [f32; 3])>,
}

impl Score {
    /// Missed, false and wrong together.
    #[must_use]
    pub fn errors(&self) -> u64 {
        self.missed + self.false_hits + self.wrong
    }
}

/// A hit, as precise as the executor has it.
#[derive(Clone, Copy)]
struct Hit {
    triangle: u32,
    t: f64,
    u: f64,
    v: f64,
}

/// Truth of a case, worked out for its first variant and kept for the others.
#[derive(Default)]
pub struct Judge {
    /// Origins and directions that the candidates belong to.
    rays: Vec<u32>,
    candidates: Vec<Candidates>,
}

impl Judge {
    /// Directions of the rays that were judged last.
    #[must_use]
    pub fn directions(&self) -> Vec<[f32; 3]> {
        let n = self.rays.len() / 6;
        (0..self.candidates.len()).map(|i| [3, 4, 5].map(|c| f32::from_bits(self.rays[c * n + i]))).collect()
    }

    /// Counts what a run found.
    ///
    /// # Errors
    /// Where the device fails.
    pub async fn score(&mut self, truth: Truth, renderer: &Renderer) -> Result<Score, RenderError> {
        let rays = renderer.plan().rays as usize;
        let origins = renderer.values(Stream::RayOrigin).await?;
        let directions = renderer.values(Stream::RayDirection).await?;
        self.prepare(renderer, rays, &origins, &directions);
        let (state, hit) = (renderer.values(Stream::State).await?, renderer.values(Stream::Hit).await?);
        let mut score = Score { non_finite: non_finite(renderer, rays).await?, ..Score::default() };
        score.undecidable = self.candidates.iter().filter(|c| c.is_open()).count() as u64;
        let ray_of = |i: usize| [&origins, &directions].map(|s| [0, 1, 2].map(|layer| s.get_f32(layer, i)));
        for (ray, candidates) in self.candidates.iter().enumerate() {
            let found = found(renderer, &state, &hit, ray);
            let (mistake, _) = candidates.judge(ray, found.map(|h| (h.triangle, h.t)));
            let [origin, direction] = ray_of(ray);
            if let Some(h) = found
                && (mistake.exact.is_none_or(|(triangle, _)| triangle != h.triangle))
                && is_edge_on(&renderer.data().vertices, direction, h.triangle)
            {
                score.edge_on += 1;
            }
            let verdict = known(truth, mistake.verdict, found.is_some());
            if let (Verdict::Same, Some(h)) = (verdict, found)
                && let Some(p) = candidates.of(h.triangle)
            {
                score.measure(h, p);
            }
            score.count(verdict);
            if score.errors() == 1 && score.first_error.is_none() {
                score.first_error = Some((origin, direction));
            }
        }
        Ok(score)
    }

    /// Works out what each ray may hit, unless these are the rays of before.
    fn prepare(&mut self, renderer: &Renderer, rays: usize, origins: &StreamData, directions: &StreamData) {
        let bits = [&origins.bits[..], &directions.bits].concat();
        if bits == self.rays && self.candidates.len() == rays {
            return;
        }
        let triangles = BruteForce::new(&renderer.data().vertices);
        let component = |s: &StreamData, ray| [0, 1, 2].map(|layer| s.get_f32(layer, ray));
        let part = |range: std::ops::Range<usize>| {
            range.map(|i| triangles.candidates(component(origins, i), component(directions, i))).collect::<Vec<_>>()
        };
        self.candidates = map_ranges(rays, 16, part).into_iter().flatten().collect();
        self.rays = bits;
    }
}

impl Score {
    fn count(&mut self, verdict: Verdict) {
        match verdict {
            Verdict::Same => {}
            Verdict::Tie => self.undecided += 1,
            Verdict::Missed => self.missed += 1,
            Verdict::False => self.false_hits += 1,
            Verdict::Wrong => self.wrong += 1,
        }
        self.verdicts.push(verdict);
    }

    fn measure(&mut self, hit: Hit, p: &Possible) {
        self.t.add(hit.t, p.t, p.far.max(p.t.abs()));
        self.u.add(hit.u, p.u, 1.0);
        self.v.add(hit.v, p.v, 1.0);
    }
}

/// What is known of every ray of a case overrules what the bounds leave open.
fn known(truth: Truth, verdict: Verdict, is_found: bool) -> Verdict {
    match (truth, is_found) {
        (Truth::Closed, false) => Verdict::Missed,
        (Truth::Nothing, true) => Verdict::False,
        _ => verdict,
    }
}

/// What a ray hit. The f64 twins' values are taken before they are rounded.
fn found(renderer: &Renderer, state: &StreamData, hit: &StreamData, ray: usize) -> Option<Hit> {
    let triangle = hit.get(HIT_TRIANGLE, ray);
    let t = state.get_f32(STATE_T, ray);
    if triangle == NO_TRIANGLE || t >= INF {
        return None;
    }
    let exact = |stream: Stream, layer: usize, rounded: f32| {
        let wide = renderer.cpu_f64().and_then(|e| e.component(stream, layer, ray));
        wide.unwrap_or(f64::from(rounded))
    };
    Some(Hit {
        triangle,
        t: exact(Stream::State, STATE_T, t),
        u: exact(Stream::Hit, 0, hit.get_f32(0, ray)),
        v: exact(Stream::Hit, 1, hit.get_f32(1, ray)),
    })
}

/// Rays with a float in any stream that is not finite.
async fn non_finite(renderer: &Renderer, rays: usize) -> Result<u64, RenderError> {
    let mut is_bad = vec![false; rays];
    for info in STREAMS.iter().filter(|s| renderer.plan().has_stream(s.stream)) {
        let values = renderer.values(info.stream).await?;
        for layer in (0..info.stream.layers()).filter(|&layer| info.stream.is_float_layer(layer)) {
            for (bad, &bits) in is_bad.iter_mut().zip(values.layer(layer)) {
                *bad |= !f32::from_bits(bits).is_finite();
            }
        }
    }
    Ok(is_bad.into_iter().filter(|&bad| bad).count() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_known_of_a_case_overrules_ties() {
        use Verdict::{False, Missed, Same, Tie, Wrong};
        for verdict in [Same, Tie] {
            assert_eq!(known(Truth::Open, verdict, false), verdict);
            assert_eq!(known(Truth::Closed, verdict, false), Missed);
            assert_eq!(known(Truth::Nothing, verdict, true), False);
            assert_eq!(known(Truth::Nothing, verdict, false), verdict);
        }
        assert_eq!(known(Truth::Closed, Wrong, true), Wrong);
    }

    #[test]
    fn an_error_is_counted_by_its_kind_and_measured_by_its_size() {
        let mut score = Score::default();
        let verdicts = [Verdict::Same, Verdict::Tie, Verdict::Tie, Verdict::Missed, Verdict::Wrong];
        verdicts.into_iter().for_each(|v| score.count(v));
        assert_eq!((score.undecided, score.missed, score.false_hits, score.wrong), (2, 1, 0, 1));
        assert_eq!((score.errors(), score.verdicts.len()), (2, 5));

        let mut largest = Largest::default();
        largest.add(1.0, 0.0, 1.0);
        assert_eq!((largest.relative, largest.ulp), (None, Some(8_388_608.0)), "nothing is relative to 0");
        largest.add(4.0, 2.0, f64::INFINITY);
        largest.add(f64::NAN, 2.0, 1.0);
        assert_eq!((largest.relative, largest.ulp), (Some(1.0), Some(8_388_608.0)));
    }
}
