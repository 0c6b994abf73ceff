//! Serves a run: a task that processes requests, reports progress, and can be cancelled.
//!
//! The task never blocks. On a desktop it has its own thread, in a browser it is polled there.

mod run;

use super::devices::Devices;
use super::request::flow;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use futures_channel::mpsc::{UnboundedReceiver, UnboundedSender};
use raystep_kernels::executor::gpu::StreamTexture;
use raystep_kernels::{Device, Progress, Region, RenderError, Stream};
use raystep_scenes::Scene;

use super::Session;
use super::confirm::Confirming;
use super::glimpse::Glimpses;
use super::request::{JobContext, Loaded, Request, Texels, Update};
use crate::settings::Settings;

/// The name of opening a scene in errors.
pub const OPENING: &str = "opening the scene";
/// The name of making a run of the open scene in errors.
pub const PREPARING: &str = "preparing the run";
/// The name of tracing at a lower resolution.
pub(super) const GLIMPSING: &str = "tracing at a lower resolution";
/// The name of following a ray.
pub(super) const FOLLOWING: &str = "following the ray";

/// A task that serves requests until all senders are gone.
pub type EngineTask = Pin<Box<dyn Future<Output = ()> + Send>>;

/// The engine's ends of the channels.
pub struct Engine {
    inbox: UnboundedReceiver<Request>,
    outbox: UnboundedSender<Update>,
    /// Requests up to this one are cancelled.
    cancel: Arc<AtomicU64>,
    moving: Arc<AtomicU64>,
    drawn: Arc<AtomicU64>,
}

struct Run {
    path: Option<String>,
    scene: Arc<Scene>,
    settings: Settings,
    session: Session,
    device: Device,
    /// Copies of the CPU reference's streams.
    copies: Vec<(Stream, StreamTexture)>,
    /// Number of passes that the client knows.
    known: usize,
    /// The selected pixel.
    followed: Option<[u32; 2]>,
    confirming: Confirming,
    glimpses: Glimpses,
}

/// Why a request was not served.
enum Trouble {
    Cancelled,
    Failed(String),
}

impl From<RenderError> for Trouble {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Cancelled { .. } => Self::Cancelled,
            other => Self::Failed(other.to_string()),
        }
    }
}

impl Engine {
    pub(super) fn new(
        inbox: UnboundedReceiver<Request>,
        outbox: UnboundedSender<Update>,
        cancel: Arc<AtomicU64>,
        moving: Arc<AtomicU64>,
        drawn: Arc<AtomicU64>,
    ) -> Self {
        Self { inbox, outbox, cancel, moving, drawn }
    }

    /// Serves requests on these devices.
    #[must_use]
    pub fn serve(self, devices: Devices) -> EngineTask {
        Box::pin(async move {
            let Self { mut inbox, outbox, cancel, moving, drawn } = self;
            let mut server =
                Server { outbox, cancel, served: 0, moving, drawn, kept_drawn: u64::MAX, devices, run: None };
            loop {
                let request = match inbox.try_recv() {
                    Ok(request) => request,
                    Err(_) if server.is_confirming() => {
                        server.confirm().await;
                        continue;
                    }
                    Err(_) => match inbox.recv().await {
                        Ok(request) => request,
                        Err(_) => break,
                    },
                };
                let what = name(&request);
                server.served += 1;
                if server.is_cancelled() {
                    server.say(Update::Cancelled(what));
                } else {
                    match server.answer(request).await {
                        Ok(()) => {}
                        Err(Trouble::Cancelled) => server.say(Update::Cancelled(what)),
                        Err(Trouble::Failed(message)) => server.say(Update::Failed(what, message)),
                    }
                }
                server.say(Update::Idle);
            }
        })
    }
}

/// Least time between two reports of progress: the window is drawn for each, which takes time from the work where both are
/// done by the CPU.
const TELL_EVERY_NS: u64 = 250_000_000;

/// The displayed name of a request.
fn name(request: &Request) -> &'static str {
    match request {
        Request::Open { .. } => OPENING,
        Request::Plan(_) | Request::Share(..) => PREPARING,
        Request::Glimpse(_) => GLIMPSING,
        Request::Step(_) => "stepping",
        Request::RunToWatch { .. } => "running to a watch",
        Request::Edit(..) => "editing a texel",
        Request::ClearEdits => "undoing edits",
        Request::TwinsUntil(_) => "running passes on the CPU reference",
        Request::Follow(_) | Request::Confirm(_) => FOLLOWING,
        Request::Draw | Request::Read { .. } | Request::ReadAll(_) | Request::Count(..) => "reading a stream",
        Request::Pin(_) => "pinning a stream",
        Request::Job(what, _) => what,
    }
}

struct Server {
    outbox: UnboundedSender<Update>,
    cancel: Arc<AtomicU64>,
    /// Requests so far.
    served: u64,
    moving: Arc<AtomicU64>,
    /// A bit for each stream that the window has drawn since it was asked last.
    drawn: Arc<AtomicU64>,
    /// What it said last.
    kept_drawn: u64,
    devices: Devices,
    run: Option<Run>,
}

/// While it exists, marks the streams as between places.
struct Moving(Arc<AtomicU64>);

impl Moving {
    fn new(count: &Arc<AtomicU64>) -> Self {
        count.fetch_add(1, Ordering::AcqRel);
        Self(count.clone())
    }
}

impl Drop for Moving {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::AcqRel);
    }
}

impl Server {
    fn say(&self, update: Update) {
        // The client is gone: the inbox ends next.
        let _ = self.outbox.unbounded_send(update);
        (self.devices.wake)();
    }

    fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed) >= self.served
    }

    /// The progress callback of work; work continues while it returns true.
    fn reporter(&self, what: &'static str) -> impl FnMut(u64, u64) -> bool + Send + use<> {
        let (outbox, cancel, wake) = (self.outbox.clone(), self.cancel.clone(), self.devices.wake.clone());
        let (served, clock) = (self.served, self.devices.clock);
        let (mut last, mut reported_ns) = (u64::MAX, None);
        move |done, of| {
            // A hundred reports are enough for a progress bar; without a known end, every hundredth.
            let mark = done.saturating_mul(100).checked_div(of).unwrap_or(done / 100);
            let now_ns = clock.map(|clock| clock());
            let is_soon =
                now_ns.zip(reported_ns).is_some_and(|(now, reported): (u64, u64)| now < reported + TELL_EVERY_NS);
            if mark != last && !is_soon {
                (last, reported_ns) = (mark, now_ns);
                let _ = outbox.unbounded_send(Update::Progress(what, done, of));
                wake();
            }
            cancel.load(Ordering::Relaxed) < served
        }
    }

    async fn answer(&mut self, request: Request) -> Result<(), Trouble> {
        match request {
            Request::Open { path, load, settings } => {
                self.say(Update::Progress("reading the scene", 0, 0));
                let Loaded { scene, folder } = match load(Box::new(self.reporter("reading the scene"))).await {
                    Ok(loaded) => loaded,
                    Err(_) if self.is_cancelled() => return Err(Trouble::Cancelled),
                    Err(message) => return Err(Trouble::Failed(message)),
                };
                self.open(Some(path), scene, Settings { folder, ..*settings }, 0).await
            }
            Request::Share(scene, settings) => self.open(None, scene, *settings, 0).await,
            Request::Plan(settings) => self.plan(*settings).await,
            Request::Glimpse(settings) => self.glimpse(*settings).await,
            Request::Step(target) => {
                let mut report = self.reporter("stepping");
                let _moving = Moving::new(&self.moving);
                let Some(run) = &mut self.run else { return Ok(()) };
                let stepped = run.session.step(target, &mut |p: &Progress| flow(report(p.rays_decided, p.rays))).await;
                self.arrived().await?;
                stepped.map(drop).map_err(Trouble::from)
            }
            Request::RunToWatch { watches, direction } => {
                let mut report = self.reporter("running to a watch");
                let _moving = Moving::new(&self.moving);
                let Some(run) = &mut self.run else { return Ok(()) };
                if let Some([x, y]) = run.followed {
                    run.session.select(x, y);
                }
                let tell = &mut |p: &Progress| flow(report(p.rays_decided, p.rays));
                let fired = run.session.run_to_watch(&watches, direction, tell).await;
                self.arrived().await?;
                self.say(Update::Fired(fired?));
                Ok(())
            }
            Request::Edit(stream, layer, [x, y], bits) => {
                let _moving = Moving::new(&self.moving);
                let Some(run) = &mut self.run else { return Ok(()) };
                run.known = run.session.place();
                run.session.edit(stream, layer, x, y, bits).await?;
                self.arrived().await
            }
            Request::ClearEdits => {
                let mut report = self.reporter("undoing edits");
                let _moving = Moving::new(&self.moving);
                let Some(run) = &mut self.run else { return Ok(()) };
                let cleared = run.session.clear_edits(&mut |p: &Progress| flow(report(p.rays_decided, p.rays))).await;
                run.known = 0;
                self.arrived().await?;
                cleared.map(drop).map_err(Trouble::from)
            }
            Request::TwinsUntil(passes) => {
                let mut report = self.reporter("running passes on the CPU reference");
                let _moving = Moving::new(&self.moving);
                let Some(run) = &mut self.run else { return Ok(()) };
                let tell = &mut |p: &Progress| flow(report(p.rays_decided, p.rays));
                let changed = run.session.twins_until(passes, tell).await;
                run.known = 0;
                self.arrived().await?;
                changed.map(drop).map_err(Trouble::from)
            }
            Request::Follow(subject) => {
                let mut report = self.reporter("following the ray");
                let _moving = Moving::new(&self.moving);
                let Some(run) = &mut self.run else { return Ok(()) };
                run.followed = subject.set.is_none().then_some(subject.texel).or(run.followed);
                let tell = &mut |p: &Progress| flow(report(p.rays_decided, p.rays));
                let followed = run.session.follow(subject, tell).await;
                self.arrived().await?;
                self.say(Update::Followed(Box::new(followed?)));
                Ok(())
            }
            Request::Confirm(pixel) => {
                let Some(run) = &mut self.run else { return Ok(()) };
                run.followed = Some(pixel);
                // On the CPU, the reference kernels are the run's own.
                if run.device.is_gpu() {
                    run.confirming.ask(pixel);
                }
                Ok(())
            }
            Request::Read { stream, region } => {
                let Some(run) = &self.run else { return Ok(()) };
                let [x, y, width, height] = region;
                let bits = run.session.region(stream, Region { x, y, width, height }).await?.bits;
                self.say(Update::Texels(Texels { stream, place: run.session.place(), region, bits, counted: None }));
                Ok(())
            }
            Request::Draw => {
                let _moving = Moving::new(&self.moving);
                self.arrived().await
            }
            Request::ReadAll(stream) => self.read_all(stream, None).await,
            Request::Count(stream, layer) => self.read_all(stream, Some(layer)).await,
            Request::Pin(stream) => self.pin(stream).await,
            Request::Job(what, job) => {
                let mut progress = self.reporter(what);
                let _moving = Moving::new(&self.moving);
                let Some(run) = &mut self.run else { return Ok(()) };
                let Run { session, scene, settings, device, .. } = run;
                let (device, measure) = (device.clone(), &self.devices.measure);
                let context = JobContext { session, scene, settings, device, measure, progress: &mut progress };
                let answer = job(context).await;
                self.arrived().await?;
                match answer {
                    Ok(answer) => self.say(Update::Done(what, answer)),
                    Err(_) if self.is_cancelled() => return Err(Trouble::Cancelled),
                    Err(message) => return Err(Trouble::Failed(message)),
                }
                Ok(())
            }
        }
    }
}
