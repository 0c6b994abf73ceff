//! The client's view of a run: plain data that panels read, updated from an engine's answers.

use std::any::Any;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use futures_channel::mpsc::{UnboundedReceiver, UnboundedSender, unbounded};
use raystep_kernels::export::trace::Trace;
use raystep_kernels::{DrawTime, Kernel, Pass, Stream};

use super::copies::bit;
use super::engine::{Engine, EngineTask, GLIMPSING};
use super::request::{At, Glimpse, Opened, Request, Texels, Update};
use super::{Edit, Fired, Sketch, Told};
use crate::settings::Settings;

/// Work in progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Work {
    /// What is done.
    pub what: &'static str,
    /// Work completed.
    pub done: u64,
    /// Total work; 0 if unknown.
    pub of: u64,
}

/// A copy of a stream after some pass.
#[derive(Clone)]
pub struct Pinned {
    /// Which stream.
    pub stream: Stream,
    /// Number of passes before it.
    pub place: usize,
    /// The generation of its run.
    pub generation: u64,
    /// The copy.
    pub texture: wgpu::Texture,
}

/// The client's view of a run, and the channel to its engine.
pub struct Model {
    requests: UnboundedSender<Request>,
    updates: UnboundedReceiver<Update>,
    cancel: Arc<AtomicU64>,
    sent: u64,
    moving: Arc<AtomicU64>,
    /// A bit for each stream that was drawn since the engine has looked.
    drawn: Arc<AtomicU64>,
    /// A bit for each stream whose texture has the values of this place.
    filled: u64,
    waiting: usize,
    /// The run; `None` until a scene is open.
    pub opened: Option<Opened>,
    /// Incremented with every run.
    pub generation: u64,
    /// Incremented with every run, and when the streams at a place change: by an edit, or by the CPU reference.
    pub edition: u64,
    /// How many of the first passes run on the CPU reference.
    pub twins: Option<usize>,
    /// Time of the passes before `place` by the host's clock.
    pub host_ns: Option<u64>,
    /// All known passes, including those after `place` if the run was there before.
    pub passes: Vec<Pass>,
    /// The parts of each of them that is drawn.
    pub draws: Vec<Vec<DrawTime>>,
    /// Passes so far.
    pub place: usize,
    /// Whether all passes are known.
    pub is_complete: bool,
    /// The kernel of the next pass; `None` at the end.
    pub next: Option<Kernel>,
    /// Bytes of checkpoints.
    pub kept_bytes: u64,
    /// Budget of checkpoints in bytes.
    pub budget: u64,
    /// Edits by hand.
    pub edits: Vec<Edit>,
    /// The result of the last run to a watch, until taken; the inner option is `None` if no watch fired.
    pub fired: Option<Option<Fired>>,
    /// The selected ray, once it is followed or the session is asked to.
    pub(super) followed: Option<[u32; 2]>,
    /// Its history.
    pub life: Option<Arc<Trace>>,
    /// Whose kernels the history is from.
    pub told: Told,
    /// The CPU reference's history, if the device's differs from it.
    pub reference_life: Option<Arc<Trace>>,
    /// A picture at a lower resolution of what will be traced next.
    pub glimpse: Option<Glimpse>,
    is_glimpsing: bool,
    wants_glimpse: bool,
    /// The ray under the cursor.
    pub(super) glanced: Option<Arc<Trace>>,
    /// The texels read last, by stream.
    pub texels: Vec<Texels>,
    /// Copies that were asked for, oldest first.
    pub pinned: Vec<Pinned>,
    /// The states after passes on the way, until taken for thumbnails.
    pub sketches: Vec<Sketch>,
    /// Work in progress.
    pub work: Option<Work>,
    /// Answers of jobs, until their requester takes them.
    pub answers: Vec<(&'static str, Box<dyn Any + Send>)>,
    /// Errors, until taken for display.
    pub failures: Vec<(&'static str, String)>,
    /// Cancelled work, until taken for display.
    pub cancelled: Vec<&'static str>,
}

/// Nobody waits for an answer any more: work in progress ends.
impl Drop for Model {
    fn drop(&mut self) {
        self.cancel.store(u64::MAX, Ordering::Relaxed);
    }
}

impl Model {
    /// Whether the program that is open has rays, or none is open.
    #[must_use]
    pub fn has_rays(&self) -> bool {
        self.opened.as_ref().is_none_or(|opened| opened.plan.program.course().is_some())
    }

    /// A model, and the task that serves it: the caller runs it in a thread, or polls it.
    #[must_use]
    pub fn new(make: impl FnOnce(Engine) -> EngineTask) -> (Self, EngineTask) {
        let (requests, inbox) = unbounded();
        let (outbox, updates) = unbounded();
        let [cancel, moving, drawn] = [0, 0, 0].map(|zero| Arc::new(AtomicU64::new(zero)));
        let task = make(Engine::new(inbox, outbox, cancel.clone(), moving.clone(), drawn.clone()));
        let model = Self {
            requests,
            updates,
            cancel,
            sent: 0,
            moving,
            drawn,
            filled: 0,
            waiting: 0,
            opened: None,
            generation: 0,
            edition: 0,
            twins: None,
            host_ns: None,
            passes: Vec::new(),
            draws: Vec::new(),
            place: 0,
            is_complete: false,
            next: None,
            kept_bytes: 0,
            budget: 0,
            edits: Vec::new(),
            fired: None,
            followed: None,
            life: None,
            told: Told::default(),
            reference_life: None,
            glimpse: None,
            is_glimpsing: false,
            wants_glimpse: false,
            glanced: None,
            texels: Vec::new(),
            pinned: Vec::new(),
            sketches: Vec::new(),
            work: None,
            answers: Vec::new(),
            failures: Vec::new(),
            cancelled: Vec::new(),
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
                self.opened = Some(*opened);
                self.generation += 1;
                self.edition += 1;
                self.passes.clear();
                self.draws.clear();
                self.texels.clear();
                self.pinned.clear();
                self.sketches.clear();
                (self.place, self.is_complete, self.next, self.life) = (0, false, None, None);
                (self.followed, self.told, self.reference_life) = (None, Told::default(), None);
                (self.edits, self.twins) = (Vec::new(), None);
                (self.glimpse, self.glanced) = (None, None);
                self.arrive(at);
            }
            Update::Glimpsed(glimpse) => {
                self.is_glimpsing = false;
                self.glimpse = Some(glimpse);
            }
            Update::At(at) => self.arrive(at),
            Update::Fired(fired) => self.fired = Some(fired),
            Update::Followed(life) => {
                (self.life, self.told) = (Some(Arc::new(*life)), Told::Device);
                self.reference_life = None;
            }
            Update::Confirmed(life) => self.compare(life),
            Update::Texels(mut texels) => {
                // Statistics of the same texels stay valid.
                let old = self.texels.iter_mut().find(|t| (t.stream, t.place) == (texels.stream, texels.place));
                if texels.counted.is_none() {
                    texels.counted = old.and_then(|old| old.counted.take());
                }
                self.texels.retain(|t| t.stream != texels.stream);
                self.texels.push(texels);
            }
            Update::Pinned { stream, place, texture } => {
                self.pinned.push(Pinned { stream, place, generation: self.generation, texture });
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

    fn arrive(&mut self, at: At) {
        let (known, was_complete) = (self.passes.len(), self.is_complete);
        // Other streams at the same place, and other passes after it.
        let is_changed = at.edits != self.edits || at.twins != self.twins;
        if is_changed {
            self.edition += 1;
            self.texels.clear();
            self.sketches.clear();
            self.passes.truncate(at.place);
            self.draws.truncate(at.place);
            self.is_complete = false;
        }
        (self.twins, self.host_ns, self.filled) = (at.twins, at.host_ns, at.filled);
        let end = at.first + at.passes.len();
        // The passes differ from those known: an edit, or another plan.
        let same = self.passes.get(at.first..end.min(self.passes.len())).is_some_and(|known| {
            known.iter().zip(&at.passes).all(|(a, b)| (a.kernel, &a.counts) == (b.kernel, &b.counts))
        });
        if !same {
            self.is_complete = false;
        }
        if !same || end > self.passes.len() {
            self.passes.truncate(at.first);
            self.passes.extend(at.passes);
            self.draws.truncate(at.first);
            if !at.draws.is_empty() {
                self.draws.resize(at.first, Vec::new());
                self.draws.extend(at.draws);
            }
        }
        (self.place, self.next, self.kept_bytes, self.budget) = (at.place, at.next, at.kept_bytes, at.budget);
        self.edits = at.edits;
        if let (Some(opened), Some(textures)) = (&mut self.opened, at.textures) {
            opened.textures = textures;
        }
        self.is_complete |= at.next.is_none();
        if is_changed || (known, was_complete) != (self.passes.len(), self.is_complete) {
            self.follow_on(is_changed);
        }
    }

    /// A stream's texture. Its values may be those of an earlier place: see [`drawn`](Self::drawn).
    #[must_use]
    pub fn texture(&self, stream: Stream) -> Option<&wgpu::Texture> {
        self.opened.as_ref()?.textures.iter().find(|(s, _)| *s == stream).map(|(_, texture)| texture)
    }

    /// A stream's texture for drawing, with the values of this place. `None` between two places, and until the engine
    /// has copied a stream that was not drawn before.
    #[must_use]
    pub fn drawn(&self, stream: Stream) -> Option<&wgpu::Texture> {
        let textures = &self.opened.as_ref()?.textures;
        let index = textures.iter().position(|(s, _)| *s == stream)?;
        self.drawn.fetch_or(bit(index), Ordering::AcqRel);
        (self.filled & bit(index) != 0 && !self.is_moving()).then(|| &textures[index].1)
    }

    /// The pass that was run last.
    #[must_use]
    pub fn last_pass(&self) -> Option<&Pass> {
        self.place.checked_sub(1).and_then(|i| self.passes.get(i))
    }

    /// Takes the answer of a job, if it has arrived.
    pub fn take_answer<T: 'static>(&mut self, what: &'static str) -> Option<Box<T>> {
        let at = self.answers.iter().position(|(name, answer)| *name == what && answer.is::<T>())?;
        self.answers.remove(at).1.downcast().ok()
    }
}
