//! The same ray's walk through the other structure: from the run that this one is compared with, or by the CPU reference
//! kernels, which need that structure but no run.

use std::sync::Arc;

use raystep_kernels::export::trace::Trace;
use raystep_kernels::history::RunSoFar;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::{Accelerator, Limits, Plan};

use crate::session::request::{Job, Opened, Request, answered, job};
use crate::settings::{DeviceKind, Settings};
use crate::ui::pane::Context;
use crate::walk::row_after_passes;

/// The engine's job, named while it runs.
const BUILDING: &str = "building the other structure";

/// The scene with another structure.
struct Built {
    generation: u64,
    plan: Plan,
    data: Arc<SceneData>,
}

/// A ray in it.
type Followed = (u64, [u32; 2], Option<Arc<Trace>>);

/// Finds the second walk.
#[derive(Default)]
pub(super) struct Second {
    /// The run for which the job was asked.
    asked: Option<u64>,
    built: Option<Built>,
    followed: Option<Followed>,
}

/// A second walk.
#[derive(Clone)]
pub(super) struct Found {
    pub(super) history: Arc<Trace>,
    pub(super) data: Arc<SceneData>,
    pub(super) name: String,
    /// The row that a second run is at; the last one without such a run.
    pub(super) row: Option<usize>,
    /// Whether there is a second run, which can be stepped.
    pub(super) is_run: bool,
}

/// The structure that a run is compared with.
pub(super) fn other_of(opened: &Opened) -> Accelerator {
    if opened.plan.accelerator == Accelerator::Grid { Accelerator::Bvh } else { Accelerator::Grid }
}

impl Second {
    /// The walk, or why there is none yet.
    pub(super) fn find(&mut self, pixel: [u32; 2], cx: &mut Context<'_>) -> Result<Found, &'static str> {
        if let Some(found) = of_run(pixel, cx) {
            return Ok(found);
        }
        let Some(opened) = cx.model.opened.clone() else { return Err("no scene is open") };
        let generation = cx.model.generation;
        if let Some(built) = cx.model.take_answer::<Built>(BUILDING)
            && built.generation == generation
        {
            self.built = Some(*built);
        }
        let Some(built) = self.built.as_ref().filter(|built| built.generation == generation) else {
            self.built = None;
            if self.asked != Some(generation) {
                self.asked = Some(generation);
                cx.model.ask(Request::Job(BUILDING, build(generation)));
            }
            return Err(match cx.model.is_busy() {
                true => "The other structure is being built …",
                false => "The other structure could not be built; see the log.",
            });
        };
        if self.followed.as_ref().is_none_or(|(of, at, _)| (*of, *at) != (generation, pixel)) {
            let run = RunSoFar { plan: &built.plan, data: &built.data, passes: &[], is_complete: false };
            let history = match opened.settings.device {
                DeviceKind::CpuF64 => run.follow::<f64>(pixel),
                DeviceKind::Auto | DeviceKind::Gpu | DeviceKind::Cpu => run.follow::<f32>(pixel),
            };
            self.followed = Some((generation, pixel, history.map(Arc::new)));
        }
        let history = self.followed.as_ref().and_then(|(.., history)| history.clone());
        let history = history.filter(|history| !history.rows.is_empty());
        let Some(history) = history else {
            return Err("This ray cannot be followed alone: open a second run (Ctrl+B).");
        };
        let row = history.rows.len().checked_sub(1);
        let name = built.plan.accelerator.to_string();
        Ok(Found { history, data: built.data.clone(), name, row, is_run: false })
    }
}

/// The walk in the run that this one is compared with, if it has the same ray.
fn of_run(pixel: [u32; 2], cx: &Context<'_>) -> Option<Found> {
    let (other, opened) = (cx.other.as_deref()?, cx.model.opened.as_ref()?);
    let second = other.opened.as_ref()?;
    let seen = |settings: &Settings| (settings.size, settings.view, settings.ray);
    let is_same = Arc::ptr_eq(&second.scene, &opened.scene) && seen(&second.settings) == seen(&opened.settings);
    let history =
        other.history.clone().filter(|history| is_same && history.pixel == pixel && !history.rows.is_empty())?;
    let row = row_after_passes(&history, other.place);
    let (data, name) = (second.data.clone(), second.plan.accelerator.to_string());
    Some(Found { history, data, name, row, is_run: true })
}

/// Builds the other structure for the same view.
fn build(generation: u64) -> Job {
    job!(job, {
        let (scene, settings) = (job.scene.clone(), job.settings.clone());
        let grid = settings.options(&scene).accelerator == Accelerator::Grid;
        let accelerator = if grid { Accelerator::Bvh } else { Accelerator::Grid };
        let options = settings.through(accelerator).options(&scene);
        let (plan, data) = Plan::new(&scene, &options, &Limits::CPU).map_err(|e| e.to_string())?;
        answered(Built { generation, plan, data: Arc::new(data) })
    })
}
