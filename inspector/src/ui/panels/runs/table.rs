//! The table of kept runs.

use egui::{Align, Button, Label, Layout, TextEdit, Ui};
use egui_extras::{Column, TableBuilder, TableRow};
use raystep_kernels::plan::Bytes;
use raystep_lab::text::counted;

use super::super::timings::duration;
use super::options::Options;
use crate::runs::kept::LONGEST_NAME;
use crate::runs::measure::Measured;
use crate::runs::spread::{Spread, Timed};
use crate::runs::{Kept, RunId};
use crate::ui::choice::Choice;
use crate::ui::pane::Context;
use crate::ui::state::kept_runs::Asked;
use crate::ui::style::strong;

/// Heads, with their explanations.
const HEADS: [(&str, &str); 9] = [
    ("", "shows the run in stream views, in place of the open run"),
    ("ref.", "the run that others are compared with"),
    ("vs.", "the run that is compared with the reference"),
    ("name", "the run's name"),
    ("", "actions for this run"),
    ("time", "median [shortest–longest] of all passes by the device's clock, or of the whole run by the host's"),
    ("passes", "number of passes"),
    ("hits", "rays that hit something; of the last sample, if there are several"),
    ("differs in", "options in which the runs differ, and the note on the run"),
];

/// Columns of numbers.
const NUMBERS: [usize; 3] = [5, 6, 7];
/// Between columns.
const GAP: f32 = 8.0;
/// A panel of this width has room for the spread of times.
const WIDE: f32 = 900.0;

/// The widths of columns in a panel of this width, from which only names and options take: they are cut off, and whole
/// when hovering.
fn widths(available: f32) -> [f32; 9] {
    let time = if available >= WIDE { 165.0 } else { 80.0 };
    let mut widths = [52.0, 26.0, 26.0, 0.0, 28.0, time, 48.0, 64.0, 0.0];
    let others = widths.iter().map(|width| width + GAP).sum::<f32>();
    let left = (available - others - GAP).max(160.0);
    widths[3] = (0.5 * left).min(220.0);
    widths[8] = left - widths[3];
    widths
}

/// Changes that a row asks for, applied once the table is drawn.
enum Change {
    Show(Option<RunId>),
    Reference(RunId),
    Compared(RunId),
    Name(RunId, String),
    Note(RunId, String),
    Ask(Asked),
}

pub(super) fn show(ui: &mut Ui, cx: &mut Context<'_>, options: &Options) {
    let height = ui.spacing().interact_size.y + 4.0;
    let mut changes = Vec::new();
    let rows = cx.runs.runs.list().len();
    // In a low panel, three runs.
    let most_height = (0.45 * ui.available_height()).max(4.0 * height);
    ui.spacing_mut().item_spacing.x = GAP;
    let widths = widths(ui.available_width());
    let mut table = TableBuilder::new(ui)
        .id_salt("kept runs")
        .striped(true)
        .auto_shrink(true)
        .max_scroll_height(most_height)
        .min_scrolled_height(most_height.min((rows as f32 + 1.0) * height))
        .cell_layout(Layout::left_to_right(Align::Center));
    for width in widths {
        table = table.column(Column::exact(width).clip(true));
    }
    let table = table.header(height, |mut header| {
        for (i, (head, about)) in HEADS.into_iter().enumerate() {
            header.col(|ui| aligned(ui, i, |ui| drop(strong(ui, head).on_hover_text(about))));
        }
    });
    table.body(|body| {
        body.rows(height, rows, |row| {
            let own = options.own.get(row.index());
            if let Some((kept, own)) = cx.runs.runs.list().get(row.index()).zip(own) {
                self::row(row, cx, kept, (own, &widths), &mut changes);
            }
        });
    });
    for change in changes {
        apply(change, cx);
    }
}

/// Numbers to the right, everything else to the left.
fn aligned(ui: &mut Ui, column: usize, add: impl FnOnce(&mut Ui)) {
    if NUMBERS.contains(&column) {
        ui.with_layout(Layout::right_to_left(Align::Center), add);
    } else {
        add(ui);
    }
}

fn apply(change: Change, cx: &mut Context<'_>) {
    let runs = &mut cx.runs;
    match change {
        Change::Show(id) => runs.set_flipped(id),
        Change::Reference(id) => {
            // Choosing the other run as the reference swaps the two.
            if runs.compared == Some(id) {
                runs.compared = runs.reference;
            }
            runs.reference = Some(id);
        }
        Change::Compared(id) => {
            if runs.reference == Some(id) {
                runs.reference = runs.compared;
            }
            runs.compared = Some(id);
        }
        Change::Name(id, name) => {
            if let Some(kept) = runs.runs.get_mut(id) {
                kept.name = name.chars().take(LONGEST_NAME).collect();
            }
        }
        Change::Note(id, note) => {
            if let Some(kept) = runs.runs.get_mut(id) {
                kept.note = note;
            }
        }
        Change::Ask(asked) => runs.asked.push(asked),
    }
}

fn row(
    mut row: TableRow<'_, '_>,
    cx: &Context<'_>,
    kept: &Kept,
    (own, widths): (&str, &[f32; 9]),
    changes: &mut Vec<Change>,
) {
    let Some(opened) = &cx.model.opened else { return };
    let (runs, id) = (&cx.runs, kept.id);
    let is_here = runs.is_of(kept, opened);
    row.col(|ui| {
        let (is_shown, why) = (runs.flipped() == Some(id), runs.why_not_flipped(kept, opened));
        let response = ui.add_enabled(why.is_none(), Choice::new(is_shown, "show"));
        let name = format!("show {}", kept.name);
        response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, why.is_none(), is_shown, &name));
        let why = why.unwrap_or_default();
        if response.on_disabled_hover_text(format!("not shown: {why}")).clicked() {
            changes.push(Change::Show((!is_shown).then_some(id)));
        }
    });
    for (is_on, what) in [(runs.reference == Some(id), "reference"), (runs.compared == Some(id), "compared")] {
        row.col(|ui| {
            let response = ui.radio(is_on, "");
            let name = format!("{what}: {}", kept.name);
            response.widget_info(|| egui::WidgetInfo::selected(egui::Role::RadioButton, true, is_on, &name));
            if response.clicked() {
                changes.push(if what == "reference" { Change::Reference(id) } else { Change::Compared(id) });
            }
        });
    }
    row.col(|ui| {
        let mut name = kept.name.clone();
        let response = ui.add(TextEdit::singleline(&mut name).id_salt(("name", id)).desired_width(widths[3] - 8.0));
        let response = response.accessible_name(format!("name of run {id}"));
        if response.on_hover_text(&kept.name).changed() {
            changes.push(Change::Name(id, name));
        }
    });
    row.col(|ui| actions(ui, cx, kept, is_here, changes));
    let is_wide = widths[5] > 100.0;
    let is_free = is_here && !cx.model.is_busy();
    for (i, (text, about)) in cells(kept, is_wide).into_iter().enumerate() {
        row.col(|ui| {
            aligned(ui, 5 + i, |ui| {
                if i == 0 && kept.outcome.is_none() {
                    if ui.add_enabled(is_free, Button::new("Run again").small()).clicked() {
                        changes.push(Change::Ask(Asked::Again(kept.id)));
                    }
                    return;
                }
                let label = ui.add(Label::new(text).truncate());
                if !about.is_empty() {
                    label.on_hover_text(about);
                }
            });
        });
    }
    row.col(|ui| {
        let about = [own, &kept.note, &kept.path].into_iter().filter(|text| !text.is_empty()).collect::<Vec<_>>();
        let text = if own.is_empty() { "–" } else { own };
        let note = if kept.note.is_empty() { String::new() } else { format!(" · {}", kept.note) };
        ui.add(Label::new(format!("{text}{note}")).truncate()).on_hover_text(about.join("\n"));
    });
}

/// What can be done with a run.
fn actions(ui: &mut Ui, cx: &Context<'_>, kept: &Kept, is_here: bool, changes: &mut Vec<Change>) {
    let id = kept.id;
    let is_free = is_here && !cx.model.is_busy();
    let menu = ui.menu_button("…", |ui| {
        let reference = cx.runs.reference.filter(|&reference| reference != id);
        for (name, about, can, asked) in [
            ("Run again", "replaces its results", is_free, Asked::Again(id)),
            (
                "Measure this run again",
                "in turn with the reference, so that their times can be compared",
                is_free && crate::runs::measure::why_not(&kept.recipe).is_none(),
                Asked::Measure(reference.into_iter().chain([id]).collect()),
            ),
            ("Open it", "makes its options and edits those of the open run", is_free, Asked::Open(id)),
            ("Remove", "forgets this run", true, Asked::Remove(id)),
        ] {
            if ui.add_enabled(can, egui::Button::new(name)).on_hover_text(about).clicked() {
                changes.push(Change::Ask(asked));
                ui.close();
            }
        }
        let mut note = kept.note.clone();
        let response = ui.add(TextEdit::singleline(&mut note).id_salt(("note", id)).hint_text("note"));
        let response = response.accessible_name(format!("note on {}", kept.name));
        if response.changed() {
            changes.push(Change::Note(id, note));
        }
    });
    let name = format!("actions: {}", kept.name);
    menu.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
}

/// The texts of the columns of numbers, with explanations; without the spread of times, unless there is room.
fn cells(kept: &Kept, is_wide: bool) -> [(String, String); 3] {
    let outcome = kept.outcome.as_ref();
    let passes = outcome.map_or_else(|| "–".into(), |outcome| outcome.passes.len().to_string());
    let hits = outcome.and_then(|outcome| outcome.hits).map_or_else(|| "–".into(), |hits| hits.to_string());
    let memory = match &kept.picture {
        Ok(picture) => format!("{} of results: {}", Bytes(kept.bytes()), picture.names()),
        Err(why) => format!("no picture: {why}"),
    };
    let device = outcome.map_or_else(String::new, |outcome| outcome.device.clone());
    [time(kept, is_wide), (passes, device), (hits, memory)]
}

/// The total time of a run, and how it was found.
fn time(kept: &Kept, is_wide: bool) -> (String, String) {
    let spread = |timed, measured: &Measured| {
        let spread = Spread::of(timed, measured)?;
        let whole = text(&spread);
        let shown = if is_wide { whole.clone() } else { text(&Spread { count: 1, ..spread }) };
        Some((shown, whole))
    };
    if let Some(measured) = &kept.measured {
        let count = counted(measured.repeats.len(), "repeat");
        if let Some((text, whole)) = spread(Timed::Device, measured) {
            let about = format!("{whole}: all passes by the device's clock, median [shortest–longest] of {count}");
            return (text, about);
        }
        let why = measured.why_no_times.clone().unwrap_or_else(|| "no pass was timed".into());
        if let Some((text, whole)) = spread(Timed::Host, measured) {
            let about = format!("{whole}: the whole run by the host's clock, {count}: {why}");
            return (format!("{text} host"), about);
        }
        return ("–".into(), why);
    }
    let Some(outcome) = &kept.outcome else { return ("–".into(), "not run yet".into()) };
    match outcome.device_ns() {
        Some(ns) => (duration(ns), "all passes by the device's clock, one run: measure it to see the spread".into()),
        None => {
            let why = outcome.why_no_times.clone().unwrap_or_else(|| "no pass was timed".into());
            ("–".into(), format!("{why}: measure the run to see its time by the host's clock"))
        }
    }
}

/// `1.20 [1.18–1.31] ms`
pub(super) fn text(spread: &Spread) -> String {
    let Spread { median, min, max, count } = *spread;
    if count == 1 {
        return duration(median.round() as u64);
    }
    let (unit, ns, digits) = match median {
        ..1e6 => ("µs", 1e3, 1),
        ..1e9 => ("ms", 1e6, 2),
        _ => ("s", 1e9, 2),
    };
    let number = |value: f64| format!("{:.digits$}", value / ns);
    format!("{} [{}–{}] {unit}", number(median), number(min), number(max))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_has_one_unit() {
        let of = |[median, min, max]: [f64; 3], count| text(&Spread { median, min, max, count });
        assert_eq!(of([1_200_000.0, 980_000.0, 1_310_000.0], 6), "1.20 [0.98–1.31] ms");
        assert_eq!(of([1_500.0, 1_450.0, 2_000_000.0], 6), "1.5 [1.4–2000.0] µs");
        assert_eq!(of([2e9, 1e9, 3e9], 2), "2.00 [1.00–3.00] s");
        assert_eq!(of([1_500.0; 3], 1), "1.5 µs");
    }

    #[test]
    fn the_columns_fit_a_panel() {
        for available in [580.0, 899.0, 900.0, 1270.0, 1590.0] {
            let widths = widths(available);
            let whole = widths.iter().map(|width| width + GAP).sum::<f32>();
            assert!(whole <= available, "{whole} of {available}");
            assert!(widths[3] >= 80.0 && widths[8] >= 80.0, "{widths:?}");
        }
        assert!(widths(100.0).iter().all(|width| *width > 0.0));
    }
}
