//! Kernels that are launched in bands of rows, each of which is short enough for one submission.

use std::mem::offset_of;

use super::books::Place;
use super::uploaded::buffer;
use super::{GpuError, GpuExecutor};
use crate::program::Kernel;
use crate::shared::scene::SceneInfo;
use crate::tables::kernel::Launch;

/// Byte offset of `first_row` in the uniform `scene`.
const FIRST_ROW: u64 = offset_of!(SceneInfo, first_row) as u64;

impl GpuExecutor {
    /// Rows of workgroups of a kernel that is launched in bands, and those of a band.
    fn bands(&self, kernel: Kernel) -> [u32; 2] {
        let (side, size) = (kernel.workgroup(), self.launched_over(kernel));
        let rows = size.height.div_ceil(side);
        let a_row = u64::from(size.width) * u64::from(side);
        [rows, (self.rays_a_dispatch / a_row.max(1)).clamp(1, u64::from(rows)) as u32]
    }

    /// Whether a kernel is not submitted together with other passes: it takes several submissions, or what it sends on
    /// is counted after it.
    pub(crate) fn is_alone(&self, kernel: Kernel) -> bool {
        let [rows, a_band] = self.bands(kernel);
        kernel.info().launch == Launch::Bands && (a_band < rows || kernel.is_counted_anew(&self.plan.features))
    }

    /// Runs a kernel in as many submissions as it takes to keep each of them short.
    pub(super) fn encode_bands(
        &self,
        mut encoder: wgpu::CommandEncoder,
        kernel: Kernel,
        place: &Place,
    ) -> Result<wgpu::CommandEncoder, GpuError> {
        let [rows, a_band] = self.bands(kernel);
        let scene = buffer(&self.buffers, "scene").ok_or(GpuError::Missing("scene"))?;
        for first in (0..rows).step_by(a_band as usize) {
            let last = first + a_band >= rows;
            let timestamp_writes =
                self.timers.as_ref().and_then(|t| t.writes((first == 0).then_some(0), last.then_some(1)));
            let label = self.pipelines.get(kernel).map(|pipeline| pipeline.label.as_str());
            let descriptor = wgpu::ComputePassDescriptor { label, timestamp_writes };
            self.dispatch(&mut encoder.begin_compute_pass(&descriptor), kernel, place, Some(a_band.min(rows - first)))?;
            // A value written to a uniform takes effect with the next submission.
            if a_band < rows {
                self.gpu.queue.write_buffer(scene, FIRST_ROW, bytemuck::bytes_of(&first));
                if !last {
                    self.gpu.submit([encoder.finish()]);
                    encoder = self.gpu.device.create_command_encoder(&Default::default());
                }
            }
        }
        Ok(encoder)
    }

    /// After the bands of a kernel: others begin with the first row. Sets of elements have different numbers of rows.
    pub(super) fn end_bands(&self, kernel: Kernel) {
        let scene = buffer(&self.buffers, "scene").filter(|_| kernel.info().launch == Launch::Bands);
        if let (Some(scene), [rows, a_band]) = (scene, self.bands(kernel))
            && a_band < rows
        {
            self.gpu.queue.write_buffer(scene, FIRST_ROW, bytemuck::bytes_of(&0u32));
        }
    }
}
