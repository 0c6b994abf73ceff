//! Texts that lie over each other.

use std::collections::HashSet;

use egui::Rect;

use super::ink::{Cover, Ink, inks_and_covers};
use crate::ui::stage::Stage;

/// How far the boxes of two texts may reach into each other, in points: a box goes from the ascenders of small letters
/// to the baseline, and positions are rounded to pixels.
const TOLERANCE: f32 = 1.5;

/// Texts of the last frame that others are drawn over, with nothing opaque between them.
pub(super) fn overlapping(stage: &Stage) -> HashSet<String> {
    let (inks, covers) = inks_and_covers(stage);
    let window = stage.harness.ctx.content_rect();
    let seen: Vec<Vec<Rect>> = inks.iter().map(|ink| visible(ink, window)).collect();
    let mut found = HashSet::new();
    for (i, below) in inks.iter().enumerate() {
        for (j, above) in inks.iter().enumerate().skip(i + 1) {
            let common = seen[i].iter().flat_map(|a| seen[j].iter().map(|b| a.intersect(*b)));
            let lost = common.filter(|common| common.width() > TOLERANCE && common.height() > TOLERANCE);
            let mut lost = lost.filter(|common| !is_covered(&covers, below, above, *common));
            if let Some(at) = lost.next() {
                found.insert(format!("{:?} over {:?} at {at:?}", above.text, below.text));
            }
        }
    }
    found
}

/// The rows of a text that are not clipped away.
fn visible(ink: &Ink, window: Rect) -> Vec<Rect> {
    let clip = ink.clip.intersect(window);
    ink.rows.iter().map(|row| row.intersect(clip)).filter(|row| row.is_positive()).collect()
}

/// Whether something opaque lies between two texts, as beneath a menu.
fn is_covered(covers: &[Cover], below: &Ink, above: &Ink, at: Rect) -> bool {
    let between = |cover: &&Cover| below.order < cover.order && cover.order <= above.order;
    covers.iter().filter(between).any(|cover| cover.rect.contains_rect(at))
}
