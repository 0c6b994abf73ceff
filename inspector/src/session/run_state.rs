//! What the client knows of a run: plain data that panels read.

use std::any::Any;
use std::sync::Arc;

use raystep_kernels::executor::gpu::StreamTexture;
use raystep_kernels::export::trace::Trace;
use raystep_kernels::{DrawTime, Kernel, Pass, Stream};

use super::request::{At, Glimpse, Opened, Texels};
use super::{Edit, Fired, Sketch, Subject};
use crate::settings::traces_rays;

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
    pub texture: StreamTexture,
}

/// Whose kernels a history is from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum HistorySource {
    /// The device's, from the session's own streams.
    #[default]
    Device,
    /// The CPU reference's; the device has yet to confirm it.
    Reference,
    /// The device's, compared with the CPU reference's.
    Compared {
        /// Rows that differ; none if the two agree in every bit.
        differing: Vec<usize>,
    },
    /// The CPU reference's; why the device could not confirm it.
    Unconfirmed(String),
}

/// The state of a run, as far as its engine has told it.
#[derive(Default)]
pub struct RunState {
    /// A bit for each stream whose texture has the values of this place.
    pub(super) filled: u64,
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
    /// The selected ray or other element, once it is followed or the session is asked to.
    pub(super) followed: Option<Subject>,
    /// Its history.
    pub history: Option<Arc<Trace>>,
    /// Whose kernels the history is from.
    pub history_source: HistorySource,
    /// The CPU reference's history, if the device's differs from it.
    pub reference_history: Option<Arc<Trace>>,
    /// A picture at a lower resolution of what will be traced next.
    pub glimpse: Option<Glimpse>,
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

impl RunState {
    /// Whether the program that is open has rays, or none is open.
    #[must_use]
    pub fn has_rays(&self) -> bool {
        self.opened.as_ref().is_none_or(|opened| traces_rays(opened.plan.program))
    }

    /// Another run is ready; it arrives at a place next.
    pub(super) fn open(&mut self, opened: Opened) {
        let known = std::mem::take(self);
        *self = Self {
            opened: Some(opened),
            generation: known.generation + 1,
            edition: known.edition + 1,
            host_ns: known.host_ns,
            fired: known.fired,
            work: known.work,
            answers: known.answers,
            failures: known.failures,
            cancelled: known.cancelled,
            ..Self::default()
        };
    }

    /// The run is at a place. Returns whether the streams there, or the passes after it, are others than before.
    pub(super) fn arrive(&mut self, at: At) -> bool {
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
        is_changed
    }

    /// Takes over texels that were read. Statistics of the same texels stay valid.
    pub(super) fn take_texels(&mut self, mut texels: Texels) {
        let old = self.texels.iter_mut().find(|t| (t.stream, t.place) == (texels.stream, texels.place));
        if texels.counted.is_none() {
            texels.counted = old.and_then(|old| old.counted.take());
        }
        self.texels.retain(|t| t.stream != texels.stream);
        self.texels.push(texels);
    }

    /// A stream's texture. Its values may be those of an earlier place: see `drawn` of the model.
    #[must_use]
    pub fn texture(&self, stream: Stream) -> Option<&StreamTexture> {
        self.opened.as_ref()?.textures.iter().find(|(s, _)| *s == stream).map(|(_, texture)| texture)
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
