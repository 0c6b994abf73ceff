//! State shared by panels.

use std::sync::Arc;

use raystep_kernels::Stream;
use raystep_kernels::scene_data::SceneData;
use serde::{Deserialize, Serialize};

use super::host::FileToSave;
use super::mask::Mask;
use super::preview::PreviewTexture;
use super::runs::KeptRuns;
use super::scrub::Scrub;
use super::thumbs::Thumbs;
use super::units::Units;
use crate::link::{Link, LinkStream};
use crate::session::Watch;

/// A line of the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogLine {
    /// An error.
    pub is_error: bool,
    /// A message.
    pub text: String,
    /// Nanoseconds since the start; `None` without a clock.
    pub at_ns: Option<u64>,
    /// The number of passes that had run.
    pub place: usize,
}

/// The contents of a stream view, as in links.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// The stream, and one of its layers.
    pub stream: LinkStream,
    /// Points per texel; `None` fits the picture to its panel.
    pub zoom: Option<f32>,
    /// The texel in the middle.
    pub pan: Option<[f32; 2]>,
}

impl Shown {
    /// The view that a link requests, if it names a stream.
    #[must_use]
    pub fn of(link: &Link) -> Option<Self> {
        Some(Self { stream: link.stream?, zoom: link.zoom, pan: link.pan })
    }
}

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

/// A place to return to.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bookmark {
    /// The number of passes before it.
    pub place: usize,
    /// The ray that was selected.
    pub pixel: Option<[u32; 2]>,
    /// The user's name for it.
    pub name: String,
}

/// State shared by panels.
pub struct Shared {
    /// The selected pixel.
    pub pixel: Option<[u32; 2]>,
    /// The pixel under the cursor, in any stream view.
    pub hovered: Option<[u32; 2]>,
    /// The cell, node or triangle that was clicked last, in any panel.
    pub picked: Option<Picked>,
    /// Which rays of a pass took a branch, drawn over streams.
    pub mask: Option<Arc<Mask>>,
    /// The same scene with another structure, if the unfolded walk shows both.
    pub beside: Option<Arc<SceneData>>,
    /// Places to return to, by the number of passes.
    pub bookmarks: Vec<Bookmark>,
    /// The scene that they belong to.
    pub bookmarked: Option<String>,
    /// The place that the timeline asks for.
    pub scrub: Scrub,
    /// Thumbnails of the stream in view.
    pub thumbs: Thumbs,
    /// A picture of the scene that is being opened, until the run has its own.
    pub(super) preview: Option<PreviewTexture>,
    /// Whether a stream view has drawn an earlier place in this frame: the present one's values are on their way.
    pub is_behind: bool,
    /// The panel that the cursor was over last: commands about a view go to it first.
    pub under: Option<egui_tiles::TileId>,
    /// The place that this frame's panels request, as a number of passes.
    pub go_to: Option<usize>,
    /// A pixel that a panel selects.
    pub select: Option<[u32; 2]>,
    /// The view requested of the first stream panel.
    pub show: Option<Shown>,
    /// The view of the first stream panel.
    pub shown: Option<Shown>,
    /// The stream that commands apply to.
    pub stream: Option<Stream>,
    /// Files that panels want to save.
    pub files: Vec<FileToSave>,
    /// Whether the next export of passes ends at the current place.
    pub is_up_to_here: bool,
    /// Watches, and whether they are active.
    pub watches: Vec<(Watch, bool)>,
    /// The result of the last run to a watch, for display.
    pub fired: Option<String>,
    /// Recent files, the latest first.
    pub recent: Vec<String>,
    /// A file that a panel wants to open.
    pub open: Option<String>,
    /// A link that a panel wants to open.
    pub visit: Option<String>,
    /// The place at which the inspector was closed, as a link.
    pub last_place: Option<String>,
    /// Kept runs.
    pub(super) runs: KeptRuns,
    /// Whether the item with keyboard focus uses keys that are commands elsewhere.
    pub keeps_keys: bool,
    /// The number of passes that have run, for the log.
    pub place: usize,
    /// A clock, nanoseconds.
    pub clock: Option<fn() -> u64>,
    /// The clock at the start.
    pub began_ns: u64,
    /// The units of lengths and of t.
    pub units: Units,
    /// Whether stream views magnify the texels around the cursor.
    pub is_magnified: bool,
    /// Messages, oldest first.
    pub log: Vec<LogLine>,
    /// The number of messages that were dropped to make room.
    pub dropped: u64,
}

impl Default for Shared {
    fn default() -> Self {
        Self {
            pixel: None,
            hovered: None,
            picked: None,
            mask: None,
            beside: None,
            bookmarks: Vec::new(),
            bookmarked: None,
            scrub: Scrub::default(),
            thumbs: Thumbs::default(),
            preview: None,
            is_behind: false,
            under: None,
            go_to: None,
            select: None,
            show: None,
            shown: None,
            stream: None,
            files: Vec::new(),
            is_up_to_here: false,
            watches: Watch::ALL.map(|watch| (watch, matches!(watch, Watch::NonFinite | Watch::TMaxBackwards))).to_vec(),
            fired: None,
            recent: Vec::new(),
            open: None,
            visit: None,
            last_place: None,
            runs: KeptRuns::default(),
            keeps_keys: false,
            place: 0,
            clock: None,
            began_ns: 0,
            units: Units::default(),
            is_magnified: false,
            log: Vec::new(),
            dropped: 0,
        }
    }
}

impl Shared {
    /// Adds a message.
    pub fn say(&mut self, is_error: bool, text: impl Into<String>) {
        const MOST: usize = 1000;
        if self.log.len() == MOST {
            self.log.remove(0);
            self.dropped += 1;
        }
        let at_ns = self.clock.map(|now| now().saturating_sub(self.began_ns));
        self.log.push(LogLine { is_error, text: text.into(), at_ns, place: self.place });
    }
}
