//! The streams before a pass: one ray's at once from the CPU reference kernels where they tell the run's own, else from
//! the session, which goes there and comes back; and passes in which an element stops.

use std::pin::Pin;
use std::task::{Context, Poll};

use raystep_kernels::export::trace::RunSoFar;
use raystep_kernels::{RenderError, Stream};
use raystep_lab::passed::{Before, Begun, Code};
use raystep_lab::stops::{self, StopsError};

use super::travel::Guide;
use super::{HistorySource, Model, OnProgress, Session, Target, go_on};
use crate::settings::DeviceKind;

impl Model {
    /// A ray's texels in these streams before a pass. `None` if only the session's streams tell: after an edit, with
    /// passes on the CPU reference, for a ray that was entered, or if the device differs from the CPU reference.
    #[must_use]
    pub fn texels_before(&self, pixel: [u32; 2], pass: usize, streams: &[Stream]) -> Option<Vec<u32>> {
        let opened = self.opened.as_ref().filter(|_| self.edits.is_empty() && self.twins.is_none())?;
        if matches!(&self.history_source, HistorySource::Compared { differing } if !differing.is_empty()) {
            return None;
        }
        let (plan, data) = (&opened.plan, &opened.data);
        let run = RunSoFar { plan, data, passes: &self.passes, is_complete: self.is_complete };
        match opened.settings.device {
            DeviceKind::CpuF64 => run.texels_before::<f64>(pixel, pass, streams),
            DeviceKind::Auto | DeviceKind::Gpu | DeviceKind::Cpu => run.texels_before::<f32>(pixel, pass, streams),
        }
    }
}

impl Session {
    /// What a pass began with in these streams, read on the way; the session returns to the current place. `None` if the run
    /// has no such pass.
    ///
    /// # Errors
    /// If the plan left a stream out, or the device fails.
    pub async fn begun(&mut self, pass: usize, streams: &[Stream]) -> Result<Option<Begun>, RenderError> {
        let here = self.place();
        self.step(Target::Pass(pass), &mut go_on).await?;
        let before = Before::read(&self.renderer, streams).await?;
        self.step(Target::Pass(pass + 1), &mut go_on).await?;
        let begun = before.and_then(|before| before.begun(&self.renderer)).filter(|begun| begun.pass.index == pass);
        self.step(Target::Pass(here), &mut go_on).await?;
        Ok(begun)
    }

    /// Runs to the next pass in which an element stops, after which the session then is; if there is none, it returns.
    ///
    /// # Errors
    /// If the device fails, an element cannot be interpreted, or `progress` stops it: with the place reached.
    pub async fn run_to_stop(
        &mut self,
        code: &Code,
        progress: &mut OnProgress<'_>,
    ) -> Result<stops::Outcome, StopsError> {
        let mut guide = Guide::new(progress);
        let here = self.place();
        let (mut passes, mut reached) = (0, 0);
        while let Some(kernel) = self.renderer.next_kernel() {
            guide.check(self.place())?;
            let before = match kernel == code.kernel() {
                true => Before::read(&self.renderer, code.streams()).await?,
                false => None,
            };
            self.go(self.place() + 1, &mut guide).await?;
            let Some(begun) = before.and_then(|before| before.begun(&self.renderer)) else { continue };
            let found = stops::of_pass(code, &begun, self.renderer.data())?;
            if found.held().next().is_some() {
                return Ok(stops::Outcome::Stopped(found));
            }
            passes += 1;
            reached += found.elements.len() as u64;
            pause().await;
        }
        let of = self.place();
        self.go(here, &mut guide).await?;
        Ok(stops::Outcome::Never { passes, of, reached, is_cut: false })
    }
}

/// Lets other tasks run, between two pieces of long work.
pub async fn pause() {
    Pause(false).await;
}

struct Pause(bool);

impl Future for Pause {
    type Output = ();

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<()> {
        if std::mem::replace(&mut self.0, true) {
            return Poll::Ready(());
        }
        context.waker().wake_by_ref();
        Poll::Pending
    }
}
