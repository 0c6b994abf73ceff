//! The walk of the selected ray, seen along one axis and unfolded along t, synchronised with the timeline: later steps
//! are dimmed. A click goes to the pass.
//!
//! Touches: other, selection, display, asks.

mod beside;
mod export;
mod picture;
mod progress;
mod second;
mod strip;

use egui::{Rect, Sense, Shape, vec2};
use raystep_kernels::Accelerator;
use raystep_kernels::export::trace::{Trace, TraceRow};
use raystep_kernels::scene_data::SceneData;
use serde::{Deserialize, Serialize};

use super::picked;
use super::walked::{Walked, describe, event_buttons, go_on, number};
use crate::command::Command;
use crate::session::request::Request;
use crate::session::{Model, Target};
use crate::ui::choice::{Choice, Choices as _};
use crate::ui::pane::{Context, NO_RAYS, Panel, saves};
use crate::ui::state::Picked;
use crate::ui::svg::Titles;
use crate::ui::units::{self, Scale};
use crate::walk::{Projected, Spacing, Strip, Structure, WalkGeometry, last_row_of_ray};
use beside::Beside;
use progress::Progress;
use second::{Found, Second};

/// The saved part of the view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
struct Look {
    /// Whether the width of a cell is its length along the ray; otherwise all cells are equally wide.
    by_t: bool,
    /// Whether the walk through the other structure is shown as well; `None` shows it while two runs are compared.
    beside: Option<bool>,
}

/// The ray's whole walk: the drawing does not change while stepping, until the pixel has another ray.
struct Whole {
    /// Its last row.
    row: usize,
    walk: WalkGeometry,
    picture: Projected,
    strip: Strip,
}

impl Whole {
    /// The walk up to a row.
    fn of(history: &Trace, data: &SceneData, row: usize) -> Self {
        let walk = WalkGeometry::new(history, data, row);
        Self { row, picture: Projected::new(&walk), strip: Strip::new(&walk), walk }
    }
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
    second: Second,
    beside: Option<Beside>,
    about: picked::About,
    /// Whether two runs were compared in the last frame.
    compares: bool,
}

/// The item under the cursor.
struct Under {
    /// Its description.
    text: String,
    /// The row that a click goes to.
    row: usize,
    /// What a click picks.
    what: Option<Picked>,
}

impl Panel for Walk2d {
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
        let Some(history) = self.walked.history.clone().filter(|history| !history.rows.is_empty()) else {
            ui.weak("Click a pixel to see its ray's path.");
            return;
        };
        // A new comparison shows both walks again, even if they were hidden in an earlier one.
        if !std::mem::replace(&mut self.compares, cx.other.is_some()) && self.compares {
            self.look.beside = self.look.beside.filter(|&is_shown| is_shown);
        }
        self.tools(ui, cx);
        self.about.show(ui, cx.model, cx.selection, cx.display);
        // Another element than a ray is of this run alone.
        let found = if history.element.is_none() { self.second_walk(ui, history.pixel, cx) } else { None };
        cx.display.beside = found.as_ref().map(|found| found.data.clone());
        let (Some(whole), Some((_, progress))) = (&self.whole, &self.progress) else { return };
        if let Some(found) = &found {
            Beside::update(&mut self.beside, &history, whole, found);
        }
        let beside = self.beside.as_ref().filter(|_| found.is_some());
        let first = cx.model.opened.as_ref().map_or(String::new(), |opened| opened.plan.accelerator.to_string());
        if let Some(beside) = beside {
            beside.differences(ui, cx);
        }
        let size = ui.available_size().max(vec2(32.0, 32.0));
        let (rect, response) = ui.allocate_exact_size(size, Sense::click());
        let unit = Scale::of(cx.display.units, &history).t64(1.0);
        let (now, picked) = (self.walked.walk.as_ref(), cx.selection.picked);
        let (hides_next, spacing, cursor) = (cx.display.hides_next, self.spacing(), response.hover_pos());
        let scene = Scene {
            walk: &whole.walk,
            now,
            progress,
            visuals: ui.visuals(),
            unit,
            picked,
            hides_next,
            spacing,
            cursor,
            titles: None,
        };
        let painter = ui.painter().with_clip_rect(rect);
        let under = match beside {
            Some(beside) => beside.draw(&painter, rect, &first, &scene),
            None => paint(&painter, rect, whole, &scene).map(|under| (0, under)),
        };
        let mut what = self.walked.walk.as_ref().map_or_else(|| "No pass has processed this ray yet.".into(), describe);
        if let Some(beside) = beside {
            let [a, b] = beside.headings(&first);
            what += &format!("; {a}; {b}");
        }
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &what));
        let found = found.as_ref();
        point_at(&response, under, &history, found, cx);
    }

    saves!(look);

    fn command(&mut self, command: Command, cx: &mut Context<'_>) -> bool {
        if command == Command::SecondWalk {
            self.look.beside = Some(!self.is_beside(cx));
            return true;
        }
        if command != Command::ExportWalk {
            return false;
        }
        self.update(cx.model);
        let shown = self.walked.history.as_ref().zip(cx.model.opened.as_ref());
        cx.asks.files.extend(shown.and_then(|(history, opened)| self.drawing(history, &opened.data)));
        self.walked.history.is_some()
    }
}

/// Hovering describes an item of the first or second walk; a click picks it and goes to its pass.
fn point_at(
    response: &egui::Response,
    under: Option<(usize, Under)>,
    history: &Trace,
    found: Option<&Found>,
    cx: &mut Context<'_>,
) {
    let Some((which, Under { text, row, what })) = under else { return };
    let second = found.filter(|_| which == 1);
    let rows = second.map_or(history, |found| &found.history);
    let place = rows.rows.get(row).and_then(TraceRow::place);
    if response.clicked() {
        let was_picked = what.is_some() && cx.selection.picked == what;
        if let Some(what) = what {
            picked::toggle(cx.selection, what);
        }
        // Without a second run, there is no pass to go to.
        match (second.map(|found| found.is_run), place.filter(|_| !was_picked)) {
            (None, Some(place)) => cx.asks.go_to = Some(place),
            (Some(true), Some(place)) => {
                if let Some(other) = cx.other.as_deref_mut().filter(|other| other.place != place) {
                    other.ask(Request::Step(Target::Pass(place)));
                }
            }
            _ => {}
        }
    }
    let on = match second {
        Some(found) if !found.is_run => format!("\nrow {} of {} in B", row + 1, rows.rows.len()),
        _ => go_on(rows, row),
    };
    let response = response.clone().on_hover_cursor(egui::CursorIcon::PointingHand);
    response.on_hover_text_at_pointer(text + &on);
}

/// The inputs of the drawing.
#[derive(Clone, Copy)]
struct Scene<'a> {
    /// The ray's whole walk.
    walk: &'a WalkGeometry,
    /// The part reached so far.
    now: Option<&'a WalkGeometry>,
    progress: &'a Progress,
    visuals: &'a egui::Visuals,
    /// t in the units shown, per t of the streams.
    unit: f64,
    picked: Option<Picked>,
    /// Whether only what the ray has reached is shown.
    hides_next: bool,
    spacing: Spacing,
    cursor: Option<egui::Pos2>,
    /// Takes what hovering would tell, for a drawing in a file.
    titles: Option<&'a Titles>,
}

impl Scene<'_> {
    /// What hovering over an area tells.
    fn title(&self, painter: &egui::Painter, area: impl Into<Shape>, text: impl FnOnce() -> String) {
        if let Some(titles) = self.titles {
            titles.add(painter, area.into(), text());
        }
    }

    /// A t in the units shown.
    fn t(&self, t: f64) -> String {
        number(t * self.unit)
    }
}

impl Walk2d {
    fn spacing(&self) -> Spacing {
        if self.look.by_t { Spacing::ByT } else { Spacing::Equal }
    }

    fn update(&mut self, model: &Model) {
        let is_other = self.walked.update(model);
        let (Some(history), Some(opened)) = (&self.walked.history, &model.opened) else {
            (self.whole, self.progress) = (None, None);
            return;
        };
        let last = last_row_of_ray(history, self.walked.row);
        if is_other || self.whole.as_ref().is_none_or(|whole| whole.row != last) {
            self.whole = Some(Whole::of(history, &opened.data, last));
            self.progress = None;
        }
        let version = self.walked.version;
        if let Some(whole) = self.whole.as_ref().filter(|_| self.progress.as_ref().is_none_or(|p| p.0 != version)) {
            self.progress = Some((version, Progress::new(&whole.walk, &whole.picture, self.walked.row)));
        }
    }

    /// Whether the walk through the other structure is to be shown.
    fn is_beside(&self, cx: &Context<'_>) -> bool {
        self.look.beside.unwrap_or(cx.other.is_some())
    }

    /// The walk through the other structure, if it is to be shown; says why there is none.
    fn second_walk(&mut self, ui: &mut egui::Ui, pixel: [u32; 2], cx: &mut Context<'_>) -> Option<Found> {
        // It is whole: while a lesson asks, it would tell what comes next.
        if !self.is_beside(cx) || cx.display.hides_next {
            self.beside = None;
            return None;
        }
        match self.second.find(pixel, cx) {
            Ok(found) => Some(found),
            Err(why) => {
                self.beside = None;
                ui.weak(why);
                None
            }
        }
    }

    fn tools(&mut self, ui: &mut egui::Ui, cx: &mut Context<'_>) {
        ui.horizontal_wrapped(|ui| {
            event_buttons(ui, cx.asks);
            let other = cx.model.opened.as_ref().map_or(Accelerator::Bvh, second::other_of);
            let name = if other == Accelerator::Bvh { "Show BVH walk" } else { "Show grid walk" };
            let text = format!(
                "the same ray through the {other} below it, on one scale of t: in the run that this one is compared with \
                 ({}), otherwise by the CPU reference kernels",
                Command::Compare.key_text(ui.ctx())
            );
            let is_beside = self.is_beside(cx);
            if ui.choice(is_beside, name).on_hover_text(text).clicked() {
                self.look.beside = Some(!is_beside);
            }
            let is_grid = self.whole.as_ref().is_some_and(|whole| whole.walk.structure == Structure::Grid);
            if is_grid && !is_beside {
                for (by_t, name, text) in [
                    (false, "equal", "all cells equally wide, so that cells that the ray barely touches are visible"),
                    (true, "by t", "width of a cell proportional to its length along the ray"),
                ] {
                    // In the next line rather than cut off.
                    let button = Choice::new(self.look.by_t == by_t, name);
                    if ui.add(button.extend()).on_hover_text(text).clicked() {
                        self.look.by_t = by_t;
                    }
                }
            }
            if let Some(history) = &self.walked.history {
                units::choose(ui, &mut cx.display.units, history.scene_units_per_stream_unit);
            }
            if ui.button("Export SVG").on_hover_text("save both pictures as SVG, up to this pass").clicked() {
                cx.asks.commands.push(Command::ExportWalk);
            }
            if let Some(walk) = self.walked.walk.as_ref().filter(|_| ui.available_size_before_wrap().x > 280.0 && cx.selection.picked.is_none()) {
                ui.weak(describe(walk));
            }
        });
    }
}

/// Paints the walk; describes the item under the cursor.
fn paint(painter: &egui::Painter, rect: Rect, whole: &Whole, scene: &Scene<'_>) -> Option<Under> {
    // The strip is all about what comes next.
    let (upper, lower) = if scene.hides_next { (Some(rect), None) } else { split(rect, whole) };
    let clipped = |rect| painter.with_clip_rect(rect);
    let in_picture = upper.and_then(|upper| picture::draw(&clipped(upper), upper, &whole.picture, scene));
    let in_strip = lower.and_then(|lower| strip::draw(&clipped(lower), lower, &whole.strip, scene));
    in_strip.or(in_picture)
}

/// The height that the strip needs.
fn strip_height(whole: &Whole) -> f32 {
    match whole.walk.structure {
        Structure::Grid => 220.0,
        Structure::Tree => strip::TREE_EDGES + 16.0 * whole.strip.lines() as f32,
        Structure::Nothing => 70.0,
    }
}

/// A strip of this height has tMax as numbers and bars, and labels of tests, each in a place of its own.
const NUMBERS_FIT: f32 = 156.0;

/// Space for the picture, if there is enough, and for the strip.
fn split(rect: Rect, whole: &Whole) -> (Option<Rect>, Option<Rect>) {
    let height = rect.height();
    let lower = strip_height(whole).min((height * 0.5).max(NUMBERS_FIT)).max(64.0).min(height);
    // What is too low for a picture belongs to the strip.
    let lower = if height - lower < 40.0 { height } else { lower };
    let (upper, lower) = rect.split_top_bottom_at_y(rect.bottom() - lower);
    ((upper.height() >= 40.0).then_some(upper), Some(lower))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_saved_when_the_view_had_units_of_its_own_is_read() {
        let mut view = Walk2d::default();
        view.load(r#"{"by_t": true, "beside": false, "scene_units": true}"#);
        assert_eq!(view.look, Look { by_t: true, beside: Some(false) });
    }
}
