//! The first value that is infinite or not a number, and what made it.

use egui::{Button, Ui};
use raystep_kernels::{Options, RenderError};
use raystep_lab::non_finite::{Found, non_finite};

use crate::command::PaneKind;
use crate::session::request::{Job, JobContext, Request, answered, flow, job};
use crate::ui::pane::Context;
use crate::ui::style::strong;

/// The engine's job, named while it runs.
const LOOKING: &str = "looking for NaN and Inf";

/// What is known of a run.
#[derive(Default)]
pub(super) struct Finite {
    found: Option<(u64, Found)>,
}

fn job(generation: u64) -> Job {
    job!(context, {
        let JobContext { session, device, progress, .. } = context;
        let mut found = async || {
            let options = Options { timings: false, keep_passes: false, ..session.options().clone() };
            let mut renderer = session.renderer().another(&options, &device).await?;
            non_finite(&mut renderer, |now| flow(progress(now.rays_decided, now.rays))).await
        };
        let found = found().await.map_err(|error: RenderError| error.to_string())?;
        answered((generation, found))
    })
}

impl Finite {
    pub(super) fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        while let Some(answer) = cx.model.take_answer::<(u64, Found)>(LOOKING) {
            self.found = Some(*answer);
        }
        let generation = cx.model.generation;
        let about = "Runs all passes again, in a run of its own and without edits by hand, and examines every float of every \
                     stream after each. The kernel is then interpreted for the first ray with such a value.";
        let button = Button::new("Look for NaN and Inf");
        if ui.add_enabled(!cx.model.is_busy(), button).on_hover_text(about).clicked() {
            cx.model.ask(Request::Job(LOOKING, job(generation)));
        }
        let Some((_, found)) = self.found.as_ref().filter(|(known, _)| *known == generation) else {
            ui.weak("The first pass in which a value becomes infinite or not a number, and the line that computes it.");
            return;
        };
        strong(ui, found.sentence());
        let Some(first) = &found.first else { return };
        ui.horizontal_wrapped(|ui| {
            if ui.button("Go there").on_hover_text("to the pass and the pixel, with the kernel beside").clicked() {
                cx.asks.select = Some(first.pixel);
                cx.asks.go_to = Some(first.pass + 1);
                cx.asks.panel = Some(PaneKind::Kernel);
            }
            ui.weak("Lines are those of the composed source in the panel Kernel.");
        });
    }
}
