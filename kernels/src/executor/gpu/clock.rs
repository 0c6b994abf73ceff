//! Checks whether a device's timestamps are valid times.
//!
//! Those of some drivers are not: they show when a command was recorded or started, not when it was finished. So the
//! device runs arithmetic that takes long enough to be measured on the host's clock too, and the two results are compared.
//!
//! The host's time begins right before the submission and ends once its results are known, so it covers all of the
//! work. A correct device time is therefore not longer, except for the drift between the two clocks. It is shorter by
//! the time to submit, to notice the end and to do other work on the machine; relative to a dispatch of
//! [`LONG_ENOUGH_NS`] that is little, and still less in the best of several tries. If more than half is missing,
//! the device's clock does not measure this work.
//!
//! If the clock is right, its step is found, too: browsers round timestamps to about 100 µs.

use std::borrow::Cow;
use std::sync::Arc;

use super::clock_check::{Clock, ClockCheck};
use super::clock_step::coarse_step;
use super::readback::Readback;
use super::timers::{Ticks, Times, read_times};
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

/// Passes whose times tell the clock's step.
const STEP_PASSES: u32 = 64;

/// How many of these passes take about as long as a submission that was compared: each takes about 0.1 ms.
const STEP_PASSES_A_SUBMISSION: f32 = 100.0;

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
    /// Compares the device's clock with the host's: `now`, in nanoseconds from any start; and finds its step. Only the
    /// first call has an effect, and it must come before creating anything that is to be timed; without it, no pass on
    /// this device has a time.
    ///
    /// # Errors
    /// If the device is lost or refuses.
    pub async fn check_clock(self: &Arc<Self>, now: fn() -> u64) -> Result<(), GpuError> {
        if self.clock.get().is_none() {
            let (check, coarse_step_ns) = match self.ticks() {
                Some(ticks) => check(self, ticks, now).await.map(|(check, step)| (Some(check), step))?,
                None => (None, None),
            };
            // If another call was faster, its result is as good.
            let was_rounded = self.rounded_to_ns.get().is_some();
            let _ = self.clock.set(Clock { now, check, coarse_step_ns, was_rounded });
        }
        Ok(())
    }

    /// The comparison of the device's clock with the host's, if it has one and they were compared.
    #[must_use]
    pub fn clock_check(&self) -> Option<ClockCheck> {
        self.clock.get()?.check
    }

    /// Nanoseconds per tick of the pass timers, if they are known to be valid times.
    #[must_use]
    pub fn clock_period_ns(&self) -> Option<f64> {
        self.timestamp_period_ns.filter(|_| self.clock_check().is_some_and(|check| check.agrees()))
    }

    /// Nanoseconds between neighbouring values of the pass timers, if they are known to be valid times: a tick, unless the
    /// system rounds the times to multiples of 10 µs or more, as browsers do.
    #[must_use]
    pub fn clock_step_ns(&self) -> Option<f64> {
        self.clock_period_ns().map(|period_ns| self.coarse_step_ns().unwrap_or(period_ns))
    }

    /// The step of the pass timers, if it is coarse: passes take about as long, or less.
    pub(super) fn coarse_step_ns(&self) -> Option<f64> {
        let clock = self.clock.get()?;
        let rounded_since = self.rounded_to_ns.get().filter(|_| !clock.was_rounded);
        clock.coarse_step_ns.or(rounded_since.map(|&step_ns| step_ns as f64))
    }

    /// Rounds the times of passes down to multiples of `step_ns`, as browsers do: for tests. Only once. Before
    /// [`check_clock`](Self::check_clock), that has to find the step; after it, the step is known.
    #[doc(hidden)]
    pub fn round_times(&self, step_ns: u64) {
        let _ = self.rounded_to_ns.set(step_ns.max(1));
    }

    /// How the ticks of its timers become times; `None` if it has no timers.
    pub(super) fn ticks(&self) -> Option<Ticks> {
        let rounded_to_ns = self.rounded_to_ns.get().copied();
        self.timestamp_period_ns.map(|period_ns| Ticks { period_ns, rounded_to_ns })
    }

    /// Why passes on this device have no times; `None` if they have.
    #[must_use]
    pub fn why_no_times(&self) -> Option<String> {
        match (self.timestamp_period_ns, self.clock_check()) {
            (None, _) => Some("the adapter has no timestamps".into()),
            (_, None) => Some("the adapter's timestamps were not compared with the host's clock".into()),
            (_, Some(check)) if check.agrees() => None,
            (_, Some(check)) => Some(format!("the adapter's timestamps are wrong ({check})")),
        }
    }

    /// The host's clock, if there is one.
    #[must_use]
    pub fn host_clock(&self) -> Option<fn() -> u64> {
        self.clock.get().map(|clock| clock.now)
    }
}

/// Compares the device's clock with the host's, `now`. Also returns its step, if the clock is right and the step coarse.
async fn check(gpu: &Arc<Gpu>, ticks: Ticks, now: fn() -> u64) -> Result<(ClockCheck, Option<f64>), GpuError> {
    gpu.health()?;
    let scopes = gpu.push_scopes();
    let work = Work::new(gpu, ticks, now);
    gpu.pop_scopes(scopes).await?;
    let mut groups = FEWEST_GROUPS;
    // Some drivers compile on first use.
    work.compare(groups).await?;
    let (mut best, mut tries): (Option<ClockCheck>, u32) = (None, 0);
    loop {
        let one = work.compare(groups).await?;
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
            let step = if nearest.agrees() { work.coarse_step(groups).await? } else { None };
            return Ok((nearest, step));
        }
        best = Some(nearest);
    }
}

struct Work<'a> {
    gpu: &'a Arc<Gpu>,
    ticks: Ticks,
    now: fn() -> u64,
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    copy: wgpu::Buffer,
}

/// Size of the timestamps of one pass.
const BYTES: u64 = 16;

impl<'a> Work<'a> {
    fn new(gpu: &'a Arc<Gpu>, ticks: Ticks, now: fn() -> u64) -> Self {
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
        let set = device.create_query_set(&wgpu::QuerySetDescriptor { label, ty, count: 2 * STEP_PASSES });
        let bytes = BYTES * u64::from(STEP_PASSES);
        let resolved = buffer(bytes, U::QUERY_RESOLVE | U::COPY_SRC);
        let copy = buffer(bytes, U::COPY_DST | U::MAP_READ);
        Self { gpu, ticks, now, pipeline, group, set, resolved, copy }
    }

    /// Compares the clocks over one pass of so many workgroups.
    async fn compare(&self, groups: u32) -> Result<ClockCheck, GpuError> {
        let (times, host_ns) = self.submit(&[groups]).await?;
        Ok(ClockCheck { device_ns: times.first().and_then(|&(_, duration)| duration), host_ns })
    }

    /// The step of the device's clock, if it is coarse. `groups` are workgroups that take [`LONG_ENOUGH_NS`].
    async fn coarse_step(&self, groups: u32) -> Result<Option<f64>, GpuError> {
        // 0.3 to 1.7 times as many, spread by the golden ratio: times at even distances would look like multiples of one.
        let uneven = |i: u32| 0.3 + 1.4 * (i as f32 * 0.618_034).fract();
        let groups = groups as f32 / STEP_PASSES_A_SUBMISSION;
        let passes: Vec<u32> = (0..STEP_PASSES).map(|i| (groups * uneven(i)).ceil() as u32).collect();
        let (times, _) = self.submit(&passes).await?;
        let told = times.into_iter().flat_map(|(begin, duration)| [begin, begin.zip(duration).map(|(b, d)| b + d)]);
        Ok(coarse_step(&told.flatten().collect::<Vec<u64>>()))
    }

    /// Makes one submission, of passes of so many workgroups, at most [`STEP_PASSES`], and waits for it. Returns the
    /// times of the passes, and that of the submission by the host's clock.
    async fn submit(&self, passes: &[u32]) -> Result<(Times, u64), GpuError> {
        let scopes = self.gpu.push_scopes();
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        for (i, groups) in (0..).zip(passes) {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("clock"),
                timestamp_writes: Some(wgpu::ComputePassTimestampWrites {
                    query_set: &self.set,
                    beginning_of_pass_write_index: Some(2 * i),
                    end_of_pass_write_index: Some(2 * i + 1),
                }),
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.group, &[]);
            pass.dispatch_workgroups(*groups.min(&GROUPS_A_ROW), groups.div_ceil(GROUPS_A_ROW), 1);
        }
        let bytes = BYTES * passes.len() as u64;
        encoder.resolve_query_set(&self.set, 0..2 * passes.len() as u32, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.copy, 0, bytes);
        let commands = encoder.finish();
        let begin = (self.now)();
        self.gpu.submit([commands]);
        let times = Readback::start(self.gpu, self.copy.clone(), bytes);
        self.gpu.pop_scopes(scopes).await?;
        let times = times.finish(bytes, |bytes| read_times(bytes, self.ticks)).await?;
        let host_ns = (self.now)().saturating_sub(begin);
        Ok((times, host_ns))
    }
}
