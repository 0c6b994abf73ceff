//! Runs passes on a wgpu adapter. Nothing here blocks: results come back from the GPU as futures.

mod adapters;
mod bands;
mod batch;
mod books;
mod buffers;
mod clock;
mod clock_check;
mod clock_step;
mod compiled;
mod device;
mod error;
mod fill;
pub mod fragment;
mod gate;
mod limits;
mod load;
mod picture;
mod pipelines;
mod poller;
mod probe;
mod read;
pub mod readback;
mod repeat;
mod rounding;
mod snapshot;
mod stream_texture;
mod timers;
mod uploaded;

use crate::executor::sizes::Sizes;
use crate::program::Kernel;
use crate::tables::elements::{Elements, Size};
use std::sync::Arc;

pub use adapters::{AdapterSummary, adapters};
use books::Books;
pub use clock_check::ClockCheck;
pub use device::{AdapterChoice, Gpu, GpuSource};
pub use error::GpuError;
use fill::Fill;
pub use gate::Held;
pub use load::Load;
use pipelines::{Bindable, Pipelines};
pub use poller::HostPolls;
use repeat::Repeater;
use snapshot::Copies;
pub(crate) use snapshot::Snapshot;
pub use stream_texture::StreamTexture;
use stream_texture::allocate;
use timers::Timers;
use uploaded::{Uploaded, upload_scene, upload_size, upload_view};

use crate::options::Accelerator;
use crate::plan::Plan;
use crate::scene_data::SceneData;
use crate::shared::constants::TURNS_A_TEST;
use crate::tables::sizes::COUNT_SLOTS;
use crate::tables::stream::{STATE_TAG, Stream, StreamData, Texel};

/// Runs kernels over the rays of a plan.
pub struct GpuExecutor {
    gpu: Arc<Gpu>,
    plan: Arc<Plan>,
    sizes: Sizes,
    streams: Vec<(Stream, StreamTexture)>,
    buffers: Vec<(&'static str, Uploaded)>,
    pipelines: Pipelines,
    books: Books,
    fill: Fill,
    timers: Option<Timers>,
    repeater: Option<Repeater>,
    device_ns: Option<u64>,
    host_ns: Option<u64>,
    copies: Copies,
    /// Most rays per dispatch of a kernel that is launched in bands.
    rays_a_dispatch: u64,
    /// Most elements per dispatch of a kernel that is launched over a list, times the weight of each.
    work_a_dispatch: u64,
}

/// Most passes per submission: each needs a slot for its counts.
pub const MOST_PASSES: usize = COUNT_SLOTS as usize;

impl GpuExecutor {
    /// Allocates the plan's streams and buffers, uploads the buffers and compiles the variants. Validation and
    /// out-of-memory errors are returned and cause no panic.
    ///
    /// # Errors
    /// If the device refuses or is lost.
    pub async fn new(gpu: Arc<Gpu>, plan: &Arc<Plan>, data: &SceneData, timed: bool) -> Result<Self, GpuError> {
        Self::beside(gpu, plan, data, timed, None).await
    }

    /// Whether the device can still run passes.
    pub(crate) fn health(&self) -> Result<(), GpuError> {
        self.gpu.health()
    }

    /// As [`new`](Self::new), with the buffers of another executor for the same data, uploaded once for both.
    pub(crate) async fn beside(
        gpu: Arc<Gpu>,
        plan: &Arc<Plan>,
        data: &SceneData,
        timed: bool,
        other: Option<&Self>,
    ) -> Result<Self, GpuError> {
        gpu.health()?;
        let device = &gpu.device;
        let scopes = gpu.push_scopes();
        let sizes = Sizes::new(plan);
        let streams = allocate(device, plan, &sizes, plan.streams.iter().map(|planned| planned.what));
        let buffers = upload_scene(&gpu, plan, data, |name: &str| other.and_then(|other| other.uploaded(name)));
        let books = Books::new(device, plan);
        let bindable = Bindable { device, streams: &streams, buffers: &buffers };
        let pipelines = Pipelines::new(&gpu, plan, data, &bindable)?;
        let fill = Fill::new(device, &gpu.queue, plan);
        let timers = Timers::new(&gpu, plan, timed);
        let coarse_step_ns = timers.as_ref().and_then(|timers| timers.coarse_step_ns);
        let repeater = coarse_step_ns.map(|_| Repeater::new(device, &books));
        let rays_a_dispatch = rays_a_dispatch(gpu.info.device_type, plan);
        let work_a_dispatch = work_a_dispatch(gpu.info.device_type);
        let mut executor = Self {
            plan: plan.clone(),
            sizes,
            gpu,
            streams,
            buffers,
            pipelines,
            books,
            fill,
            timers,
            repeater,
            device_ns: Some(0),
            host_ns: Some(0),
            copies: Copies::default(),
            rays_a_dispatch,
            work_a_dispatch,
        };
        executor.clear();
        upload_size(&executor.gpu.queue, &executor.plan, &executor.buffers);
        if let Err(error) = executor.gpu.pop_scopes(scopes).await {
            executor.gpu.compiled.clear();
            return Err(error);
        }
        Ok(executor)
    }

    /// Uploads what depends on the camera.
    pub(crate) fn set_view(&self, data: &SceneData) {
        upload_view(&self.gpu, &self.plan, &self.buffers, data);
    }

    /// The device.
    #[must_use]
    pub fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    /// Where a stream is: in a 2D array with one layer per component.
    #[must_use]
    pub fn texture(&self, stream: Stream) -> Option<&StreamTexture> {
        self.streams.iter().find(|(s, _)| *s == stream).map(|(_, t)| t)
    }

    /// Scene data, by name. Not public: unchecked shaders take indices from it that were checked only once.
    fn uploaded(&self, name: &str) -> Option<&Uploaded> {
        self.buffers.iter().find(|(n, _)| *n == name).map(|(_, b)| b)
    }

    /// Names and sizes in bytes of everything that is allocated on the device.
    #[must_use]
    pub fn allocated(&self) -> Vec<(&'static str, u64)> {
        let streams = self.streams.iter().map(|(stream, texture)| (stream.name(), texture.bytes()));
        let buffers = self.buffers.iter().map(|(n, b)| (*n, b.bytes()));
        let kept = self.repeater.iter().flat_map(Repeater::allocated);
        streams.chain(buffers).chain(self.books.allocated()).chain(self.fill.allocated()).chain(kept).collect()
    }

    /// Device time of all passes so far: per submission from the begin of the first pass to the end of the last,
    /// summed; the mean of a pass that was repeated. `None` if the adapter has no timestamps, or one of them was not valid.
    #[must_use]
    pub fn device_ns(&self) -> Option<u64> {
        self.device_ns
    }

    /// Host time of all passes so far: per submission from recording it to knowing its results, summed. `None` if there
    /// is no host clock, see [`Gpu::check_clock`].
    #[must_use]
    pub fn host_ns(&self) -> Option<u64> {
        self.host_ns
    }

    /// The size of a set and its layout in the streams; `None` while it is unknown.
    #[must_use]
    pub fn size(&self, elements: &Elements) -> Option<Size> {
        self.sizes.of(self.plan.program, elements)
    }

    /// The size of the set that a kernel is launched over.
    fn launched_over(&self, kernel: Kernel) -> Size {
        self.size(kernel.instance().over).unwrap_or(Size { width: 0, height: 0, count: 0 })
    }

    /// The current size of each set.
    pub(crate) fn sizes(&self) -> Sizes {
        self.sizes.clone()
    }

    /// Resizes sets of elements; their streams are allocated again, unwritten.
    pub(crate) fn resize(&mut self, sizes: Sizes) -> Result<(), GpuError> {
        self.resize_adopting(sizes, &[])
    }

    /// As [`resize`](Self::resize), but renames the second stream of each pair to the first.
    fn resize_adopting(&mut self, sizes: Sizes, adopted: &[(Stream, Stream)]) -> Result<(), GpuError> {
        if sizes == self.sizes {
            return Ok(());
        }
        let mut moved = Vec::new();
        for (to, from) in adopted {
            if let Some(at) = self.streams.iter().position(|(stream, _)| stream == from) {
                moved.push((*to, self.streams.swap_remove(at).1));
            }
        }
        let program = self.plan.program;
        let before = std::mem::replace(&mut self.sizes, sizes);
        let is_moved = |stream: Stream| moved.iter().any(|(to, _)| *to == stream);
        let is_new = |stream: Stream| {
            let elements = stream.info().elements;
            is_moved(stream) || before.of(program, elements) != self.sizes.of(program, elements)
        };
        self.streams.retain(|(stream, _)| !is_new(*stream));
        let changed: Vec<Stream> = self.plan.streams.iter().map(|s| s.what).filter(|stream| is_new(*stream)).collect();
        changed.iter().for_each(|stream| self.copies.forget(*stream));
        let unmoved = changed.iter().copied().filter(|stream| !is_moved(*stream));
        let new = allocate(&self.gpu.device, &self.plan, &self.sizes, unmoved);
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.fill.clear(&mut encoder, &new);
        self.gpu.submit([encoder.finish()]);
        self.streams.extend(new);
        self.streams.extend(moved);
        let Self { gpu, streams, buffers, .. } = self;
        let bindable = Bindable { device: &gpu.device, streams, buffers };
        self.pipelines.bind(&bindable, |stream| changed.contains(&stream))
    }

    /// Resets every stream to its unwritten value, and forgets the sizes of all sets that the run has counted.
    pub fn clear(&mut self) {
        // Cannot fail: kernels are not bound to sets without a size.
        let _: Result<(), GpuError> = self.resize(Sizes::new(&self.plan));
        self.books.clear();
        self.copies.forget_all();
        self.device_ns = self.timers.as_ref().map(|_| 0);
        self.host_ns = self.gpu.host_clock().map(|_| 0);
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.fill.clear(&mut encoder, &self.streams);
        self.gpu.submit([encoder.finish()]);
    }

    /// Sets the initial contents of some streams from now on: input rays.
    pub(crate) fn give(&mut self, streams: &[StreamData]) {
        self.fill.give(&self.gpu.device, &self.gpu.queue, streams);
    }

    /// Replaces one component of one ray, except its tag, on which the lists depend. Returns false if the plan left the
    /// stream out or the image has no such pixel.
    pub(crate) fn write_component(&mut self, stream: Stream, layer: usize, x: u32, y: u32, bits: u32) -> bool {
        let is_there = |t: &&StreamTexture| x < t.width() && y < t.height() && layer < stream.layers();
        let Some(texture) = self.texture(stream).filter(is_there) else { return false };
        let size = wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 };
        self.gpu.write_texture(texture.copy_at(x, y, layer as u32), size, bytemuck::bytes_of(&bits));
        self.copies.forget(stream);
        true
    }

    /// Replaces a stream. Returns false if the plan left it out or the size differs.
    pub fn write(&mut self, data: &StreamData) -> bool {
        let Some(texture) = self.texture(data.stream) else { return false };
        let size = texture.size();
        let texels = size.width as usize * size.height as usize * size.depth_or_array_layers as usize;
        if (data.width, data.height) != (size.width, size.height) || data.bits.len() != texels {
            return false;
        }
        self.gpu.write_texture(texture.as_image_copy(), size, bytemuck::cast_slice(&data.bits));
        self.copies.forget(data.stream);
        if self.plan.program.has_states(data.stream) {
            let of = data.stream.info().elements;
            self.books.relist(&self.gpu.queue, of, data.layer(STATE_TAG), data.width);
        }
        true
    }
}

/// Most rays that one dispatch of the fused kernel may trace, so that none takes much longer than 200 ms, after which
/// some systems reset the GPU.
fn rays_a_dispatch(kind: wgpu::DeviceType, plan: &Plan) -> u64 {
    const TESTS: u64 = 1 << 30;
    // Of a path, one ray at each of its hits, or less: few have all of their bounces, and a shadow ray at each.
    let of_path = if plan.features.whole_paths { u64::from(plan.features.depth) + 1 } else { 1 };
    if plan.accelerator == Accelerator::None {
        let most = if plan.features.resumes { u64::from(plan.features.turns / TURNS_A_TEST).max(1) } else { u64::MAX };
        return TESTS / plan.triangles.clamp(1, most) / of_path;
    }
    let rays: u64 = match kind {
        wgpu::DeviceType::DiscreteGpu => 1 << 24,
        _ => 1 << 20,
    };
    rays / of_path
}

/// How many elements of a kernel with a weight of 1 one dispatch may process, so that none takes longer than 200 ms: on
/// software Vulkan, 2¹³ elements of the heaviest kernels take 100 to 150 ms on two cores.
fn work_a_dispatch(kind: wgpu::DeviceType) -> u64 {
    match kind {
        wgpu::DeviceType::DiscreteGpu => 1 << 26,
        wgpu::DeviceType::Cpu => 1 << 18,
        _ => 1 << 22,
    }
}

/// The texture format of a stream.
#[must_use]
pub fn stream_format(stream: Stream) -> wgpu::TextureFormat {
    match stream.info().texel {
        Texel::F32 => wgpu::TextureFormat::R32Float,
        Texel::U32 => wgpu::TextureFormat::R32Uint,
    }
}
