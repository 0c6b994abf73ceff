//! The streams before a pass: one ray's at once from the CPU reference kernels where they tell the run's own, else from
//! the session, which goes there and comes back.

use std::pin::Pin;
use std::task::{Context, Poll};

use raystep_kernels::export::trace::RunSoFar;
use raystep_kernels::{Region, RenderError, Stream, StreamData};

use super::{HistorySource, Model, Session, Target, go_on};
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
    /// Reads streams, or one pixel of them, before a pass, and returns to the current place.
    ///
    /// # Errors
    /// If the plan left a stream out, there is no such pixel, or the device fails.
    pub async fn streams_before(
        &mut self,
        pass: usize,
        streams: &[Stream],
        pixel: Option<[u32; 2]>,
    ) -> Result<Vec<StreamData>, RenderError> {
        let here = self.place();
        self.step(Target::Pass(pass), &mut go_on).await?;
        let read = self.read(streams, pixel).await;
        self.step(Target::Pass(here), &mut go_on).await?;
        read
    }

    async fn read(&self, streams: &[Stream], pixel: Option<[u32; 2]>) -> Result<Vec<StreamData>, RenderError> {
        let mut all = Vec::with_capacity(streams.len());
        for &stream in streams {
            all.push(match pixel {
                Some([x, y]) => self.region(stream, Region { x, y, width: 1, height: 1 }).await?,
                None => self.stream(stream).await?,
            });
        }
        Ok(all)
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
