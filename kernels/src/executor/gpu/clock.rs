//! Checks whether a device's timestamps are valid times.
//!
//! Those of some drivers are not: they tell when a command was recorded or started, not when it was done. So the device
//! runs arithmetic that takes long enough to be measured on the host's clock too, and the two results are compared.
//!
//! The host's time begins right before the submission and ends once its results are known, so it covers all of the
//! work. A correct device time is therefore no longer, except for the drift between the two clocks. It is shorter by
//! what it takes to submit, to notice the end and to do other work on the machine; relative to a dispatch of
//! [`LONG_ENOUGH_NS`] that is little, and still less in the best of several tries. If more than half is missing,
//! the device's clock does not measure this work.

use std::borrow::Cow;
use std::sync::Arc;

use super::clock_check::ClockCheck;
use super::device::Clock;
use super::readback::Readback;
use super::timers::read_times;
use super::{Gpu, GpuError};

/// Host time of a submission that is worth comparing: dozens of times the cost of submitting and noticing the end
/// (about 0.1 ms on a GPU, 0.2 ms on software ones), and no longer than a frame.
const LONG_ENOUGH_NS: u64 = 10_000_000;

/// Number of submissions of that length. One that is delayed by another program says nothing; of five in a row, some
/// are not.
const TRIES: u32 = 5;

/// Workgroups of the first submission.
const FEWEST_GROUPS: u32 = 16;

/// More workgroups than any device computes in that time; ends the search if the host's clock stands still.
const MOST_GROUPS: u32 = 1 << 22;

/// Workgroups per row of the dispatch: every adapter allows at least 65,535.
const GROUPS_A_ROW: u32 = 1 << 14;

/// Each loop has few iterations, far fewer than any driver's limit; longer work means more workgroups.
const WGSL: &str = "
@group(0) @binding(0) var<storage, read_write> result: array<u32, 64>;

@compute @workgroup_size(64)
fn clock(@builtin(local_invocation_index) lane: u32, @builtin(workgroup_id) group: vec3u) {
    var value = 1u + lane + 64u * (group.x + 16384u * group.y);
    for (var turn = 0u; turn < 512u; turn++) {
        value ^= value << 13u;
        value ^= value >> 17u;
        value ^= value << 5u;
    }
    // Never true: such a generator (Marsaglia, 2003) does not reach 0. Compilers would remove work without a write.
    if (value == 0u) {
        result[lane] = value;
    }
}
";

impl Gpu {
    /// Compares the device's clock with the host's: `now`, in nanoseconds from any start. Only the first call has
    /// an effect, and it must come before creating anything that is to be timed; without it, no pass on this device has
    /// a time.
    ///
    /// # Errors
    /// If the device is lost or refuses.
    pub async fn check_clock(self: &Arc<Self>, now: fn() -> u64) -> Result<(), GpuError> {
        if self.clock.get().is_none() {
            let check = match self.timestamp_period_ns {
                Some(period_ns) => Some(check(self, period_ns, now).await?),
                None => None,
            };
            // If another call was faster, its result is as good.
            let _ = self.clock.set(Clock { now, check });
        }
        Ok(())
    }
}

/// Compares the device's clock with the host's, `now`. `period_ns`: nanoseconds per tick of the device's clock.
async fn check(gpu: &Arc<Gpu>, period_ns: f64, now: fn() -> u64) -> Result<ClockCheck, GpuError> {
    gpu.health()?;
    let scopes = gpu.push_scopes();
    let work = Work::new(gpu, period_ns, now);
    gpu.pop_scopes(scopes).await?;
    let mut groups = FEWEST_GROUPS;
    // Some drivers compile on first use.
    work.submit(groups).await?;
    let (mut best, mut tries): (Option<ClockCheck>, u32) = (None, 0);
    loop {
        let one = work.submit(groups).await?;
        // If the device reports a long time, it is the host's clock that fails to measure it.
        let is_long = one.host_ns >= LONG_ENOUGH_NS || one.device_ns.is_some_and(|ns| ns > 4 * LONG_ENOUGH_NS);
        if !is_long && groups < MOST_GROUPS {
            // Lengthen by the measured ratio, but at least twofold and at most fourfold: short submissions mostly wait.
            // An earlier one that took long with less work was delayed, and is not compared.
            let factor = LONG_ENOUGH_NS.div_ceil(one.host_ns.max(1)).clamp(2, 4) as u32;
            groups = (groups * factor).min(MOST_GROUPS);
            (best, tries) = (None, 0);
            continue;
        }
        tries += 1;
        let nearest = best.filter(|best| best.distance() <= one.distance()).unwrap_or(one);
        // Twice, to exclude one that was delayed.
        if tries >= TRIES || tries > 1 && nearest.agrees() {
            return Ok(nearest);
        }
        best = Some(nearest);
    }
}

struct Work<'a> {
    gpu: &'a Arc<Gpu>,
    period_ns: f64,
    now: fn() -> u64,
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    copy: wgpu::Buffer,
}

/// Size of two timestamps.
const BYTES: u64 = 16;

impl<'a> Work<'a> {
    fn new(gpu: &'a Arc<Gpu>, period_ns: f64, now: fn() -> u64) -> Self {
        let device = &gpu.device;
        let label = Some("clock");
        let source = wgpu::ShaderSource::Wgsl(Cow::Borrowed(WGSL));
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: None,
            module: &module,
            entry_point: Some("clock"),
            compilation_options: Default::default(),
            cache: None,
        });
        use wgpu::BufferUsages as U;
        let buffer = |size, usage| {
            device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false })
        };
        let result = buffer(256, U::STORAGE);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: result.as_entire_binding() }],
        });
        let ty = wgpu::QueryType::Timestamp;
        let set = device.create_query_set(&wgpu::QuerySetDescriptor { label, ty, count: 2 });
        let resolved = buffer(BYTES, U::QUERY_RESOLVE | U::COPY_SRC);
        let copy = buffer(BYTES, U::COPY_DST | U::MAP_READ);
        Self { gpu, period_ns, now, pipeline, group, set, resolved, copy }
    }

    /// Makes one submission and waits for it.
    async fn submit(&self, groups: u32) -> Result<ClockCheck, GpuError> {
        let scopes = self.gpu.push_scopes();
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("clock"),
                timestamp_writes: Some(wgpu::ComputePassTimestampWrites {
                    query_set: &self.set,
                    beginning_of_pass_write_index: Some(0),
                    end_of_pass_write_index: Some(1),
                }),
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.group, &[]);
            pass.dispatch_workgroups(groups.min(GROUPS_A_ROW), groups.div_ceil(GROUPS_A_ROW), 1);
        }
        encoder.resolve_query_set(&self.set, 0..2, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.copy, 0, BYTES);
        let commands = encoder.finish();
        let begin = (self.now)();
        self.gpu.submit([commands]);
        let times = Readback::start(self.gpu, self.copy.clone(), BYTES);
        self.gpu.pop_scopes(scopes).await?;
        let times = times.finish(BYTES, |bytes| read_times(bytes, self.period_ns)).await?;
        let host_ns = (self.now)().saturating_sub(begin);
        Ok(ClockCheck { device_ns: times.first().and_then(|&(_, duration)| duration), host_ns })
    }
}
