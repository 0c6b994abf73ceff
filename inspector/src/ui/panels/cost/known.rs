//! The costs that are known: of the whole run, and up to the current pass; and what to do for others.

use std::sync::Arc;

use egui::Ui;

use super::source::{Answer, COUNTING, Counts, From, Of, SORTING, Shown, Sorted, count_again, sort};
use super::warps::WarpsView;
use super::{Look, to_options};
use crate::session::request::Request;
use crate::ui::pane::Context;

/// Costs, and where they are from.
struct Found {
    of: Of,
    counts: Arc<Counts>,
    sorted: Arc<Sorted>,
    is_again: bool,
}

/// The costs of one run.
#[derive(Default)]
pub(super) struct Known {
    /// Of the whole run.
    whole: Option<Found>,
    /// Up to the current pass.
    here: Option<Found>,
    asked: Option<Of>,
}

fn has_counters(cx: &Context<'_>) -> bool {
    cx.model.opened.as_ref().is_some_and(|opened| opened.plan.counters().is_some())
}

/// Whether all passes have run.
fn is_at_end(cx: &Context<'_>) -> bool {
    cx.model.is_complete && cx.model.next.is_none() && cx.model.place == cx.model.passes.len()
}

impl Known {
    /// Takes answers, and asks for what is to be shown.
    pub(super) fn update(&mut self, cx: &mut Context<'_>, look: &Look) {
        let edition = cx.model.edition;
        for what in [SORTING, COUNTING] {
            while let Some(answer) = cx.model.take_answer::<Answer>(what) {
                self.take(*answer);
            }
        }
        for slot in [&mut self.whole, &mut self.here] {
            if slot.as_ref().is_some_and(|found| found.of.edition != edition) {
                *slot = None;
            }
        }
        if cx.model.passes.is_empty() || look.shown == Shown::Passes || cx.model.is_busy() {
            return;
        }
        let place = (!is_at_end(cx)).then_some(cx.model.place);
        let of = |place| Of { edition, place, shown: look.shown };
        // The whole run with another measure, as long as it is what is shown.
        // At the end, the run's own counters replace those of a second run: they include edits by hand.
        let is_kept = |whole: &&Found| match place {
            None => !(whole.is_again && has_counters(cx)),
            Some(_) => !look.is_up_to_here,
        };
        if let Some(whole) = self.whole.as_ref().filter(is_kept) {
            if whole.of.shown != look.shown {
                let from = From::Known(whole.counts.clone());
                self.ask(cx, of(None), from);
            }
            return;
        }
        if !has_counters(cx) {
            if let Some(here) = self.here.as_ref().filter(|here| here.of.place == place && here.of.shown != look.shown)
            {
                let from = From::Known(here.counts.clone());
                self.ask(cx, of(place), from);
            }
            return;
        }
        if self.here.as_ref().is_none_or(|here| here.of != of(place)) {
            self.ask(cx, of(place), From::Session);
        }
    }

    fn take(&mut self, answer: Answer) {
        let Answer { of, found, is_again } = answer;
        if is_again {
            // The session has yet to be asked, at its end.
            self.asked = None;
        }
        let Some((counts, sorted)) = found else {
            // The session has moved on.
            self.asked = None;
            return;
        };
        let slot = if of.place.is_none() { &mut self.whole } else { &mut self.here };
        // Known counters sorted differently are still from where they were.
        let was_again = slot.as_ref().is_some_and(|old| Arc::ptr_eq(&old.counts, &counts) && old.is_again);
        *slot = Some(Found { of, counts, sorted: Arc::new(sorted), is_again: is_again || was_again });
    }

    fn ask(&mut self, cx: &mut Context<'_>, of: Of, from: From) {
        if self.asked != Some(of) {
            self.asked = Some(of);
            cx.model.ask(Request::Job(SORTING, sort(of, from)));
        }
    }

    fn ask_again(&mut self, cx: &mut Context<'_>, of: Of) {
        self.asked = Some(of);
        cx.model.ask(Request::Job(COUNTING, count_again(of)));
    }

    fn found(&self, cx: &Context<'_>, look: &Look) -> Option<&Found> {
        let is_up_to_here = look.is_up_to_here && !is_at_end(cx) && self.here.is_some();
        let whole = self.whole.as_ref().filter(|_| !is_up_to_here);
        whole.or(self.here.as_ref())
    }

    /// The costs to show.
    pub(super) fn shown(&self, cx: &Context<'_>, look: &Look, warps: &WarpsView) -> Option<(Of, Arc<Sorted>)> {
        if look.shown == Shown::Passes {
            let of = Of { edition: cx.model.edition, place: None, shown: Shown::Passes };
            return warps.surveyed().map(|surveyed| (of, surveyed.by_passes.clone()));
        }
        // Others stay until those asked for are there, to avoid flicker.
        self.found(cx, look)
            .filter(|found| found.of.shown != Shown::Passes)
            .map(|found| (found.of, found.sorted.clone()))
    }

    /// Says what is shown, and offers what is not known.
    pub(super) fn tools(&mut self, ui: &mut Ui, cx: &mut Context<'_>, look: &mut Look, warps: &WarpsView) {
        let whole = Of { edition: cx.model.edition, place: None, shown: look.shown };
        if look.shown == Shown::Passes {
            if warps.surveyed().is_none() {
                ui.horizontal_wrapped(|ui| {
                    ui.label("Kernels do not count the passes of each ray.");
                    let button = egui::Button::new("Count them in a second run");
                    if ui.add_enabled(!cx.model.is_busy(), button).clicked() {
                        WarpsView::ask(cx, look.width);
                    }
                });
                return;
            }
            ui.label(format!("of the whole run{}", second_run(cx)));
            return;
        }
        ui.horizontal_wrapped(|ui| {
            if !has_counters(cx) {
                ui.label("This run has no counters.");
                if ui.button("Count in a second run").on_hover_text("the same run, with counters").clicked() {
                    self.ask_again(cx, whole);
                }
                ui.label("or enable them:");
                to_options(ui, cx);
            }
            match self.found(cx, look) {
                Some(found) => {
                    let again = if found.is_again { second_run(cx) } else { "" };
                    match found.of.place {
                        None => ui.label(format!("of the whole run{again}")),
                        Some(place) => ui.label(format!("up to and including pass {}{again}", place.saturating_sub(1))),
                    };
                }
                None if cx.model.passes.is_empty() => drop(ui.weak("No pass has run yet.")),
                None if cx.model.is_busy() => drop(ui.weak("…")),
                // It was cancelled.
                None if has_counters(cx) && ui.button("Sort rays by cost").clicked() => self.asked = None,
                None => {}
            }
            if self.whole.is_some() {
                if !is_at_end(cx) && has_counters(cx) {
                    ui.checkbox(&mut look.is_up_to_here, "up to this pass");
                }
            } else if has_counters(cx) && !is_at_end(cx) {
                let button = egui::Button::new("Count the whole run");
                let about = "runs all passes in a run of its own; the current pass stays";
                if ui.add_enabled(!cx.model.is_busy(), button).on_hover_text(about).clicked() {
                    self.ask_again(cx, whole);
                }
            }
        });
    }
}

/// What a second run leaves out.
fn second_run(cx: &Context<'_>) -> &'static str {
    if cx.model.edits.is_empty() { ", from a second run" } else { ", from a second run without the edits by hand" }
}
