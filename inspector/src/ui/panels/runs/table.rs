//! The table of kept runs.

use egui::{Align, Layout, ScrollArea, TextEdit, Ui};
use egui_extras::{Column, TableBuilder, TableRow};
use raystep_kernels::plan::Bytes;
use raystep_kernels::{Accelerator, Choices, GridSize, ScheduleKind};
use raystep_lab::text::counted;

use super::super::timings::duration;
use crate::runs::kept::LONGEST_NAME;
use crate::runs::measure::Measured;
use crate::runs::spread::{Spread, Timed};
use crate::runs::{Kept, RunId};
use crate::settings::Settings;
use crate::ui::pane::Context;
use crate::ui::state::kept_runs::Asked;
use crate::ui::style::strong;

/// Heads, with their explanations and the widths of columns that have a fixed one.
const HEADS: [(&str, &str, Option<f32>); 15] = [
    ("", "shows the run in stream views, in place of the open run", None),
    ("ref.", "the run that others are compared with", None),
    ("vs.", "the run that is compared with the reference", None),
    ("name", "the run's name", Some(NAME)),
    ("", "actions for this run", None),
    (
        "time",
        "median [shortest–longest] of all passes by the device's clock, or of the whole run by the host's",
        Some(175.0),
    ),
    ("passes", "number of passes", Some(50.0)),
    ("hits", "rays that hit something; of the last sample, if there are several", Some(75.0)),
    ("structure", "acceleration structure", None),
    ("schedule", "the order in which kernels run", None),
    ("numerics", "the rules for planes, steps and hits", None),
    ("skip", "whether rays skip over empty cells", None),
    ("device", "where passes ran", None),
    ("size", "width and height in pixels", Some(85.0)),
    ("note", "a note on the run", Some(NOTE)),
];

/// Columns of numbers.
const NUMBERS: [usize; 4] = [5, 6, 7, 13];
/// Width of names.
const NAME: f32 = 160.0;
/// Width of notes.
const NOTE: f32 = 180.0;

/// Changes that a row asks for, applied once the table is drawn.
enum Change {
    Show(Option<RunId>),
    Reference(RunId),
    Compared(RunId),
    Name(RunId, String),
    Note(RunId, String),
    Ask(Asked),
}

pub(super) fn show(ui: &mut Ui, cx: &mut Context<'_>, most_height: f32) {
    let height = ui.spacing().interact_size.y + 4.0;
    let mut changes = Vec::new();
    let rows = cx.runs.runs.list().len();
    ScrollArea::horizontal().id_salt("kept runs").auto_shrink([false, true]).show(ui, |ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        let mut table = TableBuilder::new(ui)
            .id_salt("kept runs")
            .striped(true)
            .auto_shrink(true)
            .max_scroll_height(most_height)
            .min_scrolled_height(most_height.min((rows as f32 + 1.0) * height))
            .cell_layout(Layout::left_to_right(Align::Center));
        for (_, _, width) in HEADS {
            table = table.column(width.map_or_else(|| Column::auto().at_least(24.0), Column::exact));
        }
        let table = table.header(height, |mut header| {
            for (i, (head, about, _)) in HEADS.into_iter().enumerate() {
                header.col(|ui| aligned(ui, i, |ui| drop(strong(ui, head).on_hover_text(about))));
            }
        });
        table.body(|body| {
            body.rows(height, rows, |row| {
                if let Some(kept) = cx.runs.runs.list().get(row.index()) {
                    self::row(row, cx, kept, &mut changes);
                }
            });
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

fn row(mut row: TableRow<'_, '_>, cx: &Context<'_>, kept: &Kept, changes: &mut Vec<Change>) {
    let Some(opened) = &cx.model.opened else { return };
    let (runs, id) = (&cx.runs, kept.id);
    let is_here = runs.is_of(kept, opened);
    row.col(|ui| {
        let (is_shown, why) = (runs.flipped() == Some(id), runs.why_not_flipped(kept, opened));
        let response = ui.add_enabled(why.is_none(), egui::Button::selectable(is_shown, "show"));
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
        let response = ui.add(TextEdit::singleline(&mut name).id_salt(("name", id)).desired_width(NAME - 8.0));
        let response = response.accessible_name(format!("name of run {id}"));
        if response.on_hover_text(&kept.name).changed() {
            changes.push(Change::Name(id, name));
        }
    });
    row.col(|ui| actions(ui, cx, kept, is_here, changes));
    for (i, (text, about)) in cells(kept, is_here).into_iter().enumerate() {
        row.col(|ui| {
            aligned(ui, 5 + i, |ui| {
                let label = ui.add(egui::Label::new(text).extend());
                if !about.is_empty() {
                    label.on_hover_text(about);
                }
            });
        });
    }
    row.col(|ui| {
        let mut note = kept.note.clone();
        let response = ui.add(TextEdit::singleline(&mut note).id_salt(("note", id)).desired_width(NOTE - 8.0));
        response.widget_info(|| {
            egui::WidgetInfo::text_edit(true, &kept.note, &kept.note, format!("note on {}", kept.name))
        });
        if response.changed() {
            changes.push(Change::Note(id, note));
        }
    });
}

/// What can be done with a run.
fn actions(ui: &mut Ui, cx: &Context<'_>, kept: &Kept, is_here: bool, changes: &mut Vec<Change>) {
    let id = kept.id;
    let is_free = is_here && !cx.model.is_busy();
    if kept.outcome.is_none() && ui.add_enabled(is_free, egui::Button::new("Run again")).clicked() {
        changes.push(Change::Ask(Asked::Again(id)));
    }
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
    });
    let name = format!("actions: {}", kept.name);
    menu.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
}

/// The texts of the columns from the time to the size, with explanations.
fn cells(kept: &Kept, is_here: bool) -> [(String, String); 9] {
    let settings = &kept.recipe.settings;
    let Settings { size, ray, device, .. } = settings;
    let Choices { accelerator, schedule, skip, grid, steps_per_pass, .. } = settings.choices;
    let cells = match grid {
        GridSize::Cells([x, y, z]) if accelerator == Accelerator::Grid => format!(" {x}×{y}×{z}"),
        GridSize::Auto | GridSize::Cells(_) => String::new(),
    };
    let other = if is_here { "" } else { " (other scene)" };
    let steps = if steps_per_pass > 1 && schedule == ScheduleKind::Compact {
        format!(" ×{steps_per_pass}")
    } else {
        String::new()
    };
    let edits = &kept.recipe.edits;
    let edited = if edits.is_empty() { String::new() } else { format!(", {}", counted(edits.len(), "edit")) };
    let outcome = kept.outcome.as_ref();
    let plain = |text: String| (text, String::new());
    let size = if ray.is_some() { "1 ray".into() } else { format!("{}×{}", size[0], size[1]) };
    let is_grid = accelerator == Accelerator::Grid;
    let passes = outcome.map_or_else(|| "–".into(), |outcome| outcome.passes.len().to_string());
    let hits = outcome.and_then(|outcome| outcome.hits).map_or_else(|| "–".into(), |hits| hits.to_string());
    let memory = match &kept.picture {
        Ok(picture) => format!("{} of results: {}", Bytes(kept.bytes()), picture.names()),
        Err(why) => format!("no picture: {why}"),
    };
    [
        time(kept),
        plain(passes),
        (hits, memory),
        (format!("{accelerator}{cells}{other}"), kept.path.clone()),
        plain(format!("{}{steps}", settings.order())),
        plain(format!("{}{edited}", settings.rules())),
        plain(if is_grid { skip.to_string() } else { "–".into() }),
        (device.name().into(), outcome.map_or_else(String::new, |outcome| outcome.device.clone())),
        plain(size),
    ]
}

/// The total time of a run, and how it was found.
fn time(kept: &Kept) -> (String, String) {
    let spread = |timed, measured: &Measured| Spread::of(timed, measured).map(|spread| text(&spread));
    if let Some(measured) = &kept.measured {
        let count = counted(measured.repeats.len(), "repeat");
        if let Some(text) = spread(Timed::Device, measured) {
            return (text, format!("all passes by the device's clock: median [shortest–longest] of {count}"));
        }
        let why = measured.why_no_times.clone().unwrap_or_else(|| "no pass was timed".into());
        if let Some(text) = spread(Timed::Host, measured) {
            return (format!("{text} host"), format!("the whole run by the host's clock, {count}: {why}"));
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
}
