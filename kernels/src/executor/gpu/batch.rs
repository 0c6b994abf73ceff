//! Submits passes in batches and reads back what each pass did.

use super::books::{Place, Wrong, blocks_a_dispatch, counted_anew, counts_after, read_sent, read_wrong};
use super::rounding::Runs;
use super::timers::read_times;
use super::{GpuError, GpuExecutor, MOST_PASSES};
use crate::executor::gpu::readback::Readback;
use crate::executor::sizes::Sizes;
use crate::executor::{PassResult, timed};
use crate::program::schedule::Call;
use crate::program::{Instance, Kernel};
use crate::tables::elements::Size;
use crate::tables::kernel::{Launch, Role};
use crate::tables::sizes::COUNT_SLOT_BYTES;
use crate::tables::state::StateCounts;
use crate::tables::stream::Stream;

/// Most dispatches of one pass per submission: enough to make the overhead of a submission small, and few enough that a
/// submission takes less than the two seconds after which some systems reset the GPU.
const DISPATCHES_A_SUBMISSION: usize = 8;
const _: () = assert!(DISPATCHES_A_SUBMISSION <= MOST_PASSES);

impl GpuExecutor {
    /// Submits passes, at most [`MOST_PASSES`], and resolves to what each of them did. `counts` are the rays in each
    /// state before the first.
    ///
    /// # Errors
    /// If the device is lost or refuses.
    pub async fn run(&mut self, calls: &[Call], counts: &StateCounts) -> Result<Vec<PassResult>, GpuError> {
        self.gpu.health()?;
        let passes: Vec<Kernel> = calls.iter().take(MOST_PASSES).map(|call| call.kernel).collect();
        let passes = passes.as_slice();
        let sizes = self.sizes.clone();
        let passes = self.sized(passes).await?;
        let counts = &self.with_new_sets(&sizes, counts);
        let passes = self.one_if_repeated(passes);
        let is_repeated = self.can_repeat(passes).await?;
        let count = passes.len() as u64;
        if passes.is_empty() {
            return Ok(Vec::new());
        }
        let host_clock = self.gpu.host_clock();
        let begin = host_clock.map(|now| now());
        self.forget_written(passes);
        let scopes = self.gpu.push_scopes();
        let sizes: Vec<Size> = passes.iter().map(|&kernel| self.launched_over(kernel)).collect();
        let places = self.books.lay_out(&self.gpu.queue, calls, counts, &sizes);
        for (&kernel, place) in passes.iter().zip(&places) {
            self.pipelines.prepare(kernel, place, &self.gpu.device, &self.books)?;
        }
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(&self.books.sent, 0, Some(count * COUNT_SLOT_BYTES));
        if is_repeated {
            self.encode_keep(&mut encoder, passes[0]);
        }
        let (encoded, encode_ns) = timed(host_clock, || match *passes {
            [kernel] if kernel.info().launch == Launch::Bands => {
                self.encode_bands(encoder, kernel, &places[0]).map(|encoder| (encoder, Vec::new()))
            }
            [kernel] if self.blocks_a_dispatch(kernel).is_some() => {
                self.encode_list(encoder, calls[0], &places[0]).map(|encoder| (encoder, Vec::new()))
            }
            _ => self.encode_all(encoder, passes, &places),
        });
        let (mut encoder, mut encoded) = encoded?;
        if encoded.is_empty() {
            encoded.push(encode_ns);
        }
        // A pass whose rays are counted afterwards is submitted alone.
        let is_counted_anew = matches!(passes, [kernel] if kernel.is_counted_anew(&self.plan.features));
        if is_counted_anew {
            self.encode_count(&mut encoder, passes[0])?;
        }
        encoder.copy_buffer_to_buffer(&self.books.sent, 0, &self.books.copy, 0, count * COUNT_SLOT_BYTES);
        let timers = self.timers.as_ref();
        let time_bytes = timers.map_or(0, |t| t.encode_read(&mut encoder, t.queries(count as u32)));
        self.gpu.submit([encoder.finish()]);
        if let [kernel] = *passes {
            self.end_bands(kernel);
        }
        let sent = Readback::start(&self.gpu, self.books.copy.clone(), count * COUNT_SLOT_BYTES);
        let times = timers.map(|t| (t.ticks, Readback::start(&self.gpu, t.copy.clone(), time_bytes)));
        self.gpu.pop_scopes(scopes).await?;

        let states = self.plan.program.states.0.len();
        let (sent, wrong) =
            sent.finish(count * COUNT_SLOT_BYTES, |bytes| (read_sent(bytes, states), read_wrong(bytes))).await?;
        self.check_users(passes, &wrong)?;
        // The passes are over by now; reading their timestamps is not part of their time.
        let took = host_clock.zip(begin).map(|(now, begin)| now().saturating_sub(begin));
        self.host_ns = self.host_ns.zip(took).map(|(sum, took)| sum + took);
        let mut times = match times {
            Some((ticks, times)) => times.finish(time_bytes, |bytes| read_times(bytes, ticks)).await?,
            None => Vec::new(),
        };
        let mut runs = vec![None; passes.len()];
        if let Some(step_ns) = self.timers.as_ref().and_then(|t| t.coarse_step_ns) {
            for ((time, runs), (&kernel, place)) in times.iter_mut().zip(&mut runs).zip(passes.iter().zip(&places)) {
                let runs = runs.insert(Runs::new(step_ns));
                if runs.add(&[*time]) && is_repeated {
                    self.repeat(kernel, place, runs).await?;
                }
                time.1 = runs.estimate_ns();
            }
        }
        self.note_span(&times);
        if !self.timers.as_ref().is_some_and(|t| t.each_pass) {
            times = vec![(None, None); passes.len()];
        }
        let mut now = counts.clone();
        let mut results = Vec::with_capacity(passes.len());
        let launched = passes.iter().zip(&places).zip(sizes);
        let timed = times.into_iter().zip(runs).zip(encoded);
        for ((((&kernel, place), size), sent), (((begin_ns, duration_ns), runs), encode_ns)) in
            launched.zip(sent).zip(timed)
        {
            let threads_launched = place.threads(kernel, &now, size);
            let elements = size.count;
            now = if is_counted_anew { counted_anew(kernel, &now, &sent) } else { counts_after(kernel, &now, &sent) };
            let duration_ns = runs.map_or(duration_ns, |runs: Runs| runs.duration_ns());
            let rounding = runs.and_then(|runs| runs.rounding());
            let (counts, sizes) = (Some(now.clone()), self.sizes.counts());
            results.push(PassResult {
                kernel,
                counts,
                sizes,
                is_active: None,
                elements,
                threads_launched,
                encode_ns,
                begin_ns,
                duration_ns,
                rounding,
                draws: Vec::new(),
            });
        }
        Ok(results)
    }

    /// Whether all loops of users' kernels have ended in these passes, and their assertions hold.
    fn check_users(&self, passes: &[Kernel], wrong: &[Wrong]) -> Result<(), GpuError> {
        for (&kernel, [line, failed @ ..]) in passes.iter().zip(wrong) {
            let Some(variant) = self.plan.variant(kernel) else { continue };
            let Some(replaced) = &variant.replaced else { continue };
            if *line > 0 {
                let place = variant.named_line(*line as usize);
                return Err(GpuError::Endless { place, turns: self.plan.turns });
            }
            let labelled = replaced.notes.asserted.iter().zip(failed).find(|(_, count)| **count > 0);
            if let Some((label, &count)) = labelled {
                let (file, label) = (replaced.by.file.clone(), label.clone());
                // Kernels of a user's program replace no others, which check-kernel would compare with.
                let is_own = !self.plan.program.files.is_empty();
                let by = if is_own { "'raystep run FOLDER --device cpu'" } else { "'raystep check-kernel'" };
                return Err(GpuError::Assertion { file, label, count, by });
            }
        }
        Ok(())
    }

    /// Adds the time from a batch's first begin to its last end.
    fn note_span(&mut self, times: &[(Option<u64>, Option<u64>)]) {
        let ends = times.last().and_then(|&(begin, duration)| begin.zip(duration)).map(|(b, d)| b + d);
        let span = times.first().and_then(|t| t.0).zip(ends).and_then(|(begin, end)| end.checked_sub(begin));
        // Without the time of one batch, the sum is unknown.
        self.device_ns = self.device_ns.zip(span).map(|(sum, span)| sum + span);
    }

    /// Records passes; also returns how long each of them took.
    fn encode_all(
        &self,
        mut encoder: wgpu::CommandEncoder,
        passes: &[Kernel],
        places: &[Place],
    ) -> Result<(wgpu::CommandEncoder, Vec<Option<u64>>), GpuError> {
        let clock = self.gpu.host_clock();
        let mut encoded = Vec::with_capacity(passes.len());
        let each = self.timers.as_ref().filter(|t| t.each_pass);
        if let Some(timers) = each {
            for (i, (&kernel, place)) in (0..).zip(passes.iter().zip(places)) {
                self.encode_copies(&mut encoder, kernel);
                let (recorded, encode_ns) = timed(clock, || {
                    let timestamp_writes = timers.writes(Some(2 * i), Some(2 * i + 1));
                    let label = self.pipelines.get(kernel).map(|pipeline| pipeline.label.as_str());
                    let descriptor = wgpu::ComputePassDescriptor { label, timestamp_writes };
                    self.dispatch(&mut encoder.begin_compute_pass(&descriptor), kernel, place, None)
                });
                recorded?;
                encoded.push(encode_ns);
            }
            return Ok((encoder, encoded));
        }
        // A copy ends what a device counts as one pass.
        let has_copies = |kernel: &Kernel| !kernel.instance().copies.is_empty();
        let mut done = 0;
        for part in passes.chunk_by(|_, next| !has_copies(next)) {
            self.encode_copies(&mut encoder, part[0]);
            let (is_first, is_last) = (done == 0, done + part.len() == passes.len());
            let (begin, end) = (is_first.then_some(0), is_last.then_some(1));
            let timestamp_writes = self.timers.as_ref().and_then(|t| t.writes(begin, end));
            let descriptor = wgpu::ComputePassDescriptor { label: Some(self.plan.program.name), timestamp_writes };
            let mut pass = encoder.begin_compute_pass(&descriptor);
            for (&kernel, place) in part.iter().zip(&places[done..]) {
                let (recorded, encode_ns) = timed(clock, || self.dispatch(&mut pass, kernel, place, None));
                recorded?;
                encoded.push(encode_ns);
            }
            done += part.len();
        }
        Ok((encoder, encoded))
    }

    /// Copies the streams of which a kernel loads other elements than it stores.
    fn encode_copies(&self, encoder: &mut wgpu::CommandEncoder, kernel: Kernel) {
        for (to, from) in kernel.instance().copies {
            if let (Some(to), Some(from)) = (self.texture(*to), self.texture(*from)) {
                encoder.copy_texture_to_texture(from.as_image_copy(), to.as_image_copy(), from.size());
            }
        }
    }

    pub(super) fn blocks_a_dispatch(&self, kernel: Kernel) -> Option<u32> {
        blocks_a_dispatch(kernel, self.launched_over(kernel), self.work_a_dispatch)
    }

    /// Runs a kernel over a list in as many dispatches as it takes to keep each of them short.
    fn encode_list(
        &self,
        mut encoder: wgpu::CommandEncoder,
        Call { kernel, parameter }: Call,
        place: &Place,
    ) -> Result<wgpu::CommandEncoder, GpuError> {
        let size = self.launched_over(kernel);
        let [x, y] = kernel.groups(size);
        let blocks = x * y;
        let a_dispatch = self.blocks_a_dispatch(kernel).unwrap_or(blocks);
        let pipeline = self.pipelines.get(kernel).ok_or(GpuError::Missing(kernel.name()))?;
        self.encode_copies(&mut encoder, kernel);
        let all: Vec<u32> = (0..blocks).step_by(a_dispatch as usize).collect();
        for submitted in all.chunks(DISPATCHES_A_SUBMISSION) {
            if submitted[0] > 0 {
                self.gpu.submit([encoder.finish()]);
                encoder = self.gpu.device.create_command_encoder(&Default::default());
            }
            // Values written to a uniform take effect with the next submission.
            self.books.begin_at(&self.gpu.queue, parameter, size, submitted);
            for (slot, &first) in (0..).zip(submitted) {
                let is_last = first + a_dispatch >= blocks;
                let timestamp_writes =
                    self.timers.as_ref().and_then(|t| t.writes((first == 0).then_some(0), is_last.then_some(1)));
                let descriptor = wgpu::ComputePassDescriptor { label: Some(&pipeline.label), timestamp_writes };
                let mut pass = encoder.begin_compute_pass(&descriptor);
                pipeline.set(&mut pass, &place.at_slot(slot))?;
                pass.dispatch_workgroups(a_dispatch.min(blocks - first), 1, 1);
            }
        }
        Ok(encoder)
    }

    /// Counts the elements in each state, after the batch's only pass.
    fn encode_count(&mut self, encoder: &mut wgpu::CommandEncoder, after: Kernel) -> Result<(), GpuError> {
        let counts = |kernel: &Kernel| kernel.role() == Role::Count && kernel.instance().over == after.instance().over;
        let counter = self.plan.program.kernels().find(counts).ok_or(GpuError::Missing("count"))?;
        self.pipelines.prepare(counter, &Place::default(), &self.gpu.device, &self.books)?;
        let label = self.pipelines.get(counter).map(|pipeline| pipeline.label.as_str());
        let descriptor = wgpu::ComputePassDescriptor { label, timestamp_writes: None };
        self.dispatch(&mut encoder.begin_compute_pass(&descriptor), counter, &Place::default(), None)
    }

    /// The counts after some sets may have got other sizes: their elements are unborn.
    fn with_new_sets(&self, before: &Sizes, counts: &StateCounts) -> StateCounts {
        let program = self.plan.program;
        let mut counts = if counts.is_empty() { StateCounts::none(program.states) } else { counts.clone() };
        for course in program.courses {
            let elements = course.stream.info().elements;
            let size = self.sizes.of(program, elements);
            if before.of(program, elements) != size {
                counts.clear(program.states_of(course));
                counts.add(course.unborn, size.map_or(0, |size| size.texels() as u32));
            }
        }
        counts
    }

    /// As many of these passes as can be submitted together. A pass that waits for elements to be counted must be the
    /// first of a batch, and their number is read back before it.
    async fn sized<'a>(&mut self, passes: &'a [Kernel]) -> Result<&'a [Kernel], GpuError> {
        let Some(&first) = passes.first() else { return Ok(passes) };
        let mut sizes = self.sizes.clone();
        sizes.renew(self.plan.program, first);
        let adopted = sizes.adopt(self.plan.program, first)?;
        // Several numbers may be in one stream.
        let mut texels: Vec<(Stream, Vec<u32>)> = Vec::new();
        while let Some(unknown) = sizes.unknown(&self.plan, first) {
            let missing = GpuError::Missing(unknown.stream.name());
            let count = match texels.iter().find(|(stream, _)| *stream == unknown.stream) {
                Some((_, layers)) => layers.get(unknown.layer).copied(),
                None => {
                    let found = self.read_texels(&[unknown.stream], 0, 0).await?.and_then(|mut found| found.pop());
                    let layers = found.unwrap_or_default();
                    let count = layers.get(unknown.layer).copied();
                    texels.push((unknown.stream, layers));
                    count
                }
            };
            sizes.found(self.plan.program, unknown, count.ok_or(missing)?)?;
        }
        if sizes != self.sizes {
            let scopes = self.gpu.push_scopes();
            let resized = self.resize_adopting(sizes, &adopted);
            self.gpu.pop_scopes(scopes).await?;
            resized?;
        }
        if self.blocks_a_dispatch(first).is_some() {
            return Ok(&passes[..1]);
        }
        let is_ready = |kernel: Kernel| {
            let Instance { renews, adopts, .. } = kernel.instance();
            let keeps_sizes = renews.is_empty() && adopts.is_empty();
            keeps_sizes && self.sizes.unknown(&self.plan, kernel).is_none() && self.blocks_a_dispatch(kernel).is_none()
        };
        let others = passes[1..].iter().take_while(|&&kernel| is_ready(kernel)).count();
        Ok(&passes[..1 + others])
    }

    pub(super) fn dispatch(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        kernel: Kernel,
        place: &Place,
        rows: Option<u32>,
    ) -> Result<(), GpuError> {
        let pipeline = self.pipelines.get(kernel).ok_or(GpuError::Missing(kernel.name()))?;
        pass.push_debug_group(&pipeline.label);
        pipeline.set(pass, place)?;
        match self.books.arguments(place) {
            Some((buffer, offset)) => pass.dispatch_workgroups_indirect(buffer, offset),
            None => {
                let [x, y] = kernel.groups(self.launched_over(kernel));
                pass.dispatch_workgroups(x, rows.unwrap_or(y), 1);
            }
        }
        pass.pop_debug_group();
        Ok(())
    }
}
