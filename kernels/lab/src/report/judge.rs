//! Rays of a run judged in f64 with exact predicates.
//!
//! Where it would take too long to judge all of them, a random sample is judged, spread over all of them and the same in
//! every run.
//!
//! At an edge, f32 may not be able to tell which of two triangles a ray hits, and either is right. But if the surface
//! continues on all sides, the ray must hit one of them: a ray that misses both counts as missed.

use raystep_kernels::Renderer;

use super::record::RAY_COLUMNS;
use super::work::Work;
use crate::Error;
use crate::judge::{self, Cracks, Traced, sample};
use crate::portions::Portions;
use crate::reference::{Counts, Possible, Verdict, error_of_t};
use crate::tidy::Row;
use crate::tidy::fill::{Drawn, verdicts};

/// Rays with a verdict between two looks at the clock.
const RAYS_A_LOOK: usize = 64;

/// The correct hits, computed for the first run and kept for later runs.
#[derive(Default)]
pub(super) struct Judge(judge::Judge);

/// A correct hit, to measure the error of its t.
#[derive(Clone, Copy, Debug)]
pub(super) struct Right {
    /// Its place in the sample.
    pub(super) place: usize,
    /// The computed t, in traced units.
    pub(super) t: f64,
    /// The exact hit and its error bound.
    pub(super) exact: Possible,
}

/// Errors of t by rational arithmetic, relative to each ray's bound.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Witness {
    /// Hits compared.
    pub(super) rays: usize,
    /// The largest error of a computed t.
    pub(super) error_by_bound: Option<f64>,
    /// The largest error of the f64 reference's t.
    pub(super) reference_error_by_bound: Option<f64>,
}

/// What a run found.
#[derive(Clone, Debug, Default)]
pub(super) struct Judged {
    /// One per ray of the sample; `None` if the ray is not resolved.
    pub(super) verdicts: Vec<Option<Verdict>>,
    /// Triangle and t that were found, in traced units.
    pub(super) found: Vec<Option<(u32, f64)>>,
    /// The same, counted.
    pub(super) counts: Counts,
    /// Every hit of the exact triangle.
    pub(super) right: Vec<Right>,
    /// Of all rays, those still active when their pass limit was reached or the run was stopped.
    pub(super) at_bound: u64,
}

impl Judge {
    /// The most rays to judge in a run.
    pub(super) fn most_rays(work: &Work<'_>) -> usize {
        work.either(1 << 14, 1 << 17)
    }

    /// Judges a run that is over, or as far as it got. Like [`witness`](Self::witness), lets other tasks run every few
    /// milliseconds.
    pub(super) async fn judge(&mut self, work: &Work<'_>, renderer: &Renderer) -> Result<Judged, Error> {
        // Less than a second, and some seconds, on two cores.
        let effort = work.either(1 << 25, 1 << 28);
        work.is_wanted()?;
        let traced = Traced::read(renderer).await?;
        let most = Self::most_rays(work).min(self.0.affordable(&traced, effort, work.seed()));
        self.0.prepare(&traced, sample(traced.rays(), most, work.seed())).await;
        let walking = (0..traced.rays()).filter(|&ray| !traced.is_decided(ray)).count() as u64;
        let mut judged = Judged { at_bound: renderer.unfinished().max(walking), ..Judged::default() };
        let verdicts = self.0.of(&traced, Cracks::Missed);
        let mut portions = Portions::new();
        for (place, &ray) in self.sample().iter().enumerate() {
            if place % RAYS_A_LOOK == 0 {
                portions.rest().await;
            }
            if !traced.is_decided(ray) {
                judged.verdicts.push(None);
                judged.found.push(None);
                continue;
            }
            let judge::Judged { hit, candidates, mistake } = verdicts.judge(place);
            if let (Verdict::Same, Some(hit)) = (mistake.verdict, hit)
                && let Some(&exact) = candidates.of(hit.triangle)
            {
                judged.right.push(Right { place, t: hit.t, exact });
            }
            judged.counts.add(mistake.verdict);
            judged.verdicts.push(Some(mistake.verdict));
            judged.found.push(hit.map(|hit| (hit.triangle, hit.t)));
        }
        Ok(judged)
    }

    /// The rays that are judged.
    pub(super) fn sample(&self) -> &[usize] {
        self.0.sample()
    }

    /// Adds every judged ray to `rays.csv`, if that is requested. `stratum` names a ray's group.
    pub(super) fn record<'s>(
        &self,
        work: &Work<'_>,
        renderer: &Renderer,
        judged: &Judged,
        configuration: &str,
        stratum: impl Fn(usize) -> &'s str,
    ) {
        if !work.record.has_rays() {
            return;
        }
        let row = |(place, verdict): (usize, &Option<Verdict>)| {
            let (ray, scale) = (self.sample()[place], renderer.t_scale(self.sample()[place]));
            let candidates = &self.0.candidates()[place];
            let found = judged.found[place];
            let exact = candidates.exact;
            let of_found = found.and_then(|(triangle, t)| Some((candidates.of(triangle)?, t)));
            let of_found = of_found.filter(|_| *verdict == Some(Verdict::Same));
            work.row(RAY_COLUMNS)
                .set("section", work.section)
                .set("configuration", configuration)
                .set("ray", ray)
                .set("stratum", stratum(ray))
                .set("verdict", verdict.map_or("unresolved", Verdict::name))
                .set("found_triangle", found.map(|(triangle, _)| triangle))
                .set("found_t", found.map(|(_, t)| t * scale))
                .set("exact_triangle", exact.map(|(triangle, _)| triangle))
                .set("exact_t", exact.map(|(_, t)| t * scale))
                .set("t_error", of_found.map(|(exact, t)| (t - exact.t).abs() * scale))
                .set("t_bound", of_found.map(|(exact, _)| exact.t_bound * scale))
        };
        work.record.add_rays(judged.verdicts.iter().enumerate().map(row));
    }

    /// Compares t of some correct hits with rational arithmetic.
    pub(super) async fn witness(&self, judged: &Judged, renderer: &Renderer, most: usize) -> Witness {
        let vertices = &renderer.data().vertices;
        let every = judged.right.len().div_ceil(most.max(1)).max(1);
        let mut witness = Witness::default();
        let largest = |old: &mut Option<f64>, new: f64| *old = Some(old.map_or(new, |old| old.max(new)));
        let mut portions = Portions::new();
        for right in judged.right.iter().step_by(every) {
            portions.rest().await;
            let [origin, direction] = self.0.ray(right.place);
            let first = 9 * right.exact.triangle as usize;
            let corners = [0, 3, 6].map(|c| [0, 1, 2].map(|axis| vertices[first + c + axis]));
            let error = |t| error_of_t(t, origin, direction, corners);
            if let (Some(of_found), Some(of_reference)) = (error(right.t), error(right.exact.t)) {
                witness.rays += 1;
                largest(&mut witness.error_by_bound, of_found / right.exact.t_bound);
                largest(&mut witness.reference_error_by_bound, of_reference / right.exact.t_bound);
            }
        }
        witness
    }

    /// The direction of a ray of the sample, in traced units per unit of t.
    pub(super) fn direction(&self, place: usize) -> [f64; 3] {
        self.0.ray(place)[1].map(f64::from)
    }
}

impl Judged {
    /// Note for a run that was stopped.
    pub(super) fn given_up(&self) -> String {
        format!("stopped, too slow or endless: {} rays were unresolved and are not judged", self.at_bound)
    }

    /// Fills the columns of verdicts.
    pub(super) fn fill(&self, row: Row, drawn: Drawn) -> Row {
        verdicts(row, &self.counts, drawn).set("at_bound", self.at_bound)
    }

    /// The verdicts on some rays, counted.
    pub(super) fn counts_of(&self, judge: &Judge, is_wanted: impl Fn(usize) -> bool) -> Counts {
        let mut counts = Counts::default();
        let of = judge.sample().iter().zip(&self.verdicts).filter(|(ray, _)| is_wanted(**ray));
        of.filter_map(|(_, verdict)| *verdict).for_each(|verdict| counts.add(verdict));
        counts
    }

    /// Rays that are wrong here and right there, and the other way round.
    pub(super) fn discordant(&self, other: &Self) -> [u64; 2] {
        let is_wrong = |verdict: &Option<Verdict>| verdict.is_some_and(Verdict::is_error);
        let mut count = [0; 2];
        for (one, two) in self.verdicts.iter().zip(&other.verdicts) {
            match (is_wrong(one), is_wrong(two)) {
                (true, false) => count[0] += 1,
                (false, true) => count[1] += 1,
                _ => {}
            }
        }
        count
    }
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use raystep_kernels::{Device, Options};
    use raystep_scenes::generate;

    use super::super::record::Record;
    use super::*;
    use crate::machine::now_ns;
    use crate::meter::Meter;
    use crate::reporter::Silent;
    use crate::subject::{Size, Subject};
    use crate::{Hash, Machine};

    #[test]
    fn a_run_that_was_given_up_has_verdicts_of_decided_rays_only() {
        let scene = generate::cornell_box();
        let subject = Subject { camera: scene.cameras[0].clone(), scene, hash: Hash::default(), file: String::new() };
        let meter = Meter::new(Machine { device: Device::Cpu(Some(now_ns)), reason: String::new() });
        let record = Record::new("test".into(), 1, false);
        let size = Size { width: 16, height: 16 };
        let work = Work { size, is_quick: true, ..Work::alone(&subject, &meter, "test", &record, &Silent) };
        let options = Options { steps_per_pass: 1, shade: false, ..Options::new(work.camera_rays()) };
        let mut renderer = work.wait(work.build(&options)).expect("a plan").renderer;
        let mut judge = Judge::default();
        let mut judge_after = |passes: usize| {
            work.wait(renderer.run_to(passes, |_| ControlFlow::Continue(()))).expect("passes");
            work.wait(judge.judge(&work, &renderer)).expect("streams")
        };
        let halfway = (1..).map(|k| judge_after(4 * k)).find(|judged| judged.at_bound < 256).expect("a decided ray");
        assert!((1..256).contains(&halfway.at_bound), "{}", halfway.at_bound);
        assert_eq!((halfway.counts.rays() + halfway.at_bound, halfway.counts.errors()), (256, 0));
        assert!(halfway.given_up().contains(&halfway.at_bound.to_string()));
        let all = judge_after(usize::MAX);
        assert_eq!((all.counts.rays(), all.at_bound, all.counts.errors()), (256, 0, 0));
    }
}
