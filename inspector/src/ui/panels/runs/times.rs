//! Times of kernels, run by run, with their spread and their ratio to the reference.

use std::collections::BTreeMap;

use egui::{Align, Label, Layout, ScrollArea, TextStyle, Ui};
use egui_extras::{Column, TableBuilder, TableRow};
use raystep_lab::statistics::Compared;

use super::table::text;
use crate::runs::Kept;
use crate::runs::measure::Measured;
use crate::runs::spread::{FEWEST_REPEATS, Ratio, Spread, Timed};
use crate::ui::pane::Context;
use crate::ui::style::{in_strong, strong};

const ABOUT: &str = "Timing every pass costs several µs per pass. Use these times to compare kernels; for the time of a \
                     whole run, use `raystep bench`, which measures runs without timers.";

/// Widths of columns.
const KERNEL: f32 = 125.0;
const TIME: f32 = 165.0;
const RATIO: f32 = 125.0;

pub(super) fn show(ui: &mut Ui, cx: &mut Context<'_>) {
    let runs = &cx.runs;
    let measured: Vec<(&Kept, &Measured)> =
        runs.runs.list().iter().filter_map(|kept| Some((kept, kept.measured.as_deref()?))).collect();
    if measured.is_empty() {
        ui.weak("No run has been measured.").on_hover_text(ABOUT);
        return;
    }
    let reference = measured.iter().find(|(kept, _)| runs.reference == Some(kept.id)).copied();
    ScrollArea::both().auto_shrink(false).show(ui, |ui| {
        for (kept, measured) in &measured {
            if let Some(why) = &measured.why_no_times {
                ui.label(format!("{}: host time only: {why}", kept.name));
            }
        }
        table(ui, &measured, reference);
        match reference {
            None => ui.weak("Measure the reference, too, to see ratios."),
            Some(_) => ui.weak(format!(
                "[ ] after a time: shortest and longest; after a ratio: its 95% interval, if there are at least {FEWEST_REPEATS} repeats in turn."
            )),
        };
    });
}

fn table(ui: &mut Ui, measured: &[(&Kept, &Measured)], reference: Option<(&Kept, &Measured)>) {
    let mut kernels: BTreeMap<&str, f64> = BTreeMap::new();
    for (_, measured) in measured {
        for (name, _) in measured.repeats.first().map_or(&[][..], |repeat| &repeat.kernels) {
            let most = Spread::of(Timed::Kernel(name), measured).map_or(0.0, |spread| spread.median);
            let known = kernels.entry(name).or_default();
            *known = known.max(most);
        }
    }
    let has_kernels = kernels.values().any(|&most| most > 0.0);
    // The longest first.
    let mut order: Vec<(&str, f64)> = kernels.into_iter().collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut rows: Vec<(String, Timed<'_>)> = Vec::new();
    if has_kernels {
        rows.extend(order.iter().map(|(name, _)| ((*name).to_owned(), Timed::Kernel(name))));
        rows.push(("all passes".into(), Timed::Device));
    }
    rows.push(("whole run, host".into(), Timed::Host));
    let height = ui.text_style_height(&TextStyle::Body) + 4.0;
    let mut builder = TableBuilder::new(ui)
        .id_salt("times")
        .striped(true)
        .vscroll(false)
        .cell_layout(Layout::right_to_left(Align::Center))
        .column(Column::exact(KERNEL));
    for _ in measured {
        builder = builder.column(Column::exact(TIME)).column(Column::exact(RATIO));
    }
    let table = builder.header(height, |mut header| {
        header.col(|ui| left(ui, |ui| drop(strong(ui, "kernel").on_hover_text(ABOUT))));
        for (kept, _) in measured {
            let is_reference = reference.is_some_and(|(own, _)| own.id == kept.id);
            let name = Label::new(in_strong(&kept.name)).truncate();
            header.col(|ui| drop(ui.add(name).on_hover_text(&kept.name)));
            header.col(|ui| drop(strong(ui, if is_reference { "reference" } else { "× reference" })));
        }
    });
    table.body(|body| {
        body.rows(height, rows.len(), |mut row| {
            let Some((name, timed)) = rows.get(row.index()) else { return };
            row.col(|ui| left(ui, |ui| drop(ui.label(name))));
            for (kept, measured) in measured {
                let reference = reference.filter(|(own, _)| own.id != kept.id).map(|(_, own)| own);
                cells(&mut row, *timed, measured, reference);
            }
        });
    });
}

/// A run's time, and its ratio.
fn cells(row: &mut TableRow<'_, '_>, timed: Timed<'_>, measured: &Measured, reference: Option<&Measured>) {
    row.col(|ui| match Spread::of(timed, measured) {
        Some(spread) => {
            let about = format!("median [shortest–longest] of {} repeats", spread.count);
            ui.label(text(&spread)).on_hover_text(about);
        }
        None => drop(ui.weak("–")),
    });
    row.col(|ui| {
        let Some(ratio) = reference.and_then(|reference| Ratio::of(timed, measured, reference)) else { return };
        let (text, about) = match (ratio.interval, ratio.is_paired) {
            (Some(interval), _) => (
                format!("{:.2} [{:.2}–{:.2}]", ratio.ratio, interval.low, interval.high),
                format!(
                    "{}: median of the ratios of pairs; covers the true median in {:.1}%",
                    Compared::of_interval(Some(interval)).words(),
                    100.0 * interval.level
                ),
            ),
            (None, true) => (
                format!("{:.2}", ratio.ratio),
                format!(
                    "{}: median of the ratios of pairs; {FEWEST_REPEATS} repeats would give an interval",
                    Compared::Unknown.words()
                ),
            ),
            (None, false) => (
                format!("{:.2}", ratio.ratio),
                "ratio of medians: the two were not measured in turn, so there is no interval".into(),
            ),
        };
        ui.label(text).on_hover_text(about);
    });
}

fn left(ui: &mut Ui, add: impl FnOnce(&mut Ui)) {
    ui.with_layout(Layout::left_to_right(Align::Center), add);
}
