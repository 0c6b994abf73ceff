//! Timestamps on the device's own clock: around every pass, or around a whole batch.

use super::MOST_PASSES;
use crate::plan::Plan;

pub(super) struct Timers {
    pub(super) set: wgpu::QuerySet,
    pub(super) resolved: wgpu::Buffer,
    pub(super) copy: wgpu::Buffer,
    pub(super) period_ns: f64,
    /// Whether to time every pass, which costs some microseconds each.
    pub(super) each_pass: bool,
}

impl Timers {
    pub(super) fn new(device: &wgpu::Device, plan: &Plan, period_ns: f64, each_pass: bool) -> Self {
        let count = 2 * MOST_PASSES as u32;
        let buffer = |name, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(&plan.label(name)),
                size: 8 * u64::from(count),
                usage,
                mapped_at_creation: false,
            })
        };
        use wgpu::BufferUsages as U;
        Self {
            set: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some(&plan.label("timers")),
                ty: wgpu::QueryType::Timestamp,
                count,
            }),
            resolved: buffer("timers, resolved", U::QUERY_RESOLVE | U::COPY_SRC),
            copy: buffer("timers, copy", U::COPY_DST | U::MAP_READ),
            period_ns,
            each_pass,
        }
    }

    /// Number of timestamps in one batch.
    pub(super) fn queries(&self, passes: u32) -> u32 {
        if self.each_pass { 2 * passes } else { 2 }
    }

    pub(super) fn writes(&self, begin: Option<u32>, end: Option<u32>) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        (begin.is_some() || end.is_some()).then_some(wgpu::ComputePassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: begin,
            end_of_pass_write_index: end,
        })
    }
}

/// Begin and duration from each pair of timestamps. An end before its begin, or 0, is not valid.
pub(super) fn read_times(bytes: &[u8], period_ns: f64) -> Vec<(Option<u64>, Option<u64>)> {
    let ticks: Vec<u64> =
        bytes.chunks_exact(8).map(|b| u64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]])).collect();
    let ns = |ticks: u64| (ticks as f64 * period_ns) as u64;
    ticks
        .chunks_exact(2)
        .map(|t| match (t[0], t[1]) {
            (0, _) | (_, 0) => (None, None),
            (begin, end) if end < begin => (Some(ns(begin)), None),
            (begin, end) => (Some(ns(begin)), Some(ns(end - begin))),
        })
        .collect()
}
