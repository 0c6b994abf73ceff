//! Runs passes: one, some, or all that remain, in batches that hide the latency of the device.

use std::ops::ControlFlow;

use super::{Pass, Progress, RenderError, Renderer};
use crate::program::Kernel;
use crate::tables::kernel::Role;
use crate::tables::state::{Population, StateCounts};

/// Most rays times passes per submission, unless that is fewer than two passes.
const RAYS_A_BATCH: u64 = 1 << 26;

impl Renderer {
    /// Runs one pass. `None` when the run is complete.
    ///
    /// # Errors
    /// If the device fails.
    pub async fn step(&mut self) -> Result<Option<Pass>, RenderError> {
        let recorded = self.advance(1).await?;
        Ok(self.records.last().filter(|_| recorded > 0))
    }

    /// The kernel that [`step`](Self::step) would run.
    #[must_use]
    pub fn next_kernel(&self) -> Option<Kernel> {
        self.next_pass().map(|(kernel, _)| kernel)
    }

    /// Kernel and turns of the pass that [`step`](Self::step) would run; see [`Pass::loops`].
    #[must_use]
    pub fn next_pass(&self) -> Option<(Kernel, Vec<u32>)> {
        let mut cursor = self.cursor.clone();
        if self.is_over_bound() {
            cursor.leave_walk(&self.plan.schedule);
        }
        let kernel = cursor.next(&self.plan.schedule, self.scheduled())?;
        Some((kernel, cursor.loops()))
    }

    /// Runs to the end. `progress` is called between batches of passes and may stop the run.
    ///
    /// # Errors
    /// If the device fails, or `progress` stopped the run.
    pub async fn run(&mut self, progress: impl FnMut(&Progress) -> ControlFlow<()>) -> Result<(), RenderError> {
        self.run_to(usize::MAX, progress).await
    }

    /// Runs until this many passes have run in total, or to the end if that comes first; never beyond. `progress` is
    /// called between batches of passes and may stop the run, which can be continued from there.
    ///
    /// # Errors
    /// If the device fails, or `progress` stopped the run.
    pub async fn run_to(
        &mut self,
        place: usize,
        progress: impl FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<(), RenderError> {
        let left = |renderer: &Self| place.checked_sub(renderer.pass_count()).filter(|&left| left > 0);
        self.run_while(left, progress).await
    }

    /// Runs while `left` returns how many passes may follow.
    async fn run_while(
        &mut self,
        left: impl Fn(&Self) -> Option<usize>,
        mut progress: impl FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<(), RenderError> {
        // Enough passes to hide the latency of the read-back, few enough rays to report often.
        let most = self.executor.most_passes();
        let mut batch = 8.min(most);
        while let Some(left_here) = left(self) {
            let submitted = batch.min(left_here);
            let recorded = self.advance(submitted).await?;
            if recorded == 0 {
                break;
            }
            // If fewer were needed than submitted, a kernel is about to become idle, and the rest was wasted.
            let wanted = if 2 * recorded < submitted { 2 * recorded } else { 2 * batch };
            // Passes that launch every ray cost as much at the end as at the beginning.
            let walking = self.undecided();
            // If no ray is walking, all rays of the next sample soon will be.
            let launched = if self.plan.features.live_lists && walking > 0 { walking } else { self.plan.rays };
            batch = wanted.min((RAYS_A_BATCH / launched.max(1)) as usize).max(2).min(most);
            let is_over = left(self).is_none() || self.next_kernel().is_none();
            if progress(&self.progress()).is_break() && !is_over {
                return Err(RenderError::Cancelled { passes: self.pass_count() });
            }
        }
        Ok(())
    }

    /// Runs until this many samples of every pixel are complete, or to the end if that comes first. Then
    /// [`image`](Self::image) is the mean of exactly those, even if passes of the next sample have run too (with counters,
    /// none has), and the run can be continued: one run of 1,024 samples gives the images of 2, 4, 8, … on its way. `progress` is called
    /// between batches of passes and may stop the run.
    ///
    /// # Errors
    /// If the device fails, or `progress` stopped the run.
    pub async fn run_to_sample(
        &mut self,
        samples: u32,
        progress: impl FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<(), RenderError> {
        self.run_while(|renderer| (renderer.samples() < samples).then_some(usize::MAX), progress).await
    }

    /// Submits up to `most` passes, and records those that the schedule required.
    async fn advance(&mut self, most: usize) -> Result<usize, RenderError> {
        self.settle().await?;
        self.submit(most).await
    }

    /// Whether the streams do not match the recorded passes, because a caller dropped a future that waited for passes.
    /// The next pass runs all of them again, from unwritten streams.
    #[must_use]
    pub fn is_ahead(&self) -> bool {
        self.is_ahead
    }

    /// Makes streams and recorded passes match. Passes are deterministic: the recorded ones are run again.
    pub(super) async fn settle(&mut self) -> Result<(), RenderError> {
        if self.is_ahead {
            let place = self.pass_count();
            self.begin();
            while self.pass_count() < place && self.submit(1).await? > 0 {}
        }
        Ok(())
    }

    async fn submit(&mut self, most: usize) -> Result<usize, RenderError> {
        if self.is_over_bound() {
            self.give_up_walks().await?;
        }
        let is_own = !self.plan.program.files.is_empty();
        if is_own && self.pass_count() as u64 >= self.pass_bound && self.next_kernel().is_some() {
            let waiting = self.population.told(self.plan.program.states);
            return Err(RenderError::Endless { passes: self.pass_bound, waiting });
        }
        let foreseen = self.foreseen.get(self.pass_count()..).filter(|left| !left.is_empty());
        let mut guess = match foreseen {
            Some(left) => left[..left.len().min(most)].to_vec(),
            None => {
                let is_alone = |kernel| self.executor.is_alone(kernel);
                self.cursor.guess(&self.plan.schedule, self.scheduled(), most, is_alone)
            }
        };
        // The counters restart with every sample: who sums them reads them between two samples. And none follows the last.
        let samples = if self.plan.counters().is_some() { 1 } else { self.samples_wanted() - self.samples() };
        let mut ends = (1..).zip(&guess).filter(|(_, call)| call.kernel.role() == Role::Sample);
        if let Some((length, _)) = ends.nth(samples.saturating_sub(1) as usize) {
            guess.truncate(length);
        }
        if guess.is_empty() {
            return Ok(0);
        }
        self.is_ahead = true;
        let results = self.executor.run(&guess, &self.population.in_state, &self.data).await?;
        let mut recorded = 0;
        // Whether the rays in each state are known.
        let mut is_counted = true;
        for result in &results {
            let mut ahead = self.cursor.clone();
            if ahead.next(&self.plan.schedule, self.scheduled()) != Some(result.kernel) {
                // The remaining passes were submitted ahead, for rays that have already left.
                let differs = |counts: &StateCounts| is_counted && *counts != self.population.in_state;
                if results[recorded..].iter().any(|r| r.counts.as_ref().is_some_and(differs)) {
                    return Err(RenderError::Overshoot(self.pass_count()));
                }
                break;
            }
            let rays_in = match result.kernel.takes() {
                [] => result.elements,
                _ => result.kernel.live(&self.population.in_state),
            };
            let sample = self.cursor.samples;
            self.cursor = ahead;
            is_counted &= result.counts.is_some();
            if let Some(counts) = &result.counts {
                self.population.in_state.clone_from(counts);
            }
            self.population.in_set.clone_from(&result.sizes);
            self.believe(result.kernel, result.is_active.unwrap_or(rays_in > 0));
            let pass = Pass {
                index: self.pass_count(),
                sample,
                iteration: self.cursor.iteration,
                loops: self.cursor.loops(),
                parameter: self.cursor.parameter,
                kernel: result.kernel,
                rays_in,
                counts: self.population.in_state.clone(),
                threads_launched: result.threads_launched,
                encode_ns: result.encode_ns,
                begin_ns: result.begin_ns,
                duration_ns: result.duration_ns,
                rounding: result.rounding,
            };
            self.records.push(pass, is_counted, &result.draws);
            recorded += 1;
        }
        // Passes that were not needed have changed nothing.
        if let Some(counts) = results.last().and_then(|last| last.counts.as_ref()) {
            self.population.in_state.clone_from(counts);
        }
        self.is_ahead = false;
        Ok(recorded)
    }

    /// The rays in each state as far as the schedule knows.
    fn scheduled(&self) -> &Population {
        self.believed.as_ref().unwrap_or(&self.population)
    }

    /// What an occlusion query tells after a pass of a kernel: whether rays were there, not where they are now. If so, some
    /// may be in any state that the kernel sends them to; if not, none is in its own states.
    fn believe(&mut self, kernel: Kernel, is_active: bool) {
        let Some(believed) = &mut self.believed else { return };
        let rays = self.plan.width * self.plan.height;
        match is_active {
            true => kernel.sends().iter().for_each(|sent| believed.in_state[sent.to as usize] = rays),
            false => believed.in_state.clear(kernel.takes().iter().copied()),
        }
    }

    /// Only possible with the paper's numerics: a ray wraps over a face of the grid.
    fn is_over_bound(&self) -> bool {
        let is_first = self.unfinished == 0 || self.plan.has_more_walks();
        let is_ours = self.plan.program.files.is_empty();
        is_ours && is_first && self.undecided() > 0 && self.records.of_sample() as u64 >= self.pass_bound
    }

    /// Ends the walks that are still active. If another sample or ray follows, their rays count as misses:
    /// otherwise they would keep walking through all following samples, a sample behind the others.
    async fn give_up_walks(&mut self) -> Result<(), RenderError> {
        if !self.plan.has_more_walks() {
            self.unfinished = self.undecided();
            self.cursor.leave_walk(&self.plan.schedule);
            return Ok(());
        }
        let program = self.plan.program;
        for course in program.courses {
            if !self.plan.has_stream(course.stream) {
                continue;
            }
            let mut state = self.values(course.stream).await?;
            self.unfinished += course.give_up_walks(program.states, &mut state);
            self.write(&state);
        }
        Ok(())
    }

    fn undecided(&self) -> u64 {
        self.plan.program.states.walking(&self.population.in_state)
    }

    /// Number of rays whose hit is decided; for a program without states, the share of its elements that corresponds to
    /// the share of its passes that have run.
    fn decided(&self) -> u64 {
        let program = self.plan.program;
        if let [_, others @ ..] = program.courses {
            let mut counts = self.population.in_state.clone();
            // Other elements with states are no rays.
            others.iter().for_each(|other| counts.clear(program.states_of(other)));
            return program.states.decided(&counts);
        }
        // Steps may be repeated, how often is not known: what is not complete never looks so.
        let done = self.pass_count() as u64;
        let left = u64::from(self.next_kernel().is_some());
        self.plan.rays * done / self.plan.schedule.passes_expected().max(done + left).max(1)
    }

    /// Progress of the run.
    #[must_use]
    pub fn progress(&self) -> Progress {
        Progress {
            passes: self.pass_count(),
            rays_decided: self.decided(),
            rays: self.plan.rays,
            samples: self.samples(),
            samples_wanted: self.samples_wanted(),
            others: self.others(),
        }
    }

    /// Name of the elements that the next pass works on, if it is not those of the program's first course.
    fn others(&self) -> Option<&'static str> {
        let first = self.plan.program.course()?.stream.info().elements.name;
        self.next_kernel().map(|kernel| kernel.instance().over.name).filter(|&name| name != first)
    }

    /// Number of complete samples per pixel, of which [`image`](Self::image) is the mean.
    #[must_use]
    pub fn samples(&self) -> u32 {
        if self.plan.features.samples { self.cursor.samples } else { u32::from(self.next_kernel().is_none()) }
    }

    /// Number of samples per pixel at the end of the run.
    fn samples_wanted(&self) -> u32 {
        if self.plan.features.samples { self.data.sampling.samples } else { 1 }
    }
}

#[cfg(test)]
mod tests {
    use crate::programs::closest_hit::{kernels, states, streams};
    use raystep_scenes::{Camera, generate};

    use super::*;
    use crate::renderer::Device;
    use crate::{Options, RaySource, Samples, ScheduleKind};

    /// As if many rays never ended: the limit of passes is reached in the middle of the first walk.
    #[test]
    fn rays_that_reach_the_bound_hold_up_no_other() {
        let scene = generate::cornell_box();
        let camera = Camera::framing(&scene.bounds());
        for (schedule, samples) in [(ScheduleKind::Second, 1), (ScheduleKind::Second, 4), (ScheduleKind::First, 4)] {
            let rays = RaySource::Camera { camera: camera.clone(), width: 20, height: 20 };
            let samples = Samples { count: samples, ..Samples::default() };
            let options = Options { schedule, samples, ..Options::new(rays) };
            let outcome = pollster::block_on(async {
                let mut renderer = Renderer::new(&scene, &options, &Device::Cpu(None)).await?;
                renderer.pass_bound = 9;
                let (mut unfinished, mut times) = (0, 0);
                while renderer.step().await?.is_some() {
                    times += u32::from(renderer.unfinished() > unfinished);
                    unfinished = renderer.unfinished();
                    // A sample takes the limit of passes, and those that begin and end it.
                    let most = samples.count as usize * (9 + 4);
                    assert!(
                        renderer.passes().len() <= most,
                        "{} passes: the limit does not hold",
                        renderer.passes().len()
                    );
                }
                assert_eq!(times, samples.count, "rays reach the limit in every sample");
                let ended = u64::from(renderer.live()[states::DONE as usize]);
                assert_eq!(ended + renderer.undecided(), 400);
                if samples.count > 1 {
                    let counts = renderer.values(streams::ACCUMULATED).await?;
                    let complete = counts.layer(4).iter().filter(|&&n| f32::from_bits(n) == 4.0).count();
                    assert_eq!((complete as u64, ended, renderer.samples()), (400, 400, 4), "no ray lags behind");
                }
                Ok::<(), RenderError>(())
            });
            assert!(outcome.is_ok(), "{outcome:?}");
        }
    }

    /// The limit applies to each sample's passes, not to the run's.
    #[test]
    fn a_bound_that_no_sample_reaches_ends_no_walk() {
        let scene = generate::cornell_box();
        let rays = RaySource::Camera { camera: Camera::framing(&scene.bounds()), width: 20, height: 20 };
        let samples = Samples { count: 4, ..Samples::default() };
        let options = Options { schedule: ScheduleKind::Second, samples, ..Options::new(rays) };
        let outcome = pollster::block_on(async {
            let mut renderer = Renderer::new(&scene, &options, &Device::Cpu(None)).await?;
            renderer.run(|_| ControlFlow::Continue(())).await?;
            let begins = |pass: &Pass| pass.kernel == kernels::GENERATE;
            let longest = renderer.passes().split(begins).map(<[Pass]>::len).max().unwrap_or(0);
            let (image, passes) = (renderer.image().await?, renderer.pass_count());
            renderer.restart();
            renderer.pass_bound = longest as u64;
            renderer.run(|_| ControlFlow::Continue(())).await?;
            assert_eq!((renderer.unfinished(), renderer.pass_count()), (0, passes));
            assert_eq!(renderer.image().await?, image);
            // The run reaches half of it.
            renderer.restart();
            renderer.pass_bound = longest as u64 / 2;
            renderer.run(|_| ControlFlow::Continue(())).await?;
            assert!(renderer.unfinished() > 0);
            Ok::<(), RenderError>(())
        });
        assert!(outcome.is_ok(), "{outcome:?}");
    }
}
