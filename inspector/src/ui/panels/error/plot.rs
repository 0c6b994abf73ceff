//! Curves of shares over device time, on axes with round tick marks.

use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Response, Sense, Shape, Stroke, Ui, pos2, vec2};
use raystep_kernels::Pass;
use raystep_lab::human::grouped;
use raystep_lab::judge::Judgement;
use raystep_lab::text::counted;

use super::scales::{Shares, Unit, percent};
use crate::ui::style::strong;

/// Points left of the plot area, for shares.
const LEFT: f32 = 46.0;
/// Points above it, for the axis title.
const HEAD: f32 = 19.0;
/// Points below it, for times and the axis title.
const FOOT: f32 = 30.0;
/// Width of a time label.
const MARK: f32 = 52.0;

/// A run.
pub(super) struct Curve<'a> {
    passes: &'a [Pass],
    place: usize,
    rays: u64,
    judgement: Option<&'a Judgement>,
    color: Color32,
    /// When each place is reached, including the start: in ns, or in passes.
    ends: Vec<f64>,
}

impl<'a> Curve<'a> {
    /// The known passes, and the current place.
    pub(super) fn new(
        passes: &'a [Pass],
        place: usize,
        rays: u64,
        judgement: Option<&'a Judgement>,
        color: Color32,
    ) -> Self {
        Self { passes, place: place.min(passes.len()), rays, judgement, color, ends: Vec::new() }
    }

    fn is_timed(&self) -> bool {
        self.passes.iter().any(|pass| pass.duration_ns.is_some())
    }

    fn resolved(&self, place: usize) -> u64 {
        let decided = |pass: &Pass| pass.kernel.program().states.decided(&pass.counts);
        place.checked_sub(1).and_then(|last| self.passes.get(last)).map_or(0, decided).min(self.rays)
    }

    fn unresolved_share(&self, place: usize) -> f64 {
        (self.rays - self.resolved(place)) as f64 / self.rays.max(1) as f64
    }

    /// The place whose end is nearest.
    fn place_at(&self, x: f64) -> usize {
        let after = self.ends.partition_point(|&end| end < x).min(self.ends.len() - 1);
        match after.checked_sub(1) {
            Some(before) if x - self.ends[before] < self.ends[after] - x => before,
            _ => after,
        }
    }
}

/// When each place is reached, including the start.
fn ends(passes: &[Pass], is_by_time: bool) -> Vec<f64> {
    let mut end = 0.0;
    let later = passes.iter().map(|pass| {
        end += if is_by_time { pass.duration_ns.unwrap_or(0) as f64 } else { 1.0 };
        end
    });
    std::iter::once(0.0).chain(later.collect::<Vec<_>>()).collect()
}

/// The total.
pub(super) struct Plot<'a> {
    curves: Vec<Curve<'a>>,
    shares: Shares,
    unit: Unit,
    /// End of the horizontal axis.
    most: f64,
    /// Of the passes, those whose time is unknown.
    untimed: usize,
}

impl<'a> Plot<'a> {
    pub(super) fn new(mut curves: Vec<Curve<'a>>, is_log: bool) -> Self {
        let is_by_time = curves.iter().all(Curve::is_timed);
        let mut untimed = 0;
        for curve in &mut curves {
            curve.ends = ends(curve.passes, is_by_time);
            untimed += curve.passes.iter().filter(|pass| is_by_time && pass.duration_ns.is_none()).count();
        }
        let most = curves.iter().filter_map(|curve| curve.ends.last()).copied().fold(0.0, f64::max).max(1.0);
        let unit = if is_by_time { Unit::of_time(most) } else { Unit::PASSES };
        let shares = Shares::of(curves.iter().map(|curve| curve.rays).max().unwrap_or(0), is_log);
        Self { curves, shares, unit, most, untimed }
    }

    /// Paints it. Returns the run and place under the pointer when clicked or dragged, and whether it was a click.
    pub(super) fn show(&self, ui: &mut Ui, height: f32) -> Option<(usize, usize, bool)> {
        let size = vec2(ui.available_width().max(120.0), height);
        let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
        let field = Rect::from_min_max(rect.min + vec2(LEFT, HEAD), rect.max - vec2(4.0, FOOT));
        self.axes(ui, rect, field);
        let painter = ui.painter_at(rect);
        for (i, curve) in self.curves.iter().enumerate().rev() {
            self.curve(&painter, field, curve, i == 0, ui.visuals().strong_text_color());
        }
        self.name(&response);
        let at = response.interact_pointer_pos().or(response.hover_pos())?;
        let time = f64::from((at.x - field.left()) / field.width().max(1.0)).clamp(0.0, 1.0) * self.most;
        let places: Vec<usize> = self.curves.iter().map(|curve| curve.place_at(time)).collect();
        let nearest = (0..places.len()).min_by(|&a, &b| {
            let off = |i: usize| (self.point(field, &self.curves[i], places[i]) - at).length();
            off(a).total_cmp(&off(b))
        })?;
        for (curve, &place) in self.curves.iter().zip(&places) {
            painter.circle_stroke(self.point(field, curve, place), 4.0, Stroke::new(1.5, curve.color));
        }
        let is_click = response.clicked();
        let is_asked = is_click || response.dragged();
        response.on_hover_ui_at_pointer(|ui| self.about(ui, &places, nearest));
        is_asked.then(|| (nearest, places[nearest], is_click))
    }

    fn at(&self, field: Rect, time: f64, share: f64) -> Pos2 {
        let x = field.left() + (time / self.most) as f32 * field.width();
        pos2(x, field.bottom() - self.shares.above(share, field.height()))
    }

    fn point(&self, field: Rect, curve: &Curve<'_>, place: usize) -> Pos2 {
        self.at(field, curve.ends[place], curve.unresolved_share(place))
    }

    fn axes(&self, ui: &Ui, rect: Rect, field: Rect) {
        let painter = ui.painter_at(rect);
        painter.rect_filled(field, 0.0, ui.visuals().extreme_bg_color);
        let (ink, font) = (ui.visuals().text_color(), FontId::proportional(11.0));
        let line = Stroke::new(0.5, ui.visuals().weak_text_color().gamma_multiply(0.5));
        for share in self.shares.marks(field.height()) {
            let y = self.at(field, 0.0, share).y;
            painter.hline(field.x_range(), y, line);
            painter.text(pos2(field.left() - 4.0, y), Align2::RIGHT_CENTER, percent(share), font.clone(), ink);
        }
        for (time, text) in self.unit.marks(self.most, (field.width() / MARK) as usize) {
            let x = self.at(field, time, 0.0).x;
            painter.vline(x, field.y_range(), line);
            // The last label ends with the plot area.
            let half = 0.5 * painter.layout_no_wrap(text.clone(), font.clone(), ink).size().x;
            let x = x.min(rect.right() - half);
            painter.text(pos2(x, field.bottom() + 5.0), Align2::CENTER_TOP, text, font.clone(), ink);
        }
        let title = match self.shares {
            Shares::Linear => "share of rays",
            Shares::Log(_) => "share of rays, logarithmic",
        };
        painter.text(rect.left_top(), Align2::LEFT_TOP, title, font.clone(), ink);
        let title = match (self.unit == Unit::PASSES, self.untimed) {
            (true, _) => "passes so far (no valid times)".to_owned(),
            (false, 0) => format!("device time so far, {}", self.unit.name),
            (false, untimed) => {
                format!("device time so far, {}, excluding {}", self.unit.name, counted(untimed, "untimed pass"))
            }
        };
        painter.text(pos2(field.center().x, rect.bottom()), Align2::CENTER_BOTTOM, title, font, ink);
    }

    fn curve(&self, painter: &Painter, field: Rect, curve: &Curve<'_>, is_first: bool, strong: Color32) {
        let steps: Vec<_> = (0..curve.ends.len()).map(|i| (curve.ends[i], curve.unresolved_share(i))).collect();
        painter.add(Shape::line(self.stairs(field, &steps), Stroke::new(1.5, curve.color)));
        if let Some(judgement) = curve.judgement.filter(|judgement| !judgement.wrong.is_empty()) {
            let last = curve.ends.len() - 1;
            let share = |wrong: usize| wrong as f64 / judgement.counts.rays().max(1) as f64;
            let known = judgement.steps().into_iter().filter(|&(place, _)| place <= last);
            let mut steps = vec![(0.0, 0.0)];
            steps.extend(known.map(|(place, wrong)| (curve.ends[place], share(wrong))));
            steps.push((curve.ends[last], share(judgement.wrong_by(last))));
            painter.extend(Shape::dashed_line(&self.stairs(field, &steps), Stroke::new(1.5, curve.color), 4.0, 3.0));
        }
        let here = self.point(field, curve, curve.place);
        if is_first {
            painter.vline(here.x, field.y_range(), Stroke::new(1.0, strong.gamma_multiply(0.6)));
        }
        painter.circle(here, 3.5, curve.color, Stroke::new(1.0, strong));
    }

    /// A step function: a pass resolves rays at its end. Steps within half a point are merged.
    fn stairs(&self, field: Rect, steps: &[(f64, f64)]) -> Vec<Pos2> {
        let mut line: Vec<Pos2> = Vec::new();
        for &(time, share) in steps {
            let at = self.at(field, time, share);
            match line.as_slice() {
                [.., before, last] if at.x - before.x < 0.5 && last.x == before.x => {
                    let x = last.x;
                    line.pop();
                    line.push(pos2(x, at.y));
                }
                [.., last] => {
                    let y = last.y;
                    line.extend([pos2(at.x, y), at]);
                }
                [] => line.push(at),
            }
        }
        line
    }

    /// For screen readers.
    fn name(&self, response: &Response) {
        let over = if self.unit == Unit::PASSES { "passes" } else { "device time" };
        let mut text = format!("rays not yet resolved over {over}");
        for (curve, name) in self.curves.iter().zip(["A", "B"]) {
            let (left, place) = (grouped(curve.rays - curve.resolved(curve.place)), curve.place);
            text += &format!("; run {name}: {left} of {} after {}", grouped(curve.rays), counted(place, "pass"));
            if let Some(judgement) = curve.judgement {
                text += &format!(", {} judged rays resolved wrongly", grouped(judgement.wrong_by(place) as u64));
            }
        }
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Slider, true, &text));
    }

    /// The places under the pointer.
    fn about(&self, ui: &mut Ui, places: &[usize], nearest: usize) {
        for (i, (curve, &place)) in self.curves.iter().zip(places).enumerate() {
            let name = if self.curves.len() > 1 { ["A, ", "B, "][i.min(1)] } else { "" };
            let pass = place.checked_sub(1).map(|last| &curve.passes[last]);
            let what = pass.map_or_else(
                || "before the first pass".into(),
                |pass| format!("after pass {}: {}", pass.index, pass.kernel.name()),
            );
            strong(ui, format!("{name}{what}"));
            if self.unit != Unit::PASSES {
                ui.label(format!("{} on the device", self.unit.text(curve.ends[place])));
            }
            let (done, rays) = (curve.resolved(place), curve.rays);
            let share = percent(curve.unresolved_share(place));
            ui.label(format!("{} of {} rays resolved, {share} unresolved", grouped(done), grouped(rays)));
            if let Some(judgement) = curve.judgement {
                let wrong = grouped(judgement.wrong_by(place) as u64);
                ui.label(format!("{wrong} of {} judged rays resolved wrongly", grouped(judgement.counts.rays())));
                if judgement.passes_between > 1 && !judgement.wrong.is_empty() {
                    ui.weak(format!("checked at least every {}", counted(judgement.passes_between, "pass")));
                }
            }
        }
        let goes = if nearest == 0 { "click to go there" } else { "click to move B there" };
        ui.weak(goes);
    }
}
