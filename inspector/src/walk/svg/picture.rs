//! The walk seen along one axis, as in the paper's Figure 3.

use glam::DVec2;

use super::super::{Outcome, Projected, Structure, WalkGeometry};
use super::sheet::{Sheet, viridis};

/// Maximum height, as a fraction of the sheet's width.
const HIGHEST: f64 = 0.62;
/// Squares smaller than this have no letters.
const ROOM_FOR_LETTER: f64 = 13.0;

pub(super) fn draw(sheet: &mut Sheet, walk: &WalkGeometry, picture: &Projected) {
    let names = ["x", "y", "z"];
    let [right, up] = picture.axes.map(|axis| names[axis]);
    let dropped = names[3 - picture.axes[0] - picture.axes[1]];
    let extent = picture.max - picture.min;
    let width = sheet.width - 2.0 * sheet.left;
    if extent.cmple(DVec2::ZERO).any() || !extent.is_finite() {
        return;
    }
    let scale = (width / extent.x).min(width * HIGHEST / extent.y);
    let size = extent * scale;
    let corner = DVec2::new(sheet.left + (width - size.x) * 0.5, sheet.y + 18.0);
    let place = |p: DVec2| DVec2::new(p.x - picture.min.x, picture.max.y - p.y) * scale + corner;
    sheet.text(sheet.left, sheet.y + 8.0, "note", &format!("View along {dropped}; {right} to the right, {up} up"));
    sheet.clip(corner, size);
    let [low, high] = [place(picture.min), place(picture.max)];
    for &x in &picture.lines[0] {
        let x = place(DVec2::new(x, 0.0)).x;
        sheet.line(DVec2::new(x, low.y), DVec2::new(x, high.y), "grid");
    }
    for &y in &picture.lines[1] {
        let y = place(DVec2::new(0.0, y)).y;
        sheet.line(DVec2::new(low.x, y), DVec2::new(high.x, y), "grid");
    }
    let count = walk.cells.len().max(walk.nodes.len());
    let is_tree = walk.structure == Structure::Tree;
    for square in &picture.squares {
        let (min, max) = (place(square.min), place(square.max));
        let at = DVec2::new(min.x, max.y);
        let color = viridis(square.visits.first().copied().unwrap_or(0), count);
        let (class, opacity) = if is_tree { ("node", ".05") } else { ("cell", ".42") };
        let colors = [("fill", color.as_str()), ("stroke", color.as_str()), ("fill-opacity", opacity)];
        sheet.rect(at, (max - min).abs(), class, &colors);
    }
    for triangle in &picture.triangles {
        let class = match triangle.outcome {
            Outcome::Nearest => "hit",
            Outcome::NotNearest => "farther",
            Outcome::Missed => "missed",
        };
        let id = walk.tested.get(triangle.test).map_or(0, |test| test.triangle);
        let corners = triangle.corners.map(place);
        sheet.polygon(&corners, class, &format!("triangle {id}: {}", triangle.outcome.name()));
    }
    let [from, to, at] = [picture.ray[0], picture.ray[1], picture.at].map(place);
    // On both sides of the current position; before the ray enters the picture there is no "so far".
    let so_far = (at - from).dot(to - from) > 0.0;
    if so_far {
        sheet.line(from, at, "ray");
    }
    sheet.line(if so_far { at } else { from }, to, "rest");
    for (point, axis) in &picture.crossings {
        sheet.circle(place(*point), 2.6, "cross", &format!("crosses a plane of {}", names[*axis]));
    }
    if so_far {
        sheet.circle(at, 3.6, "at", "current position");
    }
    for square in picture.squares.iter().filter(|square| square.is_current) {
        let (min, max) = (place(square.min), place(square.max));
        sheet.rect(DVec2::new(min.x, max.y), (max - min).abs(), "current", &[]);
    }
    for square in picture.squares.iter().filter(|_| walk.structure == Structure::Grid) {
        let (min, max) = (place(square.min), place(square.max));
        if (max - min).abs().min_element() >= ROOM_FOR_LETTER {
            let more = if square.visits.len() > 1 { "…" } else { "" };
            let x = min.x + if more.is_empty() { 8.0 } else { 14.0 };
            sheet.text(x, max.y + 13.0, "letter", &format!("{}{more}", square.letters));
        }
    }
    if let Some(hit) = picture.hit {
        sheet.circle(place(hit), 4.2, "dot-hit", "nearest hit");
    }
    sheet.unclip();
    sheet.rect(corner, size, "frame", &[]);
    sheet.y = corner.y + size.y + 26.0;
}
