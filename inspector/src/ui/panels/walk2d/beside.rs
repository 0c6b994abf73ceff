//! Two walks of the same ray below each other, on one scale of t, with what each of them tested.

use std::sync::Arc;

use egui::{Align2, FontId, Painter, Rect, Stroke, pos2};
use raystep_kernels::export::trace::Trace;

use super::super::picked;
use super::picture::{outcome_color, ray_color};
use super::progress::Progress;
use super::second::Found;
use super::{Scene, Under, Whole, strip};
use crate::ui::choice::Choice;
use crate::ui::pane::Context;
use crate::ui::state::Picked;
use crate::walk::{Both, Outcome, Spacing, Strip, Structure, WalkGeometry};

const SIDES: [&str; 2] = ["A", "B"];
/// Most triangles listed by id.
const MOST_IDS: usize = 12;
/// Height of a strip's heading.
const HEADING: f32 = 14.0;

/// The second walk, and both compared; made again when one of them changes.
pub(super) struct Beside {
    first: Arc<Trace>,
    pub(super) found: Found,
    whole: Whole,
    now: Option<(Option<usize>, Option<WalkGeometry>, Progress)>,
    both: Both,
    strips: [Strip; 2],
    structures: [Structure; 2],
}

impl Beside {
    /// Of the first walk and the one found.
    pub(super) fn update(kept: &mut Option<Self>, history: &Arc<Trace>, first: &Whole, found: &Found) {
        let is_known =
            |kept: &Self| Arc::ptr_eq(&kept.first, history) && Arc::ptr_eq(&kept.found.history, &found.history);
        if !kept.as_ref().is_some_and(is_known) {
            let whole = Whole::of(&found.history, &found.data, usize::MAX);
            let both = Both::of([&first.walk, &whole.walk], [&first.strip, &whole.strip]);
            let strips = [first.strip.clone().over(both.t), whole.strip.clone().over(both.t)];
            let structures = [first.walk.structure, whole.walk.structure];
            let (first, found) = (history.clone(), found.clone());
            *kept = Some(Self { first, found, whole, now: None, both, strips, structures });
        }
        let Some(kept) = kept else { return };
        kept.found.clone_from(found);
        if kept.now.as_ref().is_none_or(|(row, ..)| *row != found.row) {
            let walk = found.row.map(|row| WalkGeometry::new(&found.history, &found.data, row));
            let progress = Progress::new(&kept.whole.walk, &kept.whole.picture, found.row);
            kept.now = Some((found.row, walk, progress));
        }
    }

    /// What each walk did, in words. `first` is the structure of the first walk.
    pub(super) fn headings(&self, first: &str) -> [String; 2] {
        let names = [first, &self.found.name];
        [0, 1].map(|i| format!("{} {}: {}", SIDES[i], names[i], self.both.work[i].text(self.structures[i])))
    }

    /// The triangles that only one of them tested: a click picks one.
    pub(super) fn differences(&self, ui: &mut egui::Ui, cx: &mut Context<'_>) {
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 3.0;
            for (i, only) in self.both.only.iter().enumerate() {
                let side = SIDES[i];
                ui.weak(match only.len() {
                    0 => format!("only {side} tested: none"),
                    count => format!("only {side} tested {count}:"),
                });
                for &triangle in only.iter().take(MOST_IDS) {
                    let what = Picked::Triangle(triangle);
                    let button = Choice::new(cx.selection.picked == Some(what), triangle.to_string()).small();
                    let about = format!("triangle {triangle}, tested only in {side}");
                    let response = ui.add(button).on_hover_text(&about);
                    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &about));
                    if response.clicked() {
                        picked::toggle(cx.selection, what);
                    }
                }
                if only.len() > MOST_IDS {
                    let rest = only[MOST_IDS..].iter().take(400).map(u32::to_string).collect::<Vec<_>>().join(", ");
                    ui.weak("…").on_hover_text(rest);
                }
            }
            ui.weak(format!("both: {}", self.both.shared.len()));
        });
    }

    /// Draws both; describes the item under the cursor, and tells in which of them it is.
    pub(super) fn draw(&self, painter: &Painter, rect: Rect, name: &str, scene: &Scene<'_>) -> Option<(usize, Under)> {
        let first = &Scene { spacing: Spacing::ByT, ..*scene };
        let (body, scale) = strip::split_scale(rect);
        // A row of nodes needs less height than a row of cells with their bars.
        let wants = [0, 1].map(|i| {
            let strip: &Strip = &self.strips[i];
            HEADING + if strip.cells.is_empty() { 30.0 + 10.0 * strip.lines() as f32 } else { 130.0 }
        });
        let share = (wants[0] / (wants[0] + wants[1])).clamp(0.3, 0.7);
        let (upper, lower) = body.split_top_bottom_at_fraction(share);
        let now = self.now.as_ref();
        let progress = Progress::default();
        let second = Scene {
            walk: &self.whole.walk,
            now: now.and_then(|(_, walk, _)| walk.as_ref()),
            progress: now.map_or(&progress, |(.., progress)| progress),
            ..*first
        };
        // The same t in both.
        let x_of = |t: f64| body.left() + self.strips[0].place(t, Spacing::ByT) as f32 * body.width();
        let lines = [
            first.now.map(|now| (now.t, ray_color(first.visuals))),
            first.walk.hit.map(|hit| (hit.t, outcome_color(first.visuals, Outcome::Nearest))),
        ];
        for (t, color) in lines.into_iter().flatten().filter(|(t, _)| (self.both.t[0]..=self.both.t[1]).contains(t)) {
            let line = [pos2(x_of(t), body.top()), pos2(x_of(t), body.bottom())];
            let stroke = Stroke::new(1.0, color.gamma_multiply(0.8));
            painter.extend(egui::Shape::dashed_line(&line, stroke, 2.0, 3.0));
        }
        let (mut under, headings) = (None, self.headings(name));
        for (i, (rect, scene)) in [(upper, first), (lower, &second)].into_iter().enumerate() {
            let heading = rect.intersect(Rect::from_min_size(rect.min, egui::vec2(rect.width(), HEADING)));
            let lanes = Rect::from_min_max(heading.left_bottom(), rect.max);
            let painter = painter.with_clip_rect(rect.expand2(egui::vec2(4.0, 0.0)).intersect(painter.clip_rect()));
            let ink = first.visuals.weak_text_color();
            painter.line_segment([rect.left_top(), rect.right_top()], Stroke::new(1.0, ink.gamma_multiply(0.3)));
            painter.text(
                heading.left_top(),
                Align2::LEFT_TOP,
                &headings[i],
                FontId::proportional(11.0),
                first.visuals.strong_text_color(),
            );
            let found = strip::lanes(&painter, lanes, &self.strips[i], scene);
            under = found.map(|found| (i, found)).or(under);
        }
        strip::axis(painter, body, scale, &self.strips[0], first);
        under
    }
}
