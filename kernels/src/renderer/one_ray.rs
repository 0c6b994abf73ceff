//! Runs one ray alone: the same plan, kernels and texel, with every other ray left out.

use super::{RenderError, Renderer};
use crate::tables::stream::{Region, STATE_TAG, StreamData};

impl Renderer {
    /// Whether a ray alone goes through the same passes, see [`Plan::can_go_alone`](crate::Plan::can_go_alone).
    #[must_use]
    pub fn can_go_alone(&self) -> bool {
        self.plan.can_go_alone()
    }

    /// Returns to before the first pass, with one ray alone: no kernel works on any other until the next
    /// [`restart`](Self::restart). If it [cannot go alone](Self::can_go_alone), restarts with all rays and returns
    /// false.
    ///
    /// # Errors
    /// If the image has no such pixel.
    pub fn restart_alone(&mut self, x: u32, y: u32) -> Result<bool, RenderError> {
        let state = self.plan.program.state_stream();
        self.check_part(state.as_slice(), Region { x, y, width: 1, height: 1 })?;
        self.alone = self.can_go_alone().then_some([x, y]);
        self.begin();
        Ok(self.alone.is_some())
    }

    /// Removes all rays but one from the run that begins.
    pub(super) fn leave_out_others(&mut self, [x, y]: [u32; 2]) {
        let (width, height) = (self.plan.width, self.plan.height);
        let texels = width as usize * height as usize;
        let Some(course) = self.plan.program.course() else { return };
        let unwritten = || {
            let layers = course.stream.info().unwritten.iter();
            layers.flat_map(|&bits| std::iter::repeat_n(bits, texels)).collect()
        };
        let given = self.given.as_ref().and_then(|given| given.streams.iter().find(|s| s.stream == course.stream));
        let bits = given.map_or_else(unwritten, |given| given.bits.clone());
        let mut state = StreamData { stream: course.stream, width, height, bits };
        let ray = y as usize * width as usize + x as usize;
        for (i, tag) in state.bits[STATE_TAG * texels..(STATE_TAG + 1) * texels].iter_mut().enumerate() {
            // No kernel has work for an element that is done.
            *tag = if i == ray { *tag } else { course.done };
        }
        self.write(&state);
    }
}
