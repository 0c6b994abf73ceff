//! What a batch tells the host: rays in each state, and whether a draw wrote any fragment.

use crate::executor::gpu::MOST_PASSES;
use crate::plan::Plan;
use crate::plan::drawn::QUERY_BYTES;

/// Buffers with a slot for each pass of a batch.
pub(super) struct Results {
    pub(super) sent: wgpu::Buffer,
    pub(super) sent_copy: wgpu::Buffer,
    pub(super) queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    pub(super) queries_copy: wgpu::Buffer,
}

impl Results {
    pub(super) fn new(device: &wgpu::Device, plan: &Plan) -> Self {
        use wgpu::BufferUsages as U;
        let buffer = |name: &'static str, usage| {
            let size = plan.buffers.iter().find(|planned| planned.what == name).map_or(0, |planned| planned.bytes);
            let label = plan.label(name);
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(&label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        Self {
            sent: buffer("sent", U::STORAGE | U::COPY_SRC | U::COPY_DST),
            sent_copy: buffer("sent_copy", U::COPY_DST | U::MAP_READ),
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some(&plan.label("queries")),
                ty: wgpu::QueryType::Occlusion,
                count: MOST_PASSES as u32,
            }),
            resolved: buffer("queries", U::QUERY_RESOLVE | U::COPY_SRC),
            queries_copy: buffer("queries_copy", U::COPY_DST | U::MAP_READ),
        }
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

/// Whether each draw wrote any fragment.
pub(super) fn read_queries(bytes: &[u8]) -> Vec<bool> {
    bytes.chunks_exact(QUERY_BYTES as usize).map(|result| result.iter().any(|&byte| byte != 0)).collect()
}
