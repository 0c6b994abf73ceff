//! Submits passes in batches, and reads back what each of them did.

use super::FragmentExecutor;
use super::bound::Bindable;
use super::parts::{Parts, Read, time_of};
use super::pipelines::Query;
use super::results::{read_queries, read_statistics};
use crate::executor::gpu::books::read_sent;
use crate::executor::gpu::readback::Readback;
use crate::executor::gpu::rounding::Runs;
use crate::executor::gpu::timers::read_times;
use crate::executor::gpu::{GpuError, MOST_PASSES};
use crate::executor::{Drawing, PassResult, timed};
use crate::options::mapping::{Until, Update};
use crate::program::Kernel;
use crate::program::schedule::Call;
use crate::tables::sizes::COUNT_SLOT_BYTES;
use crate::tables::state::StateCounts;
use crate::tables::stream::STATE_TAG;

impl FragmentExecutor {
    /// Submits passes, at most [`MOST_PASSES`], and resolves to what each of them did.
    ///
    /// # Errors
    /// If the device is lost or refuses.
    pub(crate) async fn run(&mut self, calls: &[Call]) -> Result<Vec<PassResult>, GpuError> {
        self.gpu.health()?;
        // Programs that are drawn have no parameters.
        let passes: Vec<Kernel> = calls.iter().take(MOST_PASSES).map(|call| call.kernel).collect();
        if passes.is_empty() {
            return Ok(Vec::new());
        }
        let host_clock = self.gpu.host_clock();
        let begin = host_clock.map(|now| now());
        let scopes = self.gpu.push_scopes();
        let count = passes.len() as u32;
        let sent_bytes = u64::from(count) * COUNT_SLOT_BYTES;
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        if let Some([sent, _]) = &self.results.sent {
            encoder.clear_buffer(sent, 0, Some(sent_bytes));
        }
        let mut parts = Parts::new(self.timers.as_ref().map(|timers| timers.each_pass));
        let mut encoded = Vec::with_capacity(passes.len());
        for (slot, &kernel) in (0..).zip(&passes) {
            parts.begin_pass();
            let is_last = slot + 1 == count;
            let (recorded, encode_ns) =
                timed(host_clock, || self.encode(&mut encoder, kernel, slot, is_last, &mut parts));
            recorded?;
            encoded.push(encode_ns);
        }
        if let Some([sent, copy]) = &self.results.sent {
            encoder.copy_buffer_to_buffer(sent, 0, copy, 0, sent_bytes);
        }
        let is_queried = self.is_queried;
        let query_bytes = if is_queried { self.results.occlusion.encode_read(&mut encoder, count) } else { 0 };
        let time_bytes = self.timers.as_ref().map_or(0, |timers| timers.encode_read(&mut encoder, parts.stamps()));
        let statistics = self.results.statistics.as_ref();
        let statistics = statistics.map(|s| (s.copy.clone(), s.encode_read(&mut encoder, parts.statistics())));
        self.gpu.submit([encoder.finish()]);
        let read = |buffer: &wgpu::Buffer, bytes| Readback::start(&self.gpu, buffer.clone(), bytes);
        let sent = self.results.sent.as_ref().map(|[_, copy]| read(copy, sent_bytes));
        let queries = is_queried.then(|| read(&self.results.occlusion.copy, query_bytes));
        let times = self.timers.as_ref().map(|timers| (timers.ticks, read(&timers.copy, time_bytes)));
        let statistics = statistics.map(|(copy, bytes)| (read(&copy, bytes), bytes));
        self.gpu.pop_scopes(scopes).await?;

        let states = self.plan.program.states.0.len();
        let sent = match sent {
            Some(sent) => Some(sent.finish(sent_bytes, |bytes| read_sent(bytes, states)).await?),
            None => None,
        };
        let mut active = Vec::new();
        if let Some(queries) = queries {
            active = queries.finish(query_bytes, read_queries).await?;
        }
        // Without what the host counts, which is no part of the passes.
        let took = host_clock.zip(begin).map(|(now, begin)| now().saturating_sub(begin));
        self.host_ns = self.host_ns.zip(took).map(|(sum, took)| sum + took);
        let sent = match sent {
            Some(sent) => sent,
            // Only the last is asked for.
            None => vec![self.counted_by_host().await?; passes.len()],
        };
        let mut found = Read::default();
        if let Some((ticks, times)) = times {
            found.times = times.finish(time_bytes, |bytes| read_times(bytes, ticks)).await?;
        }
        if let Some((statistics, bytes)) = statistics {
            found.fragments = statistics.finish(bytes, read_statistics).await?;
        }
        let span = found.span();
        // Without the time of one batch, the sum is unknown.
        self.device_ns = self.device_ns.zip(span).map(|(sum, span)| sum + span);
        let size = self.plan.size();
        let step_ns = self.timers.as_ref().and_then(|timers| timers.coarse_step_ns);
        let result = |(index, &kernel): (usize, &Kernel)| {
            let is_counted = self.counts_each || index + 1 == passes.len();
            let draws = parts.of_pass(index, &found);
            let (begin_ns, mut duration_ns) = time_of(&draws);
            let runs = step_ns.map(|step_ns| {
                let mut runs = Runs::new(step_ns);
                runs.add(&[(begin_ns, duration_ns)]);
                duration_ns = runs.duration_ns();
                runs
            });
            let drawn = draws.iter().filter(|draw| draw.what != Drawing::Copies).count() as u64;
            PassResult {
                kernel,
                counts: is_counted.then(|| sent[index].clone()),
                sizes: vec![size.count],
                is_active: active.get(index).copied(),
                elements: size.count,
                threads_launched: size.texels() * drawn,
                encode_ns: encoded[index],
                begin_ns,
                duration_ns,
                rounding: runs.and_then(|runs| runs.rounding()),
                draws,
            }
        };
        Ok(passes.iter().enumerate().map(result).collect())
    }

    /// The rays in each state, from the states themselves.
    async fn counted_by_host(&self) -> Result<StateCounts, GpuError> {
        let program = self.plan.program;
        let mut counts = StateCounts::none(program.states);
        let state = program.state_stream().ok_or(GpuError::Missing("fragment"))?;
        let read = self.read(state).await?.ok_or(GpuError::Missing(state.name()))?;
        read.layer(STATE_TAG).iter().for_each(|&tag| counts.add(tag, 1));
        Ok(counts)
    }

    /// A pass of a kernel: copies, the depths, its draws, and a count of its rays.
    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        kernel: Kernel,
        slot: u32,
        is_last: bool,
        parts: &mut Parts,
    ) -> Result<(), GpuError> {
        let states = self.plan.program.states.0.len() as u64;
        let Self { pipelines, streams, timers, results, buffers, gpu, how, is_queried, copies, .. } = self;
        let index = pipelines.index(kernel).ok_or(GpuError::Missing(kernel.name()))?;
        let timers = timers.as_ref();
        let copied = match how.update {
            Update::Copy => pipelines.drawn[index].updates.clone(),
            Update::Swap => Vec::new(),
        };
        // An empty pass: copies alone have no timestamps.
        if let Some([begin, end]) = parts.begin_copies(!copied.is_empty()) {
            let timestamp_writes = timers.and_then(|timers| timers.writes(begin, end));
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("begin"), timestamp_writes });
        }
        for &stream in &copied {
            let textures = streams.get(stream).ok_or(GpuError::Missing(stream.name()))?;
            let (from, to) = (textures.current(), textures.other());
            encoder.copy_texture_to_texture(from.as_image_copy(), to.as_image_copy(), from.size());
        }
        let with = Bindable {
            device: &gpu.device,
            streams,
            buffers,
            sent: results.sent.as_ref().map(|[sent, _]| sent),
            states,
            slot,
            copied: &copied,
        };
        let statistics = results.statistics.as_ref();
        let draws = pipelines.drawn[index].draws.len();
        if pipelines.has_depth() {
            let [begin, end] = parts.begin_draw(Drawing::Depths, false);
            let query = statistics.map(|statistics| Query::Fragments(&statistics.set, parts.next_statistic()));
            pipelines.draw_depth(encoder, &with, query, timers.and_then(|timers| timers.draw_writes(begin, end)))?;
        }
        for draw in 0..draws {
            let is_last_draw = draw + 1 == draws;
            let [begin, end] = parts.begin_draw(Drawing::Draw(draw), is_last && is_last_draw);
            let query = match how.until {
                Until::Query => (is_last_draw && *is_queried).then_some(Query::Occlusion(&results.occlusion.set, slot)),
                Until::Count => statistics.map(|statistics| Query::Fragments(&statistics.set, parts.next_statistic())),
            };
            let timestamp_writes = timers.and_then(|timers| timers.draw_writes(begin, end));
            pipelines.draw(encoder, (index, draw), &with, query, timestamp_writes)?;
        }
        let written: Vec<_> = pipelines.drawn[index].writes().collect();
        for stream in written {
            copies.forget(stream);
            if how.update == Update::Swap {
                streams.swap(stream);
            }
        }
        if self.counts_each || is_last {
            let with = Bindable {
                device: &gpu.device,
                streams,
                buffers,
                sent: results.sent.as_ref().map(|[sent, _]| sent),
                states,
                slot,
                copied: &[],
            };
            pipelines.count(encoder, &with)?;
        }
        Ok(())
    }
}
