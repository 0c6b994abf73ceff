//! A run that can be stepped forwards and backwards, the selected ray, and edits by hand.
//!
//! Kernels are deterministic per ray, so an earlier pass is reached by running the same passes again, from the start
//! or from a checkpoint if that would take too long. What is shown after going back is bit for bit what was shown
//! before.

pub mod before;
mod confirm;
mod copies;
pub mod devices;
mod edit;
pub mod engine;
mod follow;
mod glimpse;
mod history;
pub mod judged;
pub mod measure;
mod model;
pub mod preview;
mod ray_history;
pub mod request;
mod run_state;
mod sketch;
mod sketcher;
mod target;
mod travel;
mod twins;
mod watch;

use std::ops::ControlFlow;

use history::History;
use raystep_kernels::export::trace::{RayState, ray_state};
use raystep_kernels::{Device, Options, Pass, Progress, Region, RenderError, Renderer, Stream, StreamData};
use raystep_scenes::Scene;
use sketcher::Sketcher;
use twins::Twins;

use crate::settings::traces_rays;

pub use edit::Edit;
pub use follow::Subject;
pub use history::DEFAULT_BUDGET;
pub use model::Model;
pub use run_state::HistorySource;
pub use run_state::{Pinned, RunState, Work};
pub(crate) use sketch::SIDE as SKETCH_SIDE;
pub use sketch::Sketch;
pub use target::Target;
pub use watch::{Direction, Fired, Watch};

/// Called between batches of passes with the progress of a run; may stop it.
pub type OnProgress<'a> = dyn FnMut(&Progress) -> ControlFlow<()> + Send + 'a;

/// An [`OnProgress`] that ignores progress and never stops.
pub fn go_on(_: &Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// A run in progress.
pub struct Session {
    renderer: Renderer,
    options: Options,
    pixel: Option<[u32; 2]>,
    history: History,
    /// In order of their places, those of one place in the order in which they were made.
    edits: Vec<Edit>,
    twins: Option<Twins>,
    /// Copies states for thumbnails, if somebody shows them.
    sketcher: Option<Sketcher>,
    /// Whether the streams are those of [`place`](Self::place), including edits. False if a future was dropped before
    /// it completed, or if the device failed.
    is_settled: bool,
}

impl Session {
    /// Prepares a run; no pass has run yet.
    ///
    /// # Errors
    /// Where the scene or options do not fit the device, or the device fails.
    pub async fn new(scene: &Scene, options: &Options, device: &Device) -> Result<Self, RenderError> {
        // Following a ray requires the records of passes.
        let options = Options { keep_passes: true, ..options.clone() };
        Ok(Self::from_renderer(Renderer::new(scene, &options, device).await?, &options))
    }

    /// Takes over a run at its current place; it was made with these options and records its passes.
    #[must_use]
    pub fn from_renderer(renderer: Renderer, options: &Options) -> Self {
        let mut history = History::new(&renderer);
        history.note(renderer.passes());
        Self {
            renderer,
            options: options.clone(),
            pixel: None,
            history,
            edits: Vec::new(),
            twins: None,
            sketcher: None,
            is_settled: true,
        }
    }

    /// Takes over another camera, and returns to before the first pass, without edits. Returns false where that needs a
    /// new run, see [`Renderer::look`].
    ///
    /// # Errors
    /// Where the camera cannot generate rays.
    pub fn look(&mut self, scene: &Scene, options: &Options) -> Result<bool, RenderError> {
        let options = Options { keep_passes: true, ..options.clone() };
        if !self.renderer.look(scene, &options)? {
            return Ok(false);
        }
        self.history.forget();
        (self.options, self.pixel, self.edits, self.twins, self.is_settled) = (options, None, Vec::new(), None, true);
        Ok(true)
    }

    /// Passes so far: the session is after pass `place() - 1`.
    #[must_use]
    pub fn place(&self) -> usize {
        self.renderer.pass_count()
    }

    /// The passes so far.
    #[must_use]
    pub fn passes(&self) -> &[Pass] {
        self.renderer.passes()
    }

    /// The passes so far, and those that ran before the session went back: they will run again.
    #[must_use]
    pub fn known(&self) -> &[Pass] {
        self.history.known()
    }

    /// The run, for reading.
    #[must_use]
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// The options of the run.
    #[must_use]
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// How many bytes checkpoints may take, on the GPU if passes run there. With fewer, going back takes longer.
    pub fn set_budget(&mut self, bytes: u64) {
        self.history.set_budget(bytes);
    }

    /// How many bytes checkpoints may take.
    #[must_use]
    pub fn budget(&self) -> u64 {
        self.history.budget()
    }

    /// How many threads passes may launch between two checkpoints, as far as the budget allows: one per ray, or one per
    /// ray in the list. Initially a short time on such a device.
    pub fn set_span(&mut self, threads: u64) {
        self.history.set_span(threads);
    }

    /// How many bytes checkpoints take.
    #[must_use]
    pub fn kept_bytes(&self) -> u64 {
        self.history.bytes()
    }

    /// The places of the checkpoints, in order.
    pub fn kept_places(&self) -> impl Iterator<Item = usize> + '_ {
        self.history.places()
    }

    /// Selects a ray. `None` if the image has no such pixel: the previous ray stays selected.
    pub fn select(&mut self, x: u32, y: u32) -> Option<[u32; 2]> {
        let plan = self.renderer.plan();
        if x < plan.width && y < plan.height {
            self.pixel = Some([x, y]);
            return self.pixel;
        }
        None
    }

    /// The pixel of the selected ray.
    #[must_use]
    pub fn pixel(&self) -> Option<[u32; 2]> {
        self.pixel
    }

    /// The current state of the selected ray; `None` also in a program without rays.
    ///
    /// # Errors
    /// Where the device fails.
    pub async fn ray(&self) -> Result<Option<RayState>, RenderError> {
        match self.pixel {
            Some([x, y]) if traces_rays(self.renderer.plan().program) => {
                ray_state(&self.renderer, x, y).await.map(Some)
            }
            _ => Ok(None),
        }
    }

    /// The current values of a stream.
    ///
    /// # Errors
    /// Where the plan left it out, or the device fails.
    pub async fn stream(&self, stream: Stream) -> Result<StreamData, RenderError> {
        self.renderer.values(stream).await
    }

    /// The current values of a region of a stream.
    ///
    /// # Errors
    /// Where the plan left it out, the image has no such part, or the device fails.
    pub async fn region(&self, stream: Stream, region: Region) -> Result<StreamData, RenderError> {
        self.renderer.region(stream, region).await
    }
}
