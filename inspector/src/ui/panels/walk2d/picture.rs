//! The walk seen along one axis, as in the paper's Figure 3.

use egui::epaint::{CircleShape, RectShape};
use egui::{Align2, Color32, FontId, Pos2, Rect, Shape, Stroke, StrokeKind, vec2};
use glam::{DVec2, Vec2Swizzles as _};
use raystep_lab::text::counted;

use super::super::picked;
use super::progress::{chosen, row_of};
use super::{Scene, Under};
use crate::draw::stream::Colors;
use crate::ui::state::Picked;
use crate::walk::{AXES, Outcome, Projected, Square, Structure};

/// Most squares and triangles painted, the first ones: a ray that tests all triangles of a large scene would become a
/// grey area.
const MOST: usize = 2000;
/// Squares smaller than this have no letters.
const ROOM_FOR_LETTER: f32 = 13.0;

/// Height of the line above the picture, and the margin around it.
const NOTE: f32 = 15.0;
const MARGIN: f32 = 3.0;

/// Transform from traced units to points in the panel.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Map {
    min: DVec2,
    scale: f64,
    /// The position of `min`.
    corner: Pos2,
    /// The first axis points up and the second to the right.
    is_turned: bool,
}

impl Map {
    /// Fits the whole picture into a rectangle, rotated if that makes it much larger; `None` if either is empty.
    fn fit(picture: &Projected, rect: Rect) -> Option<Self> {
        let extent = picture.max - picture.min;
        if !extent.is_finite() || extent.cmple(DVec2::ZERO).any() || !rect.is_positive() {
            return None;
        }
        let scale = |e: DVec2| (f64::from(rect.width()) / e.x).min(f64::from(rect.height()) / e.y);
        let is_turned = scale(extent.yx()) > 1.25 * scale(extent);
        let extent = if is_turned { extent.yx() } else { extent };
        let scale = scale(extent);
        let half = extent * scale * 0.5;
        let corner = rect.center() + vec2(-half.x as f32, half.y as f32);
        Some(Self { min: picture.min, scale, corner, is_turned })
    }

    fn place(&self, p: DVec2) -> Pos2 {
        let p = (p - self.min) * self.scale;
        let p = if self.is_turned { p.yx() } else { p };
        self.corner + vec2(p.x as f32, -p.y as f32)
    }

    fn back(&self, p: Pos2) -> DVec2 {
        let p = p - self.corner;
        let p = DVec2::new(p.x.into(), (-p.y).into()) / self.scale;
        (if self.is_turned { p.yx() } else { p }) + self.min
    }

    fn rect(&self, min: DVec2, max: DVec2) -> Rect {
        Rect::from_two_pos(self.place(min), self.place(max))
    }
}

/// The smallest square that contains a point: boxes of a BVH are nested.
fn square_at(squares: &[Square], p: DVec2) -> Option<&Square> {
    let area = |s: &Square| (s.max - s.min).element_product();
    let inside = squares.iter().filter(|s| p.cmpge(s.min).all() && p.cmple(s.max).all());
    inside.min_by(|a, b| area(a).total_cmp(&area(b)))
}

/// The height of a rectangle that the picture fills, if it has this width and at most that height; `None` if the picture
/// is empty.
pub(super) fn height(picture: &Projected, width: f32, most: f32) -> Option<f32> {
    let edges = vec2(2.0 * MARGIN, NOTE + 2.0 * MARGIN);
    let map = Map::fit(picture, Rect::from_min_size(Pos2::ZERO, vec2(width, most) - edges))?;
    Some(map.rect(picture.min, picture.max).height() + edges.y)
}

/// Draws it; describes the item under the cursor.
pub(super) fn draw(painter: &egui::Painter, rect: Rect, picture: &Projected, scene: &Scene<'_>) -> Option<Under> {
    let visuals = scene.visuals;
    let (note_rect, rest) = rect.split_top_bottom_at_y(rect.top() + NOTE);
    let map = Map::fit(picture, rest.shrink(MARGIN))?;
    let [a, b] = picture.axes.map(|axis| AXES[axis]);
    let [right, up] = if map.is_turned { [b, a] } else { [a, b] };
    let dropped = AXES[3 - picture.axes[0] - picture.axes[1]];
    let frame = map.rect(picture.min, picture.max);
    let note = format!("view along {dropped}; {right} to the right, {up} up");
    painter.text(note_rect.left_top(), Align2::LEFT_TOP, note, FontId::proportional(11.0), visuals.weak_text_color());
    let painter = painter.with_clip_rect(frame.expand(4.0).intersect(painter.clip_rect()));
    lines(&painter, &map, picture, visuals);
    squares(&painter, &map, picture, scene);
    triangles(&painter, &map, picture, scene);
    titles(&painter, &map, picture, scene);
    ray(&painter, &map, picture, scene);
    painter.rect_stroke(frame, 0.0, Stroke::new(1.0, visuals.weak_text_color()), StrokeKind::Inside);

    let at = scene.cursor.filter(|at| frame.contains(*at) && !scene.hides_next)?;
    let square = square_at(&picture.squares, map.back(at))?;
    let visit = chosen(&square.visits, scene.progress.visit)?;
    let outline = map.rect(square.min, square.max);
    painter.rect_stroke(outline, 0.0, Stroke::new(1.0, visuals.strong_text_color()), StrokeKind::Inside);
    let what = what_of(scene, visit);
    Some(Under { text: words(scene, square, visit), row: row_of(scene.walk, visit)?, what })
}

/// What a visit is of.
fn what_of(scene: &Scene<'_>, visit: usize) -> Option<Picked> {
    let node = scene.walk.nodes.get(visit).map(|node| Picked::Node(node.node));
    scene.walk.cells.get(visit).and_then(|cell| picked::cell(cell.cell)).or(node)
}

/// Describes a visit.
fn words(scene: &Scene<'_>, square: &Square, visit: usize) -> String {
    let walk = scene.walk;
    let mut text = match (walk.cells.get(visit), walk.nodes.get(visit)) {
        (Some(cell), _) => {
            let t = [cell.t_in, cell.t_out].map(|t| scene.t(t));
            format!("{}: t {} to {}, {} in its list", cell.name(), t[0], t[1], counted(cell.listed, "triangle"))
        }
        (None, Some(node)) => {
            let t = node.inside.map_or_else(String::new, |t| format!(": t {} to {}", scene.t(t[0]), scene.t(t[1])));
            format!("node {}, level {}{t}", node.node, node.depth)
        }
        _ => String::new(),
    };
    if square.visits.len() > 1 {
        text += &format!("\n{} visits overlap here", square.visits.len());
    }
    text
}

/// Titles of squares and triangles, smaller ones over larger ones.
fn titles(painter: &egui::Painter, map: &Map, picture: &Projected, scene: &Scene<'_>) {
    if scene.titles.is_none() {
        return;
    }
    let squares = picture.squares.iter().take(MOST).filter_map(|square| {
        let outline = map.rect(square.min, square.max);
        let text = words(scene, square, *square.visits.first()?);
        Some((outline.area(), Shape::from(RectShape::filled(outline, 0.0, Color32::BLACK)), text))
    });
    let triangles = picture.triangles.iter().take(MOST).filter_map(|triangle| {
        let [a, b, c] = triangle.corners.map(|corner| map.place(corner));
        let area = 0.5 * (b - a).dot((c - a).rot90()).abs();
        // Also one that is seen edge-on has a title.
        let shape = Shape::convex_polygon(vec![a, b, c], Color32::BLACK, Stroke::new(2.0, Color32::BLACK));
        let text = format!("triangle {}: {}", scene.walk.tested.get(triangle.test)?.triangle, triangle.outcome.name());
        Some((area, shape, text))
    });
    let mut all: Vec<(f32, Shape, String)> = squares.chain(triangles).collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (_, shape, text) in all {
        scene.title(painter, shape, || text);
    }
}

fn lines(painter: &egui::Painter, map: &Map, picture: &Projected, visuals: &egui::Visuals) {
    let stroke = Stroke::new(1.0, visuals.weak_text_color().gamma_multiply(0.3));
    let (min, max) = (picture.min, picture.max);
    let across = picture.lines[0].iter().map(|&x| [DVec2::new(x, min.y), DVec2::new(x, max.y)]);
    let along = picture.lines[1].iter().map(|&y| [DVec2::new(min.x, y), DVec2::new(max.x, y)]);
    for ends in across.chain(along) {
        painter.line_segment(ends.map(|p| map.place(p)), stroke);
    }
}

fn squares(painter: &egui::Painter, map: &Map, picture: &Projected, scene: &Scene<'_>) {
    let walk = scene.walk;
    let is_tree = walk.structure == Structure::Tree;
    let count = walk.cells.len().max(walk.nodes.len());
    let (mut current, mut marked) = (None, None);
    for square in picture.squares.iter().take(MOST) {
        let Some(&first) = square.visits.first() else { continue };
        let has_come = row_of(walk, first).is_some_and(|row| scene.progress.has(row));
        if scene.hides_next && !has_come {
            continue;
        }
        let outline = map.rect(square.min, square.max);
        let color = in_order(first, count);
        let (fill, line) = match (has_come, is_tree) {
            (true, true) => (0.06, 0.9),
            (true, false) => (0.45, 0.9),
            (false, true) => (0.0, 0.18),
            (false, false) => (0.08, 0.25),
        };
        painter.rect_filled(outline, 0.0, color.gamma_multiply(fill));
        painter.rect_stroke(outline, 0.0, Stroke::new(1.0, color.gamma_multiply(line)), StrokeKind::Inside);
        if scene.progress.visit.is_some_and(|visit| square.visits.contains(&visit)) {
            current = Some(outline);
        }
        let is_picked = |&visit: &usize| scene.picked.is_some() && what_of(scene, visit) == scene.picked;
        if square.visits.iter().any(is_picked) {
            marked = Some(outline);
        }
        if !is_tree && outline.size().min_elem() >= ROOM_FOR_LETTER {
            // Two more characters of the font's 11 points.
            let has_room = outline.width() >= 2.0 * ROOM_FOR_LETTER;
            let more = if square.visits.len() > 1 && has_room { "…" } else { "" };
            let color = if has_come { scene.visuals.strong_text_color() } else { scene.visuals.weak_text_color() };
            let text = format!("{}{more}", square.letters);
            let at = outline.left_top() + vec2(3.0, 1.0);
            outlined(painter, at, Align2::LEFT_TOP, &text, color, scene.visuals);
        }
    }
    // In a BVH, the current node may still have to be visited.
    let current_box = scene.now.and_then(|now| now.current_box);
    let flat = |v: glam::DVec3| DVec2::new(v[picture.axes[0]], v[picture.axes[1]]);
    let current = current_box.map(|b| map.rect(flat(b.min), flat(b.max))).or(current.filter(|_| !is_tree));
    if let Some(outline) = current {
        painter.rect_stroke(outline, 0.0, Stroke::new(2.0, current_color(scene.visuals)), StrokeKind::Inside);
    }
    if let Some(outline) = marked {
        painter.rect_stroke(outline, 0.0, Stroke::new(2.0, picked::color(scene.visuals)), StrokeKind::Outside);
    }
}

/// A letter in a coloured square, with an outline in the background's colour.
pub(super) fn outlined(
    painter: &egui::Painter,
    at: Pos2,
    align: Align2,
    text: &str,
    color: Color32,
    visuals: &egui::Visuals,
) {
    let font = FontId::proportional(11.0);
    let outline = visuals.panel_fill.gamma_multiply(0.75);
    for by in [vec2(-1.0, 0.0), vec2(1.0, 0.0), vec2(0.0, -1.0), vec2(0.0, 1.0)] {
        painter.text(at + by, align, text, font.clone(), outline);
    }
    painter.text(at, align, text, font, color);
}

fn triangles(painter: &egui::Painter, map: &Map, picture: &Projected, scene: &Scene<'_>) {
    for (triangle, outcome) in picture.triangles.iter().zip(&scene.progress.outcomes).take(MOST) {
        let (color, fill, line) = match outcome {
            None => (scene.visuals.weak_text_color(), 0.0, 0.3),
            Some(Outcome::Missed) => (outcome_color(scene.visuals, Outcome::Missed), 0.08, 0.75),
            Some(outcome @ Outcome::NotNearest) => (outcome_color(scene.visuals, *outcome), 0.08, 0.8),
            Some(outcome @ Outcome::Nearest) => (outcome_color(scene.visuals, *outcome), 0.25, 1.0),
        };
        let corners = triangle.corners.map(|c| map.place(c)).to_vec();
        painter.add(Shape::convex_polygon(
            corners,
            color.gamma_multiply(fill),
            Stroke::new(1.0, color.gamma_multiply(line)),
        ));
    }
    if let Some(Picked::Triangle(wanted)) = scene.picked {
        let is_wanted = |shown: &&crate::walk::ProjectedTriangle| {
            scene.walk.tested.get(shown.test).is_some_and(|tested| tested.triangle == wanted)
        };
        if let Some(shown) = picture.triangles.iter().find(is_wanted) {
            let corners = shown.corners.map(|c| map.place(c)).to_vec();
            painter.add(Shape::closed_line(corners, Stroke::new(2.0, picked::color(scene.visuals))));
        }
    }
}

fn ray(painter: &egui::Painter, map: &Map, picture: &Projected, scene: &Scene<'_>) {
    let color = ray_color(scene.visuals);
    let title = |at: Pos2, radius: f32, text: String| {
        scene.title(painter, CircleShape::filled(at, radius, Color32::BLACK), || text);
    };
    let [from, to] = picture.ray.map(|p| map.place(p));
    let flat = |now: &crate::walk::WalkGeometry| {
        let p = now.current_point();
        map.place(DVec2::new(p[picture.axes[0]], p[picture.axes[1]]))
    };
    let at = scene.now.filter(|now| now.t > 0.0).map(flat);
    // Before the ray enters the picture there is no "so far".
    let at = at.filter(|at| (*at - from).dot(to - from) > 0.0);
    painter.extend(Shape::dashed_line(
        &[at.unwrap_or(from), to],
        Stroke::new(1.2, color.gamma_multiply(0.7)),
        4.0,
        4.0,
    ));
    if let Some(at) = at {
        painter.line_segment([from, at], Stroke::new(2.0, color));
    }
    let crossed = scene.now.map_or(0, |now| now.crossings.len());
    for crossing in scene.walk.crossings.iter().take(crossed.min(MOST)).filter(|c| picture.axes.contains(&c.axis)) {
        let p = DVec2::new(crossing.point[picture.axes[0]], crossing.point[picture.axes[1]]);
        painter.circle(map.place(p), 2.5, scene.visuals.panel_fill, Stroke::new(1.3, color));
        title(map.place(p), 2.5, format!("crosses a plane of {}", AXES[crossing.axis]));
    }
    if let Some(at) = at {
        painter.circle_filled(at, 3.6, color);
        title(at, 3.6, "current position".into());
    }
    if let Some(hit) = scene.now.and_then(|now| now.hit) {
        let p = DVec2::new(hit.point[picture.axes[0]], hit.point[picture.axes[1]]);
        painter.circle_filled(map.place(p), 4.2, outcome_color(scene.visuals, Outcome::Nearest));
        title(map.place(p), 4.2, "nearest hit".into());
    }
}

/// A viridis colour, from the first to the last of a walk.
pub(super) fn in_order(i: usize, count: usize) -> Color32 {
    let at = if count > 1 { i as f64 / (count - 1) as f64 } else { 0.5 };
    let [r, g, b] = Colors::Viridis.at(0.15 + 0.85 * at);
    Color32::from_rgb(r, g, b)
}

/// Misses are orange, hits green, whether nearest or not.
pub(super) fn outcome_color(visuals: &egui::Visuals, outcome: Outcome) -> Color32 {
    match (outcome, visuals.dark_mode) {
        (Outcome::Missed, true) => Color32::from_rgb(0xf2, 0x99, 0x4a),
        (Outcome::Missed, false) => Color32::from_rgb(0xa0, 0x4a, 0x00),
        (_, true) => Color32::from_rgb(0x4f, 0xd0, 0x7f),
        (_, false) => Color32::from_rgb(0x12, 0x81, 0x3c),
    }
}

pub(super) fn ray_color(visuals: &egui::Visuals) -> Color32 {
    if visuals.dark_mode { Color32::from_rgb(0xff, 0x6b, 0x5e) } else { Color32::from_rgb(0xd1, 0x22, 0x2f) }
}

pub(super) fn current_color(visuals: &egui::Visuals) -> Color32 {
    if visuals.dark_mode { Color32::WHITE } else { Color32::from_gray(20) }
}

#[cfg(test)]
mod tests {
    use egui::pos2;
    use raystep_kernels::Accelerator;

    use super::super::super::walked::tests::history;
    use super::*;
    use crate::walk::WalkGeometry;

    #[test]
    fn a_click_finds_the_square_under_it() {
        let (history, data) = history(Accelerator::Grid);
        let picture = Projected::new(&WalkGeometry::new(&history, &data, usize::MAX));
        let wide = Rect::from_min_size(pos2(10.0, 20.0), vec2(300.0, 120.0));
        let high = Rect::from_min_size(pos2(10.0, 20.0), vec2(120.0, 300.0));
        for rect in [wide, high] {
            let map = Map::fit(&picture, rect).expect("a picture");
            // This ray goes along z.
            assert_eq!(map.is_turned, rect == wide);
            for square in &picture.squares {
                let outline = map.rect(square.min, square.max);
                assert!(rect.expand(0.5).contains_rect(outline), "{outline}");
                let found = square_at(&picture.squares, map.back(outline.center())).expect("a square");
                assert_eq!(found.visits, square.visits);
            }
        }
        let rect = wide;
        assert!(square_at(&picture.squares, picture.max * 2.0 - picture.min).is_none());
        assert_eq!(Map::fit(&picture, Rect::from_min_size(rect.min, vec2(0.0, 10.0))), None);
    }

    #[test]
    fn of_boxes_in_each_other_the_smallest_is_found() {
        let (history, data) = history(Accelerator::Bvh);
        let picture = Projected::new(&WalkGeometry::new(&history, &data, usize::MAX));
        let area = |s: &Square| (s.max - s.min).element_product();
        let leaf = picture.squares.iter().min_by(|a, b| area(a).total_cmp(&area(b))).expect("a node");
        let found = square_at(&picture.squares, (leaf.min + leaf.max) * 0.5).expect("a node");
        assert_eq!(area(found), area(leaf));
    }
}
