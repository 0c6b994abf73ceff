//! The paths of a sample over the whole image, bounce by bounce, and the pixels to which one vertex adds the most.
//!
//! Touches: selection, asks.

mod brightest;
mod finite;
mod rows;

use egui::{Button, Ui, Vec2, vec2};
use raystep_kernels::ScheduleKind;
use raystep_kernels::options::{Choices, Integrator};
use raystep_kernels::{Options, RenderError};
use raystep_lab::bounces::{Bounces, bounces, has_bounces};
use serde::{Deserialize, Serialize};

use super::table::Table;
use crate::session::Model;
use crate::session::request::{Job, JobContext, Opened, Request, answered, flow, job};
use crate::settings::Settings;
use crate::ui::choice::Choices as _;
use crate::ui::pane::{Context, NO_RAYS, Panel, saves};
use crate::ui::style::strong;

/// The engine's job, named while it runs.
const COUNTING: &str = "counting the paths of all bounces";

/// What is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Section {
    #[default]
    Bounces,
    Brightest,
    Finite,
}

/// The panel.
#[derive(Default)]
pub(in crate::ui) struct BouncesView {
    section: Section,
    found: Option<(Of, Bounces)>,
    bounces: Table,
    brightest: Table,
    finite: finite::Finite,
}

/// What was counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Of {
    /// The run.
    generation: u64,
    /// The sample, from 0.
    sample: u32,
}

impl Of {
    /// The sample that the run is at, and the number of passes before its first.
    fn here(model: &Model) -> (Self, usize) {
        let sample = model.last_pass().map_or(0, |pass| pass.sample);
        let place = model.passes.partition_point(|pass| pass.sample < sample);
        (Self { generation: model.generation, sample }, place)
    }
}

/// Runs the sample again, in a run of its own.
fn job(of: Of, place: usize) -> Job {
    job!(context, {
        let JobContext { session, device, progress, .. } = context;
        let mut counted = async || {
            let options = Options { timings: false, keep_passes: false, ..session.options().clone() };
            let mut renderer = session.renderer().another(&options, &device).await?;
            bounces(&mut renderer, place, |now| flow(progress(now.rays_decided, now.rays))).await
        };
        let found = counted().await.map_err(|error: RenderError| error.to_string())?;
        answered((of, found.ok_or("this run has no bounces")?))
    })
}

impl Panel for BouncesView {
    fn least(&self) -> Vec2 {
        vec2(240.0, 160.0)
    }

    fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        if !cx.has_rays() {
            ui.weak(NO_RAYS);
            return;
        }
        let Some(opened) = cx.model.opened.clone() else {
            ui.weak("Open a scene to see how its paths fare from bounce to bounce.");
            return;
        };
        if let Some((why, button, choices)) = why_none(&opened) {
            ui.horizontal_wrapped(|ui| {
                ui.label(why);
                if ui.add_enabled(!cx.model.is_busy(), Button::new(button)).clicked() {
                    let settings = Settings { choices, ..opened.settings.clone() };
                    cx.model.ask(Request::Plan(Box::new(settings)));
                }
            });
            return;
        }
        while let Some(answer) = cx.model.take_answer::<(Of, Bounces)>(COUNTING) {
            self.found = Some(*answer);
        }
        let (here, place) = Of::here(cx.model);
        if self.found.as_ref().is_some_and(|(of, _)| of.generation != here.generation) {
            self.found = None;
        }
        ui.horizontal_wrapped(|ui| {
            let samples = opened.data.sampling.samples.max(1);
            if self.found.as_ref().is_none_or(|(of, _)| *of != here) {
                let text = match samples {
                    1 => "Count paths".into(),
                    _ => format!("Count paths of sample {}", here.sample + 1),
                };
                let about = "Runs the passes again, in a run of its own and without edits by hand, and reads all paths \
                             after each bounce. The current pass stays.";
                if ui.add_enabled(!cx.model.is_busy(), Button::new(text)).on_hover_text(about).clicked() {
                    cx.model.ask(Request::Job(COUNTING, job(here, place)));
                }
            }
            if let Some((of, _)) = self.found.as_ref().filter(|_| samples > 1) {
                strong(ui, format!("sample {} of {samples}", of.sample + 1));
            }
            for (section, name, about) in [
                (Section::Bounces, "Bounces", "what paths do in each bounce"),
                (Section::Brightest, "Brightest pixels", "pixels by the most that a single vertex of their path adds"),
                (Section::Finite, "NaN or Inf", "the first value that is infinite or not a number, and what made it"),
            ] {
                ui.choice_of(&mut self.section, section, name).on_hover_text(about);
            }
        });
        if self.section == Section::Finite {
            self.finite.show(ui, cx);
            return;
        }
        let Some((of, found)) = &self.found else {
            ui.weak(
                "How many paths are left in each bounce, why they end, and what light the bounce adds to the image.",
            );
            return;
        };
        strong(ui, found.sentence());
        match self.section {
            Section::Bounces => rows::show(ui, cx, &mut self.bounces, (*of, found)),
            Section::Brightest => brightest::show(ui, cx, &mut self.brightest, (*of, found)),
            Section::Finite => {}
        }
    }

    saves!(section);
}

/// Why a run has no bounces; a button's text, and the choices with which it has.
fn why_none(opened: &Opened) -> Option<(&'static str, &'static str, Choices)> {
    let choices = opened.settings.choices;
    if choices.integrator != Integrator::Path {
        let why = "Bounces are counted for paths, with --integrator path.";
        return Some((why, "Trace paths", Choices { integrator: Integrator::Path, ..choices }));
    }
    let why = "With this schedule a single pass traces paths to their ends, and no pass is between two bounces.";
    let compact = Choices { schedule: ScheduleKind::Compact, ..choices };
    (!has_bounces(&opened.plan)).then_some((why, "Use the schedule compact", compact))
}
