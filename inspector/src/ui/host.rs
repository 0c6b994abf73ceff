//! What the inspector needs from the program that opened its window: threads, files, dialogs.

use crate::session::engine::EngineTask;
use crate::session::preview::Preview;
use crate::session::request::Loader;
use crate::settings::Settings;

/// Data to be written to a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileToSave {
    /// Proposed name, with its extension.
    pub name: String,
    /// Its contents.
    pub bytes: Vec<u8>,
    /// Description of the contents, shown once the file is written: "73 rows", "an image".
    pub holds: String,
}

/// An event reported by the host.
pub enum HostEvent {
    /// The user chose a scene.
    Chosen(String),
    /// The file of a session or kernel was read.
    Read {
        /// Its path.
        path: String,
        /// Its contents.
        bytes: Vec<u8>,
    },
    /// A scene that was to be loaded was traced at a lower resolution.
    Previewed {
        /// The path that the loader was made for.
        path: String,
        /// The picture.
        preview: Preview,
    },
    /// The file of a scene that was loaded has changed since.
    Changed {
        /// The path that the loader was made for.
        path: String,
    },
    /// A file was written.
    Saved {
        /// Description of the contents.
        holds: String,
        /// Its path.
        path: String,
    },
    /// The user cancelled the dialog.
    Cancelled(&'static str),
    /// There is no file dialog, or the path was invalid: the inspector should ask for a path itself.
    AskPath {
        /// The file to write; `None` to open a scene.
        file: Option<FileToSave>,
        /// A path to propose.
        path: String,
        /// The reason, in one line.
        why: String,
    },
    /// An error, in one line.
    Failed(String),
}

/// Threads, files and dialogs. Nothing here blocks: results arrive as events.
pub trait Host {
    /// Runs a task to its end.
    fn spawn(&mut self, task: EngineTask);
    /// The file, and which of its scenes, that a path given to [`loader`](Self::loader) means.
    fn scene_of(&self, path: &str) -> (String, Option<usize>);
    /// The inverse of `scene_file`.
    fn path_of(&self, scene: &str, index: Option<usize>) -> String;
    /// A loader for the scene at a path. A host with threads to spare also traces a [preview](HostEvent::Previewed) of
    /// it, with these settings.
    fn loader(&mut self, path: &str, settings: &Settings) -> Loader;
    /// Asks the user for a scene.
    fn choose_scene(&mut self);
    /// Asks the user for a session.
    fn choose_session(&mut self);
    /// Reads the file of a session or kernel.
    fn read(&mut self, path: &str);
    /// Reads a file again whenever it is written, where there are files: [`Read`](HostEvent::Read) events.
    fn watch(&mut self, _path: &str) {}
    /// Asks the user for a kernel's file.
    fn choose_kernel(&mut self);
    /// The path of a scene that a session's file names, relative to the session's folder.
    fn beside(&self, session: &str, scene: &str) -> String;
    /// Asks the user where to save a file, and writes it.
    fn save(&mut self, file: FileToSave);
    /// Writes to a path; replaces an existing file only if that is allowed.
    fn save_as(&mut self, file: FileToSave, path: &str, replaces: bool);
    /// The events since the last call.
    fn events(&mut self) -> Vec<HostEvent>;
    /// Whether the user can quit here: not in a browser, where the tab is not ours.
    fn can_quit(&self) -> bool {
        true
    }
    /// Stores settings for the next start.
    fn remember(&mut self, saved: &str);
}
