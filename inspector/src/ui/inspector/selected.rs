//! The selected ray or other element: followed in every run, and shown in the frame in which it was selected.

use std::sync::Arc;

use raystep_kernels::export::trace::Trace;

use super::Inspector;
use crate::session::{HistorySource, Model};

impl Inspector {
    /// The run, and the one that it is compared with.
    fn models(&self) -> impl Iterator<Item = &Model> {
        std::iter::once(&self.model).chain(&self.other)
    }

    /// What several panels show of the same ray.
    pub(super) fn selection(&self) -> (Option<[u32; 2]>, Option<[u32; 2]>, Option<*const Trace>) {
        (self.state.selection.pixel, self.state.selection.hovered, self.model.history.as_ref().map(Arc::as_ptr))
    }

    /// Whether the device has yet to confirm the selected ray's history.
    pub(super) fn is_confirming(&self) -> bool {
        self.models().any(|model| model.history_source == HistorySource::Reference)
    }

    /// Whether the selected ray has yet to be followed.
    pub(super) fn is_to_follow(&self) -> bool {
        self.state
            .selection
            .subject(&self.model)
            .is_some_and(|subject| self.models().any(|model| model.is_to_follow(subject)))
    }

    /// Selects the ray that a panel or a command asks for, and follows it in each run that has not done so.
    pub(super) fn follow_selected(&mut self) {
        self.state.selection.element = self.state.asks.follow.take().or(self.state.selection.element);
        if let Some(pixel) = self.state.asks.select.take() {
            self.state.selection.element = None;
            self.state.selection.vertex = self.state.selection.vertex.filter(|wanted| wanted.pixel == pixel);
            // A ray whose following was cancelled can be clicked again.
            let is_known =
                self.model.history.as_ref().is_some_and(|history| history.pixel == pixel && history.element.is_none());
            if self.state.selection.pixel != Some(pixel) || !is_known {
                self.state.selection.pixel = Some(pixel);
                self.model.follow(pixel);
            }
        }
        if let Some(subject) = self.state.selection.subject(&self.model) {
            let models = std::iter::once(&mut self.model).chain(self.other.as_mut());
            models.filter(|model| model.is_to_follow(subject)).for_each(|model| model.follow(subject));
        }
    }
}
