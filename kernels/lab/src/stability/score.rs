//! Verdicts on every ray of a run.

use raystep_kernels::Stream;
use raystep_kernels::renderer::{RenderError, Renderer};

use crate::judge::{Cracks, Hit, Judge, Judged, Traced};
use crate::reference::{Counts, Possible, Verdict, is_edge_on};
use crate::stability::Truth;

/// The largest error of a value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Largest {
    /// Relative to the exact value.
    pub relative: Option<f64>,
    /// In f32's units in the last place of the magnitude that is rounded: for t the depth of the triangle's farthest
    /// vertex, for u and v the sum of the weights, 1.
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

/// The verdicts on all rays of a run, their counts, and the largest errors.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Score {
    /// The verdict on each ray.
    pub verdicts: Vec<Verdict>,
    /// The same, counted.
    pub counts: Counts,
    /// Rays for which the error bound allows more than one result.
    pub undecidable: u64,
    /// Hits of triangles that are exactly edge-on or without area.
    pub edge_on: u64,
    /// Rays with a NaN or infinite value in any stream.
    pub non_finite: u64,
    /// The error of t, among hits of the exact triangle.
    pub t: Largest,
    /// The error of the weight of vertex 1, likewise.
    pub u: Largest,
    /// The error of the weight of vertex 2, likewise.
    pub v: Largest,
    /// The first ray with an error, as bits: origin and direction in traced units.
    pub first_error: Option<([f32; 3], [f32; 3])>,
}

impl Score {
    /// Judges every ray of a run, complete or not. `judge` keeps what the rays may hit for the next run of the same
    /// case.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn of(judge: &mut Judge, truth: Truth, renderer: &Renderer) -> Result<Self, RenderError> {
        let traced = Traced::read(renderer).await?;
        judge.prepare(&traced, (0..traced.rays()).collect()).await;
        let mut score = Self { non_finite: non_finite(renderer, traced.rays()).await?, ..Self::default() };
        score.undecidable = judge.candidates().iter().filter(|c| c.is_open()).count() as u64;
        // For a closed surface, [`Truth`] itself says that every ray hits it.
        for (ray, Judged { hit, candidates, mistake }) in judge.of(&traced, Cracks::Tied).all().enumerate() {
            let [origin, direction] = traced.ray(ray);
            if let Some(h) = hit
                && (mistake.exact.is_none_or(|(triangle, _)| triangle != h.triangle))
                && is_edge_on(traced.vertices(), direction, h.triangle)
            {
                score.edge_on += 1;
            }
            let verdict = known(truth, mistake.verdict, hit.is_some());
            if let (Verdict::Same, Some(h)) = (verdict, hit)
                && let Some(p) = candidates.of(h.triangle)
            {
                score.measure(h, p);
            }
            score.count(verdict);
            if score.counts.errors() == 1 && score.first_error.is_none() {
                score.first_error = Some((origin, direction));
            }
        }
        Ok(score)
    }
}

impl Score {
    fn count(&mut self, verdict: Verdict) {
        self.counts.add(verdict);
        self.verdicts.push(verdict);
    }

    fn measure(&mut self, hit: Hit, p: &Possible) {
        self.t.add(hit.t, p.t, p.far.max(p.t.abs()));
        self.u.add(hit.u, p.u, 1.0);
        self.v.add(hit.v, p.v, 1.0);
    }
}

/// Applies what is known about every ray of a case to verdicts that the bounds leave open.
fn known(truth: Truth, verdict: Verdict, is_found: bool) -> Verdict {
    match (truth, is_found) {
        (Truth::Closed, false) => Verdict::Missed,
        (Truth::Nothing, true) => Verdict::False,
        _ => verdict,
    }
}

/// Rays with a float in any stream that is not finite.
async fn non_finite(renderer: &Renderer, rays: usize) -> Result<u64, RenderError> {
    let mut is_bad = vec![false; rays];
    let streams: Vec<Stream> = renderer.plan().streams.iter().map(|planned| planned.what).collect();
    for stream in streams {
        let values = renderer.values(stream).await?;
        for layer in (0..stream.layers()).filter(|&layer| stream.is_float_layer(layer)) {
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
        assert_eq!(score.counts, Counts { same: 1, ties: 2, missed: 1, false_hits: 0, wrong: 1 });
        assert_eq!(score.verdicts, verdicts);

        let mut largest = Largest::default();
        largest.add(1.0, 0.0, 1.0);
        assert_eq!((largest.relative, largest.ulp), (None, Some(8_388_608.0)), "no error is relative to 0");
        largest.add(4.0, 2.0, f64::INFINITY);
        largest.add(f64::NAN, 2.0, 1.0);
        assert_eq!((largest.relative, largest.ulp), (Some(1.0), Some(8_388_608.0)));
    }
}
