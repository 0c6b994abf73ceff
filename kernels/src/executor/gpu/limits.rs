//! Limits of an adapter.

use super::Gpu;
use crate::plan::limits::TURNS_WITHOUT_LIMIT;
use crate::plan::{Limits, Loops};
use crate::shared::constants::{LIST_GROUPS, LIST_SIDE, WORKGROUP};
use crate::tables::sizes::ROW_ALIGNMENT;

const _: () = assert!(ROW_ALIGNMENT == wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);

/// A thread uses the adapter's limit divided by this. The adapter may count the iterations of up to 16 threads that run
/// in one vector together, and the loops that contain the counted ones take some too.
const SHARE_OF_LIMIT: u32 = 32;

impl Limits {
    /// The limits of an adapter with these limits and this handling of loops.
    #[must_use]
    pub fn of_adapter(limits: &wgpu::Limits, loops: Loops) -> Self {
        let groups = limits.max_compute_workgroups_per_dimension;
        let most = limits.max_texture_dimension_2d;
        // Without compute shaders, what is drawn has no workgroups.
        let side = if groups == 0 { most } else { most.min(groups.saturating_mul(WORKGROUP)) };
        Self {
            image_side: side,
            turns: match loops {
                Loops::Unlimited => TURNS_WITHOUT_LIMIT,
                Loops::EndAfter(turns) => (turns / SHARE_OF_LIMIT).max(1),
            },
            storage_bytes: limits.max_storage_buffer_binding_size.min(limits.max_buffer_size),
            storage_buffers: limits.max_storage_buffers_per_shader_stage,
            storage_textures: limits.max_storage_textures_per_shader_stage,
            sampled_textures: limits.max_sampled_textures_per_shader_stage,
            color_bytes: limits.max_color_attachment_bytes_per_sample,
            // Rows of workgroups in an indirect dispatch, times the rays of a row.
            rays: match groups {
                0 => u64::from(side).pow(2).min(u32::MAX.into()),
                groups => u64::from(groups.min(65_535)) * u64::from(LIST_GROUPS * LIST_SIDE * LIST_SIDE),
            },
            is_gpu: true,
        }
    }
}

impl From<&Gpu> for Limits {
    fn from(gpu: &Gpu) -> Self {
        Self { is_gpu: !gpu.is_software(), ..Self::of_adapter(&gpu.device.limits(), gpu.loops) }
    }
}
