//! What panels share, as plain state in parts: a panel says which of them it touches.

mod bookmarks;
pub(super) mod kept_runs;
mod log;

use std::sync::Arc;

use raystep_kernels::Stream;
use raystep_kernels::program::paths::Technique;
use raystep_kernels::scene_data::SceneData;

use super::host::FileToSave;
use super::mask::Mask;
use super::preview::PreviewTexture;
use super::scrub::Scrub;
use super::thumbs::Thumbs;
use super::units::Units;
use crate::command::{Command, PaneKind};
use crate::link::Shown;
use crate::session::{Model, Subject, Watch};
pub(super) use bookmarks::Bookmarks;
use kept_runs::KeptRuns;
pub(super) use log::{Log, LogLine};

/// A part of the scene's structure that was clicked in one panel, for all panels to show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Picked {
    /// A cell of the grid, by its coordinates.
    Cell([u32; 3]),
    /// A node of the BVH, by its index.
    Node(u32),
    /// A triangle, by its index in the scene.
    Triangle(u32),
}

/// A vertex of a pixel's path, which the light tree is to show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OfPath {
    /// The pixel.
    pub pixel: [u32; 2],
    /// The sample, from 0.
    pub sample: u32,
    /// Surfaces that sent on the path before.
    pub depth: u32,
    /// How its light was found.
    pub technique: Technique,
    /// The number of passes after which its light is in the streams.
    pub place: usize,
}

/// All parts.
#[derive(Default)]
pub(super) struct State {
    /// The selected ray, and what else was pointed at.
    pub selection: Selection,
    /// How things are shown.
    pub display: Display,
    /// What panels ask for.
    pub asks: Asks,
    /// Places to return to.
    pub bookmarks: Bookmarks,
    /// The watches.
    pub watches: Watches,
    /// The messages.
    pub log: Log,
    /// The kept runs.
    pub(super) runs: KeptRuns,
}

/// What is selected or pointed at.
#[derive(Default)]
pub struct Selection {
    /// The selected pixel.
    pub pixel: Option<[u32; 2]>,
    /// The selected element of another set than the image's, whose history is shown instead of the pixel's.
    pub element: Option<Subject>,
    /// The pixel under the cursor, in any stream view.
    pub hovered: Option<[u32; 2]>,
    /// The cell, node or triangle that was clicked last, in any panel.
    pub picked: Option<Picked>,
    /// The vertex that the light tree goes to, once it is known.
    pub vertex: Option<OfPath>,
}

impl Selection {
    /// Whose history is shown: the selected element's if the run has such elements, else the pixel's.
    #[must_use]
    pub fn subject(&self, model: &Model) -> Option<Subject> {
        let element = self.element.filter(|element| model.has(element));
        element.or(self.pixel.map(Subject::from))
    }
}

/// How things are shown.
#[derive(Default)]
pub struct Display {
    /// The units of lengths and of t.
    pub units: Units,
    /// The stream that commands apply to.
    pub stream: Option<Stream>,
    /// The view of the first stream panel.
    pub shown: Option<Shown>,
    /// Whether stream views magnify the texels around the cursor.
    pub is_magnified: bool,
    /// Which rays of a pass took a branch, drawn over streams.
    pub mask: Option<Arc<Mask>>,
    /// The same scene with another structure, if the unfolded walk shows both.
    pub beside: Option<Arc<SceneData>>,
    /// The function that is marked in the kernel panel.
    pub code: Option<String>,
    /// Why the last version of a user's kernel is not used: the one before it still runs.
    pub kernel_error: Option<String>,
    /// Whether views of the ray's walk leave out what comes next: the reader of a lesson is asked for it.
    pub hides_next: bool,
    /// Thumbnails of the stream in view.
    pub thumbs: Thumbs,
    /// A picture of the scene that is being opened, until the run has its own.
    pub(super) preview: Option<PreviewTexture>,
    /// Whether a stream view has drawn an earlier place in this frame: the present one's values are on their way.
    pub is_behind: bool,
    /// Whether the item with keyboard focus uses keys that are commands elsewhere.
    pub keeps_keys: bool,
    /// Recent files, the latest first.
    pub recent: Vec<String>,
    /// The place at which the inspector was closed, as a link.
    pub last_place: Option<String>,
}

/// What panels ask for, until it is done at the end of the frame.
#[derive(Default)]
pub struct Asks {
    /// Commands to perform once all panels are shown.
    pub commands: Vec<Command>,
    /// The place that this frame's panels request, as a number of passes.
    pub go_to: Option<usize>,
    /// A panel to show.
    pub panel: Option<PaneKind>,
    /// The place that the timeline asks for.
    pub scrub: Scrub,
    /// A pixel to select.
    pub select: Option<[u32; 2]>,
    /// An element of another set to select.
    pub follow: Option<Subject>,
    /// The view requested of the first stream panel.
    pub show: Option<Shown>,
    /// Files to save.
    pub files: Vec<FileToSave>,
    /// Whether the next export of passes ends at the current place.
    pub is_up_to_here: bool,
    /// A file to open.
    pub open: Option<String>,
    /// A link to open.
    pub visit: Option<String>,
}

/// The watches.
pub struct Watches {
    /// Every watch, and whether it is active.
    pub list: Vec<(Watch, bool)>,
    /// The result of the last run to a watch, for display.
    pub fired: Option<String>,
}

impl Default for Watches {
    fn default() -> Self {
        let is_active = |watch| matches!(watch, Watch::NonFinite | Watch::TMaxBackwards);
        Self { list: Watch::ALL.map(|watch| (watch, is_active(watch))).to_vec(), fired: None }
    }
}
