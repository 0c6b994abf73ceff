//! The scenes and rays to trace.

use std::path::{Path, PathBuf};

use glam::DVec3;
use raystep_kernels::{Accelerator, Options, RayHit, RaySource, Renderer, ScheduleKind};
use raystep_lab::RayKind;
use raystep_lab::rays::{PrimaryHits, random};
use raystep_scenes::{Camera, FileError, LoadOptions, Projection, Resolver, Scene, generate};

use crate::args::MeshArg;
use crate::machine::Machine;

/// Seed of random rays.
const SEED: u32 = 1;

/// The folder with a mesh's external files.
struct Beside(PathBuf);

impl Resolver for Beside {
    fn read(&self, path: &str, _max_bytes: u64) -> Result<Vec<u8>, FileError> {
        std::fs::read(self.0.join(path)).map_err(|e| e.to_string().into())
    }
}

/// A scene with its camera and name.
pub(crate) struct Viewed {
    pub(crate) name: String,
    pub(crate) scene: Scene,
    pub(crate) camera: Camera,
}

impl Viewed {
    fn new(name: &str, mut scene: Scene) -> Self {
        // Nothing is shaded, so drop normals and other attributes: there may be ten million.
        (scene.normals, scene.colors, scene.texcoords) = (None, None, None);
        let camera = scene.cameras.first().cloned().unwrap_or_else(|| Camera::framing(&scene.bounds()));
        Self { name: name.into(), scene, camera }
    }

    /// A generated scene of about this many triangles.
    pub(crate) fn generated(name: &str, triangles: Option<u64>) -> Result<Self, String> {
        let given: Vec<_> = triangles.map(|n| ("triangles", n)).into_iter().collect();
        let scene = generate::find(name).and_then(|g| g.make(&given)).map_err(|e| e.to_string())?;
        Ok(Self::new(name, scene))
    }

    /// A mesh from a file.
    pub(crate) fn read(mesh: &MeshArg) -> Result<Self, String> {
        let at = mesh.file.display().to_string();
        let bytes = std::fs::read(&mesh.file).map_err(|e| format!("{at}: {e}"))?;
        let beside = Beside(mesh.file.parent().unwrap_or(Path::new(".")).into());
        let scene = raystep_scenes::load(&at, &bytes, &beside, &LoadOptions::default());
        let scene = scene.map_err(|e| format!("{at}: {e}"))?;
        let mut viewed = Self::new(&mesh.name, scene);
        if let Some((eye, look_at, vertical_fov)) = mesh.view {
            let projection = Projection::Perspective { vertical_fov };
            viewed.camera = Camera::look_at(eye, look_at, DVec3::Y, projection)
                .ok_or_else(|| format!("--mesh {}: the eye and the point looked at are the same", mesh.name))?;
        }
        Ok(viewed)
    }

    pub(crate) fn primary(&self, (width, height): (u32, u32)) -> RaySource {
        RaySource::Camera { camera: self.camera.clone(), width, height }
    }

    /// The hits of primary rays.
    pub(crate) fn hits(&self, size: (u32, u32), machine: &Machine) -> Result<Vec<Option<RayHit>>, String> {
        let mut options = Options::new(self.primary(size));
        (options.accelerator, options.schedule, options.shade) = (Accelerator::Bvh, ScheduleKind::Fused, false);
        let hits = machine.wait(async {
            let mut renderer = Renderer::new(&self.scene, &options, machine.device()).await?;
            renderer.run(|_| std::ops::ControlFlow::Continue(())).await?;
            renderer.hits().await
        });
        hits.map_err(|e| e.to_string())
    }

    /// Rays of a kind, and a sixteenth of them for counting. `hits` are those of the primary rays of such an image.
    /// `None` if there are no rays of this kind.
    pub(crate) fn rays(
        &self,
        kind: RayKind,
        (width, height): (u32, u32),
        hits: &[Option<RayHit>],
    ) -> Option<(RaySource, RaySource)> {
        let of_hits = PrimaryHits { scene: &self.scene, camera: &self.camera, width, hits };
        let rays = match kind {
            RayKind::Primary => return Some((self.primary((width, height)), self.primary((width / 4, height / 4)))),
            RayKind::Random => random(&self.scene.bounds(), width as usize * height as usize, SEED),
            RayKind::Bounce => of_hits.bounce(SEED),
            RayKind::Shadow => of_hits.shadow(SEED),
        };
        let counted: Vec<_> = rays.iter().copied().step_by(16).collect();
        (!rays.is_empty()).then_some((RaySource::Given(rays), RaySource::Given(counted)))
    }
}
