//! Legends: a line of painted signs with their names. Where not all fit, the line ends with how many more there are.

use egui::{Color32, FontSelection, Painter, Rect, Sense, TextStyle, Ui, vec2};

const SIDE: f32 = 10.0;

/// Paints a sign.
type Paint<'a> = Box<dyn Fn(&Painter, Rect) + 'a>;

/// A painted sign and its name.
pub(super) struct Entry<'a> {
    name: String,
    about: &'a str,
    paint: Paint<'a>,
    /// Whether it gives way to others where there is little room.
    gives_way: bool,
}

impl<'a> Entry<'a> {
    /// A colour patch.
    pub(super) fn new(color: Color32, name: impl Into<String>, about: &'a str) -> Self {
        Self::painted(name, about, move |painter, rect| {
            painter.rect_filled(rect, 2.0, color);
        })
    }

    pub(super) fn painted(name: impl Into<String>, about: &'a str, paint: impl Fn(&Painter, Rect) + 'a) -> Self {
        Self { name: name.into(), about, paint: Box::new(paint), gives_way: false }
    }

    /// Leaves it out before others, for instance if the picture does not have it.
    pub(super) fn unless(self, is_there: bool) -> Self {
        Self { gives_way: !is_there, ..self }
    }

    fn show(&self, ui: &mut Ui) {
        // As high as the name: in a row that begins with it, it would stand higher than the others.
        let height = ui.text_style_height(&TextStyle::Small).max(SIDE);
        let (rect, _) = ui.allocate_exact_size(vec2(SIDE, height), Sense::hover());
        (self.paint)(ui.painter(), Rect::from_center_size(rect.center(), vec2(SIDE, SIDE)));
        let name = ui.small(&self.name);
        if !self.about.is_empty() {
            name.on_hover_text(self.about);
        }
    }
}

/// Shows them in one line of a wrapping row: in the rest of the current one if all fit there, otherwise in the next.
pub(super) fn line(ui: &mut Ui, entries: &[Entry<'_>]) {
    let font = FontSelection::Style(TextStyle::Small).resolve(ui.style());
    let text = |text: String| ui.painter().layout_no_wrap(text, font.clone(), Color32::WHITE).size().x;
    let gap = ui.spacing().item_spacing.x;
    let widths: Vec<f32> = entries.iter().map(|entry| SIDE + 2.0 * gap + text(entry.name.clone())).collect();
    let more = text(more(entries.len())) + gap;
    let room = ui.available_size_before_wrap().x + gap;
    let whole = ui.max_rect().width() + gap;
    let is_next = widths.iter().sum::<f32>() > room && room < whole - 1.0;
    if is_next {
        ui.end_row();
    }
    let ways: Vec<bool> = entries.iter().map(|entry| entry.gives_way).collect();
    let kept = kept(&widths, &ways, if is_next { whole } else { room }, more);
    for (entry, _) in entries.iter().zip(&kept).filter(|(_, is_kept)| **is_kept) {
        entry.show(ui);
    }
    let left: Vec<&Entry<'_>> = entries.iter().zip(&kept).filter(|(_, kept)| !**kept).map(|(entry, _)| entry).collect();
    if !left.is_empty() {
        ui.small(self::more(left.len())).on_hover_ui(|ui| {
            for entry in left {
                ui.horizontal(|ui| {
                    entry.show(ui);
                    ui.small(entry.about);
                });
            }
        });
    }
}

fn more(count: usize) -> String {
    format!("{count} more")
}

/// Which entries fit into a line, those first that do not give way. If not all do, `more` is kept free.
fn kept(widths: &[f32], gives_way: &[bool], room: f32, more: f32) -> Vec<bool> {
    if widths.iter().sum::<f32>() <= room {
        return vec![true; widths.len()];
    }
    let mut left = room - more;
    let mut kept = vec![false; widths.len()];
    for way in [false, true] {
        for (i, width) in widths.iter().enumerate().filter(|(i, _)| gives_way[*i] == way) {
            if *width > left {
                return kept;
            }
            left -= width;
            kept[i] = true;
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_there_gives_way_first_and_the_number_of_others_has_room() {
        let (widths, gives_way) = ([30.0, 40.0, 30.0, 40.0], [true, false, false, true]);
        let shown = |room| kept(&widths, &gives_way, room, 20.0);
        assert_eq!(shown(140.0), [true; 4]);
        assert_eq!(shown(139.0), [true, true, true, false]);
        assert_eq!(shown(119.0), [false, true, true, false]);
        assert_eq!(shown(89.0), [false, true, false, false]);
        assert_eq!(shown(50.0), [false; 4]);
    }
}
