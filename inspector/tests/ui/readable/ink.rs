//! The texts that a frame draws: their glyphs, colours, sizes, and where they are clipped.

use std::collections::HashSet;

use egui::epaint::TextShape;
use egui::{Color32, Pos2, Rect, Role, Shape, vec2};
use egui_kittest::kittest::NodeT as _;
use image::RgbaImage;

use crate::ui::stage::Stage;

/// Glyphs of one colour in a row of a text.
pub(super) struct Run {
    pub(super) rect: Rect,
    pub(super) color: Color32,
}

/// A text as it is drawn.
pub(super) struct Ink {
    pub(super) text: String,
    pub(super) runs: Vec<Run>,
    /// Its rows, as far as they have glyphs.
    pub(super) rows: Vec<Rect>,
    pub(super) clip: Rect,
    /// The smallest font, in points.
    pub(super) size: f32,
    /// Cut off with "…".
    pub(super) is_elided: bool,
    /// The colour of copies beneath it that are moved by a point: an outline.
    pub(super) outline: Option<Color32>,
    /// Its index among all texts of the frame, as they are drawn.
    pub(super) order: usize,
}

/// Something that hides the texts beneath it.
pub(super) struct Cover {
    pub(super) rect: Rect,
    /// The number of texts that are drawn before it.
    pub(super) order: usize,
}

/// Through a more opaque rectangle, texts are not seen.
const OPAQUE: u8 = 204;

/// How far the copies of an outline are moved, at most, in points.
const OUTLINE: f32 = 1.6;

/// All texts of the last frame, without the copies that outline others.
pub(super) fn inks(stage: &Stage) -> Vec<Ink> {
    inks_and_covers(stage).0
}

/// The same, and what hides some of them.
pub(super) fn inks_and_covers(stage: &Stage) -> (Vec<Ink>, Vec<Cover>) {
    let window = stage.harness.ctx.content_rect();
    let (mut shapes, mut covers) = (Vec::new(), Vec::new());
    for clipped in &stage.harness.output().shapes {
        flatten(&clipped.shape, clipped.clip_rect, window, &mut shapes, &mut covers);
    }
    let is_near = |a: &TextShape, b: &TextShape| a.galley.text() == b.galley.text() && a.pos.distance(b.pos) <= OUTLINE;
    let mut inks = Vec::new();
    for (i, (shape, clip)) in shapes.iter().enumerate() {
        // Outlines are drawn right before their text.
        let after = shapes[i + 1..].iter().take(4);
        if after.filter(|(other, _)| other.pos != shape.pos).any(|(other, _)| is_near(shape, other)) {
            continue;
        }
        let before = shapes[i.saturating_sub(4)..i].iter().filter(|(other, _)| is_near(shape, other));
        let outline = before.map(|(other, _)| color_of(other, Color32::PLACEHOLDER)).next_back();
        inks.push(Ink { order: i, ..ink(shape, *clip, outline) });
    }
    (inks, covers)
}

fn flatten<'a>(
    shape: &'a Shape,
    clip: Rect,
    window: Rect,
    found: &mut Vec<(&'a TextShape, Rect)>,
    covers: &mut Vec<Cover>,
) {
    match shape {
        Shape::Vec(shapes) => shapes.iter().for_each(|shape| flatten(shape, clip, window, found, covers)),
        // The backdrop of a modal dialog: what is beneath it is disabled.
        Shape::Rect(rect) if rect.rect.contains_rect(window) && (1..255).contains(&rect.fill.a()) => {
            found.clear();
            covers.clear();
        }
        Shape::Rect(rect) if rect.blur_width == 0.0 && (rect.fill.a() >= OPAQUE || rect.brush.is_some()) => {
            covers.push(Cover { rect: rect.rect.intersect(clip), order: found.len() });
        }
        Shape::Text(text) if !text.galley.text().trim().is_empty() => found.push((text, clip)),
        _ => {}
    }
}

/// The colour of glyphs whose mesh has this one.
fn color_of(shape: &TextShape, mesh: Color32) -> Color32 {
    let color = if mesh == Color32::PLACEHOLDER { shape.fallback_color } else { mesh };
    shape.override_text_color.unwrap_or(color).gamma_multiply(shape.opacity_factor)
}

fn ink(shape: &TextShape, clip: Rect, outline: Option<Color32>) -> Ink {
    let turn = egui::emath::Rot2::from_angle(shape.angle);
    let placed = |rect: Rect| {
        let corners = [rect.left_top(), rect.right_top(), rect.left_bottom(), rect.right_bottom()];
        Rect::from_points(&corners.map(|corner| shape.pos + turn * corner.to_vec2()))
    };
    let mut runs: Vec<Run> = Vec::new();
    let mut rows = Vec::new();
    for row in &shape.galley.rows {
        let mut last: Option<Run> = None;
        let mut whole = Rect::NOTHING;
        for glyph in row.glyphs.iter().filter(|glyph| !glyph.chr.is_whitespace() && !glyph.is_color) {
            let Some(vertex) = row.visuals.mesh.vertices.get(glyph.first_vertex as usize) else { continue };
            let color = color_of(shape, vertex.color);
            // From the ascenders of small letters to the baseline.
            let min = row.pos + glyph.pos.to_vec2() - vec2(0.0, 0.7 * glyph.font_ascent);
            let rect = placed(Rect::from_min_size(min, vec2(glyph.advance_width, 0.7 * glyph.font_ascent)));
            whole = whole.union(rect);
            match &mut last {
                Some(run) if run.color == color => run.rect = run.rect.union(rect),
                _ => runs.extend(last.replace(Run { rect, color })),
            }
        }
        runs.extend(last);
        if whole.is_positive() {
            rows.push(whole);
        }
    }
    let job = &shape.galley.job;
    let written = job.sections.iter().filter(|section| {
        let range = section.byte_range.start.0..section.byte_range.end.0;
        job.text.get(range).is_some_and(|text| !text.trim().is_empty())
    });
    let size = written.map(|section| section.format.font_id.size).fold(f32::INFINITY, f32::min);
    let is_elided = shape.galley.elided;
    Ink { text: shape.galley.text().to_owned(), runs, rows, clip, size, is_elided, outline, order: 0 }
}

/// Relative luminance (WCAG 2.1).
fn luminance(color: [f64; 3]) -> f64 {
    let [r, g, b] = color.map(|part| {
        let part = part / 255.0;
        if part <= 0.04045 { part / 12.92 } else { ((part + 0.055) / 1.055).powf(2.4) }
    });
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Contrast of two colours (WCAG 2.1).
pub(crate) fn contrast(a: [f64; 3], b: [f64; 3]) -> f64 {
    let (a, b) = (luminance(a), luminance(b));
    (a.max(b) + 0.05) / (a.min(b) + 0.05)
}

/// A colour over another one, as egui blends them.
fn over(color: Color32, under: [f64; 3]) -> [f64; 3] {
    let [r, g, b, a] = color.to_array().map(f64::from);
    let part = 1.0 - a / 255.0;
    [r + under[0] * part, g + under[1] * part, b + under[2] * part]
}

/// The contrast that nine tenths of a run's surroundings reach; the rest may be lines that cross them.
pub(super) fn contrast_of(run: &Run, ink: &Ink, beneath: &RgbaImage, points: f32) -> Option<f64> {
    let seen = run.rect.intersect(ink.clip);
    let size = vec2(beneath.width() as f32, beneath.height() as f32);
    let pixels = Rect::from_min_max((seen.min.to_vec2() * points).to_pos2(), (seen.max.to_vec2() * points).to_pos2());
    let pixels = pixels.intersect(Rect::from_min_size(Pos2::ZERO, size - vec2(1.0, 1.0)));
    if !pixels.is_positive() {
        return None;
    }
    let mut found = Vec::new();
    for y in pixels.top() as u32..=pixels.bottom() as u32 {
        for x in pixels.left() as u32..=pixels.right() as u32 {
            let [r, g, b, _] = beneath.get_pixel(x, y).0.map(f64::from);
            let under = ink.outline.map_or([r, g, b], |outline| over(outline, over(outline, [r, g, b])));
            found.push(contrast(over(run.color, under), under));
        }
    }
    found.sort_by(f64::total_cmp);
    found.get(found.len() / 10).copied()
}

/// Where disabled widgets are: their text need not be readable (WCAG 2.1, 1.4.3).
pub(super) fn disabled(stage: &Stage) -> Vec<Rect> {
    let nodes = stage.nodes();
    let is_so = |node: &&egui_kittest::Node<'_>| {
        let node = node.accesskit_node();
        node.is_disabled() && node.role() != Role::Window && node.bounding_box().is_some()
    };
    nodes.iter().filter(is_so).map(egui_kittest::Node::rect).collect()
}

/// The scroll bars: whether each is a vertical one, and where it is.
pub(super) fn scroll_bars(stage: &Stage) -> Vec<(bool, Rect)> {
    let nodes = stage.nodes();
    let bars = nodes.iter().filter(|node| node.accesskit_node().role() == Role::ScrollBar).map(|node| node.rect());
    bars.map(|rect| (rect.height() > rect.width(), rect)).collect()
}

/// Texts that are cut off by their clip rectangle, and cannot be scrolled to.
pub(super) fn cut(stage: &Stage) -> HashSet<String> {
    // Antialiasing, and the rounding of positions to pixels.
    const TOLERANCE: f32 = 1.0;
    // Scroll bars leave room for each other, and clips for the strokes of widgets.
    const EDGE: f32 = 16.0;
    let bars = scroll_bars(stage);
    let window = stage.harness.ctx.content_rect();
    let mut found = HashSet::new();
    for ink in inks(stage) {
        let clip = ink.clip.intersect(window);
        // Whether a scroll bar with the edge that cuts off can bring the rest into view. A picture in a scroll area may
        // end before it.
        let scrolls = |is_vertical: bool| {
            bars.iter().any(|&(is_so, bar)| {
                let [along, of, across, end] = match is_vertical {
                    true => [bar.y_range(), clip.y_range(), bar.x_range(), clip.x_range()],
                    false => [bar.x_range(), clip.x_range(), bar.y_range(), clip.y_range()],
                };
                let is_at_edge = (along.min - of.min).abs() < EDGE || (along.max - of.max).abs() < EDGE;
                is_so == is_vertical && is_at_edge && across.max >= end.min
            })
        };
        for row in &ink.rows {
            let [x, y] = [clip.x_range(), clip.y_range()];
            let is_cut_x = row.left() < x.min - TOLERANCE || row.right() > x.max + TOLERANCE;
            let is_cut_y = row.top() < y.min - TOLERANCE || row.bottom() > y.max + TOLERANCE;
            let is_lost = is_cut_x && !scrolls(false) || is_cut_y && !scrolls(true);
            // Outside of both ranges nothing is seen, and another row may be.
            if is_lost && (row.intersects(clip) || !is_cut_y) {
                found.insert(format!("{:?} at {:?} in {:?}", ink.text, row, clip));
            }
        }
    }
    found
}
