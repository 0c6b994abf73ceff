//! Rays to trace in a scene.

use std::ops::ControlFlow;

use raystep_kernels::{GridSize, Options, RayHit, RaySource, RenderError, Renderer};

use crate::rays::{PrimaryHits, RayKind, random};
use crate::subject::{Size, Subject};
use crate::{Error, Machine};

/// The default seed of random rays and orders.
pub const SEED: u32 = 1;

/// A scene at one size.
pub(super) struct Viewed<'a> {
    subject: &'a Subject,
    size: Size,
    grid: GridSize,
    seed: u32,
    /// Hits of the primary rays, traced when first needed.
    hits: Option<Vec<Option<RayHit>>>,
}

impl<'a> Viewed<'a> {
    pub(super) fn new(subject: &'a Subject, size: Size, grid: GridSize, seed: u32) -> Self {
        Self { subject, size, grid, seed, hits: None }
    }

    /// Rays of a kind; `None` if the scene has none of them.
    pub(super) fn rays(&mut self, kind: RayKind, machine: &Machine) -> Result<Option<RaySource>, Error> {
        let (Subject { scene, camera, .. }, Size { width, height }) = (self.subject, self.size);
        let rays = match kind {
            RayKind::Primary => return Ok(Some(self.subject.camera_rays(self.size))),
            RayKind::Random => random(&scene.bounds(), width as usize * height as usize, self.seed),
            RayKind::Bounce | RayKind::Shadow => {
                let hits = match self.hits.take() {
                    Some(hits) => hits,
                    None => machine.wait(self.trace(machine))?,
                };
                let hits = self.hits.insert(hits);
                let hits = PrimaryHits { scene, camera, width, hits };
                if kind == RayKind::Bounce { hits.bounce(self.seed) } else { hits.shadow(self.seed) }
            }
        };
        Ok((!rays.is_empty()).then_some(RaySource::Given(rays)))
    }

    /// The accelerator does not affect the hits. Always uses robust numerics, so that every set of rules is measured
    /// with the same rays.
    async fn trace(&self, machine: &Machine) -> Result<Vec<Option<RayHit>>, RenderError> {
        let rays = self.subject.camera_rays(self.size);
        let options = Options { shade: false, grid: self.grid, ..Options::new(rays) };
        let mut renderer = Renderer::new(&self.subject.scene, &options, &machine.device).await?;
        renderer.run(|_| ControlFlow::Continue(())).await?;
        renderer.hits().await
    }
}
