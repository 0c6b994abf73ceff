//! Scenes and sessions: of the repository, dropped or chosen, or from elsewhere in the web.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;

use futures_channel::mpsc::{UnboundedSender, unbounded};
use futures_channel::oneshot;
use js_sys::Uint8Array;
use raystep_inspector::session::request::{Loaded, Loader};
use raystep_inspector::session_file::{EXTENSION, MOST_BYTES};
use raystep_inspector::ui::host::HostEvent;
use raystep_kernels::options::folder::Folder;
use raystep_kernels::programs::own;
use raystep_lab::zipped;
use raystep_scenes::{ENDINGS, FileError, LoadOptions, Resolver, Scene, external_files, load};
use wasm_bindgen::prelude::*;
use wasm_bindgen_futures::JsFuture;
use web_sys::File;

use crate::{shell, tasks};

/// Most bytes of a scene's files, and of everything decoded from them: a tab has 4 GiB in all.
const MOST_FILE_BYTES: u64 = 1 << 30;
const MOST_DECODED_BYTES: u64 = 2 << 30;

/// The ending of a user's program.
const ZIP: &str = "zip";

/// The files that the user has given to the page, and what is to be told of them.
#[derive(Default)]
pub(crate) struct Files {
    local: RefCell<BTreeMap<String, File>>,
    pub(crate) events: RefCell<Vec<HostEvent>>,
    /// Someone waits for a file that the user was asked for.
    wish: RefCell<Option<oneshot::Sender<String>>>,
}

/// Where bytes are from.
#[derive(Clone)]
enum Place {
    Local(String),
    Url(String),
}

/// What a fetch tells the loader that waits for it.
enum Fetching {
    Progress(u64, u64),
    Done(Result<Fetched, String>),
}

/// What a path has led to.
enum Fetched {
    Scene(SceneFiles),
    /// A user's program, and the scene that it reads, with its path.
    Program(Folder, Option<(String, SceneFiles)>),
}

/// A scene's file, and those that it names.
struct SceneFiles {
    bytes: Vec<u8>,
    others: Others,
}

/// Files by the names that the scene has for them.
#[derive(Default)]
struct Others(BTreeMap<String, Result<Vec<u8>, String>>);

impl Resolver for Others {
    fn read(&self, path: &str, max_bytes: u64) -> Result<Vec<u8>, FileError> {
        match self.0.get(path) {
            Some(Ok(bytes)) if bytes.len() as u64 > max_bytes => Err(FileError::TooLarge { bytes: bytes.len() as u64 }),
            Some(Ok(bytes)) => Ok(bytes.clone()),
            Some(Err(why)) => Err(why.clone().into()),
            None => Err("it was not fetched".into()),
        }
    }
}

/// The last part of a path, of any system.
pub(crate) fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

/// The endings of scenes and of the files that they name, as the page's file chooser takes them.
pub(crate) fn accepted() -> String {
    let endings = ENDINGS.iter().chain(&["bin", "png", "jpg", "jpeg", ZIP]);
    endings.map(|ending| format!(".{ending}")).collect::<Vec<_>>().join(",")
}

fn has_ending(path: &str, endings: &[&str]) -> bool {
    path.rsplit_once('.').is_some_and(|(_, found)| endings.iter().any(|ending| found.eq_ignore_ascii_case(ending)))
}

/// A path without `.` and `..`.
fn plain(path: &str) -> String {
    let mut parts: Vec<&str> = Vec::new();
    for part in path.split(['/', '\\']) {
        match part {
            "." | "" => {}
            ".." => drop(parts.pop()),
            part => parts.push(part),
        }
    }
    parts.join("/")
}

fn is_url(path: &str) -> bool {
    path.starts_with("https://") || path.starts_with("http://")
}

impl Files {
    /// Takes files, and opens the first scene or session among them.
    pub(crate) fn add(&self, files: Vec<(String, File)>) {
        let paths: Vec<String> = files.iter().map(|(path, _)| plain(path)).collect();
        self.local.borrow_mut().extend(paths.iter().cloned().zip(files.into_iter().map(|(_, file)| file)));
        let wish = self.wish.take();
        let is_opened =
            |path: &&String| has_ending(path, &ENDINGS) || wish.is_none() && has_ending(path, &[EXTENSION, "wgsl"]);
        // The files of a program's folder belong to it.
        let Some(opened) = paths.iter().find(|path| is_program(path)).or_else(|| paths.iter().find(is_opened)) else {
            let names = paths.first().map_or_else(String::new, |path| format!("{path}: "));
            self.tell(HostEvent::Failed(format!(
                "{names}expected a scene ({}, with its files), a session (.{EXTENSION}) or a program (its folder, or a .{ZIP})",
                ENDINGS.map(|ending| format!(".{ending}")).join(", ")
            )));
            *self.wish.borrow_mut() = wish;
            return;
        };
        match wish {
            Some(wish) => {
                shell::ask_for("", "");
                let _ = wish.send(opened.clone());
            }
            None => self.tell(HostEvent::Chosen(opened.clone())),
        }
    }

    /// The user chose nothing.
    pub(crate) fn cancel(&self) {
        match self.wish.take() {
            // The one who waits is told by this being dropped.
            Some(_) => shell::ask_for("", ""),
            None => self.tell(HostEvent::Cancelled("cancelled: no file opened")),
        }
    }

    fn tell(&self, event: HostEvent) {
        self.events.borrow_mut().push(event);
    }

    fn place(&self, path: &str) -> Place {
        let is_local = self.local.borrow().contains_key(&plain(path));
        if is_local {
            Place::Local(plain(path))
        } else if is_url(path) {
            Place::Url(path.to_owned())
        } else {
            Place::Url(format!("scenes/{}", js_sys::encode_uri_component(file_name(path))))
        }
    }

    async fn bytes(&self, place: &Place, most_bytes: u64, progress: &js_sys::Function) -> Result<Vec<u8>, String> {
        let file = match place {
            Place::Url(url) => {
                let fetched = shell::fetch(url, most_bytes as f64, progress).await.map_err(|e| shell::reason(&e))?;
                return Ok(Uint8Array::new(&fetched).to_vec());
            }
            Place::Local(path) => self.local.borrow().get(path).cloned().ok_or("it is not here: drop it too")?,
        };
        let size = file.size() as u64;
        if size > most_bytes {
            return Err(format!("its {size} bytes are more than the limit of {most_bytes}"));
        }
        let buffer = JsFuture::from(file.array_buffer()).await.map_err(|e| shell::reason(&e))?;
        Ok(Uint8Array::new(&buffer).to_vec())
    }

    /// The place of a file that the one at `scene` names.
    fn beside(&self, scene: &Place, name: &str) -> Place {
        match scene {
            Place::Local(path) => {
                let folder = path.rsplit_once('/').map_or("", |(folder, _)| folder);
                let path = plain(&format!("{folder}/{name}"));
                // Files that were dropped one by one have lost their folders.
                let is_here = self.local.borrow().contains_key(&path);
                Place::Local(if is_here { path } else { file_name(name).to_owned() })
            }
            Place::Url(url) => {
                let encoded: Vec<String> =
                    name.split('/').map(|part| String::from(js_sys::encode_uri_component(part))).collect();
                let folder =
                    url.split(['?', '#']).next().unwrap_or(url).rsplit_once('/').map_or("", |(folder, _)| folder);
                Place::Url(format!("{folder}/{}", encoded.join("/")))
            }
        }
    }

    /// The scene's own bytes; the user is asked for a file that is nowhere.
    async fn scene_bytes(&self, path: &str, progress: &js_sys::Function) -> Result<(Place, Vec<u8>), String> {
        let place = self.place(path);
        match self.bytes(&place, MOST_FILE_BYTES, progress).await {
            Ok(bytes) => return Ok((place, bytes)),
            Err(why) if is_url(path) || matches!(place, Place::Local(_)) => return Err(format!("{path}: {why}")),
            Err(_) => {}
        }
        let (send, chosen) = oneshot::channel();
        *self.wish.borrow_mut() = Some(send);
        shell::ask_for(file_name(path), &accepted());
        let Ok(chosen) = chosen.await else {
            return Err(format!("{path}: it is on another computer, and no file was chosen"));
        };
        let place = Place::Local(chosen);
        let bytes = self.bytes(&place, MOST_FILE_BYTES, progress).await.map_err(|why| format!("{path}: {why}"))?;
        Ok((place, bytes))
    }

    async fn fetch(&self, path: &str, told: &UnboundedSender<Fetching>) -> Result<Fetched, String> {
        let sender = told.clone();
        let progress = Closure::<dyn Fn(f64, f64) -> bool>::new(move |done: f64, of: f64| {
            sender.unbounded_send(Fetching::Progress(done as u64, of as u64)).is_ok()
        });
        let progress = progress.as_ref().unchecked_ref();
        let (program, scene) = path.rsplit_once('@').filter(|(program, _)| is_program(program)).unwrap_or((path, ""));
        if !is_program(program) {
            return self.scene_files(path, progress).await.map(Fetched::Scene);
        }
        let folder = self.folder(program, progress).await?;
        let own = own::read(&Arc::new(folder.clone())).map_err(|mistake| mistake.to_string())?;
        let Some(of) = &own.scene else { return Ok(Fetched::Program(folder, None)) };
        let named = Some(scene).filter(|scene| !scene.is_empty()).or(of.file.as_deref());
        let named = named.ok_or_else(|| format!("{program} reads a scene: name one, as in {program}@cornell-box"))?;
        if let Some(bytes) = folder.file(named) {
            let files = SceneFiles { bytes: bytes.to_vec(), others: Others::default() };
            return Ok(Fetched::Program(folder, Some((named.to_owned(), files))));
        }
        // A name is that of a scene of ours.
        let paths = match has_ending(named, &ENDINGS) {
            true => vec![named.to_owned()],
            false => vec![format!("{named}.gltf"), format!("{named}.glb")],
        };
        let mut failed = String::new();
        for path in paths {
            let place = self.place(&path);
            match self.bytes(&place, MOST_FILE_BYTES, progress).await {
                Ok(bytes) => {
                    let files = self.with_others(&path, &place, bytes, progress).await?;
                    return Ok(Fetched::Program(folder, Some((path, files))));
                }
                Err(why) => failed = format!("{path}: {why}"),
            }
        }
        Err(failed)
    }

    /// A user's program: a zip file, or `program.toml` with the other files that were dropped with it.
    async fn folder(&self, path: &str, progress: &js_sys::Function) -> Result<Folder, String> {
        let failed = |why: &dyn std::fmt::Display| format!("{path}: {why}");
        if has_ending(path, &[ZIP]) {
            let (_, bytes) = self.scene_bytes(path, progress).await?;
            return zipped::folder(file_name(path), &bytes).map_err(|why| failed(&why));
        }
        let top = plain(path).strip_suffix(Folder::MANIFEST).unwrap_or_default().to_owned();
        let inside: Vec<String> = self.local.borrow().keys().filter(|file| file.starts_with(&top)).cloned().collect();
        let (mut files, mut left) = (BTreeMap::new(), Folder::MOST_BYTES);
        for file in inside.iter().take(Folder::MOST_FILES + 1) {
            let bytes = self.bytes(&Place::Local(file.clone()), left, progress).await.map_err(|why| failed(&why))?;
            left = left.saturating_sub(bytes.len() as u64);
            files.insert(file[top.len()..].to_owned(), bytes);
        }
        let name = file_name(top.trim_end_matches('/'));
        let name = if name.is_empty() { "my-program" } else { name };
        Folder::new(name.to_owned(), name.to_owned(), files).map_err(|why| failed(&why))
    }

    async fn scene_files(&self, path: &str, progress: &js_sys::Function) -> Result<SceneFiles, String> {
        let (place, bytes) = self.scene_bytes(path, progress).await?;
        self.with_others(path, &place, bytes, progress).await
    }

    /// A scene's file with those that it names.
    async fn with_others(
        &self,
        path: &str,
        place: &Place,
        bytes: Vec<u8>,
        progress: &js_sys::Function,
    ) -> Result<SceneFiles, String> {
        let names = external_files(&bytes, MOST_DECODED_BYTES).map_err(|e| format!("{path}: {e}"))?;
        let mut others = Others::default();
        let mut left = MOST_FILE_BYTES.saturating_sub(bytes.len() as u64);
        for name in names {
            let found = self.bytes(&self.beside(place, &name), left, progress).await;
            left = left.saturating_sub(found.as_ref().map_or(0, |bytes| bytes.len() as u64));
            others.0.insert(name, found);
        }
        Ok(SceneFiles { bytes, others })
    }

    /// A loader for the scene at a path, and which of its scenes.
    pub(crate) fn loader(self: &Rc<Self>, path: &str, scene: Option<usize>) -> Loader {
        let (send, mut receive) = unbounded();
        let (files, path) = (self.clone(), path.to_owned());
        let fetched = path.clone();
        tasks::spawn(async move {
            let done = files.fetch(&fetched, &send).await;
            // Nobody waits any more if it was cancelled.
            let _ = send.unbounded_send(Fetching::Done(done));
        });
        Box::new(move |mut on_read| {
            Box::pin(async move {
                loop {
                    match receive.recv().await {
                        Ok(Fetching::Progress(done, of)) if on_read(done, of) => {}
                        Ok(Fetching::Done(fetched)) => return loaded(&path, scene, fetched?),
                        Ok(Fetching::Progress(..)) | Err(_) => return Err(format!("{path}: cancelled")),
                    }
                }
            })
        })
    }

    /// Reads a session.
    pub(crate) fn read_session(self: &Rc<Self>, path: &str, then: impl FnOnce() + 'static) {
        let (files, path) = (self.clone(), path.to_owned());
        tasks::spawn(async move {
            let goes_on = Closure::<dyn Fn(f64, f64) -> bool>::new(|_, _| true);
            let progress = goes_on.as_ref().unchecked_ref();
            let read = files.bytes(&files.place(&path), MOST_BYTES as u64, progress).await;
            files.tell(match read {
                Ok(bytes) => HostEvent::Read { path, bytes },
                Err(why) => HostEvent::Failed(format!("{path}: {why}")),
            });
            then();
        });
    }
}

/// Whether a path is that of a user's program.
fn is_program(path: &str) -> bool {
    has_ending(path, &[ZIP]) || file_name(path) == Folder::MANIFEST
}

fn loaded(path: &str, scene: Option<usize>, fetched: Fetched) -> Result<Loaded, String> {
    match fetched {
        Fetched::Scene(files) => read(path, scene, &files).map(Loaded::from),
        Fetched::Program(folder, None) => Ok(Loaded::from(folder)),
        Fetched::Program(folder, Some((path, files))) => {
            Ok(Loaded { scene: Arc::new(read(&path, scene, &files)?), folder: Some(Arc::new(folder)) })
        }
    }
}

fn read(path: &str, scene: Option<usize>, fetched: &SceneFiles) -> Result<Scene, String> {
    let options = LoadOptions { scene, max_bytes: MOST_DECODED_BYTES, ..LoadOptions::default() };
    load(file_name(path), &fetched.bytes, &fetched.others, &options).map_err(|e| format!("{path}: {e}"))
}
