//! The client's view of a run, updated from an engine's answers.

use std::ops::{Deref, DerefMut};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use futures_channel::mpsc::{UnboundedReceiver, UnboundedSender, unbounded};
use raystep_kernels::Stream;
use raystep_kernels::executor::gpu::StreamTexture;

use super::HistorySource;
use super::copies::bit;
use super::engine::{Engine, EngineTask, GLIMPSING};
use super::request::{At, Request, Update};
use super::run_state::{Pinned, RunState, Work};
use crate::settings::Settings;

/// The client's view of a run: its [state](RunState), and the channel to its engine.
pub struct Model {
    state: RunState,
    requests: UnboundedSender<Request>,
    updates: UnboundedReceiver<Update>,
    cancel: Arc<AtomicU64>,
    sent: u64,
    waiting: usize,
    moving: Arc<AtomicU64>,
    /// A bit for each stream that was drawn since the engine has looked.
    drawn: Arc<AtomicU64>,
    is_glimpsing: bool,
    wants_glimpse: bool,
}

impl Deref for Model {
    type Target = RunState;

    fn deref(&self) -> &RunState {
        &self.state
    }
}

impl DerefMut for Model {
    fn deref_mut(&mut self) -> &mut RunState {
        &mut self.state
    }
}

/// Nobody waits for an answer any more: work in progress ends.
impl Drop for Model {
    fn drop(&mut self) {
        self.cancel.store(u64::MAX, Ordering::Relaxed);
    }
}

impl Model {
    /// A model, and the task that serves it: the caller runs it in a thread, or polls it.
    #[must_use]
    pub fn new(make: impl FnOnce(Engine) -> EngineTask) -> (Self, EngineTask) {
        let (requests, inbox) = unbounded();
        let (outbox, updates) = unbounded();
        let [cancel, moving, drawn] = [0, 0, 0].map(|zero| Arc::new(AtomicU64::new(zero)));
        let task = make(Engine::new(inbox, outbox, cancel.clone(), moving.clone(), drawn.clone()));
        let model = Self {
            state: RunState::default(),
            requests,
            updates,
            cancel,
            sent: 0,
            waiting: 0,
            moving,
            drawn,
            is_glimpsing: false,
            wants_glimpse: false,
        };
        (model, task)
    }

    /// Sends a request. Returns false if the engine is gone.
    pub fn ask(&mut self, request: Request) -> bool {
        let is_sent = self.requests.unbounded_send(request).is_ok();
        if is_sent {
            self.waiting += 1;
            self.sent += 1;
        } else {
            // It also ended if it panicked: earlier requests will not be answered either.
            self.waiting = 0;
            self.work = None;
            let message = "the tracing task has ended; this is a bug in raystep: open the scene in a new window";
            self.failures.push(("tracing", message.into()));
        }
        is_sent
    }

    /// Asks for a picture at a lower resolution, unless one is on its way.
    pub fn ask_glimpse(&mut self, settings: Settings) {
        self.wants_glimpse = true;
        if !self.is_glimpsing && self.has_rays() && settings.ray.is_none() {
            self.is_glimpsing = self.ask(Request::Glimpse(Box::new(settings)));
        }
    }

    /// Once per frame: a picture at a lower resolution is no longer shown when nothing moves any more, unless a run is
    /// being prepared that shows the same.
    pub fn drop_unwanted_glimpse(&mut self, is_held: bool) {
        let is_wanted = std::mem::take(&mut self.wants_glimpse);
        if !is_wanted && !is_held && !self.is_busy() {
            self.glimpse = None;
        }
    }

    /// Cancels current and queued work.
    pub fn cancel(&self) {
        self.cancel.store(self.sent, Ordering::Relaxed);
    }

    /// Whether requests are pending.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        self.waiting > 0
    }

    /// How many requests were sent.
    #[must_use]
    pub fn sent(&self) -> u64 {
        self.sent
    }

    /// How many requests were served; all of them if the engine is gone.
    #[must_use]
    pub fn served(&self) -> u64 {
        self.sent.saturating_sub(self.waiting as u64)
    }

    /// Whether the streams are between two places: drawing them now would show neither.
    #[must_use]
    pub fn is_moving(&self) -> bool {
        self.moving.load(Ordering::Acquire) > 0
    }

    /// Processes the engine's messages. Returns whether there were any.
    pub fn update(&mut self) -> bool {
        let mut is_new = false;
        while let Ok(update) = self.updates.try_recv() {
            self.apply(update);
            is_new = true;
        }
        // A stream that was not drawn before.
        if self.drawn.load(Ordering::Acquire) & !self.filled != 0 && !self.is_busy() && self.opened.is_some() {
            self.ask(Request::Draw);
        }
        is_new
    }

    fn apply(&mut self, update: Update) {
        match update {
            Update::Opened(opened, at) => {
                self.state.open(*opened);
                self.arrive(at);
            }
            Update::Glimpsed(glimpse) => {
                self.is_glimpsing = false;
                self.glimpse = Some(glimpse);
            }
            Update::At(at) => self.arrive(at),
            Update::Fired(fired) => self.fired = Some(fired),
            Update::Followed(history) => {
                (self.history, self.history_source) = (Some(Arc::new(*history)), HistorySource::Device);
                self.reference_history = None;
            }
            Update::Confirmed(history) => self.compare(history),
            Update::Texels(texels) => self.state.take_texels(texels),
            Update::Pinned { stream, place, texture } => {
                let generation = self.generation;
                self.pinned.push(Pinned { stream, place, generation, texture });
            }
            Update::Sketched(sketch) => self.sketches.push(sketch),
            Update::Done(what, answer) => self.answers.push((what, answer)),
            Update::Progress(what, done, of) => self.work = Some(Work { what, done, of }),
            Update::Failed(what, message) => {
                self.is_glimpsing &= what != GLIMPSING;
                self.failures.push((what, message));
            }
            Update::Cancelled(what) => {
                self.is_glimpsing &= what != GLIMPSING;
                self.unconfirmed(what);
                self.cancelled.push(what);
            }
            Update::Idle => {
                self.waiting = self.waiting.saturating_sub(1);
                self.work = None;
            }
        }
    }

    /// The run is at a place; the selected ray's history follows what has changed.
    fn arrive(&mut self, at: At) {
        let known = (self.passes.len(), self.is_complete);
        let is_changed = self.state.arrive(at);
        if is_changed || known != (self.passes.len(), self.is_complete) {
            self.follow_on(is_changed);
        }
    }

    /// A stream's texture for drawing, with the values of this place. `None` between two places, and until the engine
    /// has copied a stream that was not drawn before.
    #[must_use]
    pub fn drawn(&self, stream: Stream) -> Option<&StreamTexture> {
        let textures = &self.opened.as_ref()?.textures;
        let index = textures.iter().position(|(s, _)| *s == stream)?;
        self.drawn.fetch_or(bit(index), Ordering::AcqRel);
        (self.filled & bit(index) != 0 && !self.is_moving()).then(|| &textures[index].1)
    }
}
