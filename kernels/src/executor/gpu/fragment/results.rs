//! What a batch tells the host: rays in each state, and whether a draw wrote any fragment.

use crate::executor::gpu::{GpuError, MOST_PASSES, labelled_buffer, own_buffer};
use crate::plan::Plan;
use crate::plan::drawn::QUERY_BYTES;

/// Buffers with a slot for each pass of a batch.
pub(super) struct Results {
    pub(super) sent: wgpu::Buffer,
    pub(super) sent_copy: wgpu::Buffer,
    pub(super) queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    pub(super) queries_copy: wgpu::Buffer,
    pub(super) statistics: Option<Statistics>,
}

/// How many fragments each draw of a batch ran.
pub(super) struct Statistics {
    pub(super) set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    pub(super) copy: wgpu::Buffer,
}

impl Statistics {
    fn new(device: &wgpu::Device, plan: &Plan) -> Self {
        use wgpu::BufferUsages as U;
        let size = QUERY_BYTES * u64::from(wgpu::QUERY_SET_MAX_QUERIES);
        let buffer = |name: &str, usage| labelled_buffer(device, &plan.label(name), size, usage);
        Self {
            set: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some(&plan.label("statistics")),
                ty: wgpu::QueryType::PipelineStatistics(wgpu::PipelineStatisticsTypes::FRAGMENT_SHADER_INVOCATIONS),
                count: wgpu::QUERY_SET_MAX_QUERIES,
            }),
            resolved: buffer("statistics, resolved", U::QUERY_RESOLVE | U::COPY_SRC),
            copy: buffer("statistics, copy", U::COPY_DST | U::MAP_READ),
        }
    }

    /// Copies the first results to where they are read. Returns their size in bytes.
    pub(super) fn encode_read(&self, encoder: &mut wgpu::CommandEncoder, count: u32) -> u64 {
        let bytes = QUERY_BYTES * u64::from(count);
        encoder.resolve_query_set(&self.set, 0..count, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.copy, 0, bytes);
        bytes
    }
}

impl Results {
    /// `counts_fragments`: if the device can.
    pub(super) fn new(device: &wgpu::Device, plan: &Plan, counts_fragments: bool) -> Result<Self, GpuError> {
        use wgpu::BufferUsages as U;
        let can_count = device.features().contains(wgpu::Features::PIPELINE_STATISTICS_QUERY);
        let buffer = |name, usage| own_buffer(device, plan, name, usage).ok_or(GpuError::Missing(name));
        Ok(Self {
            sent: buffer("sent", U::STORAGE | U::COPY_SRC | U::COPY_DST)?,
            sent_copy: buffer("sent_copy", U::COPY_DST | U::MAP_READ)?,
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some(&plan.label("queries")),
                ty: wgpu::QueryType::Occlusion,
                count: MOST_PASSES as u32,
            }),
            resolved: buffer("queries", U::QUERY_RESOLVE | U::COPY_SRC)?,
            queries_copy: buffer("queries_copy", U::COPY_DST | U::MAP_READ)?,
            statistics: (counts_fragments && can_count).then(|| Statistics::new(device, plan)),
        })
    }

    /// Names and sizes in bytes.
    pub(super) fn allocated(&self) -> impl Iterator<Item = (&'static str, u64)> {
        let Self { sent, sent_copy, resolved, queries_copy, .. } = self;
        [("sent", sent), ("sent_copy", sent_copy), ("queries", resolved), ("queries_copy", queries_copy)]
            .map(|(name, buffer)| (name, buffer.size()))
            .into_iter()
    }

    /// Copies the results of the first queries to where they are read. Returns their size in bytes.
    pub(super) fn encode_queries(&self, encoder: &mut wgpu::CommandEncoder, count: u32) -> u64 {
        let bytes = QUERY_BYTES * u64::from(count);
        encoder.resolve_query_set(&self.queries, 0..count, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.queries_copy, 0, bytes);
        bytes
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
