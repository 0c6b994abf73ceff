//! What a batch tells the host: rays in each state, and whether a draw wrote any fragment.

use crate::executor::gpu::buffers::{labelled_buffer, own_buffer};
use crate::executor::gpu::{GpuError, MOST_PASSES};
use crate::plan::Plan;
use crate::plan::drawn::QUERY_BYTES;

/// Buffers with a slot for each pass of a batch, and queries.
pub(super) struct Results {
    /// Rays in each state, and where they are read; `None` if the host counts them.
    pub(super) sent: Option<[wgpu::Buffer; 2]>,
    /// One a pass: whether its last draw wrote any fragment.
    pub(super) occlusion: Queries,
    /// One a draw: how many fragments it ran.
    pub(super) statistics: Option<Queries>,
}

/// A set of queries, and where their results are read.
pub(super) struct Queries {
    pub(super) set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    pub(super) copy: wgpu::Buffer,
}

impl Queries {
    /// Copies the first results to where they are read. Returns their size in bytes.
    pub(super) fn encode_read(&self, encoder: &mut wgpu::CommandEncoder, count: u32) -> u64 {
        let bytes = QUERY_BYTES * u64::from(count);
        encoder.resolve_query_set(&self.set, 0..count, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.copy, 0, bytes);
        bytes
    }
}

const TO_RESOLVE: wgpu::BufferUsages = wgpu::BufferUsages::QUERY_RESOLVE.union(wgpu::BufferUsages::COPY_SRC);
const TO_READ: wgpu::BufferUsages = wgpu::BufferUsages::COPY_DST.union(wgpu::BufferUsages::MAP_READ);

impl Results {
    /// `is_counted`: whether the device counts rays. `counts_fragments`: if the device can.
    pub(super) fn new(
        device: &wgpu::Device,
        plan: &Plan,
        is_counted: bool,
        counts_fragments: bool,
    ) -> Result<Self, GpuError> {
        use wgpu::BufferUsages as U;
        let can_count = device.features().contains(wgpu::Features::PIPELINE_STATISTICS_QUERY);
        let planned = |name, usage| own_buffer(device, plan, name, usage).ok_or(GpuError::Missing(name));
        let set = |name: &str, ty, count| {
            let label = plan.label(name);
            device.create_query_set(&wgpu::QuerySetDescriptor { label: Some(&label), ty, count })
        };
        let statistics = || {
            let count = wgpu::QUERY_SET_MAX_QUERIES;
            let size = QUERY_BYTES * u64::from(count);
            let buffer = |name: &str, usage| labelled_buffer(device, &plan.label(name), size, usage);
            let types = wgpu::PipelineStatisticsTypes::FRAGMENT_SHADER_INVOCATIONS;
            Queries {
                set: set("statistics", wgpu::QueryType::PipelineStatistics(types), count),
                resolved: buffer("statistics, resolved", TO_RESOLVE),
                copy: buffer("statistics, copy", TO_READ),
            }
        };
        let sent = || {
            Ok::<_, GpuError>([
                planned("sent", U::STORAGE | U::COPY_SRC | U::COPY_DST)?,
                planned("sent_copy", TO_READ)?,
            ])
        };
        Ok(Self {
            sent: is_counted.then(sent).transpose()?,
            occlusion: Queries {
                set: set("queries", wgpu::QueryType::Occlusion, MOST_PASSES as u32),
                resolved: planned("queries", TO_RESOLVE)?,
                copy: planned("queries_copy", TO_READ)?,
            },
            statistics: (counts_fragments && can_count).then(statistics),
        })
    }

    /// Names and sizes in bytes.
    pub(super) fn allocated(&self) -> impl Iterator<Item = (&'static str, u64)> {
        let Self { sent, occlusion: Queries { resolved, copy, .. }, .. } = self;
        let sent = sent.iter().flat_map(|[sent, copy]| [("sent", sent), ("sent_copy", copy)]);
        sent.chain([("queries", resolved), ("queries_copy", copy)]).map(|(name, buffer)| (name, buffer.size()))
    }
}

/// How many fragments each draw ran.
pub(super) fn read_statistics(bytes: &[u8]) -> Vec<u64> {
    let number = |b: &[u8]| u64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]);
    bytes.chunks_exact(QUERY_BYTES as usize).map(number).collect()
}

/// Whether each draw wrote any fragment.
pub(super) fn read_queries(bytes: &[u8]) -> Vec<bool> {
    bytes.chunks_exact(QUERY_BYTES as usize).map(|result| result.iter().any(|&byte| byte != 0)).collect()
}
