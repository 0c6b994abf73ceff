//! What a run came to: its passes, and the final streams of its results.

use std::ops::ControlFlow;
use std::sync::Arc;

use raystep_kernels::program::Results;
use raystep_kernels::shared::constants::NO_TRIANGLE;
use raystep_kernels::{Device, Options, Pass, Plan, Progress, RenderError, Renderer, Stream, StreamData};
use raystep_scenes::Scene;

use super::recipe::{Recipe, RunId};
use super::scene_hash;
use crate::session::request::{Job, JobContext, answered, flow, job};
use crate::session::{Session, Target, go_on};
use crate::settings::{Settings, traces_rays};

/// The engine's job that keeps a run, named while it runs.
pub const KEEPING: &str = "keeping the run";

/// What a run came to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// Its passes, with their times if the device has a valid clock.
    pub passes: Vec<Pass>,
    /// Number of rays; 0 in a program without.
    pub rays: u64,
    /// Number of rays that hit; of the last sample, if there are several.
    pub hits: Option<u64>,
    /// The name of its device.
    pub device: String,
    /// Why its passes have no times; `None` if they have.
    pub why_no_times: Option<String>,
}

impl Outcome {
    /// Device time of all passes; `None` unless each was timed.
    #[must_use]
    pub fn device_ns(&self) -> Option<u64> {
        let times = self.passes.iter().map(|pass| pass.duration_ns);
        times.sum::<Option<u64>>().filter(|_| !self.passes.is_empty())
    }

    /// Bytes of memory that it takes.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        size_of_val(self.passes.as_slice()) as u64
    }
}

/// The final streams of a run's results: hits, colour, costs.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Where results are in the streams.
    pub results: Results,
    /// The streams, each once.
    pub streams: Vec<StreamData>,
    /// Factor from t in the streams to t in scene units.
    pub t_scale: f64,
}

impl Picture {
    /// The streams that are kept, as far as a plan has them.
    fn streams_of(plan: &Plan) -> Vec<Stream> {
        let Some(results) = plan.program.results else { return Vec::new() };
        let mut streams = Vec::new();
        for stream in [results.color, results.triangle.stream, results.t.stream, results.counters] {
            if plan.has_stream(stream) && !streams.contains(&stream) {
                streams.push(stream);
            }
        }
        streams
    }

    /// Bytes that the picture of a run with this plan would take.
    #[must_use]
    pub fn bytes_of(plan: &Plan) -> u64 {
        let texels = u64::from(plan.width) * u64::from(plan.height);
        let bytes = |stream: Stream| stream.bytes(texels).unwrap_or(u64::MAX);
        Self::streams_of(plan).into_iter().map(bytes).fold(0, u64::saturating_add)
    }

    /// Bytes of memory that it takes.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.streams.iter().map(|stream| size_of_val(stream.bits.as_slice()) as u64).sum()
    }

    /// Width and height.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.streams.first().map_or([0; 2], |stream| [stream.width, stream.height])
    }

    /// A stream, if it was kept.
    #[must_use]
    pub fn stream(&self, stream: Stream) -> Option<&StreamData> {
        self.streams.iter().find(|data| data.stream == stream)
    }

    /// The streams that were kept, by name.
    #[must_use]
    pub fn names(&self) -> String {
        self.streams.iter().map(|data| data.stream.name()).collect::<Vec<_>>().join(", ")
    }

    fn hits(&self) -> Option<u64> {
        let of = self.results.triangle;
        let ids = self.stream(of.stream)?.layer(of.layer);
        Some(ids.iter().filter(|&&id| id != NO_TRIANGLE).count() as u64)
    }
}

/// A run that was recorded, with everything that identifies it.
pub struct Recorded {
    /// The kept run that was run again; `None` if it is new.
    pub again: Option<RunId>,
    /// How to run it again.
    pub recipe: Recipe,
    /// Its scene.
    pub scene: Arc<Scene>,
    /// The scene's hash.
    pub hash: String,
    /// What it came to.
    pub outcome: Outcome,
    /// Its picture, or why there is none.
    pub picture: Result<Picture, String>,
}

/// Reads what a session at its end has come to. A picture of more than `most` bytes is left out.
async fn record(session: &Session, device: &Device, most: u64) -> Result<(Outcome, Result<Picture, String>), String> {
    let renderer = session.renderer();
    let plan = renderer.plan();
    let picture = match (plan.program.results, Picture::bytes_of(plan)) {
        (None, _) => Err(format!("the program {} traces no rays, so there is no picture to keep", plan.program.name)),
        (Some(_), bytes) if bytes > most => Err(format!(
            "its picture takes {}, more than the budget of {}",
            raystep_kernels::plan::Bytes(bytes),
            raystep_kernels::plan::Bytes(most)
        )),
        (Some(results), _) => {
            let mut streams = Vec::new();
            for stream in Picture::streams_of(plan) {
                streams.push(session.stream(stream).await.map_err(|e| e.to_string())?);
            }
            Ok(Picture { results, streams, t_scale: renderer.t_scale(0) })
        }
    };
    let (name, why_no_times) = match device {
        Device::Gpu(gpu) => (gpu.info.name.clone(), gpu.why_no_times()),
        Device::Cpu(clock) | Device::CpuF64(clock) => {
            ("CPU".into(), clock.is_none().then(|| "the host provided no clock".into()))
        }
    };
    let outcome = Outcome {
        passes: session.passes().to_vec(),
        rays: if traces_rays(plan.program) { plan.rays } else { 0 },
        hits: picture.as_ref().ok().and_then(Picture::hits),
        device: name,
        why_no_times,
    };
    Ok((outcome, picture))
}

/// Progress of a run, as an engine wants it.
pub(super) fn teller(
    progress: &mut (dyn FnMut(u64, u64) -> bool + Send),
) -> impl FnMut(&Progress) -> ControlFlow<()> + Send {
    move |at| flow(progress(at.rays_decided, at.rays))
}

/// Completes the session's run, records it, and returns to the session's place. `known`: the scene's hash.
#[must_use]
pub fn keep(known: Option<String>, most: u64) -> Job {
    job!(context, {
        let JobContext { session, scene, settings, device, progress, .. } = context;
        let here = session.place();
        let ran = session.step(Target::End, &mut teller(progress)).await;
        let recorded = match ran {
            Ok(_) => record(session, &device, most).await,
            Err(error) => Err(error.to_string()),
        };
        // Returns even if it was stopped: keeping a run must not move the user's view.
        session.step(Target::Pass(here), &mut go_on).await.map_err(|e| e.to_string())?;
        let (outcome, picture) = recorded?;
        let recipe =
            Recipe { settings: settings.clone(), edits: session.edits().to_vec(), twins: session.twin_passes() };
        let (scene, hash) = (scene.clone(), known.unwrap_or_else(|| scene_hash(scene).to_string()));
        answered(Recorded { again: None, recipe, scene, hash, outcome, picture })
    })
}

/// A session of its own for a recipe, at its start, and its device: the engine's session stays where it is.
pub(super) async fn begin(
    session: &Session,
    (scene, settings): (&Scene, &Settings),
    recipe: &Recipe,
    (device, clock): (&Device, Option<fn() -> u64>),
) -> Result<Session, RenderError> {
    if let (Device::Gpu(gpu), Some(clock)) = (device, clock) {
        gpu.check_clock(clock).await?;
    }
    let options = Options { keep_passes: true, ..recipe.settings.options(scene) };
    let renderer = if *settings == recipe.settings {
        session.renderer().another(&options, device).await?
    } else {
        Renderer::new(scene, &options, device).await?
    };
    let mut own = Session::from_renderer(renderer, &options);
    // It never goes back: checkpoints would only take time.
    own.set_budget(0);
    own.set_span(u64::MAX);
    own.set_edits(recipe.edits.clone(), &mut go_on).await?;
    own.twins_until(recipe.twins, &mut go_on).await?;
    Ok(own)
}

/// Runs a recipe in a session of its own, and records it.
#[must_use]
pub fn again(id: RunId, recipe: Recipe, device: Device, clock: Option<fn() -> u64>, most: u64) -> Job {
    job!(context, {
        let JobContext { session, scene, settings, progress, .. } = context;
        let own = begin(session, (scene, settings), &recipe, (&device, clock)).await;
        let mut own = own.map_err(|e| e.to_string())?;
        own.step(Target::End, &mut teller(progress)).await.map_err(|e| e.to_string())?;
        let (outcome, picture) = record(&own, &device, most).await?;
        let (scene, hash) = (scene.clone(), scene_hash(scene).to_string());
        answered(Recorded { again: Some(id), recipe, scene, hash, outcome, picture })
    })
}

#[cfg(test)]
pub(super) mod tests {
    use raystep_kernels::Choices;

    use super::*;

    /// The outcome of a run on the CPU.
    fn recorded(scene: &Scene, settings: &Settings, most: u64) -> (Outcome, Result<Picture, String>) {
        let device = Device::Cpu(None);
        pollster::block_on(async {
            let mut session = Session::new(scene, &settings.options(scene), &device).await.expect("a run");
            session.step(Target::End, &mut go_on).await.expect("its end");
            record(&session, &device, most).await.expect("results")
        })
    }

    /// The picture of a run on the CPU.
    pub(in crate::runs) fn picture(scene: &Scene, settings: &Settings) -> Picture {
        recorded(scene, settings, u64::MAX).1.expect("a picture")
    }

    #[test]
    fn pictures_have_the_size_that_is_expected_of_them_or_are_left_out() {
        let scene = raystep_scenes::generate::cornell_box();
        let settings = Settings { size: [16, 8], ..Settings::default() };
        // A budget that it just fits into.
        let (outcome, picture) = recorded(&scene, &settings, 16 * 8 * 4 * 13);
        let picture = picture.expect("a picture");
        // Three layers of colour, hit and counters, four of state.
        assert_eq!((picture.bytes(), picture.size()), (16 * 8 * 4 * 13, [16, 8]));
        assert_eq!((outcome.rays, outcome.device_ns(), outcome.why_no_times.is_some()), (128, None, true));
        let (outcome, picture) = recorded(&scene, &settings, 16 * 8 * 4 * 13 - 1);
        assert!(picture.is_err_and(|why| why.contains("budget")) && !outcome.passes.is_empty());
        let build = Settings {
            choices: Choices { program: raystep_kernels::options::ProgramName::GridBuild, ..settings.choices },
            ..settings
        };
        let (outcome, picture) = recorded(&scene, &build, u64::MAX);
        assert!(picture.is_err_and(|why| why.contains("traces no rays")) && !outcome.passes.is_empty());
        assert_eq!((outcome.rays, outcome.hits), (0, None));
    }
}
