//! The walk as an SVG drawing: seen along one axis, and below it unfolded along t, if wanted with a second walk.

mod picture;
mod sheet;
mod strip;

use raystep_lab::text::counted;

use super::{Both, Projected, Spacing, Strip, Structure, WalkGeometry};
use sheet::Sheet;
#[cfg(test)]
pub(super) use sheet::short;

/// The style of the drawing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SvgOptions {
    /// Its width, in units in which a line of text is 12 high.
    pub width: f64,
    /// The width of cells.
    pub spacing: Spacing,
    /// Light on dark.
    pub is_dark: bool,
}

impl Default for SvgOptions {
    fn default() -> Self {
        Self { width: 900.0, spacing: Spacing::Equal, is_dark: false }
    }
}

/// The drawing as an SVG file, with a title. A second walk of the same ray, with its name, is drawn below the first, on
/// the same scale of t.
#[must_use]
pub fn walk_svg(
    walk: &WalkGeometry,
    title: &str,
    second: Option<(&str, &WalkGeometry)>,
    options: &SvgOptions,
) -> String {
    let width = if options.width.is_finite() { options.width.clamp(320.0, 8000.0) } else { 900.0 };
    let mut sheet = Sheet::new(width, options.is_dark);
    sheet.text(sheet.left, sheet.y + 18.0, "title", title);
    sheet.text(sheet.left, sheet.y + 36.0, "note", &summary(walk));
    sheet.y += 48.0;
    picture::draw(&mut sheet, walk, &Projected::new(walk));
    let strip = Strip::new(walk);
    let Some((name, second)) = second else {
        strip::draw(&mut sheet, walk, &strip, options.spacing);
        return sheet.finish();
    };
    let other = Strip::new(second);
    let both = Both::of([walk, second], [&strip, &other]);
    strip::draw(&mut sheet, walk, &strip.over(both.t), Spacing::ByT);
    sheet.text(sheet.left, sheet.y + 18.0, "title", &format!("The same ray through the {name}"));
    sheet.text(sheet.left, sheet.y + 36.0, "note", &summary(second));
    sheet.y += 52.0;
    strip::draw(&mut sheet, second, &other.over(both.t), Spacing::ByT);
    for (only, which) in both.only.iter().zip(["first", "second"]) {
        let ids: Vec<String> = only.iter().take(24).map(u32::to_string).collect();
        let more = if only.len() > ids.len() { ", …" } else { "" };
        let text = format!("Tested only in the {which}: {}: {}{more}", counted(only.len(), "triangle"), ids.join(", "));
        sheet.text(sheet.left, sheet.y + 8.0, "note", text.trim_end_matches([':', ' ']));
        sheet.y += 15.0;
    }
    sheet.finish()
}

/// One sentence.
fn summary(walk: &WalkGeometry) -> String {
    let visited = match walk.structure {
        Structure::Grid => format!("{} visited, ", counted(walk.cells.len(), "cell")),
        Structure::Tree => format!("{} visited, ", counted(walk.nodes.len(), "node")),
        Structure::Nothing => String::new(),
    };
    let tested = counted(walk.tested.len(), "triangle") + " tested";
    let end = match (walk.hit, walk.is_over) {
        (Some(hit), true) => format!("hit triangle {} at t {}", hit.triangle, sheet::short(hit.t)),
        (Some(hit), false) => format!("nearest hit so far: triangle {} at t {}", hit.triangle, sheet::short(hit.t)),
        (None, true) => "nothing hit".into(),
        (None, false) => "nothing hit yet".into(),
    };
    format!("{visited}{tested}; {end}. Lengths and t in traced units.")
}
