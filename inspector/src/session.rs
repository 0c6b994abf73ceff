//! A run that can be stepped forward and back, and the ray that is looked at.
//!
//! Kernels are deterministic per ray, so an earlier pass is reached by running the same passes again from
//! the start: nothing is kept but the place. What is shown after going back is bit for bit what was there.

pub mod compare;
pub mod cost;
pub mod divergence;
pub mod grid_stats;
pub mod stats;

use raystep_kernels::export::trace::{RayState, ray_state};
use raystep_kernels::{Device, Kernel, Options, Pass, RenderError, Renderer, Stream, StreamData};
use raystep_scenes::Scene;

/// Where to step to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// One pass on.
    Next,
    /// One pass back.
    Previous,
    /// After the next pass of a kernel.
    NextOf(Kernel),
    /// After the previous pass of a kernel.
    PreviousOf(Kernel),
    /// After so many passes in all.
    Pass(usize),
    /// Before the first pass.
    Start,
    /// After the last pass.
    End,
}

/// A run in progress.
pub struct Session {
    renderer: Renderer,
    pixel: Option<[u32; 2]>,
}

impl Session {
    /// Prepares a run; no pass has run yet.
    ///
    /// # Errors
    /// Where the scene or options do not fit the device, or the device fails.
    pub async fn new(scene: &Scene, options: &Options, device: &Device) -> Result<Self, RenderError> {
        Ok(Self { renderer: Renderer::new(scene, options, device).await?, pixel: None })
    }

    /// Passes so far: the session is after pass `place() - 1`.
    #[must_use]
    pub fn place(&self) -> usize {
        self.renderer.passes().len()
    }

    /// The passes so far.
    #[must_use]
    pub fn passes(&self) -> &[Pass] {
        self.renderer.passes()
    }

    /// The run, for everything that only looks.
    #[must_use]
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// Goes to `target`, or as near as the run allows; returns the place reached.
    ///
    /// # Errors
    /// Where the device fails.
    pub async fn step(&mut self, target: Target) -> Result<usize, RenderError> {
        match target {
            Target::Next => drop(self.renderer.step().await?),
            Target::NextOf(kernel) => while self.renderer.step().await?.is_some_and(|p| p.kernel != kernel) {},
            Target::End => while self.renderer.step().await?.is_some() {},
            Target::Start => self.replay(0).await?,
            Target::Pass(place) => self.replay(place).await?,
            Target::Previous => self.replay(self.place().saturating_sub(1)).await?,
            Target::PreviousOf(kernel) => {
                let earlier = &self.passes()[..self.place().saturating_sub(1)];
                let place = earlier.iter().rposition(|p| p.kernel == kernel).map_or(0, |i| i + 1);
                self.replay(place).await?;
            }
        }
        Ok(self.place())
    }

    /// Runs the same passes again up to `place`, or on to it where it lies ahead.
    async fn replay(&mut self, place: usize) -> Result<(), RenderError> {
        if place < self.place() {
            self.renderer.restart();
        }
        while self.place() < place && self.renderer.step().await?.is_some() {}
        Ok(())
    }

    /// Looks at one ray. `None` where the image has no such pixel: the ray that was looked at stays.
    pub fn select(&mut self, x: u32, y: u32) -> Option<[u32; 2]> {
        let plan = self.renderer.plan();
        if x < plan.width && y < plan.height {
            self.pixel = Some([x, y]);
            return self.pixel;
        }
        None
    }

    /// The pixel of the ray that is looked at.
    #[must_use]
    pub fn pixel(&self) -> Option<[u32; 2]> {
        self.pixel
    }

    /// The ray that is looked at, as it is now.
    ///
    /// # Errors
    /// Where the device fails.
    pub async fn ray(&self) -> Result<Option<RayState>, RenderError> {
        match self.pixel {
            Some([x, y]) => ray_state(&self.renderer, x, y).await.map(Some),
            None => Ok(None),
        }
    }

    /// A stream as it is now.
    ///
    /// # Errors
    /// Where the plan left it out, or the device fails.
    pub async fn stream(&self, stream: Stream) -> Result<StreamData, RenderError> {
        self.renderer.values(stream).await
    }
}
