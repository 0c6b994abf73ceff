//! The walk of the selected ray, seen along one axis and unfolded along t, synchronised with the timeline: later steps
//! are dimmed. A click goes to the pass.

mod picture;
mod progress;
mod strip;

use egui::{Rect, Sense, vec2};
use raystep_kernels::export::trace::{Trace, TraceRow};
use serde::{Deserialize, Serialize};

use super::walked::{Walked, describe, event_buttons};
use crate::session::Model;
use crate::ui::command::Command;
use crate::ui::host::FileToSave;
use crate::ui::pane::{Context, NO_RAYS, Panel};
use crate::walk::{Projected, Spacing, Strip, Structure, SvgOptions, WalkGeometry, walk_svg};
use progress::Progress;

/// The saved part of the view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
struct Look {
    /// Whether the width of a cell is its length along the ray; otherwise all cells are equally wide.
    by_t: bool,
}

/// The ray's whole history: the drawing does not change while stepping.
struct Whole {
    walk: WalkGeometry,
    picture: Projected,
    strip: Strip,
}

/// The 2D views.
#[derive(Default)]
pub(in crate::ui) struct Walk2d {
    look: Look,
    walked: Walked,
    whole: Option<Whole>,
    /// The part of the walk reached so far, as of the walk's version.
    progress: Option<(u64, Progress)>,
    is_dark: bool,
}

/// The item under the cursor.
struct Under {
    /// Its description.
    text: String,
    /// The row that a click goes to.
    row: usize,
}

impl Panel for Walk2d {
    fn title(&self) -> String {
        "Unfolded walk".into()
    }

    fn show(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>) {
        if cx.model.opened.is_none() {
            ui.weak("Open a scene and click a pixel to see its ray's path.");
            return;
        }
        if !cx.has_rays() {
            ui.weak(NO_RAYS);
            return;
        }
        self.is_dark = ui.visuals().dark_mode;
        self.update(cx.model);
        let Some(life) = self.walked.life.clone().filter(|life| !life.rows.is_empty()) else {
            ui.weak("Click a pixel to see its ray's path.");
            return;
        };
        self.tools(ui, cx);
        let (Some(whole), Some((_, progress))) = (&self.whole, &self.progress) else { return };
        let size = ui.available_size().max(vec2(32.0, 32.0));
        let (rect, response) = ui.allocate_exact_size(size, Sense::click());
        let (upper, lower) = split(rect, whole);
        let scene = Scene { walk: &whole.walk, now: self.walked.walk.as_ref(), progress, visuals: ui.visuals() };
        let cursor = response.hover_pos();
        let mut under = None;
        if let Some(upper) = upper {
            under = picture::draw(&ui.painter().with_clip_rect(upper), upper, &whole.picture, &scene, cursor);
        }
        let painter = ui.painter().with_clip_rect(lower);
        under = strip::draw(&painter, lower, &whole.strip, self.spacing(), &scene, cursor).or(under);
        let what = self.walked.walk.as_ref().map_or_else(|| "No pass has processed this ray yet.".into(), describe);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &what));
        if let Some(Under { text, row }) = under {
            let pass = life.rows.get(row).and_then(|row| row.pass);
            if response.clicked() {
                cx.shared.go_to = pass.map(|pass| pass + 1);
            }
            let text = pass.map_or_else(|| text.clone(), |pass| format!("{text}\nclick: pass {pass}"));
            response.on_hover_cursor(egui::CursorIcon::PointingHand).on_hover_text_at_pointer(text);
        }
    }

    fn save(&self) -> String {
        serde_json::to_string(&self.look).unwrap_or_default()
    }

    fn load(&mut self, saved: &str) {
        if let Ok(look) = serde_json::from_str(saved) {
            self.look = look;
        }
    }

    fn command(&mut self, command: Command, cx: &mut Context<'_>) -> bool {
        if command != Command::ExportWalk {
            return false;
        }
        self.update(cx.model);
        let Some(life) = &self.walked.life else { return false };
        let walk = self.walked.walk.as_ref().or(self.whole.as_ref().map(|whole| &whole.walk));
        if let Some(walk) = walk {
            let file = export(life, walk, self.spacing(), self.is_dark);
            cx.shared.files.push(file);
        }
        walk.is_some()
    }
}

/// The walk as a drawing.
fn export(life: &Trace, walk: &WalkGeometry, spacing: Spacing, is_dark: bool) -> FileToSave {
    let [x, y] = life.pixel;
    let last = walk.row.and_then(|row| life.rows.get(row)).map(TraceRow::number);
    let until = last.map_or_else(String::new, |pass| format!(", up to pass {pass}"));
    let options = SvgOptions { spacing, is_dark, ..SvgOptions::default() };
    let svg = walk_svg(walk, &format!("Ray of pixel {x},{y}{until}"), &options);
    FileToSave { name: format!("ray-{x}-{y}.svg"), bytes: svg.into_bytes(), holds: "a drawing".into() }
}

/// The inputs of the drawing.
struct Scene<'a> {
    /// The ray's whole walk.
    walk: &'a WalkGeometry,
    /// The part reached so far.
    now: Option<&'a WalkGeometry>,
    progress: &'a Progress,
    visuals: &'a egui::Visuals,
}

impl Walk2d {
    fn spacing(&self) -> Spacing {
        if self.look.by_t { Spacing::ByT } else { Spacing::Equal }
    }

    fn update(&mut self, model: &Model) {
        let is_other = self.walked.update(model);
        let (Some(life), Some(opened)) = (&self.walked.life, &model.opened) else {
            (self.whole, self.progress) = (None, None);
            return;
        };
        if is_other || self.whole.is_none() {
            let walk = WalkGeometry::new(life, &opened.data, usize::MAX);
            self.whole = Some(Whole { picture: Projected::new(&walk), strip: Strip::new(&walk), walk });
            self.progress = None;
        }
        let version = self.walked.version;
        if let Some(whole) = self.whole.as_ref().filter(|_| self.progress.as_ref().is_none_or(|p| p.0 != version)) {
            self.progress = Some((version, Progress::new(&whole.walk, &whole.picture, self.walked.row)));
        }
    }

    fn tools(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>) {
        ui.horizontal_wrapped(|ui| {
            event_buttons(ui, cx);
            if self.whole.as_ref().is_some_and(|whole| whole.walk.structure == Structure::Grid) {
                for (by_t, name, text) in [
                    (false, "equal", "all cells equally wide, so that cells that the ray barely touches are visible"),
                    (true, "by t", "width of a cell proportional to its length along the ray"),
                ] {
                    // In the next line rather than cut off.
                    let button = egui::Button::selectable(self.look.by_t == by_t, name);
                    if ui.add(button.wrap_mode(egui::TextWrapMode::Extend)).on_hover_text(text).clicked() {
                        self.look.by_t = by_t;
                    }
                }
            }
            if ui.button("Export SVG").on_hover_text("save both pictures as SVG, up to this pass").clicked() {
                cx.todo.push(Command::ExportWalk);
            }
            if let Some(walk) = self.walked.walk.as_ref().filter(|_| ui.available_size_before_wrap().x > 280.0) {
                ui.weak(describe(walk));
            }
        });
    }
}

/// Space for the picture, if there is enough, and for the strip.
fn split(rect: Rect, whole: &Whole) -> (Option<Rect>, Rect) {
    let wanted = match whole.walk.structure {
        Structure::Grid => 190.0,
        Structure::Tree => strip::TREE_EDGES + 16.0 * whole.strip.lines() as f32,
        Structure::Nothing => 70.0,
    };
    let lower = wanted.min(rect.height() * 0.5).max(64.0).min(rect.height());
    let (upper, lower) = rect.split_top_bottom_at_y(rect.bottom() - lower);
    ((upper.height() >= 40.0).then_some(upper), lower)
}

#[cfg(test)]
mod tests {
    use raystep_kernels::Accelerator;

    use super::super::walked::tests::life;
    use super::*;

    #[test]
    fn a_drawing_is_of_the_walk_so_far() {
        let (life, data) = life(Accelerator::Grid);
        let [x, y] = life.pixel;
        let row = life.rows.len() / 2;
        let file = export(&life, &WalkGeometry::new(&life, &data, row), Spacing::Equal, false);
        assert_eq!(file.name, format!("ray-{x}-{y}.svg"));
        let text = String::from_utf8(file.bytes).expect("text");
        assert!(text.contains(&format!("pixel {x},{y}, up to pass {}", life.rows[row].number())), "{text}");
    }
}
