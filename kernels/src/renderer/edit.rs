//! Edits streams from outside, between two passes.

use std::sync::Arc;

use super::{RenderError, Renderer};
use crate::tables::stream::{Region, STATE_TAG, Stream, StreamData};

impl Renderer {
    /// Replaces a stream's values; the next pass works on them. Returns false if the plan left it out or the size
    /// differs.
    pub fn write(&mut self, data: &StreamData) -> bool {
        let is_written = self.executor.write(data);
        let course = self.plan.program.courses.iter().find(|course| course.stream == data.stream);
        if let Some(course) = course.filter(|_| is_written) {
            // The counts decide which kernel runs next.
            let counts = &mut self.population.in_state;
            counts.clear(self.plan.program.states_of(course));
            data.layer(STATE_TAG).iter().for_each(|&tag| counts.add(tag, 1));
            self.believe_counts();
        }
        is_written
    }

    /// Replaces one component of one ray; the next pass works on it.
    ///
    /// # Errors
    /// If the plan left the stream out, there is no such layer or pixel, or the device fails.
    pub async fn write_component(
        &mut self,
        stream: Stream,
        layer: usize,
        x: u32,
        y: u32,
        bits: u32,
    ) -> Result<(), RenderError> {
        self.check_part(&[stream], Region { x, y, width: 1, height: 1 })?;
        if layer >= stream.layers() {
            return Err(RenderError::NoLayer { stream: stream.name(), layer });
        }
        let is_tag = self.plan.program.has_states(stream) && layer == STATE_TAG;
        if self.executor.is_gpu() && (is_tag || self.plan.drawn.is_some()) {
            // Counts and lists of live rays depend on every ray's tag; and a part of a texel cannot be written.
            let mut data = self.values(stream).await?;
            let (width, height) = (data.width as usize, data.height as usize);
            data.bits[(layer * height + y as usize) * width + x as usize] = bits;
            self.write(&data);
        } else if let Some(counts) = self.executor.write_component(stream, layer, x, y, bits) {
            self.population.in_state = counts;
            self.believe_counts();
        }
        Ok(())
    }

    /// Continues where another run with the same plan is: copies its streams as f32, and its position. The passes that
    /// follow run here.
    ///
    /// # Errors
    /// If the other run has another plan, or a device fails.
    pub async fn adopt(&mut self, other: &mut Self) -> Result<(), RenderError> {
        if !Arc::ptr_eq(&self.plan, &other.plan) {
            return Err(RenderError::OtherRun);
        }
        other.settle().await?;
        // Until everything is copied, streams and position do not match.
        self.is_ahead = true;
        self.executor.resize(other.executor.sizes())?;
        for planned in &self.plan.clone().streams {
            if self.size(planned.what.info().elements).is_none() {
                continue;
            }
            let data = other.values(planned.what).await?;
            self.write(&data);
        }
        self.cursor = other.cursor.clone();
        self.population = other.population.clone();
        self.believed.clone_from(&other.believed);
        self.records.clone_from(&other.records);
        self.unfinished = other.unfinished;
        self.alone = other.alone;
        self.is_ahead = false;
        Ok(())
    }
}
