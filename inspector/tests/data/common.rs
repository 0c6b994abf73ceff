//! The repository's scenes, and options for them.

use std::path::{Path, PathBuf};

use raystep_kernels::{Accelerator, Options, RaySource, ScheduleKind};
use raystep_scenes::{Camera, LoadOptions, Resolver, Scene};

struct Beside(PathBuf);

impl Resolver for Beside {
    fn read(&self, path: &str, _max_bytes: u64) -> Result<Vec<u8>, raystep_scenes::FileError> {
        std::fs::read(self.0.join(path)).map_err(|e| e.to_string().into())
    }
}

/// Every scene file of the repository, by name.
pub(crate) fn scenes() -> Vec<(String, Scene)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let entries = std::fs::read_dir(&folder).expect("the scenes").map(|e| e.expect("an entry").file_name());
    let mut names: Vec<_> = entries.map(|name| name.to_string_lossy().into_owned()).collect();
    names.retain(|name| name.ends_with(".gltf") || name.ends_with(".glb"));
    names.sort();
    assert!(names.len() > 8, "{names:?}");
    let read = |name: String| {
        let bytes = std::fs::read(folder.join(&name)).expect("a scene");
        let scene = raystep_scenes::load(&name, &bytes, &Beside(folder.clone()), &LoadOptions::default());
        let scene = scene.unwrap_or_else(|e| panic!("{name}: {e}"));
        (name, scene)
    };
    names.into_iter().map(read).collect()
}

/// One step per pass, from the scene's first camera.
pub(crate) fn options(
    scene: &Scene,
    accelerator: Accelerator,
    schedule: ScheduleKind,
    [width, height]: [u32; 2],
) -> Options {
    let camera = scene.cameras.first().cloned().unwrap_or_else(|| Camera::framing(&scene.bounds()));
    let rays = RaySource::Camera { camera, width, height };
    Options { accelerator, schedule, steps_per_pass: 1, ..Options::new(rays) }
}
