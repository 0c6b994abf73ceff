//! What is shown where the rays' states would be a picture in one colour, and what one value in all texels is said to be.

use raystep_kernels::tables::stream::Meaning as StreamMeaning;
use raystep_kernels::{Accelerator, Plan, Stream};
use raystep_lab::layer_stats::{LayerStats, Others};

use super::StreamView;
use crate::session::Model;

/// The component that has the cell or node of each ray.
fn of_place(stream: Stream) -> Option<usize> {
    stream.info().meaning.iter().position(|&meaning| meaning == StreamMeaning::Id)
}

impl StreamView {
    /// While all rays are in one state and nothing was chosen, their cells or nodes are shown instead; if these are the
    /// same, too, as at first, the directions of rays.
    pub(super) fn telling(
        &self,
        plan: &Plan,
        streams: &[Stream],
        default: Stream,
        model: &Model,
    ) -> Option<(Stream, Option<usize>)> {
        let is_chosen = self.pinned.is_some() || self.look.stream.is_some() || self.look.layer.is_some();
        let is_of_states = plan.program.state_stream() == Some(default);
        let in_states = |counts: &[u32]| counts.iter().filter(|&&rays| rays > 0).count();
        if is_chosen || !is_of_states || model.last_pass().is_none_or(|pass| in_states(&pass.counts) != 1) {
            return None;
        }
        let has_places = plan.accelerator != Accelerator::None && self.alike != Some((model.edition, model.place));
        if let Some(layer) = of_place(default).filter(|_| has_places) {
            return Some((default, Some(layer)));
        }
        let direction = plan.program.results?.direction;
        streams.contains(&direction).then_some((direction, None))
    }

    /// Remembers where the cells or nodes of all rays are the same.
    pub(super) fn find_alike(&mut self, model: &Model, stream: Stream, layer: usize) {
        let is_of_places = model.opened.as_ref().is_some_and(|opened| {
            opened.plan.program.state_stream() == Some(stream) && of_place(stream) == Some(layer)
        });
        if let Some((edition, place, of, l, stats)) = &self.stats
            && is_of_places
            && (*of, *l) == (stream, layer)
            && only_value(stats).is_some()
        {
            self.alike = Some((*edition, *place));
        }
    }
}

/// The value that all texels have: `Some(None)` if it is none of the ordinary ones.
pub(super) fn only_value(stats: &LayerStats) -> Option<Option<f64>> {
    match (&stats.span, stats.others) {
        _ if stats.texels < 2 => None,
        (Some(span), _) if stats.ordinary == stats.texels && span.min == span.max => Some(Some(span.min)),
        (None, Others::Integer { none, .. }) if none == stats.texels => Some(None),
        _ => None,
    }
}

/// Says that all texels have a value.
pub(super) fn sentence(value: &str) -> String {
    format!("all texels have one value: {value}")
}

#[cfg(test)]
mod tests {
    use raystep_kernels::programs::closest_hit::streams::{STATE, STATE_CELL};

    use super::*;

    #[test]
    fn one_value_in_all_texels_is_found_and_no_other() {
        let of = |values: &[u32]| only_value(&LayerStats::of(STATE, STATE_CELL, values));
        assert_eq!([of(&[7, 7, 7]), of(&[u32::MAX; 2])], [Some(Some(7.0)), Some(None)]);
        assert_eq!([of(&[7, 8]), of(&[7, u32::MAX]), of(&[7]), of(&[])], [None; 4]);
    }
}
