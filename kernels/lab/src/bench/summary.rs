//! The results of a benchmark: `summary.csv`, one row per configuration, RFC 4180, raw numbers with their unit in the
//! column's name. Unknown values are empty, never 0.
//!
//! | column | contents |
//! |---|---|
//! | `schema_version` | [`SCHEMA_VERSION`]; it rises when a column changes its meaning |
//! | `run_id` | identifies the configuration, also in `passes.csv` |
//! | `scene`, `scene_hash`, `triangles` | name, [hash](crate::hash::Hash) of all files it was read from, size |
//! | `accelerator` … `tuning` | how it was traced; `tuning` has the other options that affect speed |
//! | `rays_kind` … `height_px` | kind of rays, device, and image size |
//! | `rays` | rays per run; a pixel without a hit has no bounce or shadow ray |
//! | `build_s` | wall-clock time for planning, including composing kernels and building the acceleration structure |
//! | `compile_s` | wall-clock time for compiling, allocating and uploading. raystep compiles every kernel anew; the driver may have cached its results |
//! | `n` | counted runs with a valid time |
//! | `invalid` | counted runs whose time was missing, 0 or negative |
//! | `median_device_ns`, `p05_device_ns`, `p95_device_ns` | time of a run on the clock that `timer_source` names |
//! | `median_wall_ns` | wall-clock time of the same runs, including waiting for the device |
//! | `timer_source` | `gpu_timestamp` or `cpu_clock`; `host` if the device has no clock, or one that disagrees with the host's: then only `median_wall_ns` is a time |
//! | `rays_per_s` | `rays` divided by the median device time, or by the wall-clock median if the device has no clock |
//! | `passes` | passes per run |
//! | `useful_steps_per_thread` | rays worked on divided by threads launched, over all passes |
//! | `cells_per_ray`, `tests_per_ray`, `repeated_per_ray` | cells (or BVH nodes) visited, triangles tested, repeated tests of a triangle the ray had already met; counted in a separate run, as far as the schedule can count |
//! | `bytes_per_triangle` | bytes of the grid or BVH, plus those of triangles that kernels read packed |
//! | `hits`, `hits_hash` | rays that hit something, and a [hash](crate::hash::Hash) of all hits: equal hashes mean equal bits |
//! | `baseline_ratio` | median divided by the baseline's: above 1 is slower |
//!
//! Percentiles are defined by [`crate::statistics::PERCENTILES`].

use std::io::{Read, Write};

use raystep_kernels::renderer::Pass;
use serde::{Deserialize, Serialize};

/// Version of the columns.
pub const SCHEMA_VERSION: u32 = 1;

/// `timer_source` of times measured by the host.
const HOST: &str = "host";

/// A row of `summary.csv`; its columns are described [above](self).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub struct SummaryRow {
    pub schema_version: u32,
    pub run_id: String,
    pub scene: String,
    pub scene_hash: String,
    pub triangles: u64,
    pub accelerator: String,
    pub schedule: String,
    pub numerics: String,
    pub tuning: String,
    pub rays_kind: String,
    pub device: String,
    pub width_px: u32,
    pub height_px: u32,
    pub rays: u64,
    pub build_s: f64,
    pub compile_s: f64,
    pub n: usize,
    pub invalid: usize,
    pub median_device_ns: Option<f64>,
    pub p05_device_ns: Option<f64>,
    pub p95_device_ns: Option<f64>,
    pub median_wall_ns: Option<f64>,
    pub timer_source: Option<String>,
    pub rays_per_s: Option<f64>,
    pub passes: usize,
    pub useful_steps_per_thread: Option<f64>,
    pub cells_per_ray: Option<f64>,
    pub tests_per_ray: Option<f64>,
    pub repeated_per_ray: Option<f64>,
    pub bytes_per_triangle: Option<f64>,
    pub hits: u64,
    pub hits_hash: String,
    pub baseline_ratio: Option<f64>,
}

/// A `summary.csv` that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// Not CSV, or not these columns.
    #[error("it is not a summary of a benchmark: {0}")]
    Csv(#[from] ::csv::Error),
    /// Written by another version.
    #[error("its schema_version is {0}; expected {SCHEMA_VERSION}")]
    Version(u32),
}

/// Writes `summary.csv`.
///
/// # Errors
/// If `out` fails.
pub fn write_summary(out: impl Write, rows: &[SummaryRow]) -> std::io::Result<()> {
    let mut writer = raystep_kernels::export::csv::writer(out);
    for row in rows {
        writer.serialize(row)?;
    }
    writer.flush()
}

/// Reads `summary.csv`.
///
/// # Errors
/// If it is not such a file, or has another version.
pub fn read_summary(input: impl Read) -> Result<Vec<SummaryRow>, ReadError> {
    let rows: Vec<SummaryRow> = ::csv::Reader::from_reader(input).deserialize().collect::<Result<_, _>>()?;
    match rows.iter().find(|row| row.schema_version != SCHEMA_VERSION) {
        Some(row) => Err(ReadError::Version(row.schema_version)),
        None => Ok(rows),
    }
}

impl SummaryRow {
    /// The time to compare, in nanoseconds, and its clock: the device's if that is reliable.
    #[must_use]
    pub fn time_ns(&self) -> Option<(f64, &str)> {
        match &self.timer_source {
            Some(source) if source != HOST => self.median_device_ns.map(|ns| (ns, source.as_str())),
            // Old rows have no name for the host's clock.
            _ => self.median_wall_ns.map(|ns| (ns, HOST)),
        }
    }

    /// Whether two rows have the same configuration, possibly on different devices.
    #[must_use]
    pub fn is_same_configuration(&self, other: &Self) -> bool {
        fn key(r: &SummaryRow) -> ([&str; 6], u32, u32) {
            ([&r.scene, &r.accelerator, &r.schedule, &r.numerics, &r.tuning, &r.rays_kind], r.width_px, r.height_px)
        }
        key(self) == key(other)
    }

    /// The baseline's row with the same configuration; preferably one measured with the same scene files.
    #[must_use]
    pub fn in_baseline<'a>(&self, baseline: &'a [Self]) -> Option<&'a Self> {
        let same = || baseline.iter().filter(|row| self.is_same_configuration(row));
        same().find(|row| row.scene_hash == self.scene_hash).or_else(|| same().next())
    }

    /// This row's time divided by the other's; `None` if either is unknown or the clocks differ.
    #[must_use]
    pub fn ratio_to(&self, then: &Self) -> Option<f64> {
        let ((now, clock), (then, clock_then)) = self.time_ns().zip(then.time_ns())?;
        (clock == clock_then && then > 0.0).then(|| now / then)
    }
}

/// Rays worked on divided by threads launched, over all passes; `None` if no thread was launched.
#[must_use]
pub fn useful_steps_per_thread(passes: &[Pass]) -> Option<f64> {
    let rays: u64 = passes.iter().map(|pass| u64::from(pass.rays_in)).sum();
    let threads: u64 = passes.iter().map(|pass| pass.threads_launched).sum();
    (threads > 0).then(|| rays as f64 / threads as f64)
}

#[cfg(test)]
mod tests {
    use raystep_kernels::programs::closest_hit::kernels;
    use raystep_kernels::tables::state::StateCounts;

    use super::*;

    fn row() -> SummaryRow {
        SummaryRow {
            schema_version: SCHEMA_VERSION,
            run_id: "a-0".into(),
            scene: "odd, \"name\"\nof two lines".into(),
            // Only digits, but still text.
            scene_hash: "0000000000000012".into(),
            accelerator: "grid".into(),
            median_device_ns: Some(1500.5),
            timer_source: Some("gpu_timestamp".into()),
            ..SummaryRow::default()
        }
    }

    #[test]
    fn a_summary_is_read_back_as_it_was_written() {
        let rows = [row(), SummaryRow { n: 7, build_s: 1e-9, ..SummaryRow { schema_version: 1, ..row() } }];
        let mut file = Vec::new();
        write_summary(&mut file, &rows).expect("memory");
        assert_eq!(read_summary(file.as_slice()).expect("a summary"), rows);

        let mut reader = ::csv::ReaderBuilder::new().flexible(false).from_reader(file.as_slice());
        let names = reader.headers().expect("names").clone();
        let first = reader.records().next().expect("a row").expect("as many fields as names");
        let value = |name: &str| &first[names.iter().position(|n| n == name).expect(name)];
        for name in ["p05_device_ns", "median_wall_ns", "cells_per_ray", "baseline_ratio"] {
            assert_eq!(value(name), "", "unknown is empty: {name}");
        }
        assert_eq!((value("scene_hash"), value("median_device_ns")), ("0000000000000012", "1500.5"));
    }

    #[test]
    fn what_is_no_summary_is_refused() {
        let mut file = Vec::new();
        write_summary(&mut file, &[SummaryRow { schema_version: 9, ..row() }]).expect("memory");
        let refused = |bytes: &[u8]| read_summary(bytes).map_err(|e| e.to_string()).expect_err("no summary");
        assert!(refused(&file).contains("schema_version is 9"));
        for bytes in
            [&b"a,b\r\n1,2\r\n"[..], b"a,b\r\n1\r\n", &[0xff, 0xfe, b'\n', b'1', b'\n'], &file[..file.len() - 4]]
        {
            assert!(refused(bytes).starts_with("it is not a summary of a benchmark: "), "{bytes:?}");
        }
        assert!(read_summary(&b""[..]).is_ok_and(|rows| rows.is_empty()));
    }

    #[test]
    fn a_baseline_is_matched_by_configuration_and_clock() {
        let then = SummaryRow { median_device_ns: Some(1000.0), device: "another".into(), ..row() };
        let moved = SummaryRow { scene_hash: "x".into(), run_id: "b".into(), ..then.clone() };
        let other = [
            SummaryRow { rays_kind: "bounce".into(), ..then.clone() },
            SummaryRow { width_px: 5, ..then.clone() },
            SummaryRow { tuning: "grid=20,20,20".into(), ..then.clone() },
            SummaryRow { schedule: "fused".into(), ..then.clone() },
        ];
        assert_eq!(row().in_baseline(&other), None);
        assert_eq!(row().in_baseline(&[moved.clone(), then.clone()]), Some(&then));
        assert_eq!(row().in_baseline(std::slice::from_ref(&moved)), Some(&moved));
        assert_eq!(row().ratio_to(&then), Some(1.5005));
        let by_wall = SummaryRow { timer_source: None, median_wall_ns: Some(1000.0), ..then };
        assert_eq!((row().ratio_to(&by_wall), by_wall.ratio_to(&by_wall)), (None, Some(1.0)));
        // The device's clock is ignored.
        let by_host = SummaryRow { timer_source: Some("host".into()), median_wall_ns: Some(3000.0), ..row() };
        assert_eq!((by_host.time_ns(), by_host.ratio_to(&by_wall)), (Some((3000.0, "host")), Some(3.0)));
    }

    #[test]
    fn useful_steps_are_rays_by_threads() {
        let pass = |rays_in, threads_launched| Pass {
            index: 0,
            iteration: 0,
            kernel: kernels::INTERSECT,
            rays_in,
            counts: StateCounts::default(),
            threads_launched,
            begin_ns: None,
            duration_ns: None,
        };
        assert_eq!(useful_steps_per_thread(&[pass(64, 64), pass(26, 56)]), Some(0.75));
        assert_eq!(useful_steps_per_thread(&[pass(0, 0)]), None);
    }
}
