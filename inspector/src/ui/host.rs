//! What the inspector needs from whoever opened its window: threads, files, dialogs.

use crate::session::engine::EngineTask;
use crate::session::request::Loader;

/// Something to be written to a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileToSave {
    /// A name to propose, with its extension.
    pub name: String,
    /// Its contents.
    pub bytes: Vec<u8>,
    /// What that is, as it is told once it is written: "73 rows", "a picture".
    pub holds: String,
}

/// What a host has to tell.
pub enum HostEvent {
    /// The user chose a scene.
    Chosen(String),
    /// A file was written.
    Saved {
        /// What it holds.
        holds: String,
        /// Where it is.
        path: String,
    },
    /// The user chose no place, or no scene.
    Cancelled(&'static str),
    /// There is no dialog to ask with, or the path was not one: the inspector is to ask for a path itself.
    AskPath {
        /// What is to be written; `None` where a scene is to be opened.
        file: Option<FileToSave>,
        /// A path to propose.
        path: String,
        /// Why it is asked, in one line.
        why: String,
    },
    /// Something failed; one line.
    Failed(String),
}

/// Threads, files and dialogs. Nothing here blocks: results come as events.
pub trait Host {
    /// Lets a task run until it ends.
    fn spawn(&mut self, task: EngineTask);
    /// The file, and which of its scenes, that a path given to [`loader`](Self::loader) means.
    fn scene_of(&self, path: &str) -> (String, Option<usize>);
    /// The other way round.
    fn path_of(&self, scene: &str, index: Option<usize>) -> String;
    /// What reads a scene by its path.
    fn loader(&mut self, path: &str) -> Loader;
    /// Asks the user for a scene.
    fn choose_scene(&mut self);
    /// Asks the user where to, and writes.
    fn save(&mut self, file: FileToSave);
    /// Writes to a path, over a file that is there only where that is allowed.
    fn save_as(&mut self, file: FileToSave, path: &str, replaces: bool);
    /// What happened since the last call.
    fn events(&mut self) -> Vec<HostEvent>;
    /// Keeps what is to be found again when the inspector is opened the next time.
    fn remember(&mut self, saved: &str);
}
