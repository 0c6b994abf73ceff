//! What panels have in common.

use raystep_kernels::Stream;

use super::host::FileToSave;
use crate::link::{Link, LinkStream};
use crate::session::Watch;

/// A line of the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogLine {
    /// Something went wrong.
    pub is_error: bool,
    /// What happened.
    pub text: String,
}

/// What a stream view shows, as links say it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// The stream, and one of its layers.
    pub stream: LinkStream,
    /// Points a texel; `None` fits the picture into its panel.
    pub zoom: Option<f32>,
    /// The texel in the middle.
    pub pan: Option<[f32; 2]>,
}

impl Shown {
    /// What a link asks for, where it names a stream.
    #[must_use]
    pub fn of(link: &Link) -> Option<Self> {
        Some(Self { stream: link.stream?, zoom: link.zoom, pan: link.pan })
    }
}

/// What panels have in common.
pub struct Shared {
    /// The pixel whose ray is looked at.
    pub pixel: Option<[u32; 2]>,
    /// The pixel under the cursor, in any stream view.
    pub hovered: Option<[u32; 2]>,
    /// The panel that the cursor was over last: commands about a view go to it first.
    pub under: Option<egui_tiles::TileId>,
    /// Where this frame's panels want the run to be, as a number of passes.
    pub go_to: Option<usize>,
    /// A pixel that a panel wants to be looked at.
    pub select: Option<[u32; 2]>,
    /// What the first stream view is asked to show.
    pub show: Option<Shown>,
    /// What the first stream view shows.
    pub shown: Option<Shown>,
    /// The stream that commands are about.
    pub stream: Option<Stream>,
    /// Files that panels want to be saved.
    pub files: Vec<FileToSave>,
    /// The next export of passes ends here.
    pub is_up_to_here: bool,
    /// What to stop at, and whether it is on.
    pub watches: Vec<(Watch, bool)>,
    /// What the last run to a watch stopped at, in words.
    pub fired: Option<String>,
    /// Files that were opened, the latest first.
    pub recent: Vec<String>,
    /// A file that a panel wants to be opened.
    pub open: Option<String>,
    /// A link that a panel wants to be gone to.
    pub visit: Option<String>,
    /// Where the inspector was when it was closed, as a link.
    pub last_place: Option<String>,
    /// What happened, oldest first.
    pub log: Vec<LogLine>,
}

impl Default for Shared {
    fn default() -> Self {
        Self {
            pixel: None,
            hovered: None,
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
            log: Vec::new(),
        }
    }
}

impl Shared {
    /// Notes what happened.
    pub fn say(&mut self, is_error: bool, text: impl Into<String>) {
        const MOST: usize = 1000;
        if self.log.len() == MOST {
            self.log.remove(0);
        }
        self.log.push(LogLine { is_error, text: text.into() });
    }
}
