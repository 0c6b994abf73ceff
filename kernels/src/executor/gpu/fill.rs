//! Initial contents of every stream, kept on the GPU: a restart copies them and uploads nothing.

use super::StreamTexture;
use crate::plan::Plan;
use crate::tables::sizes::{fill_bytes, fill_values, fill_words, given_bytes, pitch};
use crate::tables::stream::{Stream, StreamData};

/// Constant texels, and the streams with input data.
pub(super) struct Fill {
    /// One part per distinct value.
    constants: wgpu::Buffer,
    values: Vec<u32>,
    given: Vec<(Stream, wgpu::Buffer)>,
    /// The program's name, for labels.
    program: &'static str,
    /// Words per part.
    part: u64,
}

impl Fill {
    pub(super) fn new(device: &wgpu::Device, queue: &wgpu::Queue, plan: &Plan) -> Self {
        let (size, sets, streams) = (plan.size(), plan.sets.len(), plan.program.streams);
        let (values, part) = (fill_values(streams), fill_words(size, sets) as usize);
        let constants = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(&plan.label("fill")),
            size: fill_bytes(size, sets, streams),
            usage: wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        for (i, &value) in values.iter().enumerate() {
            queue.write_buffer(&constants, 4 * (i * part) as u64, bytemuck::cast_slice(&vec![value; part]));
        }
        Self { constants, values, part: part as u64, given: Vec::new(), program: plan.program.name }
    }

    /// Sets the initial contents of these streams from now on.
    pub(super) fn give(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, streams: &[StreamData]) {
        for data in streams {
            let (width, padding) = (data.width as usize, (pitch(data.width) - data.width) as usize);
            let size = given_bytes(data.stream, data.width, data.height);
            let kept = self.given.iter().find(|(stream, buffer)| *stream == data.stream && buffer.size() == size);
            let buffer = kept.map(|(_, buffer)| buffer.clone()).unwrap_or_else(|| {
                device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(&format!("{}.{}, given", self.program, data.stream.name())),
                    size,
                    usage: wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                })
            });
            let mut words = Vec::with_capacity(buffer.size() as usize / 4);
            for row in data.bits.chunks_exact(width) {
                words.extend_from_slice(row);
                words.extend(std::iter::repeat_n(0, padding));
            }
            queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&words));
            self.given.retain(|(stream, _)| *stream != data.stream);
            self.given.push((data.stream, buffer));
        }
    }

    /// Names and sizes in bytes of its buffers.
    pub(super) fn allocated(&self) -> Vec<(&'static str, u64)> {
        let mut all = vec![("fill", self.constants.size())];
        if !self.given.is_empty() {
            all.push(("given", self.given.iter().map(|(_, b)| b.size()).sum()));
        }
        all
    }

    /// Resets every stream to its initial contents.
    pub(super) fn clear(&self, encoder: &mut wgpu::CommandEncoder, streams: &[(Stream, StreamTexture)]) {
        let part = 4 * self.part;
        let mut copy = |buffer: &wgpu::Buffer, offset, texture: &StreamTexture, first, rows, layer| {
            let (width, pitch) = (texture.width(), pitch(texture.width()));
            encoder.copy_buffer_to_texture(
                wgpu::TexelCopyBufferInfo {
                    buffer,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset,
                        bytes_per_row: Some(4 * pitch),
                        rows_per_image: Some(rows),
                    },
                },
                texture.copy_at(0, first, layer),
                wgpu::Extent3d { width, height: rows, depth_or_array_layers: 1 },
            );
        };
        for (stream, texture) in streams {
            let (height, pitch) = (texture.height(), pitch(texture.width()));
            let band = (self.part as u32 / pitch).clamp(1, height);
            let given = self.given.iter().find(|(s, _)| s == stream).map(|(_, buffer)| buffer);
            for (layer, value) in (0u32..).zip(stream.info().unwritten) {
                if let Some(buffer) = given {
                    let offset = 4 * u64::from(layer) * u64::from(pitch) * u64::from(height);
                    copy(buffer, offset, texture, 0, height, layer);
                    continue;
                }
                let constant = self.values.binary_search(value).unwrap_or(0) as u64;
                for first in (0..height).step_by(band as usize) {
                    copy(&self.constants, constant * part, texture, first, band.min(height - first), layer);
                }
            }
        }
    }
}
