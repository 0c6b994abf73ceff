//! Threads, files and dialogs of a desktop.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant, SystemTime};

use eframe::egui;
use raystep_inspector::session::engine::EngineTask;
use raystep_inspector::session::request::Loader;
use raystep_inspector::session_file::EXTENSION;
use raystep_inspector::settings::Settings;
use raystep_inspector::ui::host::{FileToSave, Host, HostEvent};
use raystep_kernels::Gpu;
use raystep_scenes::ENDINGS;

use super::opening::Opening;
use super::{files, last_error, watch};
use crate::args::ReadArgs;
use crate::output::{Target, write};
use crate::session_file;
use crate::terminal::say;
use crate::threads;

/// A scene's path, and which scene of a file with several.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SceneChoice {
    /// The file.
    pub(crate) path: PathBuf,
    /// `--scene-index`
    pub(crate) index: Option<usize>,
}

impl fmt::Display for SceneChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        self.index.map_or(Ok(()), |index| write!(f, "#{index}"))
    }
}

impl SceneChoice {
    /// The inverse. A file whose name ends like an index is that file.
    fn parse(text: &str) -> Self {
        let whole = Self { path: text.into(), index: None };
        match text.rsplit_once('#') {
            Some((path, index)) if !Path::new(text).exists() => match index.parse() {
                Ok(index) => Self { path: path.into(), index: Some(index) },
                Err(_) => whole,
            },
            _ => whole,
        }
    }
}

/// A desktop host.
pub(super) struct Desktop {
    ctx: egui::Context,
    gpu: Arc<Gpu>,
    read: ReadArgs,
    /// The first scene, if it is on its way.
    opening: Option<Opening>,
    events: Receiver<HostEvent>,
    tell: Sender<HostEvent>,
    /// The settings that were saved last.
    remembered: String,
    /// Whether saving failed, and the user was told.
    cannot_remember: bool,
    /// The scene that was loaded last.
    loaded: Option<Loaded>,
    /// The files that threads watch until the window is closed.
    watched: Vec<String>,
    is_open: Arc<()>,
}

/// A scene's path as the inspector gave it, its file, and when that was written.
struct Loaded {
    path: String,
    file: PathBuf,
    written: Option<SystemTime>,
    looked: Instant,
}

impl Loaded {
    fn new(path: &str, file: PathBuf) -> Self {
        Self { path: path.to_owned(), written: written(&file), file, looked: Instant::now() }
    }

    /// Whether the file was written since it was loaded, or since this was last true. A file that is gone, as while it is
    /// replaced, has not changed.
    fn has_changed(&mut self) -> bool {
        /// The file system is asked no more often.
        const PAUSE: Duration = Duration::from_secs(1);
        if self.looked.elapsed() < PAUSE {
            return false;
        }
        self.looked = Instant::now();
        let now = written(&self.file);
        now.is_some() && std::mem::replace(&mut self.written, now) != now
    }
}

fn written(file: &Path) -> Option<SystemTime> {
    file.metadata().and_then(|about| about.modified()).ok()
}

impl Desktop {
    pub(super) fn new(ctx: egui::Context, gpu: Arc<Gpu>, read: ReadArgs, opening: Option<Opening>) -> Self {
        let (tell, events) = channel();
        let (remembered, cannot_remember) = (String::new(), false);
        let (loaded, watched, is_open) = (None, Vec::new(), Arc::new(()));
        Self { ctx, gpu, read, opening, events, tell, remembered, cannot_remember, loaded, watched, is_open }
    }

    /// Runs slow work in a thread, and reports its result.
    fn aside(&self, work: impl FnOnce() -> Option<HostEvent> + Send + 'static) {
        let (tell, ctx) = (self.tell.clone(), self.ctx.clone());
        std::thread::spawn(move || {
            if let Some(event) = work() {
                // The window may be closed by now.
                let _ = tell.send(event);
                ctx.request_repaint();
            }
        });
    }

    /// Asks for a file with one of these endings.
    fn choose(&self, kind: &str, endings: &[impl ToString], cancelled: &'static str) {
        // Dialogs require the main thread on macOS, and are asynchronous everywhere.
        let asking = Asking::begin();
        let dialog = rfd::AsyncFileDialog::new().add_filter(kind, endings).pick_file();
        self.aside(move || {
            Some(match files::wait(dialog) {
                Some(file) => HostEvent::Chosen(file.path().to_string_lossy().into_owned()),
                None => match asking.failure() {
                    Some(why) => HostEvent::AskPath { file: None, path: files::proposed(""), why },
                    None => HostEvent::Cancelled(cancelled),
                },
            })
        });
    }
}

impl Host for Desktop {
    fn spawn(&mut self, task: EngineTask) {
        threads::spawn(self.gpu.clone(), task);
    }

    fn scene_of(&self, path: &str) -> (String, Option<usize>) {
        let SceneChoice { path, index } = SceneChoice::parse(path);
        (path.to_string_lossy().into_owned(), index)
    }

    fn path_of(&self, scene: &str, index: Option<usize>) -> String {
        SceneChoice { path: scene.into(), index }.to_string()
    }

    fn loader(&mut self, path: &str, settings: &Settings) -> Loader {
        let choice = SceneChoice::parse(path);
        self.loaded = Some(Loaded::new(path, choice.path.clone()));
        let begun = self.opening.take().filter(|opening| opening.is_of(&choice, settings));
        let Opening { scene, preview, .. } =
            begun.unwrap_or_else(|| Opening::begin(choice, self.read, settings.clone()));
        let of = path.to_owned();
        self.aside(move || preview.recv().ok().map(|preview| HostEvent::Previewed { path: of, preview }));
        let path = path.to_owned();
        Box::new(|_| {
            Box::pin(async move {
                // The thread sends one answer, unless it panics.
                scene.recv().unwrap_or_else(|_| Err(format!("{path}: reading it failed; this is a bug in raystep")))
            })
        })
    }

    fn choose_scene(&mut self) {
        // Linux distinguishes the letters' case.
        let endings: Vec<_> = ENDINGS.iter().flat_map(|ending| [(*ending).to_owned(), ending.to_uppercase()]).collect();
        self.choose("Scenes", &endings, "cancelled: no scene opened");
    }

    fn choose_kernel(&mut self) {
        self.choose("WGSL", &["wgsl"], "cancelled: no kernel replaced");
    }

    fn watch(&mut self, path: &str) {
        if !self.watched.iter().any(|watched| watched == path) {
            self.watched.push(path.to_owned());
            let (tell, ctx, window) = (self.tell.clone(), self.ctx.clone(), Arc::downgrade(&self.is_open));
            watch::begin(PathBuf::from(path), window, move |event| {
                let _ = tell.send(event);
                ctx.request_repaint();
            });
        }
    }

    fn choose_session(&mut self) {
        self.choose("raystep session", &[EXTENSION], "cancelled: no session opened");
    }

    fn read(&mut self, path: &str) {
        let path = path.to_owned();
        self.aside(move || {
            Some(match session_file::bytes(Path::new(&path)) {
                Ok(bytes) => HostEvent::Read { path, bytes },
                Err(error) => HostEvent::Failed(error.message().to_owned()),
            })
        });
    }

    fn beside(&self, session: &str, scene: &str) -> String {
        session_file::beside(Path::new(session), scene).to_string_lossy().into_owned()
    }

    fn save(&mut self, file: FileToSave) {
        let extension = Path::new(&file.name).extension().unwrap_or_default().to_string_lossy().into_owned();
        let asking = Asking::begin();
        let dialog =
            rfd::AsyncFileDialog::new().set_file_name(&file.name).add_filter(&extension, &[&extension]).save_file();
        self.aside(move || {
            Some(match files::wait(dialog) {
                // The dialog has already asked whether to replace an existing file.
                Some(chosen) => save(file, &chosen.path().to_string_lossy(), chosen.path(), true),
                None => match asking.failure() {
                    Some(why) => HostEvent::AskPath { path: files::proposed(&file.name), file: Some(file), why },
                    None => HostEvent::Cancelled("cancelled: nothing written"),
                },
            })
        });
    }

    fn save_as(&mut self, file: FileToSave, path: &str, replaces: bool) {
        let path = path.to_owned();
        self.aside(move || Some(save(file, &path, Path::new(&path), replaces)));
    }

    fn events(&mut self) -> Vec<HostEvent> {
        let changed = self.loaded.as_mut().and_then(|loaded| loaded.has_changed().then(|| loaded.path.clone()));
        let changed = changed.map(|path| HostEvent::Changed { path });
        self.events.try_iter().chain(changed).collect()
    }

    fn remember(&mut self, saved: &str) {
        if self.remembered == saved {
            return;
        }
        saved.clone_into(&mut self.remembered);
        if let Err(why) = files::remember(saved)
            && !std::mem::replace(&mut self.cannot_remember, true)
        {
            let message = format!("cannot save the window's settings: {why}");
            // The window may close before it shows the message.
            say(&message);
            let _ = self.tell.send(HostEvent::Failed(message));
        }
    }
}

/// The result of writing a file. If it failed, the user is asked for another path.
fn save(file: FileToSave, name: &str, path: &Path, replaces: bool) -> HostEvent {
    let path_text = name.to_owned();
    let (file, path) = match session_file::prepared(file, path) {
        Ok(prepared) => prepared,
        Err((file, why)) => return HostEvent::AskPath { file: Some(file), path: path_text, why },
    };
    let path = path.as_path();
    if !replaces && path.exists() {
        let why = format!("{name} already exists: choose another file, or allow replacing it");
        return HostEvent::AskPath { file: Some(file), path: path_text, why };
    }
    match Target::new(path).and_then(|target| write(vec![(target, file.bytes.clone())])) {
        Ok(()) => HostEvent::Saved { holds: file.holds, path: path.display().to_string() },
        Err(error) => HostEvent::AskPath { file: Some(file), path: path_text, why: error.message().to_owned() },
    }
}

/// An open dialog. rfd returns the same value whether the user closed it or there is none; only its log messages tell
/// them apart.
struct Asking;

impl Asking {
    fn begin() -> Self {
        last_error::take_of("rfd");
        Self
    }

    /// Why there was no dialog.
    fn failure(&self) -> Option<String> {
        last_error::take_of("rfd")?;
        Some("There is no file dialog on this system: install xdg-desktop-portal or zenity to get one.".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_written_is_kept_and_another_path_asked_for() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("file"), "no folder").expect("a file");
        for path in ["file/passes.csv", "nowhere/passes.csv", ""] {
            let path = folder.path().join(path);
            let file = FileToSave { name: "passes.csv".into(), bytes: b"pass\n".to_vec(), holds: "0 rows".into() };
            match save(file, "passes.csv", &path, true) {
                HostEvent::AskPath { file: Some(file), path, why } => {
                    assert_eq!((file.bytes.as_slice(), path.as_str()), (&b"pass\n"[..], "passes.csv"));
                    assert!(!why.is_empty() && !why.contains('\n'), "{why}");
                }
                _ => panic!("{}: written, or given up", path.display()),
            }
        }
    }

    #[test]
    fn a_file_has_changed_once_each_time_it_is_written() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        let mut loaded = Loaded::new("scene", file.path().to_owned());
        let mut changed = || {
            let before = loaded.looked;
            // As if the pause were over.
            loaded.looked = before.checked_sub(Duration::from_secs(2)).unwrap_or(before);
            loaded.has_changed()
        };
        assert!(!changed());
        let write = |seconds| {
            let when = SystemTime::now() + Duration::from_secs(seconds);
            file.as_file().set_modified(when).expect("a time");
        };
        write(60);
        assert!(changed() && !changed());
        write(120);
        assert!(changed());
        std::fs::remove_file(file.path()).expect("it is there");
        assert!(!changed(), "a file that is gone has not changed");
    }
}
