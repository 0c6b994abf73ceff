//! A run of a scene, stepped forwards and backwards.

use std::ffi::OsString;
use std::sync::Arc;

use numpy::PyArray1;
use pollster::block_on;
use pyo3::prelude::*;
use raystep_app::api::{self, Failure};
use raystep_kernels::export::Recorded;
use raystep_kernels::export::csv::RunContext;
use raystep_kernels::export::plan::plan;
use raystep_kernels::export::structure::Structure;
use raystep_kernels::history::{Rays, trace};
use raystep_kernels::plan::PlanText;
use raystep_kernels::programs::own;
use raystep_kernels::renderer::CounterSums;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::tables::elements::Count;
use raystep_kernels::tables::stream::Texel;
use raystep_kernels::{self as kernels, Options, Plan, Stream};
use raystep_lab::Machine;
use raystep_lab::outside::{MISSES_ALL, misses_all};
use raystep_lab::rough::drawn_as_diffuse;
use raystep_scenes as scenes;

use crate::border::{Turns, Watcher, detached};
use crate::error::{DeviceError, OptionError, SceneError, of_request};
use crate::scene::Scene;
use crate::travel::Run;

/// Index, sample, iteration, kernel, rays in, rays in each state, threads, begin, duration, bound of the duration.
type PassParts =
    (usize, u32, u32, &'static str, u32, Vec<(&'static str, u32)>, u64, Option<u64>, Option<u64>, Option<u64>);

/// Name, components, their meanings, whether texels are floats, unit.
type StreamParts = (&'static str, Vec<&'static str>, Vec<String>, bool, &'static str);

/// The bits of a stream, its columns and rows, and the number of its elements.
type Values<'py> = (Bound<'py, PyArray1<u32>>, u32, u32, Option<u32>);

/// A run between two passes.
#[pyclass(frozen, module = "raystep._raystep")]
pub(crate) struct Renderer {
    scene: Arc<scenes::Scene>,
    pub(crate) machine: Machine,
    pub(crate) options: Options,
    pub(crate) plan: Arc<Plan>,
    data: Arc<SceneData>,
    pub(crate) run: Turns<Run>,
    run_id: String,
    notes: Vec<String>,
}

#[pymethods]
impl Renderer {
    /// Plans, builds and compiles; `words` are options of the command line.
    #[new]
    fn new(py: Python<'_>, scene: &Scene, words: Vec<OsString>) -> PyResult<Self> {
        detached(py, || {
            let mut words = words;
            words.push(format!("--device={}", scene.machine.kind()).into());
            let (options, mut notes) = api::run_options(&scene.scene, &words).map_err(|failure| match failure {
                Failure::Usage(line) => OptionError::new_err(line),
                Failure::Failed(line) => SceneError::new_err(line),
            })?;
            let options = Options { folder: scene.folder.clone(), ..options };
            let machine = scene.machine.clone();
            let renderer = block_on(kernels::Renderer::new(&scene.scene, &options, &machine.device));
            let renderer = renderer.map_err(|error| of_request(&error))?;
            if options.traces_rays() && misses_all(&scene.scene, &options, renderer.plan()) {
                notes.push(MISSES_ALL.to_owned());
            }
            notes.extend(drawn_as_diffuse(&scene.scene, &options).filter(|_| options.traces_rays()));
            notes.extend(machine.note_on_times().filter(|_| options.timings));
            let (plan, data) = (renderer.shared_plan(), renderer.shared_data());
            let run = Turns::new(Run::new(renderer));
            Ok(Self { scene: scene.scene.clone(), machine, options, plan, data, run, run_id: api::run_id(), notes })
        })
    }

    /// Notes on the options.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// Width and height in pixels.
    #[getter]
    fn size(&self) -> [u32; 2] {
        [self.plan.width, self.plan.height]
    }

    /// Passes so far.
    fn pass_count(&self, py: Python<'_>) -> PyResult<usize> {
        self.run.take(py, |run| Ok(run.renderer.pass_count()))
    }

    /// Passes, rays decided, rays, samples, and samples at the end.
    fn progress(&self, py: Python<'_>) -> PyResult<(usize, u64, u64, u32, u32)> {
        let now = self.run.take(py, |run| Ok(run.renderer.progress()))?;
        Ok((now.passes, now.rays_decided, now.rays, now.samples, now.samples_wanted))
    }

    /// Whether no pass is left.
    fn is_complete(&self, py: Python<'_>) -> PyResult<bool> {
        self.run.take(py, |run| Ok(run.renderer.next_kernel().is_none()))
    }

    /// Runs to a place, forwards or backwards.
    fn go(&self, py: Python<'_>, place: usize, callback: Option<Py<PyAny>>) -> PyResult<()> {
        self.run.take(py, |run| arrive(run, place, Watcher::new(callback)))
    }

    /// Runs the next pass; `None` if none is left.
    fn step(&self, py: Python<'_>) -> PyResult<Option<PassParts>> {
        self.run.take(py, |run| {
            let place = run.renderer.pass_count() + 1;
            arrive(run, place, Watcher::new(None))?;
            Ok(run.renderer.passes().get(place - 1).map(|pass| self.parts(pass)))
        })
    }

    /// Goes back by a pass, and returns the one before it; `None` at the start.
    fn back(&self, py: Python<'_>) -> PyResult<Option<PassParts>> {
        self.run.take(py, |run| {
            let place = run.renderer.pass_count().saturating_sub(1);
            arrive(run, place, Watcher::new(None))?;
            Ok(run.renderer.passes().last().map(|pass| self.parts(pass)))
        })
    }

    /// The streams of the plan.
    fn streams(&self) -> Vec<StreamParts> {
        let parts = |stream: Stream| {
            let info = stream.info();
            let meanings = info.meaning.iter().map(|meaning| format!("{meaning:?}").to_lowercase());
            (info.name, info.layers.to_vec(), meanings.collect(), info.texel == Texel::F32, info.unit)
        };
        self.plan.streams.iter().map(|planned| parts(planned.what)).collect()
    }

    /// A stream's values, layer by layer, as bits; its columns, rows, and the number of its elements if they are one after the
    /// other, and not the pixels of an image.
    fn values<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Values<'py>> {
        let stream = self.plan.streams.iter().map(|planned| planned.what).find(|stream| stream.name() == name);
        let stream = stream.ok_or_else(|| OptionError::new_err(format!("{name}: this run has no such stream")))?;
        let elements = stream.info().elements;
        let (values, count) = self.run.take(py, |run| {
            let count = run.renderer.size(elements).map(|size| size.count);
            let values = block_on(run.renderer.values(stream)).map_err(|error| of_request(&error))?;
            Ok((values, count))
        })?;
        let count = count.filter(|_| elements.count != Count::Image);
        Ok((PyArray1::from_vec(py, values.bits), values.width, values.height, count))
    }

    /// The stream of a user's program that is its result, and the layer; `None` for a colour.
    fn result(&self) -> Option<(&'static str, Option<usize>)> {
        let own = own::read(self.options.folder.as_ref()?).ok()?;
        own.result.map(|result| (result.stream.name(), result.layer))
    }

    /// The image so far: r, g, b, a per pixel.
    fn image<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let pixels = self.run.take(py, |run| {
            let image = block_on(run.renderer.image());
            image.map(|image| image.pixels).map_err(|error| of_request(&error))
        })?;
        Ok(PyArray1::from_vec(py, pixels.into_flattened()))
    }

    /// The history of a pixel's ray, as CSV.
    fn history(&self, py: Python<'_>, x: u32, y: u32) -> PyResult<String> {
        let [width, height] = self.size();
        if x >= width || y >= height {
            let message = format!("pixel {x},{y}: the image has pixels 0,0 to {},{}", width - 1, height - 1);
            return Err(OptionError::new_err(message));
        }
        if !self.options.schedule.is_stepped() {
            return Err(OptionError::new_err(
                "--schedule fused traces a ray in one pass, so there are no steps to follow; use first, second or compact",
            ));
        }
        self.run.take(py, |run| {
            let mut watcher = Watcher::new(None);
            let result = block_on(async {
                let side = run.side(&self.options, &self.machine.device).await?;
                trace(side, x, y, Rays::One, |_| watcher.ask()).await
            });
            let trace = watcher.finish(result)?;
            let mut csv = Vec::new();
            trace.write_csv(&mut csv).map_err(|e| DeviceError::new_err(format!("cannot write as CSV: {e}")))?;
            Ok(String::from_utf8_lossy(&csv).into_owned())
        })
    }

    /// The plan as text and as JSON.
    fn plan(&self, py: Python<'_>) -> PyResult<(String, String)> {
        detached(py, || {
            let asked = self.options.accelerator;
            let text = PlanText(&self.plan, &Structure::of(asked, &self.plan, &self.data)).to_string();
            let json = serde_json::to_string(&plan(asked, &self.plan, &self.data));
            Ok((text, json.map_err(|e| DeviceError::new_err(format!("cannot write as JSON: {e}")))?))
        })
    }

    /// `passes.csv` of the passes so far.
    fn timings(&self, py: Python<'_>) -> PyResult<String> {
        let csv = self.run.take(py, |run| {
            let counted = self.counted(run)?;
            let renderer = &run.renderer;
            let context = self.machine.run_context(self.run_id.clone(), &self.scene, &self.options, renderer.plan());
            let context = RunContext { host_run_ns: renderer.host_ns(), ..context };
            let csv = Recorded::of(&context, renderer, &counted).csv();
            csv.map_err(|e| DeviceError::new_err(format!("cannot write as CSV: {e}")))
        })?;
        Ok(String::from_utf8_lossy(&csv).into_owned())
    }
}

impl Renderer {
    fn parts(&self, pass: &kernels::Pass) -> PassParts {
        let states = self.plan.program.states.iter().map(|state| (state.name, pass.counts[state.tag as usize]));
        let kernels::Pass { index, sample, iteration, rays_in, threads_launched, begin_ns, duration_ns, .. } = *pass;
        let (kernel, states) = (pass.kernel.name(), states.collect());
        (index, sample, iteration, kernel, rays_in, states, threads_launched, begin_ns, duration_ns, pass.below_ns())
    }

    /// What each pass so far has added to the counters, by another run; nothing if rays are not counted.
    fn counted(&self, run: &mut Run) -> PyResult<Vec<CounterSums>> {
        if self.plan.counters().is_none() {
            return Ok(Vec::new());
        }
        let (place, mut watcher) = (run.renderer.pass_count(), Watcher::new(None));
        let result = block_on(async {
            let side = run.side(&self.options, &self.machine.device).await?;
            side.restart();
            side.count_passes(place, |_| watcher.ask()).await
        });
        watcher.finish(result)
    }

    /// Another run with the same plan, at its start.
    pub(crate) fn another(&self, py: Python<'_>) -> PyResult<kernels::Renderer> {
        let options = Options { timings: false, ..self.options.clone() };
        let device = &self.machine.device;
        self.run.take(py, |run| {
            let another = block_on(run.renderer.another(&options, device));
            another.map_err(|error| of_request(&error))
        })
    }
}

/// Goes to a place, unless the watcher ends it. A thread polls a GPU meanwhile: several runs may use it at a time.
fn arrive(run: &mut Run, place: usize, mut watcher: Watcher) -> PyResult<()> {
    let result = block_on(run.go(place, &mut watcher));
    watcher.finish(result)
}
