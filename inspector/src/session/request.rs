//! What an engine is asked, and what it answers.

use std::sync::Arc;

use raystep_kernels::export::trace::Trace;
use raystep_kernels::plan::Plan;
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::{Kernel, Pass, Stream};
use raystep_lab::layer_stats::LayerStats;
use raystep_scenes::Scene;

use super::{Edit, Fired, Target, Watch, Way};
use crate::settings::Settings;

/// Reads a scene, or says in one line why it cannot.
pub type Loader = Box<dyn FnOnce() -> Result<Scene, String> + Send>;

/// Something to do. Requests are served one after the other.
pub enum Request {
    /// Reads a scene and prepares a run; the old run stays where the new scene cannot be read.
    Open {
        /// What its user calls it, for [`Opened::path`].
        path: String,
        /// Reads it.
        load: Loader,
        /// What to run.
        settings: Box<Settings>,
    },
    /// Prepares a run of the same scene.
    Plan(Box<Settings>),
    /// Takes over a scene that another engine has read.
    Share(Arc<Scene>, Box<Settings>),
    /// Goes to a place.
    Step(Target),
    /// Runs to where one of the watches fires.
    RunToWatch {
        /// What to stop at.
        watches: Vec<Watch>,
        /// Which way.
        way: Way,
    },
    /// Changes a component of a ray's texel at the current place: stream, layer, pixel, bits.
    Edit(Stream, usize, [u32; 2], u32),
    /// Takes all changes back.
    ClearEdits,
    /// Lets the first passes run on the twins.
    TwinsUntil(Option<usize>),
    /// Follows this pixel's ray from the first pass to the last; the place stays as it is.
    Follow([u32; 2]),
    /// Reads part of a stream as it is now: x, y, width, height.
    Read {
        /// Which stream.
        stream: Stream,
        /// Texels.
        region: [u32; 4],
    },
    /// Reads a whole stream as it is now.
    ReadAll(Stream),
    /// Reads a whole stream as it is now, and counts one of its layers.
    Count(Stream, usize),
    /// Keeps a copy of a stream as it is now.
    Pin(Stream),
    /// Something of one's own to do with the session: an export, a map of divergence.
    Job(&'static str, Job),
}

/// Work on a session that the engine does between two requests.
pub type Job = Box<dyn for<'a> FnOnce(JobContext<'a>) -> JobFuture<'a> + Send>;

/// A future of a [`Job`]: what it answers, or why it failed.
pub type JobFuture<'a> =
    std::pin::Pin<Box<dyn Future<Output = Result<Box<dyn std::any::Any + Send>, String>> + Send + 'a>>;

/// What a [`Job`] works with.
pub struct JobContext<'a> {
    /// The run.
    pub session: &'a mut super::Session,
    /// Its scene.
    pub scene: &'a Arc<Scene>,
    /// Its settings.
    pub settings: &'a Settings,
    /// Where it runs.
    pub device: raystep_kernels::Device,
    /// Says how far it is, and hears whether to stop: `true` to go on.
    pub progress: &'a mut (dyn FnMut(u64, u64) -> bool + Send),
}

/// A run that is ready.
#[derive(Clone)]
pub struct Opened {
    /// The path that it was opened by; `None` where another engine read it.
    pub path: Option<String>,
    /// The scene.
    pub scene: Arc<Scene>,
    /// What it was asked for.
    pub settings: Settings,
    /// What it needs.
    pub plan: Arc<Plan>,
    /// The scene as kernels read it.
    pub data: Arc<SceneData>,
    /// Streams as textures that can be drawn from; on the twins copies.
    pub textures: Vec<(Stream, wgpu::Texture)>,
    /// The name of what it runs on.
    pub device: String,
    /// Why its passes have no times; `None` where they have.
    pub why_no_times: Option<String>,
}

/// Where a run is.
#[derive(Clone, Debug)]
pub struct At {
    /// Passes so far.
    pub place: usize,
    /// Where `passes` begins in the list of all passes.
    pub first: usize,
    /// The passes from there on to `place`.
    pub passes: Vec<Pass>,
    /// The kernel of the next pass; `None` at the end.
    pub next: Option<Kernel>,
    /// Bytes of what is kept for going back.
    pub kept_bytes: u64,
    /// Bytes that may be kept.
    pub budget: u64,
    /// What was changed by hand.
    pub edits: Vec<Edit>,
    /// How many of the first passes run on the twins.
    pub twins: Option<usize>,
    /// What the passes so far took on the host's clock.
    pub host_ns: Option<u64>,
}

/// Texels that were asked for.
#[derive(Clone, Debug)]
pub struct Texels {
    /// Which stream.
    pub stream: Stream,
    /// Passes so far when they were read.
    pub place: usize,
    /// x, y, width, height.
    pub region: [u32; 4],
    /// Layer after layer, rows from the top, floats as bits.
    pub bits: Vec<u32>,
    /// One of the layers in numbers, where it was to be counted.
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
}

/// What an engine says.
pub enum Update {
    /// A run is ready.
    Opened(Box<Opened>),
    /// The run is somewhere.
    At(At),
    /// A watch fired; `None` where none did.
    Fired(Option<Fired>),
    /// A ray's life.
    Followed(Box<Trace>),
    /// Texels.
    Texels(Texels),
    /// A copy of a stream.
    Pinned {
        /// Which stream.
        stream: Stream,
        /// After so many passes.
        place: usize,
        /// The copy.
        texture: wgpu::Texture,
    },
    /// What a job answers, by the job's name.
    Done(&'static str, Box<dyn std::any::Any + Send>),
    /// Work goes on: what, how much is done, of how much (0 where that is not known).
    Progress(&'static str, u64, u64),
    /// Work was refused or failed; one line.
    Failed(&'static str, String),
    /// Work was cancelled.
    Cancelled(&'static str),
    /// A request is served.
    Idle,
}
