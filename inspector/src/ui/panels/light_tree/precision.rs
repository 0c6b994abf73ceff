//! Where the selected pixel's light tree parts between the device, f32 and f64.

use std::sync::Arc;

use egui::Ui;
use raystep_kernels::export::light_tree::LightTree;
use raystep_kernels::export::trace::{RunSoFar, Trace};
use raystep_lab::divergence::Apart;

use crate::session::request::Opened;
use crate::session::{HistorySource, Model};
use crate::settings::DeviceKind;
use crate::ui::pane::Context;

/// What is known of a history.
#[derive(Default)]
pub(super) struct Precision {
    known: Option<(Arc<Trace>, HistorySource, Vec<Line>)>,
}

/// A sentence, and the vertex that it is about.
struct Line {
    text: String,
    vertex: Option<usize>,
}

impl Precision {
    /// Says where they part; `tree` is that in view. Returns a vertex that was asked for.
    pub(super) fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>, history: &Arc<Trace>) -> Option<usize> {
        let source = &cx.model.history_source;
        let is_known =
            |known: &(Arc<Trace>, HistorySource, Vec<Line>)| Arc::ptr_eq(&known.0, history) && known.1 == *source;
        if !self.known.as_ref().is_some_and(is_known) {
            let source = source.clone();
            self.known =
                cx.model.opened.as_ref().map(|opened| (history.clone(), source, lines(cx.model, opened, history)));
        }
        let mut wanted = None;
        for Line { text, vertex } in self.known.iter().flat_map(|(.., lines)| lines) {
            ui.horizontal_wrapped(|ui| {
                ui.label(text);
                if let Some(vertex) = vertex
                    && ui.button("Go there").clicked()
                {
                    wanted = Some(*vertex);
                }
            });
        }
        wanted
    }
}

fn lines(model: &Model, opened: &Opened, history: &Trace) -> Vec<Line> {
    let plain = |text: String| Line { text, vertex: None };
    if !model.edits.is_empty() || model.twins.is_some() {
        return vec![plain(
            "Precisions are compared in runs without edits by hand, and with all passes on one device.".into(),
        )];
    }
    let (plan, data) = (&opened.plan, &opened.data);
    let run = RunSoFar { plan, data, passes: &model.passes, is_complete: model.is_complete };
    let tree = |life: &Trace| LightTree::of(&life.rows, plan.program, data);
    let of_twin = |life: Option<Trace>| life.and_then(|life| tree(&life));
    let [single, double] = [of_twin(run.follow::<f32>(history.pixel)), of_twin(run.follow::<f64>(history.pixel))];
    let Some((single, double)) = single.zip(double) else {
        return vec![plain("This ray cannot be followed alone.".into())];
    };
    let compared = |a: &LightTree, b: &LightTree, names: [&str; 2]| {
        let apart = Apart::of(a, b);
        Line { text: apart.sentence(names, a.samples), vertex: apart.first.map(|part| part.vertex) }
    };
    let mut lines = Vec::new();
    if opened.settings.device == DeviceKind::Gpu {
        lines.push(match &model.history_source {
            HistorySource::Reference => plain("The GPU has yet to trace this pixel.".into()),
            HistorySource::Unconfirmed(why) => plain(format!("The GPU has not traced this pixel: {why}.")),
            HistorySource::Device | HistorySource::Compared { .. } => match tree(history) {
                Some(device) => compared(&device, &single, ["The GPU", "f32"]),
                None => plain("The GPU has not traced this pixel yet.".into()),
            },
        });
    }
    lines.push(compared(&single, &double, ["f32", "f64"]));
    lines
}
