//! Rows of the CSV files: runs, and small measurements.

use raystep_lab::meter::Valid;
use serde::{Deserialize, Serialize};

/// Runs of one configuration. Unknown values are empty, never 0.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Row {
    pub(crate) section: String,
    pub(crate) scene: String,
    pub(crate) triangles: u64,
    pub(crate) rays_kind: String,
    pub(crate) width_px: u32,
    pub(crate) height_px: u32,
    pub(crate) rays: u64,
    pub(crate) accelerator: String,
    pub(crate) schedule: String,
    pub(crate) numerics: String,
    /// The option `--skip`; empty without a grid.
    pub(crate) skip: String,
    /// Whether rays skip empty cells.
    pub(crate) leaps: Option<bool>,
    /// `auto`, or the requested cells.
    pub(crate) grid: String,
    /// Cells of the grid that was built, along x, y and z.
    pub(crate) cells: String,
    pub(crate) steps_per_pass: u32,
    /// Seconds to build the grid or BVH and to pack triangles.
    pub(crate) build_s: Option<f64>,
    /// Seconds to compile, allocate and upload. Kernels are compiled anew; the driver may have cached its results.
    pub(crate) prepare_s: Option<f64>,
    /// Whether only the necessary passes were submitted.
    pub(crate) is_replay: bool,
    pub(crate) n: usize,
    pub(crate) invalid: usize,
    pub(crate) median_device_ns: Option<f64>,
    /// Ends of the 95% confidence interval of the median, from 6 runs.
    #[serde(default)]
    pub(crate) low_device_ns: Option<f64>,
    #[serde(default)]
    pub(crate) high_device_ns: Option<f64>,
    pub(crate) median_wall_ns: Option<f64>,
    pub(crate) passes: Option<usize>,
    pub(crate) threads_launched: Option<u64>,
    /// Threads that had a ray to work on.
    pub(crate) threads_with_ray: Option<u64>,
    pub(crate) cells_per_ray: Option<f64>,
    pub(crate) tests_per_ray: Option<f64>,
    pub(crate) repeated_per_ray: Option<f64>,
    /// Number of rays in the counting run for the three columns above.
    pub(crate) counted_rays: Option<u64>,
    /// Cells or nodes visited plus triangles tested, divided by threads launched.
    pub(crate) useful_steps_per_thread: Option<f64>,
    pub(crate) bytes_per_triangle: Option<f64>,
    pub(crate) hits: Option<u64>,
    /// Why there is no time.
    pub(crate) reason: String,
}

impl Row {
    pub(crate) fn mray_per_s(&self) -> Option<f64> {
        self.median_device_ns.filter(|&ns| ns > 0.0).map(|ns| self.rays as f64 / ns * 1e3)
    }

    /// Share of the launched threads that had a ray to work on.
    pub(crate) fn share_with_ray(&self) -> Option<f64> {
        self.threads_with_ray.zip(self.threads_launched).map(|(with, all)| with as f64 / all as f64)
    }

    /// The configuration for display: `grid with skipping, compact K=8`.
    pub(crate) fn way(&self) -> String {
        let steps = match (self.schedule.as_str(), self.steps_per_pass) {
            ("compact", steps) => format!(" K={steps}"),
            _ => String::new(),
        };
        let skip = if self.skip == "on" { " with skipping" } else { "" };
        format!("{}{skip}, {}{steps}", self.accelerator, self.schedule)
    }
}

/// One small measurement, with a value of its own if it is not a time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Probe {
    pub(crate) section: String,
    pub(crate) what: String,
    pub(crate) scene: String,
    pub(crate) accelerator: String,
    pub(crate) width_px: u32,
    pub(crate) height_px: u32,
    /// Dispatches of one submission, or passes of a run.
    pub(crate) passes: u64,
    /// Minimum bytes read and written by each submission.
    pub(crate) bytes: Option<u64>,
    pub(crate) n: usize,
    pub(crate) invalid: usize,
    /// Time of a whole submission or run.
    pub(crate) median_device_ns: Option<f64>,
    /// Ends of the 95% confidence interval of the median, from 6 runs.
    #[serde(default)]
    pub(crate) low_device_ns: Option<f64>,
    #[serde(default)]
    pub(crate) high_device_ns: Option<f64>,
    pub(crate) value: Option<f64>,
    pub(crate) reason: String,
}

impl Probe {
    pub(crate) fn with_times(mut self, times: &[Option<u64>]) -> Self {
        let times = Valid::of(times);
        (self.n, self.invalid) = (times.ns.len(), times.invalid);
        [self.median_device_ns, self.low_device_ns, self.high_device_ns] = median_low_high(&times);
        if self.n == 0 && self.reason.is_empty() {
            self.reason = "no time was valid".into();
        }
        self
    }
}

/// The median and the ends of its interval; unknown if too few times were valid.
pub(crate) fn median_low_high(times: &Valid) -> [Option<f64>; 3] {
    let interval = times.interval();
    [times.median(), interval.map(|i| i.low), interval.map(|i| i.high)]
}
