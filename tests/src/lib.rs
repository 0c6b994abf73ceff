//! Shared by tests across crates: the repository's scenes, a GPU, and comparisons.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use configurations::Configuration;
use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::{AdapterChoice, Device, Gpu, Options, RaySource, Renderer, ScheduleKind, Stream, StreamData};
use raystep_lab::judge::{Cracks, Judge, Report, Traced, check_rays};
use raystep_lab::reference::Mistake;
use raystep_scenes::{Camera, LoadOptions, Resolver, Scene};

pub use raystep_lab::block_on;
pub use raystep_lab::machine::now_ns;

pub mod configurations;
pub mod floors;
pub mod parity;
pub mod rays;
pub mod sessions;
pub mod watertight;
pub mod words;

/// Whether to run long tests, as `sh tests/full.sh` requests with the variable `RAYSTEP_THOROUGH`: more scenes, rays
/// and configurations. Short tests find what breaks a whole kernel or rule, long ones find rare errors.
#[must_use]
pub fn thorough() -> bool {
    std::env::var_os("RAYSTEP_THOROUGH").is_some_and(|value| !value.is_empty())
}

/// The folder of scene files: beside this crate, or in the current folder if a test binary was copied elsewhere.
#[must_use]
pub fn scenes_dir() -> PathBuf {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    if beside.is_dir() { beside } else { PathBuf::from("scenes") }
}

/// Resolves external files in a folder.
pub struct Beside(pub PathBuf);

impl Resolver for Beside {
    fn read(&self, path: &str, _max_bytes: u64) -> Result<Vec<u8>, raystep_scenes::FileError> {
        std::fs::read(self.0.join(path)).map_err(|e| e.to_string().into())
    }
}

/// Loads a scene file of the repository by its name.
#[must_use]
pub fn scene(file: &str) -> Scene {
    let dir = scenes_dir();
    let bytes = std::fs::read(dir.join(file)).unwrap_or_else(|e| panic!("{file}: {e}"));
    raystep_scenes::load(file, &bytes, &Beside(dir), &LoadOptions::default()).unwrap_or_else(|e| panic!("{file}: {e}"))
}

/// Every scene file of the repository, by name, in order.
#[must_use]
pub fn scene_files() -> Vec<String> {
    let entries = std::fs::read_dir(scenes_dir()).expect("the scenes folder");
    let mut files: Vec<String> = entries
        .filter_map(|e| e.ok()?.file_name().into_string().ok())
        .filter(|f| f.ends_with(".gltf") || f.ends_with(".glb"))
        .collect();
    files.sort();
    assert!(files.len() > 8, "{files:?}");
    files
}

/// The scene's first camera, or one that frames it.
#[must_use]
pub fn camera(scene: &Scene) -> Camera {
    scene.cameras.first().cloned().unwrap_or_else(|| Camera::framing(&scene.bounds()))
}

/// Default options for an image of the scene.
#[must_use]
pub fn options(scene: &Scene, width: u32, height: u32) -> Options {
    Options::new(RaySource::Camera { camera: camera(scene), width, height })
}

/// The best adapter. A test that needs one fails if there is none; it never passes by skipping.
#[must_use]
pub fn gpu() -> Arc<Gpu> {
    static GPU: OnceLock<Arc<Gpu>> = OnceLock::new();
    let open = || {
        let gpu = pollster::block_on(Gpu::new(&AdapterChoice::Best)).expect("an adapter: see tests/run.sh");
        eprintln!("adapter: {} ({}, {})", gpu.info.name, gpu.info.backend, gpu.info.driver_info);
        gpu
    };
    GPU.get_or_init(open).clone()
}

/// Every component of two streams that differs: (layer, ray, left, right).
pub fn differences<'a>(
    left: &'a StreamData,
    right: &'a StreamData,
) -> impl Iterator<Item = (usize, usize, u32, u32)> + 'a {
    let rays = left.width as usize * left.height as usize;
    let pairs = left.bits.iter().zip(&right.bits).enumerate();
    pairs.filter(|(_, (a, b))| a != b).map(move |(i, (&a, &b))| (i / rays, i % rays, a, b))
}

/// All streams of a run.
#[must_use]
pub fn streams_of(plan: &raystep_kernels::Plan) -> Vec<Stream> {
    plan.streams.iter().map(|s| s.what).collect()
}

/// The devices whose results are compared: the adapter, and the CPU.
#[must_use]
pub fn devices() -> Vec<(&'static str, Device)> {
    vec![("gpu", Device::Gpu(gpu())), ("cpu", Device::Cpu(None))]
}

/// The GPU of a device, if it is one.
#[must_use]
pub fn gpu_of(device: &Device) -> Option<&Gpu> {
    match device {
        Device::Gpu(gpu) => Some(gpu),
        _ => None,
    }
}

/// Runs to the end without shading and returns the renderer.
#[must_use]
pub fn traced(scene: &Scene, options: &Options, device: &Device) -> Renderer {
    block_on(gpu_of(device), async {
        let mut renderer = Renderer::new(scene, options, device).await.expect("a renderer");
        renderer.run(|_| ControlFlow::Continue(())).await.expect("a run");
        renderer
    })
}

/// A stream's values after a run.
#[must_use]
pub fn values(renderer: &Renderer, stream: Stream) -> StreamData {
    block_on(renderer.gpu().map(|g| &**g.gpu()), renderer.values(stream)).expect("values")
}

/// The hits of all rays, as bits: t, u, v and triangle.
#[must_use]
pub fn hits(renderer: &Renderer) -> [Vec<u32>; 4] {
    let (state, hit) = (values(renderer, streams::STATE), values(renderer, streams::HIT));
    [state.layer(1).to_vec(), hit.layer(0).to_vec(), hit.layer(1).to_vec(), hit.layer(2).to_vec()]
}

/// Compares a run's hits with f64 brute force.
#[must_use]
pub fn check(renderer: &Renderer) -> Report {
    check_rays(&read(renderer), |_, _| ControlFlow::Continue(()))
}

fn read(renderer: &Renderer) -> Traced<'_> {
    block_on(renderer.gpu().map(|g| &**g.gpu()), Traced::read(renderer)).expect("streams")
}

/// The mistakes of some of a run's rays, by f64 brute force; ties are not mistakes.
#[must_use]
pub fn mistakes_among(renderer: &Renderer, rays: &[usize]) -> Vec<Mistake> {
    let (traced, mut judge) = (read(renderer), Judge::default());
    block_on(None, judge.prepare(&traced, rays.to_vec()));
    let mistakes = judge.of(&traced, Cracks::Missed);
    mistakes.all().map(|judged| judged.mistake).filter(|mistake| mistake.verdict.is_error()).collect()
}

/// The results of a configuration.
#[derive(Clone, Debug)]
pub struct Checked {
    /// The configuration.
    pub configuration: Configuration,
    /// Comparison with f64 brute force.
    pub report: Report,
    /// The triangle hit by each ray.
    pub triangles: Vec<u32>,
}

/// Traces the same rays in several configurations and compares each with f64 brute force.
#[must_use]
pub fn check_each(scene: &Scene, options: &Options, configurations: &[Configuration], device: &Device) -> Vec<Checked> {
    let mut seen: Vec<([Vec<u32>; 3], Report)> = Vec::new();
    let check = |configuration: &Configuration| {
        // A fused kernel that does not shade generates its rays itself, so brute force could not read them.
        let shade = configuration.schedule == ScheduleKind::Fused && matches!(options.rays, RaySource::Camera { .. });
        let renderer = traced(scene, &Options { shade, ..configuration.of(options) }, device);
        assert_eq!(renderer.unfinished(), 0, "{configuration}");
        let traced = read(&renderer);
        // The same rays with the same hits need no second check: on one device most configurations agree.
        let [origins, directions, state, hit] = &traced.streams;
        let same = [[&origins.bits[..], &directions.bits].concat(), state.layer(1).to_vec(), hit.bits.clone()];
        let report = match seen.iter().find(|(streams, _)| *streams == same) {
            Some((_, report)) => report.clone(),
            None => {
                let report = check_rays(&traced, |_, _| ControlFlow::Continue(()));
                seen.push((same, report.clone()));
                report
            }
        };
        Checked {
            configuration: *configuration,
            report,
            triangles: hit.layer(2)[..renderer.plan().rays as usize].to_vec(),
        }
    };
    configurations.iter().map(check).collect()
}
