//! Opens devices, and notices when a device is lost.

use std::future::poll_fn;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::task::Poll;

use super::adapters::{DRAWING, drawing_limits, enumerate, is_usable, lacks, named, only_draws, told};
use super::buffers::filled_buffer;
use super::clock_check::Clock;
use super::compiled::Pipelines;
use super::error::{GpuError, first_line};
use super::gate::{Gate, Held};
use super::poller::{HostPolls, Poller};
use super::probe::loops;
use crate::plan::Loops;

/// A device, its queue, and its state.
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// The adapter's name, driver and backend.
    pub info: wgpu::AdapterInfo,
    /// Nanoseconds per tick of the pass timers; `None` if the adapter has none. Whether the ticks are valid times is
    /// told by [`clock_period_ns`](Self::clock_period_ns).
    pub timestamp_period_ns: Option<f64>,
    /// How it handles long loops: measured, or assumed if it has no compute shaders.
    pub loops: Loops,
    /// Whether kernels can run on it as compute shaders; otherwise it only draws.
    pub computes: bool,
    /// The device's instance and adapter: a window needs them to show what is drawn on it.
    pub source: Option<GpuSource>,
    trouble: Arc<Mutex<Option<GpuError>>>,
    pub(super) gate: Arc<Gate>,
    pub(super) compiled: Pipelines,
    pub(super) poller: Poller,
    pub(super) clock: OnceLock<Clock>,
    pub(super) rounded_to_ns: OnceLock<u64>,
}

/// The instance and adapter of a device.
#[derive(Clone, Debug)]
pub struct GpuSource {
    /// The instance that listed the adapter.
    pub instance: wgpu::Instance,
    /// The adapter that opened the device.
    pub adapter: wgpu::Adapter,
}

/// Which adapter to take.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum AdapterChoice {
    /// A hardware GPU if there is one, else a software adapter; the most capable first.
    #[default]
    Best,
    /// The first adapter whose name contains this, ignoring case.
    Named(String),
}

impl Gpu {
    /// Opens a device on the chosen adapter, with all the limits it offers, and with timestamps and pipeline statistics if
    /// it has them.
    ///
    /// # Errors
    /// If there is no such adapter, or it gives no device.
    pub async fn new(choice: &AdapterChoice) -> Result<Arc<Self>, GpuError> {
        let optional = wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::PIPELINE_STATISTICS_QUERY;
        Self::with_features(choice, optional).await
    }

    /// As [`new`](Self::new), but with only those of the `optional` features that the adapter has.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub async fn with_features(choice: &AdapterChoice, optional: wgpu::Features) -> Result<Arc<Self>, GpuError> {
        let (mut instance, adapters) = enumerate(wgpu::Backends::PRIMARY).await;
        let mut names: Vec<String> = adapters.iter().map(told).collect();
        let adapter = match choice {
            AdapterChoice::Best => adapters.into_iter().find(is_usable),
            AdapterChoice::Named(name) => {
                let wanted = name.to_lowercase();
                let is_wanted = |a: &wgpu::Adapter| named(a.get_info()).name.to_lowercase().contains(&wanted);
                let mut found = adapters.into_iter().find(is_wanted);
                if found.is_none() {
                    let drawing;
                    (instance, drawing) = enumerate(DRAWING).await;
                    names.extend(drawing.iter().map(told));
                    found = drawing.into_iter().find(is_wanted);
                }
                found
            }
        };
        let names = names.join(", ");
        let Some(adapter) = adapter else {
            let there = if names.is_empty() { "there are none".into() } else { format!("there are: {names}") };
            return Err(GpuError::NoAdapter(match choice {
                AdapterChoice::Best => format!("with compute shaders and core WebGPU limits ({there})"),
                AdapterChoice::Named(name) => format!("has {name:?} in its name ({there})"),
            }));
        };
        let info = named(adapter.get_info());
        let refused =
            |message: String| GpuError::NoDevice { adapter: info.name.clone(), message: first_line(&message) };
        let lacks = lacks(&adapter);
        if !lacks.is_empty() {
            return Err(refused(format!("it lacks {}", lacks.join(" and "))));
        }
        let only_draws = only_draws(&adapter);
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("raystep"),
            required_features: if only_draws { wgpu::Features::empty() } else { adapter.features() & optional },
            required_limits: if only_draws { drawing_limits(&adapter) } else { adapter.limits() },
            ..Default::default()
        };
        let (device, queue) = adapter.request_device(&descriptor).await.map_err(|e| refused(e.to_string()))?;
        if only_draws {
            let trouble = listen(&device);
            return Ok(Self::opened(device, queue, info, Some(GpuSource { instance, adapter }), None, trouble));
        }
        Self::from_device(device, queue, info, Some(GpuSource { instance, adapter })).await
    }

    /// Takes over a device that was opened elsewhere, and tests how it handles long loops.
    ///
    /// # Errors
    /// If the device is lost, or cannot be read back from.
    pub async fn from_device(
        device: wgpu::Device,
        queue: wgpu::Queue,
        info: wgpu::AdapterInfo,
        source: Option<GpuSource>,
    ) -> Result<Arc<Self>, GpuError> {
        // Before anything is done on it: without a listener, an error panics.
        let trouble = listen(&device);
        let loops = loops(&device, &queue).await?;
        Ok(Self::opened(device, queue, info, source, Some(loops), trouble))
    }

    /// Takes over a device without compute shaders, such as one of WebGL: it runs kernels as fragment programs with lists in
    /// textures.
    #[must_use]
    pub fn for_drawing(device: wgpu::Device, queue: wgpu::Queue, info: wgpu::AdapterInfo) -> Arc<Self> {
        let trouble = listen(&device);
        Self::opened(device, queue, named(info), None, None, trouble)
    }

    /// `loops`: how it handles long loops; `None` if it only draws.
    fn opened(
        device: wgpu::Device,
        queue: wgpu::Queue,
        info: wgpu::AdapterInfo,
        source: Option<GpuSource>,
        loops: Option<Loops>,
        trouble: Arc<Mutex<Option<GpuError>>>,
    ) -> Arc<Self> {
        let has_timestamps = device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        let timestamp_period_ns = has_timestamps.then(|| f64::from(queue.get_timestamp_period()));
        Arc::new(Self {
            device,
            queue,
            info,
            timestamp_period_ns,
            // It cannot be asked, and may be one of those with the lowest limit that is known.
            loops: loops.unwrap_or(Loops::EndAfter(65_535)),
            computes: loops.is_some(),
            source,
            trouble,
            gate: Arc::default(),
            compiled: Pipelines::default(),
            poller: Poller::default(),
            clock: OnceLock::new(),
            rounded_to_ns: OnceLock::new(),
        })
    }

    /// Whether the results of queries can be read in the submission that asks them. WebGL 2 has them only for a later
    /// event, and before it answers 0.
    pub(super) fn answers_queries(&self) -> bool {
        self.computes || !cfg!(target_arch = "wasm32")
    }

    /// Declares that the host polls the device whenever a future of this crate waits, so that no thread does (feature
    /// `poll-thread`), until the returned guard is dropped. For a loop that draws with the same device, or that has
    /// other events to wait for. Several hosts may poll at once.
    pub fn leave_polling_to_host(&self) -> HostPolls<'_> {
        HostPolls::new(&self.poller, &self.device)
    }

    /// Whether a future of this crate waits for the device to be polled.
    #[must_use]
    pub fn is_awaited(&self) -> bool {
        self.poller.is_expecting()
    }

    /// Tells the thread that polls (feature `poll-thread`) to end, and waits up to this long for it: whether it has ended.
    /// From then on only hosts poll. For a process that is about to end: a driver may crash if a thread calls it while
    /// its exit handlers run.
    #[must_use]
    pub fn end_polling(&self, patience: std::time::Duration) -> bool {
        self.poller.end(patience)
    }

    /// Drops the pipelines compiled so far, so that the next run compiles its own: to time a first start. Drivers may
    /// still keep theirs.
    pub fn forget_compiled(&self) {
        self.compiled.clear();
    }

    /// Whether its driver computes on the CPU.
    #[must_use]
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// Whether the device still works.
    ///
    /// # Errors
    /// The first error that occurred on it.
    pub fn health(&self) -> Result<(), GpuError> {
        health(&self.trouble)
    }

    /// As [`health`](Self::health), after an error whose cause may not be known yet: see [`cause`].
    pub(super) async fn health_after_an_error(&self) -> Result<(), GpuError> {
        cause(&self.device, &self.trouble).await
    }

    /// Starts catching errors of the calls that follow, until [`pop_scopes`](Self::pop_scopes).
    pub(super) fn push_scopes(&self) -> [wgpu::ErrorScopeGuard; 2] {
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let validation = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        // In the order in which they must be popped; an error in between drops them in this order too.
        [validation, memory]
    }

    /// Stops catching; resolves to the first error caught.
    pub(super) fn pop_scopes(
        &self,
        [validation, memory]: [wgpu::ErrorScopeGuard; 2],
    ) -> impl Future<Output = Result<(), GpuError>> + use<> {
        // Popped now, in reverse order; awaited later.
        let (validation, memory) = (validation.pop(), memory.pop());
        let (device, trouble) = (self.device.clone(), self.trouble.clone());
        async move {
            // Out of memory is the cause of the validation errors that follow it.
            let (validation, memory) = (validation.await, memory.await);
            match memory.or(validation) {
                None => health(&trouble),
                Some(error) => cause(&device, &trouble).await.and(Err(error.into())),
            }
        }
    }

    /// Submits work to the queue. Waits only while submissions are [held back](Self::hold_back), never for the GPU. All
    /// work is submitted here, except that of the thread that draws a window.
    pub fn submit(&self, work: impl IntoIterator<Item = wgpu::CommandBuffer>) {
        #[expect(clippy::disallowed_methods, reason = "the one place where it is called")]
        self.gate.pass(|| {
            self.queue.submit(work);
        });
    }

    /// A buffer with contents. If the device is lost or has no memory for it, that is reported as its errors are.
    pub fn filled_buffer(&self, label: &str, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        filled_buffer(&self.device, label, contents, usage)
    }

    /// Writes a part of a texture, rows and layers one after the other. Not while another thread
    /// submits: to submit, wgpu locks the queue and then the state of a texture, and to write, the other way round.
    pub fn write_texture(&self, to: wgpu::TexelCopyTextureInfo<'_>, size: wgpu::Extent3d, texels: &[u8]) {
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(to.texture.format().block_copy_size(None).unwrap_or(4) * size.width),
            rows_per_image: Some(size.height),
        };
        #[expect(clippy::disallowed_methods, reason = "the one place where it is called")]
        self.gate.pass(|| self.queue.write_texture(to, texels, layout, size));
    }

    /// Holds back everything that other threads submit, until the returned guard is dropped. The thread that calls this
    /// must not submit while it holds the guard.
    pub fn hold_back(self: &Arc<Self>) -> Held {
        self.gate.hold_back()
    }
}

/// Keeps the first error of a device, or its loss.
fn listen(device: &wgpu::Device) -> Arc<Mutex<Option<GpuError>>> {
    let trouble = Arc::new(Mutex::new(None));
    let lost = trouble.clone();
    device.set_device_lost_callback(move |reason, message| {
        let message = if message.is_empty() { format!("{reason:?}") } else { first_line(&message) };
        // Of other errors, it is the cause, though it may be reported after them.
        *lost.lock().unwrap_or_else(PoisonError::into_inner) = Some(GpuError::Lost(message));
    });
    let uncaptured = trouble.clone();
    device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
        // Keep the first error: later ones are its consequences.
        uncaptured.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error.into());
    }));
    trouble
}

/// The first error of a device, or its loss.
fn health(trouble: &Mutex<Option<GpuError>>) -> Result<(), GpuError> {
    match &*trouble.lock().unwrap_or_else(PoisonError::into_inner) {
        Some(error) => Err(error.clone()),
        None => Ok(()),
    }
}

/// The cause of an error, if the device tells one. A lost device refuses calls at once, but reports its loss by a poll after
/// all its work has ended, perhaps by that of another thread.
async fn cause(device: &wgpu::Device, trouble: &Mutex<Option<GpuError>>) -> Result<(), GpuError> {
    /// Polls after the work has ended: enough for another thread to report what it has seen.
    const POLLS: usize = 4;
    let mut left = POLLS;
    poll_fn(|context| {
        let status = device.poll(wgpu::PollType::Poll);
        let found = health(trouble);
        if matches!(status, Ok(wgpu::PollStatus::QueueEmpty)) {
            left -= 1;
        }
        // A browser reports a loss by itself, and polls nothing.
        if matches!(found, Err(GpuError::Lost(_))) || status.is_err() || left == 0 || cfg!(target_arch = "wasm32") {
            return Poll::Ready(found);
        }
        context.waker().wake_by_ref();
        Poll::Pending
    })
    .await
}
