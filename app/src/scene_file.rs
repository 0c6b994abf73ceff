//! Reads scene files, and selects the camera.

mod beside;
mod named;

use std::fs::{self, File};
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use beside::Beside;
use glam::DVec3;
pub(crate) use named::{file_of, is_known, names, set_folder};
use raystep_kernels::RaySource;
use raystep_kernels::options::folder::Folder;
use raystep_kernels::plan::Bytes;
use raystep_lab::Hash;
use raystep_lab::text::visible;
use raystep_scenes::{Camera, FileError, LoadError, LoadOptions, Projection, Scene, load};

use crate::args::{CameraArgs, ReadArgs, SceneArgs, SightArgs, Vector, WRONG_FOV};
use crate::error::{Error, reason};
use crate::program_folder;

/// Vertical angle of view for `--eye` without `--fov`, degrees.
const DEFAULT_FOV_DEG: f64 = 40.0;

/// A scene and its files, or a program that needs none.
pub(crate) struct SceneFile {
    /// The program's folder.
    pub(crate) folder: Option<Arc<Folder>>,
    /// The scene.
    pub(crate) scene: Scene,
    /// The canonical names of the file and of those it refers to: no output may replace them.
    pub(crate) inputs: Vec<PathBuf>,
    /// The same files by the names under which they are found: in the scene's folder or below it, unless others are
    /// allowed. Its own is the first.
    pub(crate) files: Vec<PathBuf>,
}

/// Reads a scene.
pub(crate) fn read(args: &SceneArgs) -> Result<SceneFile, Error> {
    let found = read_any(args)?;
    match &found.folder {
        Some(folder) => Err(Error::usage(format!(
            "{} is a program: expected a scene; 'raystep run', 'inspect', 'check', 'trace', 'stop', 'cost', 'dump', 'plan' \
             and 'bench' take programs",
            folder.place
        ))),
        None => Ok(found),
    }
}

/// Reads a scene, or a program's folder in its place.
pub(crate) fn read_any(args: &SceneArgs) -> Result<SceneFile, Error> {
    let SceneArgs { scene, scene_index, read } = args;
    if let Some(found) = program_folder::find(scene) {
        let (folder, mut files) = program_folder::read(&found.folder)?;
        let folder = Arc::new(folder);
        let own = program_folder::program(&folder)?;
        let mut inputs = canonical(&files);
        let scene = match program_folder::scene_of(&found, &own)? {
            None => Scene { name: folder.name.clone(), ..Scene::default() },
            Some(path) => {
                let of = self::read(&SceneArgs { scene: path, scene_index: *scene_index, read: *read })?;
                inputs.extend(of.inputs);
                files.extend(of.files);
                of.scene
            }
        };
        return Ok(SceneFile { folder: Some(folder), scene, inputs, files });
    }
    let path = &file_of(scene)?;
    let options = LoadOptions { scene: *scene_index, max_bytes: read.max_memory, ..LoadOptions::default() };
    let failed = |problem: &dyn std::fmt::Display| Error::failed(format!("{}: {problem}", path.display()));
    let raises = format!("--max-memory, currently {}, raises the limit", Bytes(read.max_memory));
    let bytes = read_file(path, options.max_bytes).map_err(|e| match e {
        FileError::TooLarge { .. } => failed(&format!("{e}; {raises}")),
        _ => failed(&e),
    })?;
    // The scene's name appears in tables, pages and titles, so control characters are escaped.
    let name = name_in_folder(path);
    let files = Beside::new(path, read.allow_outside).map_err(|e| failed(&e))?;
    let allows = "--allow-outside lets a scene read such files";
    let mut scene = load(&visible(&name), &bytes, &files, &options).map_err(|e| match e {
        LoadError::NoSuchScene { .. } => Error::usage(format!("--scene-index: {e}")),
        LoadError::Outside { .. } => failed(&format!("{e}; {allows}")),
        LoadError::TooLarge { .. } => failed(&format!("{e}; {raises}")),
        _ => failed(&e),
    })?;
    // What the picture does not need is left out for the same reasons.
    for note in &mut scene.notes {
        if note.0.contains("lies outside of") {
            note.0 = format!("{}; {allows}", note.0);
        } else if note.0.contains("of the limit of") {
            note.0 = format!("{}; {raises}", note.0);
        }
    }
    if named::built_in_name(path).is_some() {
        return Ok(SceneFile { folder: None, scene, inputs: vec![path.clone()], files: vec![path.clone()] });
    }
    let files = files.into_read(path);
    Ok(SceneFile { folder: None, scene, inputs: canonical(&files), files })
}

/// Reads a program's folder, with the scene that it reads; also returns the rays of its view.
pub(crate) fn read_program(path: &Path, sight: &SightArgs) -> Result<(SceneFile, RaySource), Error> {
    let file = read_any(&SceneArgs { read: sight.read, ..alone(path) })?;
    let (camera, _) = self::camera(&sight.camera, &file.scene)?;
    Ok((file, RaySource::Camera { camera, width: sight.size.width, height: sight.size.height }))
}

/// The name of a scene's file without its folder; a built-in scene's is that of a GLB file.
pub(crate) fn name_in_folder(path: &Path) -> String {
    match named::built_in_name(path) {
        Some(name) => format!("{name}.glb"),
        None => path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
    }
}

/// A scene's file, or a program, with the default limits.
pub(crate) fn alone(path: &Path) -> SceneArgs {
    SceneArgs { scene: path.to_owned(), scene_index: None, read: ReadArgs::default() }
}

/// The path of a file that another one names, as scenes name their textures: in its folder or below, unless others are
/// allowed.
pub(crate) fn beside(file: &Path, name: &str, read: ReadArgs) -> Result<PathBuf, String> {
    let found = Beside::new(file, read.allow_outside).and_then(|files| files.find(name).map_err(|e| e.to_string()));
    let allows = |e: String| if e.contains("outside") { format!("{e}; --allow-outside permits it") } else { e };
    found.map_err(|e| format!("{name}: {}", allows(e)))
}

/// Checks whether a file may be a scene, without reading it.
pub(crate) fn expect_scene(path: &Path) -> Result<(), Error> {
    if program_folder::find(path).is_some() {
        return Ok(());
    }
    let path = &file_of(path)?;
    if named::built_in_name(path).is_some() {
        return Ok(());
    }
    regular_file(path).map(drop).map_err(|e| Error::at(path, e))
}

/// Resolves links, so that two names of a file compare equal.
pub(crate) fn canonical(paths: &[PathBuf]) -> Vec<PathBuf> {
    paths.iter().filter_map(|path| fs::canonicalize(path).ok()).collect()
}

/// The size of a regular file.
fn regular_file(path: &Path) -> Result<fs::Metadata, String> {
    let found = fs::metadata(path).map_err(|e| reason(&e))?;
    if found.is_dir() {
        return Err("it is a folder; expected a file".into());
    }
    if !found.is_file() {
        return Err("it is not a regular file".into());
    }
    Ok(found)
}

/// Reads a regular file of at most `max_bytes`, or a built-in scene as such a file. Devices and pipes are refused, as they
/// may never end.
pub(crate) fn read_file(path: &Path, max_bytes: u64) -> Result<Vec<u8>, FileError> {
    if let Some(bytes) = named::built_in(path) {
        return Ok(bytes?);
    }
    let found = regular_file(path)?;
    if found.len() > max_bytes {
        return Err(FileError::TooLarge { bytes: found.len() });
    }
    let mut bytes = Vec::new();
    bytes
        .try_reserve_exact(found.len() as usize)
        .map_err(|_| format!("not enough memory for its {} bytes", found.len()))?;
    // It may grow during reading.
    File::open(path)
        .and_then(|f| f.take(max_bytes.saturating_add(1)).read_to_end(&mut bytes))
        .map_err(|e| reason(&e))?;
    let read = bytes.len() as u64;
    if read > max_bytes { Err(FileError::TooLarge { bytes: read }) } else { Ok(bytes) }
}

/// The same, with an error that names the file.
pub(crate) fn bytes_of(path: &Path, max_bytes: u64) -> Result<Vec<u8>, Error> {
    read_file(path, max_bytes).map_err(|e| Error::at(path, e))
}

/// A hash that goes on with the contents of files, one after the other.
pub(crate) fn hashed(mut hash: Hash, files: &[PathBuf], max_bytes: u64) -> Result<Hash, Error> {
    for path in files {
        let bytes = read_file(path, max_bytes);
        hash.add(&bytes.map_err(|e| Error::at(path, e))?);
    }
    Ok(hash)
}

/// The up direction: `wanted`, unless the view is parallel to it.
fn usable_up(wanted: DVec3, forward: DVec3) -> DVec3 {
    // The same criterion as in `Camera::look_at`.
    let is_usable = |up: &DVec3| forward.cross(*up).length() > 1e-6;
    [wanted, DVec3::Y, DVec3::Z].into_iter().find(is_usable).unwrap_or(wanted)
}

/// The camera for the given options, and a note if it differs from the request.
pub(crate) fn camera(args: &CameraArgs, scene: &Scene) -> Result<(Camera, Option<String>), Error> {
    if let (Some(eye), Some(target)) = (args.eye, args.look_at) {
        let fov = args.fov.unwrap_or(DEFAULT_FOV_DEG);
        if !(fov > 0.0 && fov < 180.0) {
            return Err(Error::usage(format!("--fov {fov}: {WRONG_FOV}")));
        }
        let Vector([x, y, z]) = args.up.unwrap_or(Vector([0.0, 1.0, 0.0]));
        let Some(up) = DVec3::new(x, y, z).try_normalize() else {
            return Err(Error::usage(format!("--up {x},{y},{z}: expected a direction with a length above 0")));
        };
        let projection = Projection::Perspective { vertical_fov: fov.to_radians() };
        let [eye, target] = [eye, target].map(|point| DVec3::from(point.0) - scene.offset);
        let camera = Camera::look_at(eye, target, up, projection)
            .ok_or_else(|| Error::usage("--look-at is the same point as --eye: choose another"))?;
        let taken = usable_up(up, camera.forward);
        let note = || {
            format!(
                "the view is parallel to up ({x},{y},{z}): using {taken} as up; --up sets another \
                               direction"
            )
        };
        let note = (taken != up).then(note);
        return Ok((camera, note));
    }
    match (args.camera, scene.cameras.as_slice()) {
        (None, []) => Ok((Camera::framing(&scene.bounds()), None)),
        (index, cameras) => {
            let index = index.unwrap_or(0);
            cameras.get(index).cloned().map(|camera| (camera, None)).ok_or_else(|| {
                let count = cameras.len();
                Error::usage(match count {
                    0 => {
                        format!(
                            "--camera {index}: the scene has no camera; omit the option to use one that frames \
                                 the scene"
                        )
                    }
                    1 => format!("--camera {index}: the scene has one camera, number 0"),
                    _ => format!("--camera {index}: the scene has {count} cameras, 0 to {}", count - 1),
                })
            })
        }
    }
}
