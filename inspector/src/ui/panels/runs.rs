//! Kept runs: a table, the difference of two of them, and how long each takes.
//!
//! Touches: selection, asks, runs.

mod difference;
mod options;
mod start;
mod table;
mod times;

use egui::{Button, DragValue, ScrollArea, TextEdit, Ui};
use raystep_kernels::plan::Bytes;
use raystep_lab::text::counted;
use serde::{Deserialize, Serialize};

use crate::command::Command;
use crate::runs::RunId;
use crate::runs::measure::{MOST_REPEATS, why_not};
use crate::runs::spread::FEWEST_REPEATS;
use crate::ui::choice::Choices as _;
use crate::ui::pane::{Context, Panel, saves};
use crate::ui::state::kept_runs::Asked;
use difference::DifferenceView;
use options::Options;

/// What is shown below the table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Part {
    /// Where two runs differ.
    #[default]
    Difference,
    /// How long each run takes.
    Times,
    /// The user's notes.
    Notes,
}

/// The panel.
#[derive(Default)]
pub(in crate::ui) struct RunsPanel {
    part: Part,
    difference: DifferenceView,
}

const ABOUT_MEASURING: &str = "Repeats the runs in turns, after a first one that does not count, and takes the times of \
                               their kernels. Stepping waits meanwhile; Escape cancels it.";

impl Panel for RunsPanel {
    fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        let Some(opened) = cx.model.opened.clone() else {
            ui.weak("Open a scene, then keep runs of it side by side.");
            return;
        };
        let list = cx.runs.runs.list();
        let options = Options::of(list.iter().map(|kept| (kept, cx.runs.is_of(kept, &opened))));
        self.tools(ui, cx, &options);
        let is_empty = cx.runs.runs.list().is_empty();
        if !is_empty {
            table::show(ui, cx, &options);
        }
        ui.horizontal_wrapped(|ui| {
            for (part, name) in [(Part::Difference, "Difference"), (Part::Times, "Times"), (Part::Notes, "Notes")] {
                ui.choice_of(&mut self.part, part, name);
            }
            if !is_empty {
                self.part_tools(ui, cx);
            }
        });
        match self.part {
            Part::Difference | Part::Times if is_empty => start::show(ui, cx),
            Part::Difference => self.difference.show(ui, cx),
            Part::Times => times::show(ui, cx),
            Part::Notes => {
                let notes = &mut cx.runs.notes;
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    let field = TextEdit::multiline(notes).desired_width(f32::INFINITY).desired_rows(4);
                    ui.add(field.hint_text("Notes, saved with the session")).accessible_name("notes");
                });
            }
        }
    }

    saves!(part);
}

impl RunsPanel {
    fn tools(&self, ui: &mut Ui, cx: &mut Context<'_>, options: &Options) {
        ui.horizontal_wrapped(|ui| {
            start::keep(ui, cx);
            let is_unknown = cx.runs.runs.list().iter().any(|kept| kept.outcome.is_none());
            let again = Button::new("Run all again");
            let about = "runs kept runs of this scene that have no results";
            if is_unknown && ui.add_enabled(!cx.model.is_busy(), again).on_hover_text(about).clicked() {
                cx.asks.commands.push(Command::RunKept);
            }
            for (command, name) in [(Command::SaveSession, "Save session…"), (Command::OpenSession, "Open session…")]
            {
                if ui.button(name).on_hover_text("runs, edits, bookmarks, watches, notes, layout").clicked() {
                    cx.asks.commands.push(command);
                }
            }
            ui.separator();
            let runs = &mut cx.runs;
            let (bytes, budget) = (runs.runs.bytes(), runs.runs.budget());
            let label = ui.label(format!("{} of", Bytes(bytes)));
            let mut mib = budget >> 20;
            let value = DragValue::new(&mut mib).range(1..=1 << 20).suffix(" MiB");
            let about = "Memory for results of kept runs. Beyond it, the oldest pictures are dropped.";
            if ui.add(value).labelled_by(label.id).on_hover_text(about).changed() {
                runs.asked.push(Asked::Budget(mib << 20));
            }
            if !options.shared.is_empty() {
                ui.separator();
                let whose = if options.own.len() == 1 { "the run" } else { "all runs" };
                ui.weak(format!("{whose}: {}", options.shared)).on_hover_text("options that all kept runs share");
            }
        });
    }

    /// The tools of the part that is shown.
    fn part_tools(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        match self.part {
            Part::Difference => self.difference.tools(ui, cx),
            Part::Notes => {}
            Part::Times => {
                ui.separator();
                let label = ui.label("repeats");
                let value = DragValue::new(&mut cx.runs.repeats).range(1..=MOST_REPEATS);
                let about = format!("{FEWEST_REPEATS} or more give an interval of ratios");
                ui.add(value).labelled_by(label.id).on_hover_text(about);
                let opened = cx.model.opened.as_ref();
                let runs = &cx.runs;
                let ids = |wanted: &[Option<RunId>]| -> Vec<RunId> {
                    let list = runs.runs.list().iter();
                    let fits = list.filter(|kept| opened.is_some_and(|opened| runs.is_of(kept, opened)));
                    let fits = fits.filter(|kept| why_not(&kept.recipe).is_none()).map(|kept| kept.id);
                    fits.filter(|id| wanted.is_empty() || wanted.contains(&Some(*id))).collect()
                };
                let (pair, all) = (ids(&[runs.reference, runs.compared]), ids(&[]));
                for (name, ids) in
                    [("Measure both".to_owned(), pair), (format!("Measure {}", counted(all.len(), "run")), all)]
                {
                    let button = Button::new(name);
                    let can = !ids.is_empty() && !cx.model.is_busy();
                    if ui.add_enabled(can, button).on_hover_text(ABOUT_MEASURING).clicked() {
                        cx.runs.asked.push(Asked::Measure(ids));
                    }
                }
            }
        }
    }
}
