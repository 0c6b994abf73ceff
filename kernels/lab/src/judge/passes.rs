//! Rays resolved, and rays resolved wrongly, after each pass of a run.
//!
//! The counters of each pass have the number of resolved rays. Those that are wrong are found in f64, among all rays or,
//! if that would take long, in a random sample of them. The hit of a resolved ray does not change any more, so each ray
//! is judged once, at the end; only for wrong rays is the pass that resolved them determined, by running the same passes
//! again.

use std::ops::ControlFlow;

use raystep_kernels::tables::stream::STATE_TAG;
use raystep_kernels::{Pass, Plan, RenderError, Renderer};

use super::{RAYS_A_BATCH, Traced, affordable, judge, sample};
use crate::portions::map_in_portions;
use crate::reference::{Counts, Mistake, Triangles, Verdict};

/// Maximum work of the judge, see [`affordable`]: some seconds on a few cores.
const MOST_WORK: u64 = 1 << 30;

/// Maximum number of passes after which the states of wrong rays are read.
const MOST_PLACES: usize = 64;

/// Selects the same rays in every run.
const SEED: u32 = 1;

/// A ray that did not hit what it should.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WrongRay {
    /// The ray's index, y * width + x.
    pub ray: usize,
    /// What is wrong.
    pub verdict: Verdict,
    /// Number of passes after which it was resolved; `None` if it was still unresolved at the end of the run.
    pub resolved_by: Option<usize>,
}

/// The verdicts on a run's rays.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Judgement {
    /// Rays of the run.
    pub rays: u64,
    /// Verdicts on the judged rays: all, or a random sample.
    pub counts: Counts,
    /// The wrong rays, in the order in which they were resolved.
    pub wrong: Vec<WrongRay>,
    /// The precision of `resolved_by`: a ray may have been resolved up to this many passes earlier.
    pub passes_between: usize,
}

impl Judgement {
    /// How many rays the first `place` passes resolved wrongly.
    #[must_use]
    pub fn wrong_by(&self, place: usize) -> usize {
        self.wrong.partition_point(|wrong| wrong.resolved_by.is_some_and(|by| by <= place))
    }

    /// Every pass count at which wrong rays are resolved, with their number by then.
    #[must_use]
    pub fn steps(&self) -> Vec<(usize, usize)> {
        let mut steps: Vec<(usize, usize)> = Vec::new();
        for (place, rays) in self.wrong.iter().filter_map(|wrong| wrong.resolved_by).zip(1..) {
            match steps.last_mut() {
                Some(last) if last.0 == place => last.1 = rays,
                _ => steps.push((place, rays)),
            }
        }
        steps
    }
}

/// Why the rays of a run cannot be judged, in one line; `None` if they can.
#[must_use]
pub fn why_not(plan: &Plan) -> Option<&'static str> {
    let Some(results) = plan.program.results else { return Some("not judged: the program traces no rays") };
    if plan.features.any_hit {
        Some("not judged: rays end at the first hit found, which may not be the nearest")
    } else if plan.features.samples {
        Some(
            "not judged: with several samples per pixel, only the last one's rays are available; trace with one \
              sample",
        )
    } else if !results.of_hits().into_iter().all(|stream| plan.has_stream(stream)) {
        Some("not judged: the rays are generated within a kernel, and are not in a stream")
    } else {
        None
    }
}

/// Runs `renderer` from start to end and judges what its rays hit. Use a separate renderer: it is restarted, and left
/// after some pass. [`why_not`] says whether it can be judged.
///
/// `progress` gets the work done and the total, and may stop. Other tasks run every few milliseconds.
///
/// # Errors
/// If the device fails, the plan omits a required stream, or `progress` stopped it.
pub async fn judge_passes(
    renderer: &mut Renderer,
    mut progress: impl FnMut(u64, u64) -> ControlFlow<()>,
) -> Result<Judgement, RenderError> {
    // The three phases, in thousandths of the work: the run, the judging, the same run again.
    const WHOLE: u64 = 1000;
    const RUN: u64 = 100;
    const AGAIN: u64 = 800;
    renderer.restart();
    renderer.run(|now| progress(RUN * now.rays_decided / now.rays.max(1), WHOLE)).await?;
    let passes = renderer.passes().to_vec();
    let traced = Traced::read(renderer).await?;
    let scene = Triangles::new(traced.vertices());
    let sample = sample(traced.rays(), affordable(&scene, &traced, MOST_WORK, SEED), SEED);
    let mut judgement = Judgement { rays: renderer.plan().rays, ..Judgement::default() };
    for (i, rays) in sample.chunks(RAYS_A_BATCH).enumerate() {
        let part = RUN + (AGAIN - RUN) * (i * RAYS_A_BATCH) as u64 / sample.len() as u64;
        if progress(part, WHOLE).is_break() {
            return Err(RenderError::Cancelled { passes: passes.len() });
        }
        // The possible hits of all rays together need too much memory, so none are kept.
        let judged = |i: usize| judge(&scene, &traced, rays[i]);
        for (Mistake { ray, verdict, .. }, _) in map_in_portions(rays.len(), judged).await {
            judgement.counts.add(verdict);
            if verdict.is_error() {
                judgement.wrong.push(WrongRay { ray, verdict, resolved_by: None });
            }
        }
    }
    drop(traced);

    let places = places(&passes, MOST_PLACES);
    judgement.passes_between = places.windows(2).map(|w| w[1] - w[0]).max().unwrap_or(0);
    if !judgement.wrong.is_empty() {
        renderer.restart();
    }
    for (i, &place) in places.iter().enumerate() {
        if judgement.wrong.iter().all(|wrong| wrong.resolved_by.is_some()) {
            break;
        }
        let part = AGAIN + (WHOLE - AGAIN) * i as u64 / places.len() as u64;
        renderer.run_to(place, |_| progress(part, WHOLE)).await?;
        let now = renderer.values(renderer.results()?.t.stream).await?;
        for wrong in judgement.wrong.iter_mut().filter(|wrong| wrong.resolved_by.is_none()) {
            wrong.resolved_by =
                renderer.plan().program.states.is_decided(now.get(STATE_TAG, wrong.ray)).then_some(place);
        }
    }
    judgement.wrong.sort_by_key(|wrong| (wrong.resolved_by.unwrap_or(usize::MAX), wrong.ray));
    Ok(judgement)
}

/// Pass counts after passes that resolved rays, including the last one; at most `most`, evenly chosen.
fn places(passes: &[Pass], most: usize) -> Vec<usize> {
    let mut before = 0;
    let mut all = Vec::new();
    for (pass, place) in passes.iter().zip(1..) {
        let now = pass.kernel.program().states.decided(&pass.counts);
        if now != before {
            all.push(place);
        }
        before = now;
    }
    let count = all.len().min(most);
    (1..=count).map(|i| all[i * all.len() / count - 1]).collect()
}

#[cfg(test)]
mod tests {
    use raystep_kernels::{Accelerator, Device, GridSize, Numerics, Options, RaySource, ScheduleKind};
    use raystep_scenes::generate;

    use raystep_kernels::programs::closest_hit::{states, streams};

    use super::*;

    fn options(numerics: Numerics, side: u32) -> Options {
        let camera = generate::cornell_box().cameras[0].clone();
        Options {
            accelerator: Accelerator::Grid,
            schedule: ScheduleKind::Second,
            numerics,
            grid: GridSize::Cells([20; 3]),
            ..Options::new(RaySource::Camera { camera, width: side, height: side })
        }
    }

    fn renderer(options: &Options) -> Renderer {
        pollster::block_on(Renderer::new(&generate::cornell_box(), options, &Device::Cpu(None))).expect("a renderer")
    }

    fn judged(numerics: Numerics, side: u32) -> (Judgement, Vec<Pass>) {
        let mut renderer = renderer(&options(numerics, side));
        pollster::block_on(renderer.run(|_| ControlFlow::Continue(()))).expect("a run");
        let passes = renderer.passes().to_vec();
        let judgement =
            pollster::block_on(judge_passes(&mut renderer, |_, _| ControlFlow::Continue(()))).expect("a judgement");
        (judgement, passes)
    }

    #[test]
    fn by_robust_rules_none_is_wrong_and_by_the_papers_some_are() {
        let (robust, passes) = judged(Numerics::Robust, 64);
        assert_eq!((robust.rays, robust.counts.rays(), robust.wrong.len()), (64 * 64, 64 * 64, 0));
        assert_eq!(robust.counts.errors(), 0);
        assert!(robust.counts.same > 4000, "{robust:?}");
        let counts: Vec<u64> = passes.iter().map(|pass| pass.kernel.program().states.decided(&pass.counts)).collect();
        assert!(counts.is_sorted() && counts[0] == 0, "{counts:?}");
        assert_eq!(counts.last(), Some(&(64 * 64)));

        // Rays pass through cracks where f32 cannot tell which side they hit, and through surfaces at cell faces.
        let (paper, passes) = judged(Numerics::Paper, 512);
        assert!(paper.wrong.len() > 500, "{} of {}", paper.wrong.len(), paper.counts.rays());
        assert_eq!(paper.counts.errors(), paper.wrong.len() as u64);
        assert!(paper.wrong.iter().all(|wrong| wrong.resolved_by.is_some_and(|by| by <= passes.len())));
        assert_eq!((paper.wrong_by(0), paper.wrong_by(passes.len())), (0, paper.wrong.len()));
        let steps = paper.steps();
        assert!(steps.windows(2).all(|w| w[0].0 < w[1].0 && w[0].1 < w[1].1), "{steps:?}");
        assert_eq!(steps.last().map(|step| step.1), Some(paper.wrong.len()));
        assert!(steps.iter().all(|&(place, rays)| paper.wrong_by(place) == rays && paper.wrong_by(place - 1) < rays));
    }

    #[test]
    fn a_wrong_ray_is_resolved_by_its_place_and_not_before_the_one_looked_at_before() {
        let (judgement, passes) = judged(Numerics::Paper, 256);
        let places = places(&passes, MOST_PLACES);
        let mut run = renderer(&options(Numerics::Paper, 256));
        for wrong in judgement.wrong.iter().take(8) {
            let by = wrong.resolved_by.expect("resolved");
            let index = places.binary_search(&by).expect("one of the places");
            let before = index.checked_sub(1).map_or(0, |i| places[i]);
            for (place, is_so) in [(before, false), (by, true)] {
                run.restart();
                pollster::block_on(run.run_to(place, |_| ControlFlow::Continue(()))).expect("a run");
                let now = pollster::block_on(run.values(streams::STATE)).expect("its states");
                assert_eq!(states::STATES.is_decided(now.get(STATE_TAG, wrong.ray)), is_so, "{wrong:?} after {place}");
            }
        }
    }

    #[test]
    fn places_are_those_that_resolve_rays_and_no_more_than_asked_for() {
        let (_, passes) = judged(Numerics::Robust, 64);
        let all = places(&passes, usize::MAX);
        assert!(all.len() > 10 && all.len() < passes.len(), "{} of {}", all.len(), passes.len());
        let few = places(&passes, 5);
        assert_eq!((few.len(), few.last()), (5, all.last()));
        assert!(few.iter().all(|place| all.contains(place)) && few.is_sorted());
        assert!(places(&[], 5).is_empty());
    }

    #[test]
    fn judging_says_how_far_it_is_and_stops() {
        let mut renderer = renderer(&options(Numerics::Paper, 64));
        let mut parts = Vec::new();
        pollster::block_on(judge_passes(&mut renderer, |done, of| {
            parts.push((done, of));
            ControlFlow::Continue(())
        }))
        .expect("a judgement");
        assert!(parts.iter().all(|&(done, of)| done <= of && of == 1000) && parts.is_sorted(), "{parts:?}");
        // Stop in each of the three phases.
        for at in [0, 100, 800] {
            let stopped = pollster::block_on(judge_passes(&mut renderer, |done, _| {
                if done >= at { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            }));
            assert!(matches!(stopped, Err(RenderError::Cancelled { .. })), "{at}");
        }
    }

    #[test]
    fn what_cannot_be_judged_says_why() {
        let plain = options(Numerics::Robust, 64);
        let why = |options: &Options| why_not(renderer(options).plan());
        assert_eq!(why(&plain), None);
        let any_hit = Options { any_hit: true, ..plain.clone() };
        assert!(why(&any_hit).is_some_and(|why| why.contains("first hit")));
        let fused = Options { schedule: ScheduleKind::Fused, shade: false, ..plain };
        assert!(why(&fused).is_some_and(|why| why.contains("not in a stream")));
    }
}
