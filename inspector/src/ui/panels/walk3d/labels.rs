//! Labels in the 3D view: the cell, its tmax, the tested triangles, what was picked.

use std::sync::Arc;

use egui::{Color32, FontId, Galley, Pos2, Rect, Vec2, vec2};
use glam::{DVec2, DVec3};

use super::super::labels::{Avoid, LabelRect, Wanted, places};
use super::super::picked;
use super::super::walked::number;
use crate::draw::scene3d::Marked;
use crate::orbit::Orbit;
use crate::ui::state::Picked;
use crate::ui::units::Scale;
use crate::walk::{AXES, Branch, Crossing, Outcome, Structure, TestedTriangle, WalkGeometry};

/// The subject of a label.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum About {
    /// What was picked.
    Picked,
    /// The ray's current cell or node.
    Place,
    /// A plane that the ray may cross next, of this axis.
    Axis(usize),
    /// A triangle, and the result of its test.
    Triangle(Outcome),
    /// A light.
    Light,
}

#[derive(Clone, Debug, PartialEq)]
struct Label {
    /// The point it refers to, in traced units.
    at: DVec3,
    text: String,
    about: About,
}

/// What has labels.
#[derive(Clone, Copy)]
pub(super) struct Subject<'a> {
    /// The walk of a ray.
    pub(super) walk: &'a WalkGeometry,
    /// The rays of its pixel's light tree.
    pub(super) lights: &'a [Branch],
    /// What was picked.
    pub(super) picked: Option<(Picked, Marked)>,
}

/// What the labels of a walk depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LabelStyle {
    pub(super) scale: Scale,
    /// None says which plane is crossed next: a lesson asks.
    pub(super) hides_next: bool,
}

/// Most earlier tests in the current cell that have labels.
const MOST_TESTS: usize = 8;

/// Most lights that have labels.
const MOST_LIGHTS: usize = 8;

/// The labels of a walk, the most important first: what is tested now or hit, the cell, the tmax of the next step, what
/// was picked, the lights, the other tmax, and earlier tests in this cell.
fn labels(Subject { walk, lights, picked }: Subject<'_>, style: LabelStyle) -> Vec<Label> {
    let mut labels = Vec::new();
    let LabelStyle { scale, hides_next } = style;
    let number = |t| number(scale.t64(t));
    let mut add = |at, text, about| labels.push(Label { at, text, about });
    let tested = walk.tested.last().filter(|tested| Some(tested.row) == walk.row);
    if let Some(tested) = tested {
        add(middle_of(walk, tested), words(tested, true, &scale), About::Triangle(tested.outcome));
    } else if let Some(hit) = &walk.hit {
        let text = format!("triangle {}: hit, t {}", hit.triangle, number(hit.t));
        add(hit.point, text, About::Triangle(Outcome::Nearest));
    }
    match walk.structure {
        Structure::Grid => {
            if let Some(cell) = walk.current_cell() {
                add(cell.bounds.center(), cell.name(), About::Place);
            }
        }
        Structure::Tree => {
            if let (Some(node), Some(bounds)) = (walk.current_node, walk.current_box) {
                add(bounds.center(), format!("node {node}"), About::Place);
            }
        }
        Structure::Nothing => {}
    }
    let next = if walk.is_over { Vec::new() } else { walk.next_crossings() };
    let leaves = walk.current_cell().filter(|_| !hides_next).map(|cell| cell.exit_axis);
    let tmax = |crossing: &Crossing| {
        let name = AXES[crossing.axis];
        (crossing.point, format!("tmax {name} {}", number(crossing.t)), About::Axis(crossing.axis))
    };
    for (at, text, about) in next.iter().filter(|crossing| leaves == Some(crossing.axis)).map(tmax) {
        add(at, text + ": next", about);
    }
    if let Some((picked, marked)) = picked {
        let (name, at) = match (picked, marked) {
            (Picked::Cell([x, y, z]), Marked::Box(bounds)) => (format!("cell {x},{y},{z}"), bounds.center()),
            (Picked::Node(node), Marked::Box(bounds)) => (format!("node {node}"), bounds.center()),
            (Picked::Triangle(triangle), Marked::Triangle([a, b, c])) => {
                (format!("triangle {triangle}"), (a + b + c) / 3.0)
            }
            _ => (String::new(), DVec3::NAN),
        };
        add(at, name, About::Picked);
    }
    for light in lights.iter().filter(|line| line.light.is_some()).take(MOST_LIGHTS) {
        add(light.beyond.unwrap_or(light.to), light.name.clone(), About::Light);
    }
    for (at, text, about) in next.iter().filter(|crossing| leaves != Some(crossing.axis)).map(tmax) {
        add(at, text, about);
    }
    let here = walk.tested.last().filter(|last| !walk.is_over || last.outcome.is_hit()).and_then(|last| last.visit);
    let shown = tested.map(|tested| tested.triangle).or(walk.hit.map(|hit| hit.triangle));
    let current = match walk.structure {
        Structure::Grid => walk.cells.len().checked_sub(1),
        _ => here,
    };
    let earlier = walk.tested.iter().rev().filter(|test| test.visit == current && Some(test.triangle) != shown);
    for test in earlier.filter(|_| walk.structure != Structure::Nothing).take(MOST_TESTS) {
        add(middle_of(walk, test), words(test, false, &scale), About::Triangle(test.outcome));
    }
    labels
}

/// Where the label of a test points: to the hit, or to the middle of the triangle that was missed.
fn middle_of(walk: &WalkGeometry, test: &TestedTriangle) -> DVec3 {
    let [a, b, c] = test.corners;
    test.t.filter(|_| test.outcome.is_hit()).map_or((a + b + c) / 3.0, |t| walk.point(t))
}

/// A test in words: with its reason, or as short as possible.
fn words(test: &TestedTriangle, is_long: bool, scale: &Scale) -> String {
    let t = test.t.filter(|_| test.outcome.is_hit());
    let t = t.map_or_else(String::new, |t| format!(", t {}", number(scale.t64(t))));
    match (is_long, test.outcome) {
        (true, Outcome::Nearest) => format!("triangle {}: hit{t}", test.triangle),
        (true, Outcome::NotNearest) => format!("triangle {}: hit{t}, {}", test.triangle, test.why),
        (true, Outcome::Missed) => format!("triangle {}: missed, {}", test.triangle, test.why),
        (false, outcome) => format!("{}: {}", test.triangle, if outcome.is_hit() { "hit" } else { "missed" }),
    }
}

/// A label that is ready to be painted.
#[derive(Clone)]
pub(super) struct Ready {
    at: Pos2,
    place: LabelRect,
    galley: Arc<Galley>,
    color: Color32,
}

/// Height of the line below the labels, which names the units.
const FOOT: f32 = 18.0;
const MARGIN: Vec2 = vec2(4.0, 1.0);

/// Arranges the labels of a walk within its picture. The camera is in traced units.
pub(super) fn arrange(
    painter: &egui::Painter,
    visuals: &egui::Visuals,
    rect: Rect,
    subject: Subject<'_>,
    camera: &Orbit,
    style: LabelStyle,
) -> Vec<Ready> {
    let size = DVec2::new(rect.width().into(), rect.height().into());
    let seen_at = |point: DVec3| {
        let (pixel, _) = camera.pixel(point, size)?;
        Some(rect.min + vec2(pixel.x as f32, pixel.y as f32))
    };
    let walk = subject.walk;
    let font = FontId::proportional(11.5);
    let seen: Vec<(Pos2, Arc<Galley>, Color32)> = labels(subject, style)
        .into_iter()
        .filter_map(|label| {
            // A tmax along an axis on which the ray hardly moves lies far outside.
            let at = seen_at(label.at).filter(|at| rect.contains(*at))?;
            let color = color(visuals, label.about);
            Some((at, painter.layout_no_wrap(label.text, font.clone(), color), color))
        })
        .collect();
    let wanted: Vec<Wanted> =
        seen.iter().map(|(at, galley, _)| Wanted { at: *at, size: galley.size() + 2.0 * MARGIN }).collect();
    let ray = seen_at(walk.current_point()).zip(seen_at(walk.point(walk.last_t())));
    let way =
        seen_at(walk.inside.map_or(walk.origin, |[enter, _]| walk.point(enter))).zip(seen_at(walk.current_point()));
    let lines = [ray, way].into_iter().flatten().map(|(a, b)| [a, b]).collect();
    let current = walk.current_cell().map(|cell| cell.bounds).or(walk.current_box);
    let area = current.and_then(|bounds| {
        let corners: Option<Vec<Pos2>> = bounds.corners().into_iter().map(seen_at).collect();
        corners.map(|corners| Rect::from_points(&corners))
    });
    let avoid = Avoid { areas: area.into_iter().collect(), lines };
    let mut room = rect.shrink(1.0);
    room.max.y -= FOOT;
    let places = places(room, &wanted, &avoid);
    let ready = |((at, galley, color), place): (_, Option<LabelRect>)| Some(Ready { at, place: place?, galley, color });
    seen.into_iter().zip(places).filter_map(ready).collect()
}

/// Paints them.
pub(super) fn draw(painter: &egui::Painter, visuals: &egui::Visuals, ready: &[Ready]) {
    // All lines first, so that none crosses a text.
    for label in ready {
        let stroke = egui::Stroke::new(1.0, label.color.gamma_multiply(0.75));
        if let Some(line) = label.place.leader {
            painter.line_segment(line, stroke);
        }
        painter.circle_stroke(label.at, 2.0, stroke);
    }
    let background = visuals.extreme_bg_color;
    for label in ready {
        painter.rect_filled(label.place.rect, 3.0, background);
        painter.galley(label.place.rect.min + MARGIN, label.galley.clone(), label.color);
    }
}

/// The colours of the picture, see [`crate::draw::scene3d`].
fn color(visuals: &egui::Visuals, about: About) -> Color32 {
    let pick = |dark: [u8; 3], light: [u8; 3]| {
        let [r, g, b] = if visuals.dark_mode { dark } else { light };
        Color32::from_rgb(r, g, b)
    };
    match about {
        About::Picked => picked::color(visuals),
        About::Place => pick([255, 214, 90], [140, 95, 0]),
        About::Axis(0) => pick([255, 130, 130], [190, 40, 40]),
        About::Axis(1) => pick([130, 220, 110], [40, 125, 30]),
        About::Axis(_) => pick([130, 175, 255], [40, 90, 205]),
        About::Light => pick([250, 230, 150], [100, 78, 0]),
        About::Triangle(Outcome::Missed) => pick([255, 160, 80], [175, 80, 0]),
        About::Triangle(_) => pick([90, 230, 140], [10, 120, 50]),
    }
}

#[cfg(test)]
mod tests;
