//! The selected pixel's light by each strategy of a path tracer, side by side.

use egui::{Button, DragValue, Grid, ScrollArea, Ui};
use raystep_kernels::options::Strategy;
use raystep_lab::strategies::{Estimate, estimate};
use smart_default::SmartDefault;

use crate::session::before::pause;
use crate::session::request::{Job, JobContext, Request, answered, job};
use crate::ui::pane::Context;
use crate::ui::style::strong;
use crate::ui::units::decimals;

/// The engine's job, named while it runs.
const ESTIMATING: &str = "estimating a pixel by each strategy";
/// What may be asked for.
const SAMPLES: std::ops::RangeInclusive<u32> = 2..=65_536;

/// Which pixel of which run.
type Of = (u64, [u32; 2]);

/// What is known.
#[derive(SmartDefault)]
pub(super) struct Strategies {
    #[default(256)]
    samples: u32,
    found: Option<(Of, Vec<Estimate>)>,
}

fn job(of: Of, samples: u32) -> Job {
    job!(context, {
        let JobContext { session, scene, progress, .. } = context;
        let mut found = Vec::new();
        for (done, &strategy) in Strategy::ALL.iter().enumerate() {
            if !progress(done as u64, Strategy::ALL.len() as u64) {
                return Err("cancelled".into());
            }
            pause().await;
            let estimated = estimate(scene, session.options(), strategy, of.1, samples).map_err(|e| e.to_string())?;
            found.extend(estimated);
        }
        if found.is_empty() {
            return Err("the rays of this run cannot be followed alone".into());
        }
        answered((of, found))
    })
}

impl Strategies {
    /// Shows the table, or how to get it.
    pub(super) fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>, pixel: [u32; 2]) {
        while let Some(answer) = cx.model.take_answer::<(Of, Vec<Estimate>)>(ESTIMATING) {
            self.found = Some(*answer);
        }
        let of = (cx.model.generation, pixel);
        ui.horizontal_wrapped(|ui| {
            let about = "Traces the pixel alone on the CPU reference kernels in f32, with this many samples by each \
                         strategy, and adds up their light trees.";
            let button = Button::new("Estimate by each strategy");
            if ui.add_enabled(!cx.model.is_busy(), button).on_hover_text(about).clicked() {
                cx.model.ask(Request::Job(ESTIMATING, job(of, self.samples)));
            }
            let label = ui.label("samples").id;
            ui.add(DragValue::new(&mut self.samples).range(SAMPLES)).labelled_by(label);
        });
        let Some((_, found)) = self.found.as_ref().filter(|(known, _)| *known == of) else { return };
        let largest = found.iter().flat_map(|estimate| estimate.mean).fold(0.0, f64::max);
        let digits = decimals(largest).saturating_sub(1);
        let three = |rgb: [f64; 3]| rgb.map(|c| format!("{c:.digits$}")).join(" ");
        let samples = found.first().map_or(0, |estimate| estimate.samples);
        let mean = format!("mean of {samples}");
        // What is below wraps at the width of the panel, not of the grid.
        let grid = ScrollArea::horizontal().id_salt("strategies");
        let columns = Grid::new("strategies").num_columns(3).spacing([14.0, 2.0]);
        grid.show(ui, |ui| {
            columns.show(ui, |ui| {
                for (head, about) in [
                    ("by strategy", "how paths find light"),
                    (
                        mean.as_str(),
                        "mean of the samples, linear r g b: all strategies have the same, up to their errors",
                    ),
                    ("standard error", "of the mean, as if samples did not depend on each other, r g b"),
                ] {
                    strong(ui, head).on_hover_text(about);
                }
                ui.end_row();
                for estimate in found {
                    ui.label(estimate.strategy.name());
                    for cell in [three(estimate.mean), three(estimate.error)] {
                        ui.monospace(cell);
                    }
                    ui.end_row();
                }
            })
        });
    }
}
