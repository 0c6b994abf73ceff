//! Submits passes in batches, and reads back what each of them did.

use super::FragmentExecutor;
use super::pipelines::Bindable;
use super::results::read_queries;
use crate::executor::PassResult;
use crate::executor::gpu::books::read_sent;
use crate::executor::gpu::readback::Readback;
use crate::executor::gpu::timers::{Times, read_times};
use crate::executor::gpu::{GpuError, MOST_PASSES};
use crate::options::mapping::{Until, Update};
use crate::program::Kernel;
use crate::tables::sizes::COUNT_SLOT_BYTES;

impl FragmentExecutor {
    /// Submits passes, at most [`MOST_PASSES`], and resolves to what each of them did.
    ///
    /// # Errors
    /// If the device is lost or refuses.
    pub(crate) async fn run(&mut self, passes: &[Kernel]) -> Result<Vec<PassResult>, GpuError> {
        self.gpu.health()?;
        let passes = &passes[..passes.len().min(MOST_PASSES)];
        if passes.is_empty() {
            return Ok(Vec::new());
        }
        let host_clock = self.gpu.host_clock();
        let begin = host_clock.map(|now| now());
        let scopes = self.gpu.push_scopes();
        let count = passes.len() as u32;
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(&self.results.sent, 0, Some(u64::from(count) * COUNT_SLOT_BYTES));
        // An empty pass, from whose timestamp on copies count, too.
        let each = self.timers.as_ref().is_some_and(|timers| timers.each_pass);
        let mut stamps = Stamps { each, next: 0, of_passes: Vec::new() };
        for (slot, &kernel) in (0..).zip(passes) {
            self.encode(&mut encoder, kernel, slot, slot + 1 == count, &mut stamps)?;
        }
        encoder.copy_buffer_to_buffer(
            &self.results.sent,
            0,
            &self.results.sent_copy,
            0,
            u64::from(count) * COUNT_SLOT_BYTES,
        );
        let is_queried = self.drawn.how.until == Until::Query;
        let query_bytes = if is_queried { self.results.encode_queries(&mut encoder, count) } else { 0 };
        let time_bytes = self.timers.as_ref().map_or(0, |timers| timers.encode_read(&mut encoder, stamps.next));
        self.gpu.submit([encoder.finish()]);
        let sent = Readback::start(&self.gpu, self.results.sent_copy.clone(), u64::from(count) * COUNT_SLOT_BYTES);
        let queries = is_queried.then(|| Readback::start(&self.gpu, self.results.queries_copy.clone(), query_bytes));
        let times = self.timers.as_ref().map(|t| (t.ticks, Readback::start(&self.gpu, t.copy.clone(), time_bytes)));
        self.gpu.pop_scopes(scopes).await?;

        let sent = sent.finish(u64::from(count) * COUNT_SLOT_BYTES, read_sent).await?;
        let took = host_clock.zip(begin).map(|(now, begin)| now().saturating_sub(begin));
        self.host_ns = self.host_ns.zip(took).map(|(sum, took)| sum + took);
        let active = match queries {
            Some(queries) => Some(queries.finish(query_bytes, read_queries).await?),
            None => None,
        };
        let times = match times {
            Some((ticks, times)) => times.finish(time_bytes, |bytes| read_times(bytes, ticks)).await?,
            None => Vec::new(),
        };
        self.note_span(&times);
        let size = self.plan.size();
        let mut results = Vec::with_capacity(passes.len());
        for (index, &kernel) in passes.iter().enumerate() {
            let is_counted = self.counts_each || index + 1 == passes.len();
            let (begin_ns, duration_ns) = stamps.of(index, &times);
            let draws =
                self.drawn.of(kernel).map_or(0, |drawn| drawn.draws.len()) + usize::from(self.pipelines.has_depth());
            results.push(PassResult {
                kernel,
                counts: is_counted.then(|| sent[index]),
                is_active: active.as_ref().map(|active| active[index]),
                elements: size.count,
                threads_launched: size.texels() * draws as u64,
                begin_ns,
                duration_ns,
                rounding: None,
            });
        }
        Ok(results)
    }

    /// A pass of a kernel: copies, the depths, its draws, and a count of its rays.
    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        kernel: Kernel,
        slot: u32,
        is_last: bool,
        stamps: &mut Stamps,
    ) -> Result<(), GpuError> {
        let Self { pipelines, streams, timers, results, buffers, gpu, drawn, copies, .. } = self;
        let index = pipelines.index(kernel).ok_or(GpuError::Missing(kernel.name()))?;
        let first = stamps.next;
        let writes = |stamps: &mut Stamps, is_end: bool| stamps.writes(timers.as_ref(), is_end);
        if stamps.each || first == 0 {
            let timestamp_writes =
                timers.as_ref().and_then(|timers| timers.writes(Some(first), stamps.each.then_some(first + 1)));
            if timestamp_writes.is_some() {
                stamps.next += 2;
                encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("begin"), timestamp_writes });
            }
        }
        let copied = match drawn.how.update {
            Update::Copy => pipelines.drawn[index].updates.clone(),
            Update::Swap => Vec::new(),
        };
        for &stream in &copied {
            let textures = streams.get(stream).ok_or(GpuError::Missing(stream.name()))?;
            let (from, to) = (textures.current(), textures.other());
            encoder.copy_texture_to_texture(from.as_image_copy(), to.as_image_copy(), from.size());
        }
        let draws = pipelines.drawn[index].draws.len();
        {
            let with = Bindable { device: &gpu.device, streams, buffers, sent: &results.sent, copied: &copied };
            if pipelines.has_depth() {
                pipelines.draw_depth(encoder, &with, writes(stamps, false))?;
            }
            for draw in 0..draws {
                let is_last_draw = draw + 1 == draws;
                let query = (drawn.how.until == Until::Query && is_last_draw).then_some((&results.queries, slot));
                let timestamp_writes = writes(stamps, is_last && is_last_draw);
                pipelines.draw(encoder, (index, draw), &with, query, timestamp_writes)?;
            }
        }
        stamps.of_passes.push(first..stamps.next);
        let written: Vec<_> = pipelines.drawn[index].writes().collect();
        for stream in written {
            copies.forget(stream);
            if drawn.how.update == Update::Swap {
                streams.swap(stream);
            }
        }
        if self.counts_each || is_last {
            let with = Bindable { device: &gpu.device, streams, buffers, sent: &results.sent, copied: &[] };
            pipelines.count(encoder, &with, slot)?;
        }
        Ok(())
    }

    /// Adds the time from a batch's first begin to its last end.
    fn note_span(&mut self, times: &Times) {
        let span = match times.as_slice() {
            [(Some(_), Some(duration))] => Some(*duration),
            [(Some(begin), _), .., (Some(last), Some(duration))] => (last + duration).checked_sub(*begin),
            _ => None,
        };
        self.device_ns = self.device_ns.zip(span).map(|(sum, span)| sum + span);
    }
}

/// The timestamps of a batch: around each draw, or around the batch.
struct Stamps {
    each: bool,
    next: u32,
    of_passes: Vec<std::ops::Range<u32>>,
}

impl Stamps {
    /// The timestamps of the next draw; `is_end`: it is the batch's last.
    fn writes<'a>(
        &mut self,
        timers: Option<&'a super::Timers>,
        is_end: bool,
    ) -> Option<wgpu::RenderPassTimestampWrites<'a>> {
        let timers = timers?;
        if self.each {
            self.next += 2;
            return timers.draw_writes(Some(self.next - 2), Some(self.next - 1));
        }
        // The other half of the pair that the batch began with.
        if is_end { timers.draw_writes(None, Some(1)) } else { None }
    }

    /// Begin and duration of a pass, from its first to its last timestamp.
    fn of(&self, pass: usize, times: &Times) -> (Option<u64>, Option<u64>) {
        if !self.each || times.is_empty() {
            return (None, None);
        }
        let range = &self.of_passes[pass];
        let times = &times[range.start as usize / 2..range.end as usize / 2];
        let (Some(&(begin, _)), Some(&(last, duration))) = (times.first(), times.last()) else { return (None, None) };
        let end = last.zip(duration).map(|(last, duration)| last + duration);
        (begin, begin.zip(end).and_then(|(begin, end)| end.checked_sub(begin)))
    }
}
