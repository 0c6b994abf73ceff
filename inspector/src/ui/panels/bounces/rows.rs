//! A row for each bounce.

use egui::Ui;
use raystep_kernels::program::paths::{Ending, Technique};
use raystep_lab::bounces::{Bounce, Bounces};

use super::Of;
use crate::ui::pane::Context;
use crate::ui::panels::table::{Head, Listed, ListedCell, Look, Table, View, version};
use crate::ui::units::decimals;

const HEADS: [Head<'static>; 11] = [
    Head::number("depth", "surfaces that have sent the path on; 0 is the camera's ray"),
    Head::number("paths", "paths at the start of the bounce, each with a ray to trace"),
    Head::number("adds", "luminance that the bounce adds to the image, its mean per pixel"),
    Head::number("share", "share of the luminance of all bounces"),
    Head::number("throughput", "mean luminance of the throughput of the paths at the start of the bounce"),
    Head::number("shadow rays", "shadow rays that the bounce casts"),
    Head::number("occluded", "shadow rays that something is in the way of"),
    Head::number("emitter hits", "luminance of emitters that paths hit, its mean per pixel").minor(),
    Head::number("light samples", "luminance of emitters that shadow rays reach, its mean per pixel").minor(),
    Head::number("background", "luminance of the background that paths reach, its mean per pixel").minor(),
    Head::prose("ends", "paths that end in the bounce, by reason"),
];

/// Shows the rows; a click goes to the first pass of a bounce.
pub(super) fn show(ui: &mut Ui, cx: &mut Context<'_>, table: &mut Table, (of, found): (Of, &Bounces)) {
    let bar = ui.visuals().selection.bg_fill.gamma_multiply(0.6);
    let rows = Listed { rows: (0..found.rows.len()).map(|depth| cells(found, depth, bar)).collect() };
    let is_here = Of::here(cx.model).0 == of;
    let current = found.rows.iter().rposition(|row| is_here && row.place < cx.model.place);
    let version = version((of, bar.to_array()));
    let view = View { name: "bounces", heads: &HEADS, rows: &rows, version, current };
    if let Some(row) = table.show(ui, &view).and_then(|row| found.rows.get(row)) {
        cx.asks.go_to = Some(row.place + 1);
    }
}

fn cells(found: &Bounces, depth: usize, bar: egui::Color32) -> Vec<ListedCell> {
    let row = &found.rows[depth];
    let all = found.light();
    let digits = decimals(found.rows.iter().map(Bounce::light).fold(0.0, f64::max)).saturating_sub(2);
    let count = |count: u64| ListedCell::number(count as f64, count.to_string());
    let light = |light: f64| ListedCell::number(light, format!("{light:.digits$}")).about(light.to_string());
    let with_bar = |part: f64| Look { bar: Some((part.clamp(0.0, 1.0) as f32, bar)), ..Look::default() };
    let brightest = found.rows.iter().map(Bounce::light).fold(0.0, f64::max);
    let percent = |part: f64, of: f64| if of > 0.0 { part / of } else { 0.0 };
    let share = percent(row.light(), all);
    let occluded = percent(row.occluded as f64, row.shadow_rays as f64);
    vec![
        count(depth as u64),
        count(row.paths).look(with_bar(row.paths as f64 / found.pixels.max(1) as f64)),
        light(row.light()).look(with_bar(percent(row.light(), brightest))),
        ListedCell::number(share, format!("{:.1}%", share * 100.0)),
        ListedCell::number(row.throughput(), format!("{:.3}", row.throughput())).about(row.throughput().to_string()),
        count(row.shadow_rays),
        ListedCell::number(row.occluded as f64, format!("{:.0}%", occluded * 100.0)).about(row.occluded.to_string()),
        light(row.added[Technique::EmitterHit as usize]),
        light(row.added[Technique::LightSample as usize]),
        light(row.added[Technique::Background as usize]),
        ListedCell::text(ends(row)).about(about_ends(row)),
    ]
}

/// How many paths end, by reason.
fn ends(row: &Bounce) -> String {
    let reasons = Ending::ALL.iter().filter(|&&why| row.ended[why as usize] > 0);
    let reasons: Vec<String> = reasons.map(|&why| format!("{} {}", row.ended[why as usize], why.name())).collect();
    if reasons.is_empty() { "no path".into() } else { reasons.join(", ") }
}

fn about_ends(row: &Bounce) -> String {
    let all = Ending::ALL.iter().map(|&why| format!("{} {}", row.ended[why as usize], why.summary()));
    all.collect::<Vec<_>>().join("\n")
}
