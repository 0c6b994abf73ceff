//! From the command line to a prepared run.

use std::path::PathBuf;
use std::time::Instant;

use raystep_kernels::export::Recorded;
use raystep_kernels::export::csv::RunContext;
use raystep_kernels::export::json::RunOptions;
use raystep_kernels::export::structure::Structure;
use raystep_kernels::plan::Plan;
use raystep_kernels::renderer::CounterSums;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::{Choices, Options, RaySource, Renderer};
use raystep_lab::Machine;
use raystep_lab::outside::{MISSES_ALL, misses_all};
use raystep_lab::rough::drawn_as_diffuse;
use raystep_scenes::Scene;

use crate::args::choices::{ChoiceArgs, What};
use crate::args::{RunArgs, SceneArgs, ViewArgs};
use crate::device;
use crate::error::Error;
use crate::scene_file::{self, SceneFile};
use crate::terminal::Progress;

/// Seconds per stage, in order.
#[derive(Debug)]
pub(crate) struct Stopwatch {
    last: Instant,
    /// Name and seconds.
    pub(crate) stages: Vec<(&'static str, f64)>,
}

impl Stopwatch {
    pub(crate) fn start() -> Self {
        Self { last: Instant::now(), stages: Vec::new() }
    }

    /// Ends a stage.
    pub(crate) fn lap(&mut self, stage: &'static str) {
        self.stages.push((stage, self.last.elapsed().as_secs_f64()));
        self.last = Instant::now();
    }
}

/// A planned run.
pub(crate) struct Session {
    /// The scene's file as the user wrote it.
    pub(crate) scene_path: PathBuf,
    /// The scene as it was read.
    pub(crate) scene: Scene,
    /// The files that were read.
    pub(crate) inputs: Vec<PathBuf>,
    /// The options.
    pub(crate) options: Options,
    /// The device.
    pub(crate) chosen: Machine,
    /// The plan.
    pub(crate) plan: Plan,
    /// The scene data for kernels.
    pub(crate) data: SceneData,
    /// Times of the stages so far.
    pub(crate) watch: Stopwatch,
}

impl Session {
    /// Reads the scene, prints its notes, selects a device and plans. `adjust` can override options.
    pub(crate) fn new(
        scene: &SceneArgs,
        view: &ViewArgs,
        run: &RunArgs,
        progress: &Progress,
        adjust: impl FnOnce(&Scene, &mut Options),
    ) -> Result<Self, Error> {
        Self::of(scene, scene_file::read, view, run, progress, adjust)
    }

    /// The same with a scene or a program's folder.
    pub(crate) fn of_any(
        scene: &SceneArgs,
        view: &ViewArgs,
        run: &RunArgs,
        progress: &Progress,
        adjust: impl FnOnce(&Scene, &mut Options),
    ) -> Result<Self, Error> {
        Self::of(scene, scene_file::read_any, view, run, progress, adjust)
    }

    /// The same with a choice of the program, to be stepped pass by pass.
    pub(crate) fn stepped(
        scene: &SceneArgs,
        program: &ChoiceArgs<What>,
        view: &ViewArgs,
        run: &RunArgs,
        progress: &Progress,
    ) -> Result<Self, Error> {
        Self::of_any(scene, view, run, progress, |_, options| {
            let Choices { program, elements, .. } = program.values;
            (options.program, options.elements) = (program, elements);
            if !run.tracing.has("steps-per-pass") {
                options.steps_per_pass = 1;
            }
        })
    }

    fn of(
        scene: &SceneArgs,
        read: fn(&SceneArgs) -> Result<SceneFile, Error>,
        view: &ViewArgs,
        run: &RunArgs,
        progress: &Progress,
        adjust: impl FnOnce(&Scene, &mut Options),
    ) -> Result<Self, Error> {
        run.check(view)?;
        let replaced = run.kernels.read()?;
        let mut watch = Stopwatch::start();
        progress.stage("reading the scene");
        let scene_path = scene.scene.clone();
        let SceneFile { folder, scene, inputs, .. } = read(scene)?;
        for note in &scene.notes {
            progress.say(format_args!("note: {}", note.0));
        }
        let (camera, note) = scene_file::camera(&view.camera, &scene)?;
        if let Some(note) = note {
            progress.say(format_args!("note: {note}"));
        }
        watch.lap("load");
        progress.stage("looking for a device");
        let device = run.device();
        let chosen = device::choose(&if folder.is_some() { device.for_users() } else { device })?;
        watch.lap("device");
        let rays = RaySource::Camera { camera, width: view.size.width, height: view.size.height };
        let choices = run.choices_on(view, &chosen);
        if choices != run.choices(view) {
            let Choices { mapping, scene_data, schedule, .. } = choices;
            progress.say(format_args!(
                "note: {} has no compute shaders, so kernels are drawn: --mapping {} --scene-data {scene_data} \
                 --schedule {schedule}",
                chosen.name(),
                mapping.name(),
            ));
        }
        let mut options = Options { replaced, folder, ..Options::new(rays).chosen(&choices) };
        adjust(&scene, &mut options);
        progress.stage("planning and building");
        let (plan, data) = chosen.wait(Plan::on(&scene, &options, &chosen.device))?;
        watch.lap("plan_and_grid");
        if options.traces_rays() && misses_all(&scene, &options, &plan) {
            progress.say(format_args!("note: {MISSES_ALL}"));
        }
        if let Some(note) = drawn_as_diffuse(&scene, &options) {
            progress.say(format_args!("note: {note}"));
        }
        Ok(Self { scene_path, scene, inputs, options, chosen, plan, data, watch })
    }

    /// Compiles, allocates and uploads.
    pub(crate) fn start(self, progress: &Progress) -> Result<Running, Error> {
        let Self { scene_path, scene, options, chosen, plan, data, mut watch, .. } = self;
        progress.stage("compiling kernels");
        let renderer = chosen.wait(Renderer::from_plan(plan, data, &options, &chosen.device))?;
        watch.lap("compile_and_upload");
        Ok(Running { run_id: run_id(), scene_path, scene, options, chosen, renderer, watch })
    }
}

/// A run between two passes.
pub(crate) struct Running {
    /// A unique id.
    pub(crate) run_id: String,
    /// The scene's file as the user wrote it.
    pub(crate) scene_path: PathBuf,
    /// The scene as it was read.
    pub(crate) scene: Scene,
    /// The options.
    pub(crate) options: Options,
    /// The device.
    pub(crate) chosen: Machine,
    /// The run.
    pub(crate) renderer: Renderer,
    /// Times of the stages.
    pub(crate) watch: Stopwatch,
}

impl Running {
    /// The acceleration structure.
    pub(crate) fn structure(&self) -> Structure {
        Structure::of(self.options.accelerator, self.renderer.plan(), self.renderer.data())
    }

    /// The options that determine a run, for reports.
    pub(crate) fn run_options(&self) -> RunOptions {
        let (options, plan) = (&self.options, self.renderer.plan());
        RunOptions {
            scene_path: self.scene_path.to_string_lossy().into_owned(),
            choices: options.choices(),
            width_px: plan.width,
            height_px: plan.height,
            counters: options.counters,
        }
    }

    /// The columns that all rows of `passes.csv` share.
    pub(crate) fn run_context(&self) -> RunContext {
        let context = self.chosen.run_context(self.run_id.clone(), &self.scene, &self.options, self.renderer.plan());
        RunContext { host_run_ns: self.renderer.host_ns(), ..context }
    }

    /// The passes so far as `passes.csv`; `counted` is what each of them has added to the counters, if known.
    pub(crate) fn passes_csv(&self, run: &RunContext, counted: &[CounterSums]) -> Result<Vec<u8>, Error> {
        let csv = Recorded::of(run, &self.renderer, counted).csv();
        csv.map_err(|e| Error::failed(format!("cannot write the passes: {e}")))
    }
}

/// A unique id from the time of day and the process.
pub(crate) fn run_id() -> String {
    let since_1970 = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    format!("{:x}-{:x}", since_1970.as_nanos(), std::process::id())
}
