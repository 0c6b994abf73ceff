//! The rays that are traced in a scene.

use std::ops::ControlFlow;

use raystep_kernels::{Options, RayHit, RaySource, Renderer};
use raystep_lab::Machine;
use raystep_lab::RayKind;
use raystep_lab::rays::{PrimaryHits, random};

use crate::args::{Size, TuningArgs};
use crate::commands::input::Input;
use crate::error::Error;

/// What random rays begin with: the same in every run of every version.
pub(super) const SEED: u32 = 1;

/// A scene at one size.
pub(super) struct Viewed<'a> {
    input: &'a Input,
    size: Size,
    tuning: &'a TuningArgs,
    /// What primary rays hit, once somebody needs it.
    hits: Option<Vec<Option<RayHit>>>,
}

impl<'a> Viewed<'a> {
    pub(super) fn new(input: &'a Input, size: Size, tuning: &'a TuningArgs) -> Self {
        Self { input, size, tuning, hits: None }
    }

    /// Rays of a kind; `None` where there is not a single one.
    pub(super) fn rays(&mut self, kind: RayKind, chosen: &Machine) -> Result<Option<RaySource>, Error> {
        let (Input { scene, camera, .. }, Size { width, height }) = (self.input, self.size);
        let rays = match kind {
            RayKind::Primary => return Ok(Some(self.primary())),
            RayKind::Random => random(&scene.bounds(), width as usize * height as usize, SEED),
            RayKind::Bounce | RayKind::Shadow => {
                let hits = match self.hits.take() {
                    Some(hits) => hits,
                    None => self.trace(chosen)?,
                };
                let hits = self.hits.insert(hits);
                let hits = PrimaryHits { scene, camera, width, hits };
                if kind == RayKind::Bounce { hits.bounce(SEED) } else { hits.shadow(SEED) }
            }
        };
        Ok((!rays.is_empty()).then_some(RaySource::Given(rays)))
    }

    fn primary(&self) -> RaySource {
        let Size { width, height } = self.size;
        RaySource::Camera { camera: self.input.camera.clone(), width, height }
    }

    /// Which structure finds the hits does not matter, and the rules are always the robust ones: what is
    /// measured with other rules is measured with the same rays.
    fn trace(&self, chosen: &Machine) -> Result<Vec<Option<RayHit>>, Error> {
        let options = Options { shade: false, grid: self.tuning.grid, ..Options::new(self.primary()) };
        let mut renderer = chosen.wait(Renderer::new(&self.input.scene, &options, &chosen.device))?;
        chosen.wait(renderer.run(|_| ControlFlow::Continue(())))?;
        Ok(chosen.wait(renderer.hits())?)
    }
}
