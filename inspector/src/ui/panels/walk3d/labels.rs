//! Labels in the 3D view: the cell, its tmax, the tested triangle.

use egui::{Color32, FontId, Pos2, Rect, Vec2, vec2};
use glam::{DVec2, DVec3};

use super::super::walked::number;
use crate::orbit::Orbit;
use crate::walk::{Outcome, Structure, WalkGeometry};

/// The subject of a label.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum About {
    /// The ray's current cell or node.
    Place,
    /// A plane that the ray may cross next, of this axis.
    Axis(usize),
    /// A triangle, and the result of its test.
    Triangle(Outcome),
}

#[derive(Clone, Debug, PartialEq)]
struct Label {
    /// The point it refers to, in traced units.
    at: DVec3,
    text: String,
    about: About,
}

/// The labels of a walk, the most important first.
fn labels(walk: &WalkGeometry) -> Vec<Label> {
    let mut labels = Vec::new();
    let mut add = |at, text, about| labels.push(Label { at, text, about });
    let tested = walk.tested.last().filter(|tested| Some(tested.row) == walk.row);
    if let Some(tested) = tested {
        let [a, b, c] = tested.corners;
        let on_ray = tested.t.filter(|_| tested.outcome.is_hit()).map(|t| walk.point(t));
        let at = on_ray.unwrap_or((a + b + c) / 3.0);
        let t = tested.t.filter(|_| tested.outcome.is_hit()).map_or_else(String::new, |t| format!(", t {}", number(t)));
        let text = format!("triangle {}: {}{t}", tested.triangle, tested.outcome.name());
        add(at, text, About::Triangle(tested.outcome));
    } else if let Some(hit) = &walk.hit {
        let text = format!("triangle {}: hit, t {}", hit.triangle, number(hit.t));
        add(hit.point, text, About::Triangle(Outcome::Nearest));
    }
    match walk.structure {
        Structure::Grid => {
            if let Some(cell) = walk.current_cell() {
                let [x, y, z] = cell.cell;
                add(cell.bounds.center(), format!("cell {x},{y},{z}"), About::Place);
            }
        }
        Structure::Tree => {
            if let (Some(node), Some(bounds)) = (walk.current_node, walk.current_box) {
                add(bounds.center(), format!("node {node}"), About::Place);
            }
        }
        Structure::Nothing => {}
    }
    if !walk.is_over {
        for crossing in walk.next_crossings() {
            let name = ["x", "y", "z"][crossing.axis];
            add(crossing.point, format!("tmax {name} {}", number(crossing.t)), About::Axis(crossing.axis));
        }
    }
    labels
}

/// Draws the labels of a walk over its picture. The camera is in traced units.
pub(super) fn draw(painter: &egui::Painter, visuals: &egui::Visuals, rect: Rect, walk: &WalkGeometry, camera: &Orbit) {
    let size = DVec2::new(rect.width().into(), rect.height().into());
    let font = FontId::proportional(11.5);
    let seen: Vec<(Pos2, Label)> = labels(walk)
        .into_iter()
        .filter_map(|label| {
            let (pixel, _) = camera.pixel(label.at, size)?;
            let at = rect.min + vec2(pixel.x as f32, pixel.y as f32);
            // A tmax along an axis on which the ray hardly moves lies far outside.
            rect.contains(at).then_some((at, label))
        })
        .collect();
    let galleys: Vec<_> = seen
        .iter()
        .map(|(_, label)| painter.layout_no_wrap(label.text.clone(), font.clone(), color(visuals, label.about)))
        .collect();
    let margin = vec2(4.0, 2.0);
    let wanted: Vec<(Pos2, Vec2)> =
        seen.iter().zip(&galleys).map(|((at, _), galley)| (*at, galley.size() + 2.0 * margin)).collect();
    let background = visuals.extreme_bg_color.gamma_multiply(0.82);
    let places = arrange(&wanted, rect);
    // All lines first, so that none crosses a text.
    for ((at, label), place) in seen.iter().zip(&places) {
        let stroke = egui::Stroke::new(1.0, color(visuals, label.about).gamma_multiply(0.7));
        painter.line_segment([*at, place.clamp(*at)], stroke);
    }
    for (((_, label), galley), place) in seen.iter().zip(galleys).zip(places) {
        let color = color(visuals, label.about);
        painter.rect_filled(place, 3.0, background);
        painter.galley(place.min + margin, galley, color);
    }
}

/// The colours of the picture, see [`crate::draw::scene3d`].
fn color(visuals: &egui::Visuals, about: About) -> Color32 {
    let pick = |dark: [u8; 3], light: [u8; 3]| {
        let [r, g, b] = if visuals.dark_mode { dark } else { light };
        Color32::from_rgb(r, g, b)
    };
    match about {
        About::Place => pick([255, 214, 90], [140, 95, 0]),
        About::Axis(0) => pick([255, 130, 130], [190, 40, 40]),
        About::Axis(1) => pick([130, 220, 110], [40, 125, 30]),
        About::Axis(_) => pick([130, 175, 255], [40, 90, 205]),
        About::Triangle(Outcome::Missed) => pick([255, 160, 80], [175, 80, 0]),
        About::Triangle(_) => pick([90, 230, 140], [10, 120, 50]),
    }
}

/// Places boxes beside their points without overlap, as long as there is room.
fn arrange(wanted: &[(Pos2, Vec2)], within: Rect) -> Vec<Rect> {
    const AWAY: f32 = 12.0;
    let mut placed: Vec<Rect> = Vec::new();
    for &(at, size) in wanted {
        let inside = |min: Pos2| {
            let most = (within.max - size).max(within.min);
            Rect::from_min_size(min.clamp(within.min, most), size)
        };
        let sides = |rise: f32| {
            let right = at.x + AWAY;
            let left = at.x - AWAY - size.x;
            [(right, at.y - rise - size.y), (right, at.y + rise), (left, at.y - rise - size.y), (left, at.y + rise)]
        };
        let mut places =
            (0..12).flat_map(|i| sides(AWAY * 0.5 + i as f32 * (size.y + 2.0))).map(|(x, y)| inside(Pos2::new(x, y)));
        let is_free = |place: &Rect| placed.iter().all(|other| !other.intersects(*place));
        let first = places.clone().next();
        let place = places.find(is_free).or(first).unwrap_or(Rect::from_min_size(at, size));
        placed.push(place);
    }
    placed
}

#[cfg(test)]
mod tests {
    use raystep_kernels::Accelerator;

    use super::super::super::walked::tests::life;
    use super::*;

    #[test]
    fn labels_do_not_cover_each_other() {
        let within = Rect::from_min_size(Pos2::ZERO, vec2(300.0, 200.0));
        for at in [Pos2::new(150.0, 100.0), Pos2::ZERO, Pos2::new(300.0, 200.0), Pos2::new(0.0, 200.0)] {
            let places = arrange(&[(at, vec2(90.0, 18.0)); 5], within);
            for (i, place) in places.iter().enumerate() {
                assert!(within.contains_rect(*place), "{place}");
                assert!(places[..i].iter().all(|other| !other.intersects(*place)), "{at}: {places:?}");
            }
        }
        // Labels without room are still drawn.
        assert_eq!(
            arrange(&[(Pos2::ZERO, vec2(90.0, 18.0)); 3], Rect::from_min_size(Pos2::ZERO, vec2(9.0, 9.0))).len(),
            3
        );
    }

    #[test]
    fn labels_tell_cell_and_test() {
        let (life, data) = life(Accelerator::Grid);
        let whole = WalkGeometry::new(&life, &data, usize::MAX);
        let test = whole.tested.iter().find(|test| !test.outcome.is_hit()).expect("a miss");
        let texts: Vec<String> =
            labels(&WalkGeometry::new(&life, &data, test.row)).into_iter().map(|label| label.text).collect();
        let [x, y, z] = whole.cells[test.visit.expect("a cell")].cell;
        assert!(texts.contains(&format!("triangle {}: missed", test.triangle)), "{texts:?}");
        assert!(texts.contains(&format!("cell {x},{y},{z}")), "{texts:?}");
        assert!(texts.iter().any(|text| text.starts_with("tmax ")), "{texts:?}");
        // At the end, there is no next cell.
        let end = labels(&whole);
        assert!(end.iter().all(|label| !matches!(label.about, About::Axis(_))), "{end:?}");
        assert_eq!(end[0].about, About::Triangle(Outcome::Nearest));
    }
}
