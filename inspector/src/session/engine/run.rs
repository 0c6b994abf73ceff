//! The parts of requests that concern a run's device: opening, where it is, reading, and confirming a ray.

use std::sync::Arc;

use raystep_kernels::{Device, RenderError, Stream, StreamData};
use raystep_lab::layer_stats::LayerStats;
use raystep_scenes::Scene;

use super::super::Session;
use super::super::confirm::Confirming;
use super::super::copies::{fill, stream_copy, textures};
use super::super::request::{At, Opened, Texels, Update};
use super::super::sketch::Sketcher;
use super::{Moving, Run, Server, Trouble};
use crate::settings::Settings;

impl Server {
    /// Whether a ray waits to be confirmed.
    pub(super) fn is_confirming(&self) -> bool {
        self.run.as_ref().is_some_and(|run| run.confirming.is_asked())
    }

    /// A pass of the run that confirms a ray.
    pub(super) async fn confirm(&mut self) {
        let Some(run) = &mut self.run else { return };
        match run.confirming.step(&run.session, &run.device).await {
            Ok(None) => {}
            Ok(Some(trace)) => self.say(Update::Confirmed(Ok(Box::new(trace)))),
            Err(error) => self.say(Update::Confirmed(Err(error.to_string()))),
        }
    }

    pub(super) async fn read_all(&self, stream: Stream, counted: Option<usize>) -> Result<(), Trouble> {
        let Some(run) = &self.run else { return Ok(()) };
        let data = run.session.stream(stream).await?;
        let place = run.session.place();
        let counted = counted.filter(|&layer| layer < stream.layers());
        let counted = counted.map(|layer| (layer, LayerStats::of(stream, layer, data.layer(layer))));
        let StreamData { width, height, bits, .. } = data;
        self.say(Update::Texels(Texels { stream, place, region: [0, 0, width, height], bits, counted }));
        Ok(())
    }

    /// The old run stays until the new one is ready.
    pub(super) async fn open(
        &mut self,
        path: Option<String>,
        scene: Arc<Scene>,
        settings: Settings,
    ) -> Result<(), Trouble> {
        self.say(Update::Progress("building and compiling", 0, 0));
        let settings = Settings { device: settings.device.on(&self.devices.gpu), ..settings };
        let device = self.device(settings.device);
        if let (Device::Gpu(gpu), Some(clock)) = (&device, self.devices.clock) {
            gpu.check_clock(clock).await.map_err(|error| Trouble::Failed(error.to_string()))?;
        }
        let mut session = Session::new(&scene, &settings.options(&scene), &device).await?;
        session.sketcher = Sketcher::new(&self.devices.gpu, session.renderer(), &self.outbox);
        let renderer = session.renderer();
        let mut copies = Vec::new();
        let textures = textures(&self.devices.gpu, renderer, &mut copies);
        let device_name = match &device {
            Device::Gpu(gpu) => gpu.info.name.clone(),
            Device::Cpu(_) | Device::CpuF64(_) => settings.device.name().into(),
        };
        let why_no_times = match &device {
            Device::Gpu(gpu) => gpu.why_no_times(),
            Device::Cpu(clock) | Device::CpuF64(clock) => clock.is_none().then(|| "the host provided no clock".into()),
        };
        let _moving = Moving::new(&self.moving);
        self.say(Update::Opened(Box::new(Opened {
            path: path.clone(),
            scene: scene.clone(),
            settings: settings.clone(),
            plan: renderer.shared_plan(),
            data: renderer.shared_data(),
            textures,
            device: device_name,
            why_no_times,
        })));
        let confirming = Confirming::default();
        self.run = Some(Run { path, scene, settings, session, device, copies, known: 0, followed: None, confirming });
        self.arrived().await
    }

    /// Reports the run's place, once its streams can be drawn.
    pub(super) async fn arrived(&mut self) -> Result<(), Trouble> {
        let Some(run) = &mut self.run else { return Ok(()) };
        let renderer = run.session.renderer();
        if renderer.gpu().is_some() {
            // Without its device the run has no place: the last known place is where to resume.
            self.devices.gpu.health().map_err(|error| Trouble::Failed(error.to_string()))?;
        }
        // Streams come and go with the sizes of their elements.
        let is_fixed = renderer.plan().sets.iter().all(|set| set.size.is_some());
        let textures = (!is_fixed).then(|| textures(&self.devices.gpu, renderer, &mut run.copies));
        for (stream, texture) in &run.copies {
            let data = run.session.stream(*stream).await?;
            fill(&self.devices.gpu, texture, &data);
        }
        let (place, passes) = (run.session.place(), run.session.passes());
        // One known pass is included: it shows whether the rest is unchanged.
        let first = run.known.min(place.saturating_sub(1));
        let at = At {
            place,
            first,
            passes: passes[first..].to_vec(),
            next: run.session.renderer().next_kernel(),
            kept_bytes: run.session.kept_bytes(),
            budget: run.session.budget(),
            edits: run.session.edits().to_vec(),
            twins: run.session.twin_passes(),
            host_ns: run.session.renderer().host_ns(),
            textures,
        };
        run.known = place;
        self.say(Update::At(at));
        Ok(())
    }

    pub(super) fn pin(&self, stream: Stream) -> Result<(), Trouble> {
        let Some(run) = &self.run else { return Ok(()) };
        let source = match run.session.renderer().gpu() {
            Some(gpu) => gpu.texture(stream),
            None => run.copies.iter().find(|(s, _)| *s == stream).map(|(_, texture)| texture),
        };
        let source = source.ok_or_else(|| Trouble::Failed(RenderError::NoStream(stream.name()).to_string()))?;
        let texture = stream_copy(&self.devices.gpu, stream, source.width(), source.height());
        let gpu = &self.devices.gpu;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_texture(source.as_image_copy(), texture.as_image_copy(), source.size());
        gpu.submit([encoder.finish()]);
        self.say(Update::Pinned { stream, place: run.session.place(), texture });
        Ok(())
    }
}
