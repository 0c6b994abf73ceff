//! Confirms a ray's history by the device's own streams: in a second run, so that the session stays where it is.

use raystep_kernels::export::trace::{Follower, Rays, Trace};
use raystep_kernels::{Device, Options, RenderError, Renderer};

use super::Session;

/// A second run of a session's plan on its device, in which a ray is followed pass by pass.
#[derive(Default)]
pub(super) struct Confirming {
    /// Made when it is first needed.
    renderer: Option<Renderer>,
    /// The ray to begin with.
    asked: Option<[u32; 2]>,
    /// The ray that is followed.
    follower: Option<Follower>,
}

impl Confirming {
    /// Follows this ray next, and gives up the one before.
    pub(super) fn ask(&mut self, pixel: [u32; 2]) {
        (self.asked, self.follower) = (Some(pixel), None);
    }

    /// Whether there is a ray to follow.
    pub(super) fn is_asked(&self) -> bool {
        self.asked.is_some() || self.follower.is_some()
    }

    /// Runs a pass; returns the ray's history after the last one. A ray that fails is given up.
    pub(super) async fn step(&mut self, session: &Session, device: &Device) -> Result<Option<Trace>, RenderError> {
        let (asked, follower) = (self.asked.take(), self.follower.take());
        let renderer = match &mut self.renderer {
            Some(renderer) => renderer,
            none => {
                let options = Options { timings: false, keep_passes: false, ..session.options().clone() };
                none.insert(session.renderer().another(&options, device).await?)
            }
        };
        let mut follower = match (asked, follower) {
            (Some(pixel), _) => Follower::begin(renderer, pixel, Rays::One).await?,
            (None, Some(follower)) => follower,
            (None, None) => return Ok(None),
        };
        if follower.step(renderer).await?.is_some() {
            self.follower = Some(follower);
            return Ok(None);
        }
        Ok(Some(follower.finish(renderer)))
    }
}
