//! Thumbnails under the chart, each at its pass.

use egui::{Color32, Painter, Rect, pos2};

use crate::ui::thumbs::Thumbs;

/// The rectangle and place of each thumbnail that has room, from the left: none overlaps another.
pub(super) fn placed(lane: Rect, thumbs: &Thumbs, x: impl Fn(usize) -> Option<f32>) -> Vec<(Rect, usize)> {
    let widths = thumbs.shown().map(|thumb| (thumb.place, thumb.width(lane.height())));
    side_by_side(lane, widths, x)
}

fn side_by_side(
    lane: Rect,
    widths: impl Iterator<Item = (usize, f32)>,
    x: impl Fn(usize) -> Option<f32>,
) -> Vec<(Rect, usize)> {
    let mut placed: Vec<(Rect, usize)> = Vec::new();
    for (place, width) in widths {
        let Some(x) = x(place) else { continue };
        let left = (x - 0.5 * width).clamp(lane.left(), (lane.right() - width).max(lane.left()));
        let rect = Rect::from_min_max(pos2(left, lane.top()), pos2((left + width).min(lane.right()), lane.bottom()));
        if placed.last().is_none_or(|(before, _)| before.right() + 1.0 <= rect.left()) {
            placed.push((rect, place));
        }
    }
    placed
}

/// Paints them; those ahead of the place are fainter.
pub(super) fn paint(painter: &Painter, placed: &[(Rect, usize)], thumbs: &Thumbs, place: usize) {
    for thumb in thumbs.shown() {
        if let Ok(i) = placed.binary_search_by_key(&thumb.place, |(_, place)| *place) {
            let tint = if thumb.place > place { Color32::from_gray(140) } else { Color32::WHITE };
            thumb.paint(painter, placed[i].0, tint);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thumbnails_lie_at_their_passes_and_none_over_another() {
        let lane = Rect::from_min_max(pos2(100.0, 0.0), pos2(200.0, 30.0));
        let placed = side_by_side(lane, (0..100).map(|place| (place, 30.0)), |place| Some(100.0 + place as f32));
        let places: Vec<usize> = placed.iter().map(|(_, place)| *place).collect();
        assert_eq!(places, [0, 46, 77]);
        assert!(placed.windows(2).all(|two| two[0].0.right() < two[1].0.left()));
        assert!(placed.iter().all(|(rect, _)| lane.contains_rect(*rect)));
        assert!(side_by_side(lane, [(3, 500.0)].into_iter(), |_| None).is_empty());
        let wide = side_by_side(lane, [(3, 500.0)].into_iter(), |_| Some(150.0));
        assert_eq!(wide, [(lane, 3)]);
    }
}
