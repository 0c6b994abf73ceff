//! The parts of requests that concern a run's device: opening, where it is, reading, and confirming a ray.

use crate::session::request::flow;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use futures_channel::mpsc::{UnboundedReceiver, unbounded};
use raystep_kernels::{Device, Progress, RenderError, Stream, StreamData};
use raystep_lab::layer_stats::LayerStats;
use raystep_scenes::Scene;

use super::super::confirm::Confirming;
use super::super::copies::{bit, copy_of, textures};
use super::super::glimpse::Glimpses;
use super::super::request::{At, Opened, Texels, Update};
use super::super::sketcher::Sketcher;
use super::super::{Session, Target};
use super::{GLIMPSING, Moving, PREPARING, Run, Server, Trouble};
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

    /// The old run stays until the new one is ready, at a place that is not before `place` where it has that many passes.
    pub(super) async fn open(
        &mut self,
        path: Option<String>,
        scene: Arc<Scene>,
        settings: Settings,
        place: usize,
    ) -> Result<(), Trouble> {
        self.say(Update::Progress("building and compiling", 0, 0));
        let settings = settings.on(&self.devices.gpu);
        let device = self.devices.of(settings.device);
        if let (Device::Gpu(gpu), Some(clock)) = (&device, self.devices.clock) {
            gpu.check_clock(clock).await.map_err(|error| Trouble::Failed(error.to_string()))?;
        }
        let mut session = Session::new(&scene, &settings.options(&scene), &device).await?;
        let sketches = self.sketch(&mut session);
        let reached = self.reach(&mut session, place).await;
        if let Err(Trouble::Failed(message)) = reached {
            return Err(Trouble::Failed(message));
        }
        let (confirming, glimpses) = (Confirming::default(), Glimpses::default());
        let copies = Vec::new();
        self.run = Some(Run {
            path,
            scene,
            settings,
            session,
            device,
            copies,
            known: 0,
            followed: None,
            confirming,
            glimpses,
        });
        self.ready(sketches).await?;
        reached
    }

    /// A run of the same scene at the same place. If only the camera is another, nothing is built or compiled.
    pub(super) async fn plan(&mut self, settings: Settings) -> Result<(), Trouble> {
        let settings = settings.on(&self.devices.gpu);
        let moving = Moving::new(&self.moving);
        let Some(mut run) = self.run.take() else { return Ok(()) };
        let place = if run.session.renderer().next_kernel().is_none() { usize::MAX } else { run.session.place() };
        let is_only_a_view = Settings { view: settings.view, ..run.settings.clone() } == settings;
        let options = settings.options(&run.scene);
        let looks = if is_only_a_view { run.session.look(&run.scene, &options) } else { Ok(false) };
        if !matches!(looks, Ok(true)) {
            drop(moving);
            let (path, scene) = (run.path.clone(), run.scene.clone());
            self.run = Some(run);
            looks?;
            return self.open(path, scene, settings, place).await;
        }
        run.settings = settings;
        (run.known, run.followed, run.confirming) = (0, None, Confirming::default());
        let sketches = self.sketch(&mut run.session);
        let reached = self.reach(&mut run.session, place).await;
        self.run = Some(run);
        self.ready(sketches).await?;
        reached
    }

    /// Has the session make sketches; those made before its run is reported are sent after that.
    fn sketch(&self, session: &mut Session) -> UnboundedReceiver<Update> {
        let (before, sketches) = unbounded();
        session.sketcher = Sketcher::new(&self.devices.gpu, session.renderer(), &before);
        sketches
    }

    async fn reach(&self, session: &mut Session, place: usize) -> Result<(), Trouble> {
        if place == 0 {
            return Ok(());
        }
        let mut report = self.reporter(PREPARING);
        let tell = &mut |p: &Progress| flow(report(p.rays_decided, p.rays));
        session.step(Target::Pass(place), tell).await.map(drop).map_err(Trouble::from)
    }

    /// Reports a run that is ready, once its streams can be drawn, and what was sketched on the way.
    async fn ready(&mut self, mut sketches: UnboundedReceiver<Update>) -> Result<(), Trouble> {
        let at = self.at().await?;
        let Some((run, at)) = self.run.as_mut().zip(at) else { return Ok(()) };
        if let Some(sketcher) = &mut run.session.sketcher {
            sketcher.send_to(&self.outbox);
        }
        let renderer = run.session.renderer();
        let textures = textures(&self.devices.gpu, renderer, &mut run.copies);
        let device = match &run.device {
            Device::Gpu(gpu) => gpu.info.name.clone(),
            Device::Cpu(_) | Device::CpuF64(_) => run.settings.device.name().into(),
        };
        let why_no_times = match &run.device {
            Device::Gpu(gpu) => gpu.why_no_times(),
            Device::Cpu(clock) | Device::CpuF64(clock) => clock.is_none().then(|| "the host provided no clock".into()),
        };
        let opened = Opened {
            path: run.path.clone(),
            scene: run.scene.clone(),
            settings: run.settings.clone(),
            plan: renderer.shared_plan(),
            data: renderer.shared_data(),
            textures,
            device,
            why_no_times,
        };
        self.say(Update::Opened(Box::new(opened), at));
        while let Ok(sketch) = sketches.try_recv() {
            // The client is gone: the inbox ends next.
            let _ = self.outbox.unbounded_send(sketch);
        }
        Ok(())
    }

    /// Reports the run's place, once its streams can be drawn.
    pub(super) async fn arrived(&mut self) -> Result<(), Trouble> {
        if let Some(at) = self.at().await? {
            self.say(Update::At(at));
        }
        Ok(())
    }

    /// The run's place; copies the streams that cannot be drawn where they are.
    async fn at(&mut self) -> Result<Option<At>, Trouble> {
        let Some(run) = &mut self.run else { return Ok(None) };
        let renderer = run.session.renderer();
        // Without its device the run has no place: the last known place is where to resume.
        renderer.health().map_err(|error| Trouble::Failed(error.to_string()))?;
        // Streams come and go with the sizes of their elements, and if they are drawn, two textures may take turns.
        let is_fixed = renderer.plan().sets.iter().all(|set| set.size.is_some()) && renderer.plan().drawn.is_none();
        let now = textures(&self.devices.gpu, renderer, &mut run.copies);
        // What is not drawn need not be copied: a stream has up to four megabytes at a usual size.
        match self.drawn.swap(0, Ordering::AcqRel) {
            0 => {}
            drawn => self.kept_drawn = drawn,
        }
        let filled = if run.copies.is_empty() { u64::MAX } else { self.kept_drawn };
        for (_, (stream, texture)) in run.copies.iter().enumerate().filter(|(i, _)| filled & bit(*i) != 0) {
            run.session.copy_stream(&self.devices.gpu, *stream, texture).await?;
        }
        let (place, passes) = (run.session.place(), run.session.passes());
        // One known pass is included: it shows whether the rest is unchanged.
        let first = run.known.min(place.saturating_sub(1));
        let at = At {
            place,
            first,
            passes: passes[first..].to_vec(),
            draws: run.session.renderer().draws().get(first..).unwrap_or_default().to_vec(),
            next: run.session.renderer().next_kernel(),
            kept_bytes: run.session.kept_bytes(),
            budget: run.session.budget(),
            edits: run.session.edits().to_vec(),
            twins: run.session.twin_passes(),
            host_ns: run.session.renderer().host_ns(),
            textures: (!is_fixed).then_some(now),
            filled,
        };
        run.known = place;
        Ok(Some(at))
    }

    /// A picture at a lower resolution; the run is left alone.
    pub(super) async fn glimpse(&mut self, settings: Settings) -> Result<(), Trouble> {
        let gpu = &self.devices.gpu;
        // Where every pass is waited for, many small ones are faster on the CPU.
        let settings = if gpu.computes { settings.on(gpu) } else { settings.computed() };
        let device = self.devices.of(settings.device);
        let mut report = self.reporter(GLIMPSING);
        let Some(run) = &mut self.run else { return Ok(()) };
        let tell = &mut |p: &Progress| flow(report(p.rays_decided, p.rays));
        if let Some(glimpse) = run.glimpses.trace(&run.scene, &settings, &device, &self.devices, tell).await? {
            self.say(Update::Glimpsed(glimpse));
        }
        Ok(())
    }

    pub(super) async fn pin(&self, stream: Stream) -> Result<(), Trouble> {
        let Some(run) = &self.run else { return Ok(()) };
        let copied = run.copies.iter().find(|(s, _)| *s == stream).map(|(_, texture)| texture);
        if let Some(copy) = copied {
            run.session.copy_stream(&self.devices.gpu, stream, copy).await?;
        }
        let source = copied.cloned().or_else(|| run.session.renderer().texture(stream));
        let source = source.ok_or_else(|| Trouble::Failed(RenderError::NoStream(stream.name()).to_string()))?;
        let texture = copy_of(&self.devices.gpu, stream.name(), &source);
        self.say(Update::Pinned { stream, place: run.session.place(), texture });
        Ok(())
    }
}
