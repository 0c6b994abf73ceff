//! Timestamps on the device's own clock: around every pass, or around a whole batch.

use super::{Gpu, MOST_PASSES};
use crate::plan::Plan;

/// How ticks of a device's clock become nanoseconds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ticks {
    pub(super) period_ns: f64,
    /// Whether times are rounded down to multiples of so many nanoseconds, as browsers do: for tests.
    pub(super) rounded_to_ns: Option<u64>,
}

impl Ticks {
    fn ns(self, ticks: u64) -> u64 {
        let ns = (ticks as f64 * self.period_ns) as u64;
        self.rounded_to_ns.map_or(ns, |step| ns - ns % step)
    }

    /// Time between two ticks, in order.
    fn between(self, begin: u64, end: u64) -> u64 {
        match self.rounded_to_ns {
            Some(_) => self.ns(end).saturating_sub(self.ns(begin)),
            None => self.ns(end - begin),
        }
    }
}

/// Begin and duration of each pass, nanoseconds.
pub(super) type Times = Vec<(Option<u64>, Option<u64>)>;

pub(super) struct Timers {
    pub(super) set: wgpu::QuerySet,
    pub(super) resolved: wgpu::Buffer,
    pub(super) copy: wgpu::Buffer,
    pub(super) ticks: Ticks,
    /// Whether to time every pass, which costs some microseconds each.
    pub(super) each_pass: bool,
    /// The clock's step, if every pass is timed and it is coarse.
    pub(super) coarse_step_ns: Option<f64>,
}

impl Timers {
    /// `None` if the device's timestamps are not valid times.
    pub(super) fn new(gpu: &Gpu, plan: &Plan, each_pass: bool) -> Option<Self> {
        Self::with_room(gpu, plan, each_pass, 2 * MOST_PASSES as u32)
    }

    /// As [`new`](Self::new), for passes that are several draws each.
    pub(super) fn of_draws(gpu: &Gpu, plan: &Plan, each_pass: bool) -> Option<Self> {
        Self::with_room(gpu, plan, each_pass, wgpu::QUERY_SET_MAX_QUERIES)
    }

    fn with_room(gpu: &Gpu, plan: &Plan, each_pass: bool, count: u32) -> Option<Self> {
        let ticks = gpu.clock_period_ns().and_then(|_| gpu.ticks())?;
        let device = &gpu.device;
        let buffer = |name, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(&plan.label(name)),
                size: 8 * u64::from(count),
                usage,
                mapped_at_creation: false,
            })
        };
        use wgpu::BufferUsages as U;
        Some(Self {
            set: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some(&plan.label("timers")),
                ty: wgpu::QueryType::Timestamp,
                count,
            }),
            resolved: buffer("timers, resolved", U::QUERY_RESOLVE | U::COPY_SRC),
            copy: buffer("timers, copy", U::COPY_DST | U::MAP_READ),
            ticks,
            each_pass,
            coarse_step_ns: gpu.coarse_step_ns().filter(|_| each_pass),
        })
    }

    /// Number of timestamps in one batch.
    pub(super) fn queries(&self, passes: u32) -> u32 {
        if self.each_pass { 2 * passes } else { 2 }
    }

    /// Copies the first timestamps to where they are read. Returns their size in bytes.
    pub(super) fn encode_read(&self, encoder: &mut wgpu::CommandEncoder, queries: u32) -> u64 {
        let bytes = 8 * u64::from(queries);
        encoder.resolve_query_set(&self.set, 0..queries, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.copy, 0, bytes);
        bytes
    }

    pub(super) fn writes(&self, begin: Option<u32>, end: Option<u32>) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        (begin.is_some() || end.is_some()).then_some(wgpu::ComputePassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: begin,
            end_of_pass_write_index: end,
        })
    }
}

impl Timers {
    /// The same for a render pass.
    pub(super) fn draw_writes(
        &self,
        begin: Option<u32>,
        end: Option<u32>,
    ) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        (begin.is_some() || end.is_some()).then_some(wgpu::RenderPassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: begin,
            end_of_pass_write_index: end,
        })
    }
}

/// Begin and duration from each pair of timestamps. An end before its begin, or 0, is not valid.
pub(super) fn read_times(bytes: &[u8], ticks: Ticks) -> Times {
    let stamps: Vec<u64> =
        bytes.chunks_exact(8).map(|b| u64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]])).collect();
    stamps
        .chunks_exact(2)
        .map(|t| match (t[0], t[1]) {
            (0, _) | (_, 0) => (None, None),
            (begin, end) if end < begin => (Some(ticks.ns(begin)), None),
            (begin, end) => (Some(ticks.ns(begin)), Some(ticks.between(begin, end))),
        })
        .collect()
}
