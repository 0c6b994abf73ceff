//! Requests to an engine, and its answers.

use std::ops::ControlFlow;
use std::sync::Arc;

use raystep_kernels::executor::gpu::StreamTexture;
use raystep_kernels::export::trace::Trace;
use raystep_kernels::plan::Plan;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::{DrawTime, Kernel, Pass, Stream};
use raystep_lab::layer_stats::LayerStats;
use raystep_scenes::Scene;

use super::measure::Measure;
use super::{Direction, Edit, Fired, Sketch, Subject, Target, Watch};
use crate::settings::Settings;
use raystep_kernels::options::folder::Folder;

/// Reads a scene; the error is one line.
pub type Loader = Box<dyn FnOnce(OnRead) -> Loading + Send>;

/// The future of a [`Loader`].
pub type Loading = std::pin::Pin<Box<dyn Future<Output = Result<Loaded, String>> + Send>>;

/// What a [`Loader`] has read.
pub struct Loaded {
    /// The scene; empty for a program that needs none.
    pub scene: Arc<Scene>,
    /// The user's program.
    pub folder: Option<Arc<Folder>>,
}

impl From<Scene> for Loaded {
    fn from(scene: Scene) -> Self {
        Self { scene: Arc::new(scene), folder: None }
    }
}

impl From<Folder> for Loaded {
    fn from(folder: Folder) -> Self {
        let scene = Scene { name: folder.name.clone(), ..Scene::default() };
        Self { scene: Arc::new(scene), folder: Some(Arc::new(folder)) }
    }
}

/// Called by a loader that takes long: bytes read so far, and in total, 0 if that is not known. It returns whether to go
/// on.
pub type OnRead = Box<dyn FnMut(u64, u64) -> bool + Send>;

/// A loader that reads the scene at once, where it may block.
pub fn at_once(read: impl FnOnce() -> Result<Scene, String> + Send + 'static) -> Loader {
    Box::new(|_| Box::pin(async { read().map(Loaded::from) }))
}

/// A request. Requests are served one after the other.
pub enum Request {
    /// Reads a scene and prepares a run; if the new scene cannot be read, the old run stays.
    Open {
        /// The user's name for it, for [`Opened::path`].
        path: String,
        /// Its loader.
        load: Loader,
        /// The settings of the run.
        settings: Box<Settings>,
    },
    /// Prepares a run of the same scene and goes to the place of the run before, which stays until then.
    Plan(Box<Settings>),
    /// Traces a picture at a lower resolution, in a run of its own.
    Glimpse(Box<Settings>),
    /// Takes over a scene that another engine has read.
    Share(Arc<Scene>, Box<Settings>),
    /// Goes to a place.
    Step(Target),
    /// Runs to where one of the watches fires.
    RunToWatch {
        /// The watches.
        watches: Vec<Watch>,
        /// The direction.
        direction: Direction,
    },
    /// Edits a component of a ray's texel at the current place: stream, layer, pixel, bits.
    Edit(Stream, usize, [u32; 2], u32),
    /// Undoes all edits.
    ClearEdits,
    /// Runs the first passes on the CPU reference.
    TwinsUntil(Option<usize>),
    /// Follows this ray or other element from the first pass to the last in the session's own streams; the place stays the
    /// same.
    Follow(Subject),
    /// Selects this pixel's ray, and follows it on the device when there is nothing else to do, in a run of its own.
    Confirm([u32; 2]),
    /// Copies the streams that are drawn by now, where they cannot be drawn from the device's own textures.
    Draw,
    /// Reads a region of the current stream: x, y, width, height.
    Read {
        /// Which stream.
        stream: Stream,
        /// The region.
        region: [u32; 4],
    },
    /// Reads the whole current stream.
    ReadAll(Stream),
    /// Reads the whole current stream, and computes statistics of one of its layers.
    Count(Stream, usize),
    /// Copies the current stream.
    Pin(Stream),
    /// Custom work with the session: an export, a map of divergence.
    Job(&'static str, Job),
}

/// Work on a session that the engine performs between two requests.
pub type Job = Box<dyn for<'a> FnOnce(JobContext<'a>) -> JobFuture<'a> + Send>;

/// The future of a [`Job`]: its answer, or an error.
pub type JobFuture<'a> =
    std::pin::Pin<Box<dyn Future<Output = Result<Box<dyn std::any::Any + Send>, String>> + Send + 'a>>;

/// A [`Job`]: a pattern for its context, and what it does.
macro_rules! job {
    ($context:pat, $work:block) => {
        Box::new(move |$context: $crate::session::request::JobContext<'_>| -> $crate::session::request::JobFuture<'_> {
            Box::pin(async move { $work })
        })
    };
}
pub(crate) use job;

/// The answer of a [`Job`].
///
/// # Errors
/// Never: the type is that of a [`Job`]'s last line.
pub fn answered(answer: impl std::any::Any + Send) -> Result<Box<dyn std::any::Any + Send>, String> {
    Ok(Box::new(answer))
}

/// Whether to go on, for what reports progress.
pub fn flow(goes_on: bool) -> ControlFlow<()> {
    if goes_on { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
}

/// The context of a [`Job`].
pub struct JobContext<'a> {
    /// The run.
    pub session: &'a mut super::Session,
    /// Its scene.
    pub scene: &'a Arc<Scene>,
    /// Its settings.
    pub settings: &'a Settings,
    /// Its device.
    pub device: raystep_kernels::Device,
    /// Measures choices.
    pub measure: &'a Measure,
    /// Reports progress; returns `true` to continue.
    pub progress: &'a mut (dyn FnMut(u64, u64) -> bool + Send),
}

/// A run that is ready.
#[derive(Clone)]
pub struct Opened {
    /// The path it was opened by; `None` if another engine read it.
    pub path: Option<String>,
    /// The scene.
    pub scene: Arc<Scene>,
    /// What it was asked for.
    pub settings: Settings,
    /// Its plan.
    pub plan: Arc<Plan>,
    /// The scene data for kernels.
    pub data: Arc<SceneData>,
    /// Streams as textures for drawing; copies, for the CPU reference.
    pub textures: Vec<(Stream, StreamTexture)>,
    /// The name of its device.
    pub device: String,
    /// Why its passes have no times; `None` if they have.
    pub why_no_times: Option<String>,
}

/// The place of a run.
#[derive(Clone, Debug)]
pub struct At {
    /// Passes so far.
    pub place: usize,
    /// As [`Opened::textures`] now, if they depend on the place.
    pub textures: Option<Vec<(Stream, StreamTexture)>>,
    /// The index of the first of `passes` in the list of all passes.
    pub first: usize,
    /// The passes from there on to `place`.
    pub passes: Vec<Pass>,
    /// The parts of each of them, if they are drawn.
    pub draws: Vec<Vec<DrawTime>>,
    /// The kernel of the next pass; `None` at the end.
    pub next: Option<Kernel>,
    /// Bytes of checkpoints.
    pub kept_bytes: u64,
    /// Budget of checkpoints in bytes.
    pub budget: u64,
    /// Edits by hand.
    pub edits: Vec<Edit>,
    /// How many of the first passes run on the CPU reference.
    pub twins: Option<usize>,
    /// Time of the passes so far by the host's clock.
    pub host_ns: Option<u64>,
    /// A bit for each of [`Opened::textures`] that has the values of this place.
    pub filled: u64,
}

/// Requested texels.
#[derive(Clone, Debug)]
pub struct Texels {
    /// Which stream.
    pub stream: Stream,
    /// Passes so far when they were read.
    pub place: usize,
    /// x, y, width, height.
    pub region: [u32; 4],
    /// Layers in order, rows from the top, floats as bits.
    pub bits: Vec<u32>,
    /// Statistics of one of the layers, if they were requested.
    pub counted: Option<(usize, LayerStats)>,
}

impl Texels {
    /// One component of all texels of the region, row by row.
    #[must_use]
    pub fn layer(&self, layer: usize) -> &[u32] {
        let [_, _, width, height] = self.region;
        let texels = width as usize * height as usize;
        self.bits.get(layer * texels..(layer + 1) * texels).unwrap_or_default()
    }

    /// All components of a texel of the stream; `None` outside of the region.
    #[must_use]
    pub fn texel(&self, [x, y]: [u32; 2]) -> Option<Vec<u32>> {
        let [left, top, width, height] = self.region;
        let (column, row) = (x.checked_sub(left)?, y.checked_sub(top)?);
        let at = (column < width && row < height).then(|| row as usize * width as usize + column as usize)?;
        (0..self.stream.layers()).map(|layer| self.layer(layer).get(at).copied()).collect()
    }
}

/// A picture at a lower resolution than the run's.
#[derive(Clone)]
pub struct Glimpse {
    /// The stream of colours.
    pub stream: Stream,
    /// A copy of it.
    pub texture: StreamTexture,
    /// Which of all glimpses it is.
    pub index: u64,
}

/// A message from an engine.
pub enum Update {
    /// A run is ready, at this place.
    Opened(Box<Opened>, At),
    /// A quick picture.
    Glimpsed(Glimpse),
    /// The place of the run.
    At(At),
    /// A watch fired; `None` if none did.
    Fired(Option<Fired>),
    /// The history of a ray in the session's own streams.
    Followed(Box<Trace>),
    /// The history of a ray on the device, or why there is none.
    Confirmed(Result<Box<Trace>, String>),
    /// Texels.
    Texels(Texels),
    /// A copy of a stream.
    Pinned {
        /// Which stream.
        stream: Stream,
        /// Number of passes before it.
        place: usize,
        /// The copy.
        texture: StreamTexture,
    },
    /// The states after a pass on the way.
    Sketched(Sketch),
    /// The answer of a job, with the job's name.
    Done(&'static str, Box<dyn std::any::Any + Send>),
    /// Progress: name of the work, amount done, total (0 if unknown).
    Progress(&'static str, u64, u64),
    /// Work was refused or failed; one line.
    Failed(&'static str, String),
    /// Work was cancelled.
    Cancelled(&'static str),
    /// A request has been served.
    Idle,
}
