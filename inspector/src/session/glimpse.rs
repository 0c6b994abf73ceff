//! Quick pictures at a lower resolution, while a camera turns or an option is dragged.

use raystep_kernels::executor::gpu::StreamTexture;
use raystep_kernels::options::mapping::Mapping;
use raystep_kernels::{Choices, Device, Options, RenderError, Renderer, Samples, ScheduleKind, Stream};
use raystep_scenes::Scene;
use smart_default::SmartDefault;

use super::OnProgress;
use super::copies::{copy_of, fill, stream_copy};
use super::devices::Devices;
use super::request::Glimpse;
use crate::settings::Settings;

/// A picture that takes longer is followed by a coarser one, nanoseconds.
const LONG_NS: u64 = 40_000_000;
/// A picture that takes less time is followed by a finer one.
const SHORT_NS: u64 = 8_000_000;
/// Pixels of the image per pixel of a glimpse, along each axis, as a power of two: at first, and at least and most.
const COARSE: u32 = 2;
const FINEST: u32 = 1;
const COARSEST: u32 = 4;
/// Steps per pass: passes are not looked at.
const STEPS: u32 = 64;

/// The run that traces glimpses, and how coarse they are.
#[derive(SmartDefault)]
pub(super) struct Glimpses {
    run: Option<(Settings, Renderer)>,
    #[default(COARSE)]
    coarse: u32,
    count: u64,
}

impl Glimpses {
    /// Traces a picture with these settings. `None` for a program without an image.
    pub(super) async fn trace(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        device: &Device,
        devices: &Devices,
        progress: &mut OnProgress<'_>,
    ) -> Result<Option<Glimpse>, RenderError> {
        let begin_ns = devices.clock.map(|clock| clock());
        let settings = self.coarser(settings);
        let mut renderer = self.renderer(scene, &settings, device).await?;
        let Some(stream) = renderer.plan().streams.iter().map(|s| s.what).find(|stream| stream.is_color()) else {
            return Ok(None);
        };
        renderer.run(progress).await?;
        let texture = picture(&renderer, stream, devices).await?;
        if let Some((begin_ns, now)) = begin_ns.zip(devices.clock) {
            self.coarse = match now().saturating_sub(begin_ns) {
                // What was built or compiled will not be again.
                LONG_NS.. if self.run.is_some() => (self.coarse + 1).min(COARSEST),
                ..SHORT_NS => (self.coarse - 1).max(FINEST),
                _ => self.coarse,
            };
        }
        self.run = Some((settings, renderer));
        self.count += 1;
        Ok(Some(Glimpse { stream, texture, index: self.count }))
    }

    fn coarser(&self, settings: &Settings) -> Settings {
        let size = settings.size.map(|side| side.div_ceil(1 << self.coarse).max(1));
        let choices = Choices {
            samples: Samples::default(),
            schedule: ScheduleKind::Compact,
            steps_per_pass: STEPS,
            mapping: Mapping::Compute,
            ..settings.choices
        };
        Settings { size, choices, counters: false, ..settings.clone() }
    }

    /// The run of the last glimpse if only the camera is another.
    async fn renderer(&mut self, scene: &Scene, settings: &Settings, device: &Device) -> Result<Renderer, RenderError> {
        let options = Options { timings: false, keep_passes: false, ..settings.options(scene) };
        let (kept, mut renderer) = match self.run.take() {
            Some(run) => run,
            None => return Renderer::new(scene, &options, device).await,
        };
        let kept = Settings { view: settings.view, ..kept };
        if kept == *settings && renderer.look(scene, &options)? {
            self.run = None;
            return Ok(renderer);
        }
        Renderer::new(scene, &options, device).await
    }
}

/// A copy of a stream, which the next glimpse does not change.
async fn picture(renderer: &Renderer, stream: Stream, devices: &Devices) -> Result<StreamTexture, RenderError> {
    let gpu = &devices.gpu;
    let plan = renderer.plan();
    if let Some(own) = renderer.texture(stream) {
        return Ok(copy_of(gpu, stream.name(), &own));
    }
    let copy = stream_copy(gpu, stream, plan.width, plan.height);
    fill(gpu, &copy, &renderer.values(stream).await?);
    Ok(copy)
}
