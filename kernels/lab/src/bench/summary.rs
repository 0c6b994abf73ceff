//! The results of a benchmark: `summary.csv`, one row per configuration, RFC 4180, raw numbers with their unit in the
//! column's name. Unknown values are empty, never 0. [`crate::tidy::columns`] describes the columns.

use std::io::{Read, Write};

use raystep_kernels::Traversal;
use raystep_kernels::options::Integrator;
use raystep_kernels::options::mapping::Mapping;
use raystep_kernels::renderer::Pass;
use serde::{Deserialize, Serialize};

use super::OF_FILE;
use super::runs::{self, RunRow};
use crate::rays::RayKind;
use crate::statistics::interval::{self, Interval};
use crate::statistics::median;
use crate::subject::Size;
pub use crate::tidy::SCHEMA_VERSION;

/// `clock` of times measured by the host.
pub(super) const HOST: &str = "host";

/// `build` of rows that this program measured itself.
pub const THIS: &str = "this";

csv_row! {
    /// A row of `summary.csv`. `start_s` includes compiling: raystep compiles every kernel anew, but the driver may have
    /// cached its results.
    pub struct SummaryRow {
        pub schema_version: u32,
        pub run_id: String,
        pub configuration: String,
        pub build: String,
        pub scene: String,
        pub scene_hash: String,
        pub triangles: u64,
        pub accelerator: String,
        pub schedule: String,
        pub numerics: String,
        pub grid: String,
        pub skip: String,
        pub steps_per_pass: Option<u32>,
        pub keep_all: bool,
        pub rays_kind: String,
        pub seed: u32,
        pub adapter: String,
        pub width_px: Option<u32>,
        pub height_px: Option<u32>,
        pub rays: u64,
        pub build_s: f64,
        pub start_s: f64,
        pub clock: String,
        pub runs: usize,
        pub invalid_runs: usize,
        pub median_ns: Option<f64>,
        pub low_ns: Option<f64>,
        pub high_ns: Option<f64>,
        pub min_ns: Option<f64>,
        pub max_ns: Option<f64>,
        pub interval_method: Option<String>,
        pub interval_level: Option<f64>,
        pub median_wall_ns: Option<f64>,
        pub fixed_work_ns: Option<f64>,
        pub rays_per_s: Option<f64>,
        pub time_ratio: Option<f64>,
        pub time_ratio_low: Option<f64>,
        pub time_ratio_high: Option<f64>,
        pub ratio_to: Option<String>,
        pub passes: usize,
        pub useful_steps_per_thread: Option<f64>,
        pub cells_per_ray: Option<f64>,
        pub tests_per_ray: Option<f64>,
        pub repeated_per_ray: Option<f64>,
        pub structure_bytes: u64,
        pub bytes_per_triangle: Option<f64>,
        pub hits: Option<u64>,
        pub hits_hash: String,
        pub baseline_ratio: Option<f64>,
        /// Earlier files lack it.
        #[serde(default = "compute")]
        pub mapping: String,
        /// Earlier files lack it.
        #[serde(default = "amanatides_woo")]
        pub traversal: String,
        /// Earlier files lack it, and what follows.
        #[serde(default = "local")]
        pub integrator: String,
        pub samples_per_s: Option<f64>,
        pub secondary_rays: Option<u64>,
        pub shadow_rays: Option<u64>,
        /// Unknown in earlier files.
        #[serde(default)]
        pub integrator_options: String,
    }
}

/// The only mapping of earlier files.
fn compute() -> String {
    Mapping::Compute.to_string()
}

/// The only traversal of earlier files.
fn amanatides_woo() -> String {
    Traversal::AmanatidesWoo.to_string()
}

/// The only light of earlier files: none, since they are about hits.
fn local() -> String {
    Integrator::default().to_string()
}

/// A file of a benchmark that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// Not CSV, or not these columns.
    #[error("it is not a file of a benchmark: {0}")]
    Csv(#[from] ::csv::Error),
    /// Written by another version.
    #[error("its schema_version is {0}; expected {SCHEMA_VERSION}")]
    Version(u32),
}

/// Refuses rows of another version.
pub(super) fn check_version(versions: impl IntoIterator<Item = u32>) -> Result<(), ReadError> {
    versions.into_iter().find(|&v| v != SCHEMA_VERSION).map_or(Ok(()), |version| Err(ReadError::Version(version)))
}

/// Writes `summary.csv` or `runs.csv`.
///
/// # Errors
/// If `out` fails.
pub fn write_rows(out: impl Write, rows: &[impl Serialize]) -> std::io::Result<()> {
    let mut writer = raystep_kernels::export::csv::writer(out);
    for row in rows {
        writer.serialize(row)?;
    }
    writer.flush()
}

/// The one column that every version had.
#[derive(Deserialize)]
struct Version {
    schema_version: u32,
}

/// Reads `summary.csv`.
///
/// # Errors
/// If it is not such a file, or has another version.
pub fn read_summary(mut input: impl Read) -> Result<Vec<SummaryRow>, ReadError> {
    let mut bytes = Vec::new();
    input.read_to_end(&mut bytes).map_err(::csv::Error::from)?;
    // Another version has other columns, and its number says more than the first that is missing.
    let mut reader = ::csv::Reader::from_reader(bytes.as_slice());
    if reader.headers()?.iter().any(|name| name == "schema_version") {
        let versions = reader.into_deserialize::<Version>().map_while(Result::ok);
        check_version(versions.map(|row| row.schema_version))?;
    }
    Ok(::csv::Reader::from_reader(bytes.as_slice()).deserialize().collect::<Result<_, _>>()?)
}

impl SummaryRow {
    /// Fills in the statistics of its counted runs. `seed` is that of bootstrapped intervals.
    pub fn set_times(&mut self, counted: &[RunRow], seed: u64) {
        let valid = runs::valid(counted);
        (self.runs, self.invalid_runs) = (valid.ns.len(), valid.invalid);
        self.median_ns = valid.median();
        self.min_ns = valid.ns.iter().copied().reduce(f64::min);
        self.max_ns = valid.ns.iter().copied().reduce(f64::max);
        if let Some(Interval { low, high, level, method, .. }) = interval::of_median(&valid.ns, seed) {
            (self.low_ns, self.high_ns) = (Some(low), Some(high));
            (self.interval_level, self.interval_method) = (Some(level), Some(method.name().into()));
        }
        let of = |ns: fn(&RunRow) -> u64| median(&counted.iter().map(|run| ns(run) as f64).collect::<Vec<_>>());
        (self.median_wall_ns, self.fixed_work_ns) = (of(|run| run.wall_ns), of(|run| run.fixed_work_ns));
        let per_s = |rays: u64| self.median_ns.filter(|&ns| ns > 0.0).map(|ns| rays as f64 / ns * 1e9);
        let cast = self.secondary_rays.unwrap_or(0) + self.shadow_rays.unwrap_or(0);
        let samples = (self.rays_kind == RayKind::Primary.name()).then_some(self.rays);
        (self.rays_per_s, self.samples_per_s) = (per_s(self.rays + cast), samples.and_then(per_s));
    }

    /// Fills in the ratio of its runs' times to those of the configuration `to` in the same rounds.
    pub fn set_ratio(&mut self, to: &str, pairs: &[(f64, f64)], seed: u64) {
        self.ratio_to = Some(to.to_owned());
        let ratios: Vec<f64> = pairs.iter().map(|(a, b)| a / b).collect();
        self.time_ratio = median(&ratios);
        if let Some(Interval { low, high, median, .. }) = interval::of_ratio(pairs, seed) {
            (self.time_ratio, self.time_ratio_low, self.time_ratio_high) = (Some(median), Some(low), Some(high));
        }
    }

    /// Whether two rows have the same configuration, possibly on different devices. Options of light that an earlier file
    /// lacks are taken to be the same.
    #[must_use]
    pub fn is_same_configuration(&self, other: &Self) -> bool {
        type Key<'a> = ([&'a str; 10], Option<u32>, bool, Option<Size>, u32);
        fn key(r: &SummaryRow) -> Key<'_> {
            let tracing = [&r.accelerator, &r.schedule, &r.mapping, &r.traversal, &r.numerics, &r.grid, &r.skip];
            let [a, b, c, d, e, f, g] = tracing;
            let texts = [&r.scene, &r.rays_kind, a, b, c, d, e, f, g, &r.integrator];
            (texts.map(String::as_str), r.steps_per_pass, r.keep_all, r.size(), r.seed)
        }
        let options = [self, other].map(|row| row.integrator_options.as_str());
        key(self) == key(other) && (options[0] == options[1] || options.contains(&""))
    }

    /// Size of the image that its rays are from; `None` if they are from a file.
    #[must_use]
    pub fn size(&self) -> Option<Size> {
        Some(Size { width: self.width_px?, height: self.height_px? })
    }

    /// Whether hits were measured, and no light.
    #[must_use]
    pub fn is_of_hits(&self) -> bool {
        self.integrator == local()
    }

    /// Its configuration in words.
    #[must_use]
    pub fn name(&self) -> String {
        let Self { scene, rays_kind, accelerator, schedule, numerics, grid, skip, .. } = self;
        let rays_kind = if rays_kind.starts_with("file ") { OF_FILE } else { rays_kind };
        let size = self.size().map(|size| format!(" {size}")).unwrap_or_default();
        let mut name = format!("{scene}{size} {rays_kind}, {accelerator} {schedule} {numerics}");
        if (grid.as_str(), skip.as_str()) != ("auto", "auto") {
            name += &format!(" grid={grid} skip={skip}");
        }
        if self.mapping != compute() {
            name += &format!(" {}", self.mapping);
        }
        if self.traversal != amanatides_woo() {
            name += &format!(" {}", self.traversal);
        }
        if !self.is_of_hits() {
            name += &format!(" {}", self.integrator);
        }
        if !self.integrator_options.is_empty() {
            name += &format!(" {}", self.integrator_options);
        }
        if let Some(steps) = self.steps_per_pass {
            name += &format!(" steps_per_pass={steps}");
        }
        name + if self.keep_all { " keep_all" } else { "" }
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
        let (now, before) = self.median_ns.zip(then.median_ns)?;
        (self.clock == then.clock && before > 0.0).then(|| now / before)
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

    use super::*;

    fn row() -> SummaryRow {
        SummaryRow {
            schema_version: SCHEMA_VERSION,
            run_id: "a".into(),
            scene: "odd, \"name\"\nof two lines".into(),
            scene_hash: "fnv1a64:0000000000000012".into(),
            accelerator: "grid".into(),
            median_ns: Some(1500.5),
            clock: "gpu_timestamp".into(),
            ..SummaryRow::default()
        }
    }

    fn run(round: usize, time_ns: u64) -> RunRow {
        RunRow { round, time_ns: Some(time_ns), wall_ns: time_ns + 1, fixed_work_ns: 10, ..RunRow::default() }
    }

    #[test]
    fn a_summary_is_read_back_as_it_was_written() {
        let rows = [row(), SummaryRow { runs: 7, build_s: 1e-9, steps_per_pass: Some(8), ..row() }];
        let mut file = Vec::new();
        write_rows(&mut file, &rows).expect("memory");
        assert_eq!(read_summary(file.as_slice()).expect("a summary"), rows);

        let mut reader = ::csv::ReaderBuilder::new().flexible(false).from_reader(file.as_slice());
        let names = reader.headers().expect("names").clone();
        let expected = "schema_version run_id configuration build scene scene_hash triangles accelerator schedule numerics \
                        grid skip steps_per_pass keep_all rays_kind seed adapter width_px height_px rays build_s start_s \
                        clock runs invalid_runs median_ns low_ns high_ns min_ns max_ns interval_method interval_level \
                        median_wall_ns fixed_work_ns rays_per_s time_ratio time_ratio_low time_ratio_high ratio_to passes \
                        useful_steps_per_thread cells_per_ray tests_per_ray repeated_per_ray structure_bytes \
                        bytes_per_triangle hits hits_hash baseline_ratio mapping traversal integrator samples_per_s \
                        secondary_rays shadow_rays integrator_options";
        assert_eq!(names.iter().collect::<Vec<_>>().join(" "), expected);
        assert_eq!(SummaryRow::COLUMNS.join(" "), expected);
        let first = reader.records().next().expect("a row").expect("as many fields as names");
        let value = |name: &str| &first[names.iter().position(|n| n == name).expect(name)];
        for name in ["low_ns", "median_wall_ns", "cells_per_ray", "hits", "baseline_ratio", "steps_per_pass"] {
            assert_eq!(value(name), "", "unknown is empty: {name}");
        }
        assert_eq!((value("scene_hash"), value("median_ns")), ("fnv1a64:0000000000000012", "1500.5"));
    }

    #[test]
    fn what_is_no_summary_is_refused() {
        let mut file = Vec::new();
        write_rows(&mut file, &[SummaryRow { schema_version: 9, ..row() }]).expect("memory");
        let refused = |bytes: &[u8]| read_summary(bytes).map_err(|e| e.to_string()).expect_err("no summary");
        assert!(refused(&file).contains("schema_version is 9"));
        assert!(refused(b"schema_version,run_id\r\n1,a\r\n").contains("schema_version is 1"));
        for bytes in
            [&b"a,b\r\n1,2\r\n"[..], b"a,b\r\n1\r\n", &[0xff, 0xfe, b'\n', b'1', b'\n'], &file[..file.len() - 4]]
        {
            assert!(refused(bytes).starts_with("it is not a file of a benchmark: "), "{bytes:?}");
        }
        assert!(read_summary(&b""[..]).is_ok_and(|rows| rows.is_empty()));
    }

    #[test]
    fn times_have_an_interval_from_six_runs_on() {
        let mut row = row();
        row.set_times(&[5, 1, 4, 2, 3].map(|ns| run(0, ns)), 1);
        assert_eq!((row.runs, row.median_ns, row.low_ns, row.interval_level), (5, Some(3.0), None, None));
        assert_eq!(
            (row.min_ns, row.max_ns, row.median_wall_ns, row.fixed_work_ns),
            (Some(1.0), Some(5.0), Some(4.0), Some(10.0))
        );
        let invalid = RunRow { time_ns: None, ..run(6, 1) };
        row.set_times(&[&[5, 1, 4, 2, 3, 6].map(|ns| run(0, ns))[..], &[invalid]].concat(), 1);
        assert_eq!((row.runs, row.invalid_runs, row.low_ns, row.high_ns), (6, 1, Some(1.0), Some(6.0)));
        assert_eq!(row.interval_method.as_deref(), Some("order_statistics"));
        assert!(row.interval_level.is_some_and(|level| (level - 0.96875).abs() < 1e-9), "{row:?}");
        row.set_ratio("7", &[(2.0, 1.0); 6], 1);
        assert!(row.time_ratio_low.is_some_and(|low| (low - 2.0).abs() < 1e-12), "{row:?}");
        assert_eq!(row.ratio_to.as_deref(), Some("7"));
    }

    #[test]
    fn a_baseline_is_matched_by_configuration_and_clock() {
        let then = SummaryRow { median_ns: Some(1000.0), adapter: "another".into(), ..row() };
        let moved = SummaryRow { scene_hash: "x".into(), run_id: "b".into(), ..then.clone() };
        let other = [
            SummaryRow { rays_kind: "bounce".into(), ..then.clone() },
            SummaryRow { width_px: Some(5), height_px: Some(5), ..then.clone() },
            SummaryRow { grid: "20,20,20".into(), ..then.clone() },
            SummaryRow { steps_per_pass: Some(3), ..then.clone() },
            SummaryRow { keep_all: true, ..then.clone() },
            SummaryRow { seed: 7, ..then.clone() },
            SummaryRow { schedule: "fused".into(), ..then.clone() },
            SummaryRow { integrator: "shadows".into(), ..then.clone() },
            SummaryRow { integrator_options: "photons=1000".into(), ..then.clone() },
        ];
        let row = || SummaryRow { integrator_options: "photons=2000".into(), ..row() };
        assert_eq!(row().in_baseline(&other), None);
        assert_eq!(row().in_baseline(&[moved.clone(), then.clone()]), Some(&then));
        assert_eq!(row().in_baseline(std::slice::from_ref(&moved)), Some(&moved));
        assert_eq!(row().ratio_to(&then), Some(1.5005));
        assert_eq!(row().ratio_to(&SummaryRow { clock: HOST.into(), ..then }), None);
    }

    #[test]
    fn useful_steps_are_rays_by_threads() {
        let pass = |rays_in, threads_launched| Pass { rays_in, threads_launched, ..Pass::of(kernels::INTERSECT) };
        assert_eq!(useful_steps_per_thread(&[pass(64, 64), pass(26, 56)]), Some(0.75));
        assert_eq!(useful_steps_per_thread(&[pass(0, 0)]), None);
    }
}
