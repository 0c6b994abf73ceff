//! Texels edited by hand: part of the run's history, so that going back and forth repeats them.

use raystep_kernels::{RenderError, Stream};
use serde::{Deserialize, Serialize};

use super::travel::Guide;
use super::{OnProgress, Session, go_on};
use crate::names::saved_stream;

/// One component of one ray that was edited between two passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Edit {
    /// Passes before it.
    pub place: usize,
    /// The stream.
    #[serde(deserialize_with = "saved_stream")]
    pub stream: Stream,
    /// The component.
    pub layer: usize,
    /// Column of the ray's pixel.
    pub x: u32,
    /// Its row.
    pub y: u32,
    /// The new value; a float as its bits.
    pub bits: u32,
}

impl Session {
    /// Edits one component of one ray at the current place. The following passes use it, also after going back to an
    /// earlier place and forwards again.
    ///
    /// # Errors
    /// Where the plan left the stream out, there is no such layer or pixel, or the device fails: nothing is changed.
    pub async fn edit(&mut self, stream: Stream, layer: usize, x: u32, y: u32, bits: u32) -> Result<(), RenderError> {
        self.go(self.place(), &mut Guide::new(&mut go_on)).await?;
        self.is_settled = false;
        let result = self.renderer.write_component(stream, layer, x, y, bits).await;
        if result.is_ok() {
            let edit = Edit { place: self.place(), stream, layer, x, y, bits };
            self.insert(edit);
            self.history.forget_from(edit.place);
            self.leave_twins();
        }
        self.is_settled = !self.renderer.is_ahead();
        result
    }

    /// The position of an edit in the list: after those of the same place, replacing one of the same component.
    fn insert(&mut self, edit: Edit) {
        let is_same = |e: &Edit| Edit { bits: 0, ..*e } == Edit { bits: 0, ..edit };
        self.edits.retain(|e| !is_same(e));
        let behind = self.edits.partition_point(|e| e.place <= edit.place);
        self.edits.insert(behind, edit);
    }

    /// All edits, in the order of places.
    #[must_use]
    pub fn edits(&self) -> &[Edit] {
        &self.edits
    }

    /// Undoes all edits. The session stays at its place, as far as the run then allows; returns the place reached.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub async fn clear_edits(&mut self, progress: &mut OnProgress<'_>) -> Result<usize, RenderError> {
        self.set_edits(Vec::new(), progress).await
    }

    /// Replaces the edits, for example by those of a saved session, or by all but one. The session stays at its place,
    /// as far as the run then allows; returns the place reached.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub async fn set_edits(
        &mut self,
        mut edits: Vec<Edit>,
        progress: &mut OnProgress<'_>,
    ) -> Result<usize, RenderError> {
        edits.sort_by_key(|e| e.place);
        let same = edits.iter().zip(&self.edits).take_while(|(new, old)| new == old).count();
        let first = [edits.get(same), self.edits.get(same)].into_iter().flatten().map(|e| e.place).min();
        self.edits = edits;
        let here = self.place();
        if let Some(first) = first {
            self.history.forget_from(first);
            if here >= first {
                self.is_settled = false;
                self.go(here, &mut Guide::new(progress)).await?;
            }
        }
        Ok(self.place())
    }
}
