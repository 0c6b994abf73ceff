//! Useful lanes: of every 32 threads that a GPU runs together, the number that have a ray to process.

use egui::Ui;
use raystep_kernels::tables::stream::STATE_TAG;
use raystep_kernels::{Kernel, Pass, Plan};
use raystep_lab::text::counted;
use raystep_lab::work::{LANES, Lanes, Launch};

use crate::session::Edit;
use crate::session::request::{Job, Request, answered, job};
use crate::ui::pane::Context;
use crate::ui::panels::chart::Histogram;
use crate::ui::style::strong;

/// The engine's job, named while it runs.
const COUNTING: &str = "counting useful lanes";

/// The pass to examine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Which {
    /// The last one: it worked from a list, so its number of rays is sufficient.
    Last,
    /// The next one, from the rays' current states.
    Next(Kernel),
}

/// The key of an answer.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Of {
    generation: u64,
    place: usize,
    /// Edits by hand.
    edits: Vec<Edit>,
    which: Which,
}

/// This section of the panel.
#[derive(Default)]
pub(super) struct LanesView {
    asked: Option<Of>,
    known: Option<(Of, Lanes)>,
}

/// The pass that can be examined now; `None` at the end of a run whose last pass worked on tiles.
fn which(plan: &Plan, last: Option<&Pass>, next: Option<Kernel>) -> Option<Which> {
    let is_list = |kernel: Kernel| Launch::of(kernel, &plan.features) == Launch::List;
    if last.is_some_and(|pass| is_list(pass.kernel)) { Some(Which::Last) } else { next.map(Which::Next) }
}

/// A pass that has not run yet, as far as it is known: its kernel, and the rays that wait for it.
fn ahead(index: usize, kernel: Kernel, rays_in: u32) -> Pass {
    Pass { index, rays_in, ..Pass::of(kernel) }
}

impl LanesView {
    /// Computes what it can, asks for the rest, and shows the result.
    pub(super) fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        ui.separator();
        strong(ui, "useful lanes").on_hover_text(
            "Most GPUs run threads in lockstep in groups of 32: threads without a ray wait for those with one.",
        );
        let Some(plan) = cx.model.opened.as_ref().map(|opened| opened.plan.clone()) else { return };
        let Some(which) = which(&plan, cx.model.last_pass(), cx.model.next) else {
            ui.weak(
                "The run is at its end, and its last pass launched every pixel. Step back to see the useful lanes of \
                 the next pass.",
            );
            return;
        };
        let of = Of { generation: cx.model.generation, place: cx.model.place, edits: cx.model.edits.clone(), which };
        self.find(cx, &plan, of);
        let kernel = match which {
            Which::Last => cx.model.last_pass().map_or("?", |pass| pass.kernel.name()),
            Which::Next(kernel) => kernel.name(),
        };
        let title = match which {
            Which::Last => format!("the last pass, {kernel}"),
            Which::Next(_) => format!("the next pass, {kernel}, from the current states"),
        };
        // The old counts stay while the new ones are computed, to avoid flicker.
        let Some((_, lanes)) = &self.known else {
            ui.weak(title);
            return;
        };
        let how = match lanes.launch {
            Launch::List => "one thread per ray in a list: all groups except the last are full",
            Launch::Tiles => "one thread per pixel, 8 × 4 pixels per group",
        };
        ui.label(title).on_hover_text(how);
        ui.horizontal_wrapped(|ui| {
            ui.label(format!("mean {:.1} of {LANES}", lanes.mean())).on_hover_text(counted(lanes.groups(), "group"));
            ui.label(format!("{:.1} in non-empty groups", lanes.mean_where_any()))
                .on_hover_text("groups without a ray end at once and cost little");
            if lanes.launch == Launch::List {
                ui.weak("launched from a list of rays").on_hover_text(how);
            }
        });
        let about =
            |lanes: usize, groups: u64| format!("{} with {lanes} of {LANES} lanes useful", counted(groups, "group"));
        Histogram { counts: &lanes.histogram, name: "groups by useful lanes", about: &about, is_open: false }
            .show(ui, 80.0);
    }

    fn find(&mut self, cx: &mut Context<'_>, plan: &Plan, of: Of) {
        while let Some(answer) = cx.model.take_answer::<(Of, Option<Lanes>)>(COUNTING) {
            let (answered, lanes) = *answer;
            match lanes {
                Some(lanes) if answered.generation == of.generation => self.known = Some((answered, lanes)),
                // The run may return to its previous place.
                _ => self.asked = None,
            }
        }
        if self.known.as_ref().is_some_and(|(known, _)| known.generation != of.generation) {
            self.known = None;
        }
        if self.known.as_ref().is_some_and(|(known, _)| *known == of) {
            return;
        }
        let lanes = match of.which {
            Which::Last => cx.model.last_pass().and_then(|pass| Lanes::of(pass, plan, &[])),
            Which::Next(kernel) if Launch::of(kernel, &plan.features) == Launch::List => {
                let rays = cx.model.last_pass().map_or(0, |pass| kernel.live(&pass.counts));
                Lanes::of(&ahead(of.place, kernel, rays), plan, &[])
            }
            Which::Next(kernel) => {
                if self.asked.as_ref() != Some(&of) && !cx.model.is_busy() {
                    self.asked = Some(of.clone());
                    cx.model.ask(Request::Job(COUNTING, count(of, kernel)));
                }
                return;
            }
        };
        self.known = lanes.map(|lanes| (of, lanes));
    }
}

/// Counts the threads of the next pass that will have work. Returns nothing if the run has moved on.
fn count(of: Of, kernel: Kernel) -> Job {
    job!(job, {
        let renderer = job.session.renderer();
        if job.session.place() != of.place || renderer.next_kernel() != Some(kernel) {
            return answered((of, None::<Lanes>));
        }
        let Some(states) = renderer.plan().program.state_stream() else {
            return answered((of, None::<Lanes>));
        };
        let state = job.session.stream(states).await.map_err(|error| error.to_string())?;
        let lanes = Lanes::of(&ahead(of.place, kernel, 0), renderer.plan(), state.layer(STATE_TAG));
        answered((of, lanes))
    })
}

#[cfg(test)]
mod tests {
    use raystep_kernels::programs::closest_hit::kernels;
    use raystep_kernels::{Limits, Options, RaySource, ScheduleKind};
    use raystep_scenes::generate;

    use super::*;

    fn plan(schedule: ScheduleKind) -> Plan {
        let scene = generate::cornell_box();
        let camera = scene.cameras[0].clone();
        let mut options = Options::new(RaySource::Camera { camera, width: 16, height: 8 });
        (options.schedule, options.steps_per_pass) = (schedule, 1);
        Plan::new(&scene, &options, &Limits::CPU).expect("a small scene").0
    }

    #[test]
    fn a_pass_from_a_list_is_told_by_itself_and_any_other_before_it_runs() {
        let (walk, setup) = (ahead(3, kernels::INTERSECT, 70), ahead(1, kernels::SETUP, 128));
        let compact = plan(ScheduleKind::Compact);
        let next = Some(kernels::TRAVERSE_GRID);
        assert_eq!(which(&compact, Some(&walk), next), Some(Which::Last));
        assert_eq!(which(&compact, Some(&setup), next), Some(Which::Next(kernels::TRAVERSE_GRID)));
        assert_eq!(which(&compact, None, Some(kernels::GENERATE)), Some(Which::Next(kernels::GENERATE)));
        let second = plan(ScheduleKind::Second);
        assert_eq!(which(&second, Some(&walk), next), Some(Which::Next(kernels::TRAVERSE_GRID)));
        assert_eq!(which(&second, Some(&walk), None), None);
    }
}
