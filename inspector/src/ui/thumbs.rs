//! Thumbnails of a stream after passes: of all that were shown, and of some on the way to them.

use super::canvas::WHOLE;
use std::sync::Arc;

use egui::{Align2, Color32, FontId, Rect, Ui, vec2};
use raystep_kernels::Stream;
use raystep_lab::text::counted;

use super::canvas::{Canvas, Moment, Picture};
use super::style::SMALLEST;
use crate::draw::stream::{self, Colors, Meaning};
use crate::session::{Model, Sketch};

/// Most thumbnails: with [`SIDE`] at most 4 MiB.
const MOST: usize = 64;
/// Most pixels along a side.
const SIDE: u32 = crate::session::SKETCH_SIDE;
/// Sketches drawn per frame.
const A_FRAME: usize = 4;

/// What a stream view shows: a stream and its layer, or what it shows if none was chosen.
pub(super) type View = Option<(Stream, Option<usize>)>;

/// A thumbnail.
pub struct Thumb {
    /// The number of passes before it.
    pub place: usize,
    view: View,
    picture: Picture,
    /// Pixels along both sides.
    size: [u32; 2],
}

impl Thumb {
    /// Its width for a height, in points.
    #[must_use]
    pub fn width(&self, height: f32) -> f32 {
        let [width, rows] = self.size.map(|side| side as f32);
        height * (width / rows.max(1.0)).clamp(0.25, 4.0)
    }

    /// Paints it.
    pub fn paint(&self, painter: &egui::Painter, rect: Rect, tint: Color32) {
        if let Some(id) = self.picture.id() {
            painter.image(id, rect, WHOLE, tint);
        }
    }
}

/// The thumbnails of the streams as they are now.
#[derive(Default)]
pub struct Thumbs {
    edition: u64,
    view: View,
    /// In the order of their places.
    kept: Vec<Thumb>,
}

impl Thumbs {
    /// The view whose thumbnails are shown from now on.
    pub fn look(&mut self, view: View) {
        self.view = view;
    }

    /// Keeps a small copy of a picture that a view has drawn.
    pub fn take(&mut self, canvas: &Arc<Canvas>, (edition, place): Moment, view: View, of: &stream::Picture<'_>) {
        self.enter(edition);
        self.keep(canvas, place, view, of);
    }

    /// Draws what the engine has sketched on its way. Returns whether there is more.
    pub fn draw_sketches(&mut self, canvas: &Arc<Canvas>, model: &mut Model) -> bool {
        self.enter(model.edition);
        let Some(states) = model.opened.as_ref().map(|opened| opened.plan.program.states) else { return false };
        let count = model.sketches.len().min(A_FRAME);
        for Sketch { stream, place, texture, .. } in model.sketches.drain(..count) {
            if self.kept.iter().any(|thumb| (thumb.place, thumb.view) == (place, None)) {
                continue;
            }
            let of = stream::Picture {
                stream,
                states,
                texture: &texture,
                minus: None,
                layer: 0,
                meaning: Meaning::Tag,
                range: [0.0, 1.0],
                exposure: 1.0,
                colors: Colors::default(),
                offset: [0.0; 2],
                scale: 1.0,
            };
            self.keep(canvas, place, None, &of);
        }
        !model.sketches.is_empty()
    }

    /// Those of the current view, in the order of their places.
    pub fn shown(&self) -> impl DoubleEndedIterator<Item = &Thumb> {
        self.kept.iter().filter(|thumb| thumb.view == self.view)
    }

    /// The thumbnail whose place is nearest.
    #[must_use]
    pub fn nearest(&self, place: usize) -> Option<&Thumb> {
        self.shown().min_by_key(|thumb| thumb.place.abs_diff(place))
    }

    /// Over the picture of a place that is not the wanted one: the thumbnail that is nearer to it, if there is one.
    pub fn cover(&self, ui: &Ui, clip: Rect, picture: Rect, shown: usize, wanted: Option<usize>) {
        let Some(wanted) = wanted.filter(|&wanted| wanted != shown) else { return };
        let Some(thumb) = self.nearest(wanted).filter(|t| t.place.abs_diff(wanted) < shown.abs_diff(wanted)) else {
            return;
        };
        let painter = ui.painter().with_clip_rect(clip);
        painter.rect_filled(picture, 0.0, ui.visuals().panel_fill);
        thumb.paint(&painter, picture, Color32::WHITE);
        let text = format!("thumbnail: after {}", counted(thumb.place, "pass"));
        let ink = ui.visuals().strong_text_color();
        let galley = painter.layout_no_wrap(text, FontId::proportional(SMALLEST), ink);
        let label = Align2::LEFT_TOP.anchor_size(picture.intersect(clip).min, galley.size() + vec2(8.0, 4.0));
        painter.rect_filled(label, 2.0, ui.visuals().window_fill);
        painter.galley(label.min + vec2(4.0, 2.0), galley, ink);
    }

    /// Other streams: what is kept shows none of them.
    fn enter(&mut self, edition: u64) {
        if self.edition != edition {
            (self.edition, self.kept) = (edition, Vec::new());
        }
    }

    fn keep(&mut self, canvas: &Arc<Canvas>, place: usize, view: View, of: &stream::Picture<'_>) {
        let sides = [of.texture.width(), of.texture.height()];
        let scale = f64::from(SIDE) / f64::from(sides[0].max(sides[1]).max(SIDE));
        let size = sides.map(|side| ((f64::from(side) * scale).round() as u32).clamp(1, SIDE));
        let at = self.kept.partition_point(|thumb| thumb.place < place);
        let same = self.kept[at..].iter().take_while(|thumb| thumb.place == place).position(|t| t.view == view);
        let mut picture = match same {
            Some(same) => self.kept.remove(at + same).picture,
            None => Picture::default(),
        };
        if let Some(target) = picture.target(canvas, size, true) {
            canvas.streams.draw(&stream::Picture { offset: [0.0; 2], scale: scale as f32, ..*of }, target);
        }
        self.kept.insert(at, Thumb { place, view, picture, size });
        while let Some(least) = self.least() {
            self.kept.remove(least);
        }
    }

    /// The one to drop if there are too many: of another view, otherwise the one whose neighbours are closest together.
    fn least(&self) -> Option<usize> {
        let places: Vec<(usize, bool)> = self.kept.iter().map(|thumb| (thumb.place, thumb.view == self.view)).collect();
        least(&places)
    }
}

/// As [`Thumbs::least`], for places in order, and whether they are of the current view.
fn least(places: &[(usize, bool)]) -> Option<usize> {
    if places.len() <= MOST {
        return None;
    }
    places.iter().position(|(_, is_shown)| !is_shown).or_else(|| {
        // The first and the last stay.
        let gaps = places.windows(3).map(|near| near[2].0 - near[0].0);
        gaps.enumerate().min_by_key(|&(_, gap)| gap).map(|(i, _)| i + 1)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thumbnails_are_limited_and_evenly_spaced() {
        let mut places: Vec<(usize, bool)> = Vec::new();
        for place in 0..1000 {
            places.push((place, true));
            while let Some(i) = least(&places) {
                places.remove(i);
            }
            assert!(places.len() <= MOST);
        }
        assert_eq!((places.len(), places[0].0, places[MOST - 1].0), (MOST, 0, 999));
        let longest = places.windows(2).map(|near| near[1].0 - near[0].0).max();
        // 1000 places in 63 gaps are 16 each; dropping one doubles a gap, twice at most where others are still small.
        assert!(longest <= Some(64), "{longest:?} in {places:?}");
        places.insert(10, (places[10].0, false));
        assert_eq!(least(&places), Some(10), "one of another view goes first");
        const { assert!(MOST * (SIDE * SIDE * 4) as usize <= 4 << 20) };
    }
}
