//! The sections to measure. Most are benchmarks of [`raystep_lab::bench`].
//!
//! | section | asks |
//! |---|---|
//! | `paper` | the paper's Tables 2 and 3, and the same with each of our schedules |
//! | `resolution` | time against rays: is it a straight line? |
//! | `steps` | time against steps per pass |
//! | `bytes` | bytes that passes move, compared with the device's copy speed; cost of an empty pass |
//! | `tdelta` | §4.2.3: recompute tDelta in every pass, or load it? |
//! | `meshes` | rays per second by kind of ray, and their counters |
//! | `triangles` | time against triangles, and where one configuration overtakes another |

use std::path::Path;
use std::time::{Duration, Instant};

use raystep_kernels::export::json::AdapterInfo;
use raystep_kernels::{AdapterChoice, Device, Gpu, Options, RaySource, ScheduleKind};
use raystep_lab::bench::{self, SEED, Wanted};
use raystep_lab::configuration::Configuration;
use raystep_lab::machine::now_ns;
use raystep_lab::meter::{Meter, Turns};
use raystep_lab::reporter::Reporter;
use raystep_lab::tidy::{Row, TIMES, Table, count, joined};
use raystep_lab::{Machine, RayKind, Size, Subject, block_on, columns};
use serde_json::{Value, json};

use crate::{Adapter, MeasureArgs, bytes, tdelta};

/// In the order in which they run: the largest scenes last.
pub(crate) const SECTIONS: [&str; 7] = ["paper", "resolution", "steps", "bytes", "tdelta", "meshes", "triangles"];

const GROUPS: &[&[&str]] = &[
    columns![
        schema_version section scene triangles rays_kind width_px height_px rays accelerator schedule numerics skip grid
        cells steps_per_pass build_s start_s
    ],
    TIMES,
    columns![
        median_wall_ns passes threads_launched threads_with_ray cells_per_ray tests_per_ray repeated_per_ray
        structure_bytes hits
    ],
];

/// The columns of a section that traces rays: those of `raystep bench`, and of passes.
pub(crate) const COLUMNS: &[&str] = &joined::<{ count(GROUPS) }>(GROUPS);

/// The device, and how much is measured.
pub(crate) struct Setup {
    pub(crate) meter: Meter,
    /// Whether the device is fast enough for large images.
    pub(crate) is_fast: bool,
    pub(crate) is_quick: bool,
}

impl Setup {
    fn open(args: &MeasureArgs) -> Result<Self, String> {
        let open = |choice| block_on(None, Gpu::new(&choice)).map_err(|e| e.to_string());
        let device = match args.adapter {
            Adapter::Cpu => Device::Cpu(Some(now_ns)),
            Adapter::Software => Device::Gpu(open(AdapterChoice::Named("llvmpipe".into()))?),
            Adapter::Gpu => Device::Gpu(open(AdapterChoice::Best)?),
        };
        if let Device::Gpu(gpu) = &device {
            if args.adapter == Adapter::Gpu && gpu.is_software() {
                return Err(format!("--adapter gpu: the only adapter is {}, which is software", gpu.info.name));
            }
            block_on(Some(gpu), gpu.check_clock(now_ns)).map_err(|e| e.to_string())?;
            if let Some(why) = gpu.why_no_times() {
                return Err(format!("{}: {why}", gpu.info.name));
            }
        }
        let meter = Meter::new(Machine { device, reason: "--adapter".into() });
        Ok(Self { meter, is_fast: args.adapter == Adapter::Gpu, is_quick: args.quick })
    }

    /// Chooses by device: of a fast one, of others, and of others in a quick measurement.
    pub(crate) fn choose<T>(&self, fast: T, slow: T, quick: T) -> T {
        match (self.is_fast, self.is_quick) {
            (true, _) => fast,
            (false, false) => slow,
            (false, true) => quick,
        }
    }

    /// Maximum number of runs per configuration.
    pub(crate) fn repeats(&self) -> usize {
        if self.is_quick { 3 } else { self.choose(31, 9, 3) }
    }

    /// Keeps a GPU busy until its clocks are up.
    pub(crate) fn raise_clocks(&self) {
        if self.is_fast {
            self.meter.raise_clocks(Duration::from_millis(250));
        }
    }

    /// `machine.json`.
    fn about(&self) -> Value {
        let processor = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let processor = processor.lines().find_map(|l| l.strip_prefix("model name")?.split_once(": "));
        let processor = processor.map_or(std::env::consts::ARCH, |(_, name)| name).trim();
        let gpu = self.meter.machine.gpu();
        let info = gpu.map(AdapterInfo::from);
        json!({
            "raystep_version": env!("CARGO_PKG_VERSION"),
            "name": info.as_ref().map_or_else(|| format!("CPU: {processor}"), |info| info.name.clone()),
            "adapter": info,
            "timestamp_period_ns": gpu.and_then(Gpu::clock_period_ns),
            "processor": processor,
            "cores": std::thread::available_parallelism().map_or(1, usize::from),
            "arguments": std::env::args().skip(2).collect::<Vec<_>>().join(" "),
            "quick": self.is_quick,
            "seconds": {},
            "notes": [],
        })
    }
}

/// Measures the requested sections.
pub(crate) fn measure(args: &MeasureArgs) -> Result<(), String> {
    let setup = Setup::open(args)?;
    std::fs::create_dir_all(&args.output).map_err(|e| format!("{}: {e}", args.output.display()))?;
    let (mut about, begin) = (setup.about(), Instant::now());
    let word = |value: &Value| value.as_str().unwrap_or("none").to_owned();
    let [backend, driver] = ["backend", "driver"].map(|key| word(&about["adapter"][key]));
    eprintln!("{} ({backend}, {driver}), {} cores", word(&about["name"]), about["cores"]);
    for name in SECTIONS.into_iter().filter(|name| args.only.is_empty() || args.only.iter().any(|only| only == name)) {
        let start = Instant::now();
        let end = start + budget(&setup, name, begin.elapsed());
        let table = Table::new(if matches!(name, "bytes" | "tdelta") { bytes::COLUMNS } else { COLUMNS });
        let mut section = Section { setup: &setup, name, end, table, notes: Vec::new() };
        match name {
            "paper" => section.paper()?,
            "resolution" => section.resolution()?,
            "steps" => section.steps()?,
            "bytes" => bytes::measure(&mut section)?,
            "tdelta" => tdelta::measure(&mut section)?,
            "meshes" => section.meshes(&args.meshes)?,
            _ => section.triangles()?,
        }
        let mut file = Vec::new();
        section.table.write(&mut file).map_err(|e| e.to_string())?;
        write(&args.output.join(format!("{name}.csv")), &file)?;
        let seconds = start.elapsed().as_secs_f64();
        eprintln!("{name}: {seconds:.1} s");
        about["seconds"][name] = seconds.into();
        if let Some(notes) = about["notes"].as_array_mut() {
            notes.extend(section.notes.into_iter().map(|note| Value::from(format!("{name}: {note}"))));
        }
        // Written after every section, so that an interruption loses nothing.
        write(&args.output.join("machine.json"), format!("{about:#}\n").as_bytes())?;
    }
    Ok(())
}

pub(crate) fn write(path: &Path, contents: &[u8]) -> Result<(), String> {
    std::fs::write(path, contents).map_err(|e| format!("{}: {e}", path.display()))
}

/// Time for a section. On a GPU all of them take less than six minutes: small sections use less than their share, and
/// the two with large scenes get the rest.
fn budget(setup: &Setup, section: &str, elapsed: Duration) -> Duration {
    const ALL: Duration = Duration::from_secs(330);
    const TRIANGLES: Duration = Duration::from_secs(120);
    let small = match section {
        "paper" => 30,
        "resolution" => 20,
        "steps" | "bytes" => 15,
        _ => 10,
    };
    match (setup.is_fast, setup.is_quick, section) {
        (true, false, "meshes") => ALL.saturating_sub(TRIANGLES + elapsed),
        (true, false, "triangles") => ALL.saturating_sub(elapsed),
        (true, false, _) => Duration::from_secs(small),
        (_, true, _) => Duration::from_secs(30),
        (false, false, "meshes" | "triangles") => Duration::from_secs(1200),
        (false, false, _) => Duration::from_secs(20 * small),
    }
}

/// A section in progress.
pub(crate) struct Section<'a> {
    pub(crate) setup: &'a Setup,
    name: &'static str,
    end: Instant,
    pub(crate) table: Table,
    /// What is left out, and why.
    pub(crate) notes: Vec<String>,
}

/// Progress on the terminal.
struct Lines;

impl Reporter for Lines {
    fn stage(&self, name: &str) {
        eprintln!("{name}");
    }

    fn note(&self, text: &str) {
        eprintln!("{text}");
    }
}

impl Section<'_> {
    pub(crate) fn is_over(&self) -> bool {
        Instant::now() >= self.end
    }

    /// An empty row.
    pub(crate) fn row(&self) -> Row {
        Row::new(self.table.columns).set("section", self.name)
    }

    /// Notes that something was left out for want of time.
    pub(crate) fn late(&mut self, what: &str) {
        self.notes.push(format!("omitted: {what}: the section's time was over"));
    }

    /// Which configurations' work is counted: of one schedule only if the others take the same steps.
    fn is_counted(&self) -> fn(&Configuration) -> bool {
        match self.name {
            "paper" => |_| true,
            "meshes" => {
                |one| one.schedule == ScheduleKind::Fused || (one.schedule, one.steps) == (ScheduleKind::Compact, 1)
            }
            _ => |_| false,
        }
    }

    /// Which configurations' timed runs submit exactly the passes that they need: the paper's.
    fn is_replayed(&self) -> fn(&Configuration) -> bool {
        match self.name {
            "paper" => |one| matches!(one.schedule, ScheduleKind::First | ScheduleKind::Second),
            _ => |_| false,
        }
    }

    /// Measures configurations on the same rays, interleaved. What cannot be measured becomes a note. Returns the new
    /// rows.
    pub(crate) fn group(&mut self, subject: &Subject, kind: RayKind, size: Size, all: Vec<Configuration>) -> &[Row] {
        let (first, scene) = (self.table.rows.len(), &subject.scene);
        // Scenes of the same name may differ in their triangles.
        let triangles = scene.triangles.len();
        if self.is_over() {
            self.late(&format!("{} of {triangles} triangles, {size} {kind}", scene.name));
            return &[];
        }
        let setup = self.setup;
        let [each, longest] =
            if setup.is_quick { [0.6, 3.0] } else { setup.choose([0.4, 1.5], [2.0, 20.0], [0.6, 3.0]) };
        let turns = Turns { fewest: 1, each: Some(Duration::from_secs_f64(each)), ..Turns::of(1, setup.repeats()) };
        let wanted = Wanted {
            configurations: all,
            sizes: vec![size],
            rays: vec![kind],
            file: None,
            turns,
            longest_run: Duration::from_secs_f64(longest),
            until: Some(self.end),
            is_counted: self.is_counted(),
            is_replayed: self.is_replayed(),
            seed: SEED,
            tuning: Options::new(RaySource::Given(Vec::new())),
        };
        setup.raise_clocks();
        match bench::measure(&wanted, std::slice::from_ref(subject), String::new(), &setup.meter, &Lines) {
            Ok(measured) => {
                for (of, details) in measured.rows.iter().zip(&measured.details) {
                    let threads: u64 = details.passes.iter().map(|pass| pass.threads_launched).sum();
                    let with_ray: u64 = details.passes.iter().map(|pass| u64::from(pass.rays_in)).sum();
                    let cells = details.cells.map(|cells| cells.map(|n| n.to_string()).join("x"));
                    let row = self.row().with(of).set("threads_launched", threads).set("threads_with_ray", with_ray);
                    self.table.rows.push(row.set("cells", cells));
                }
                self.notes.extend(measured.notes.iter().map(|note| format!("{triangles} triangles: {note}")));
            }
            Err(error) => {
                self.notes.push(format!("omitted: {} of {triangles} triangles, {size} {kind}: {error}", scene.name));
            }
        }
        &self.table.rows[first..]
    }
}

#[cfg(test)]
mod tests {
    use raystep_kernels::Accelerator;

    use super::*;
    use crate::subjects::generated;

    const SIZE: Size = Size { width: 8, height: 8 };

    fn setup() -> Setup {
        let machine = Machine { device: Device::Cpu(Some(now_ns)), reason: String::new() };
        Setup { meter: Meter::new(machine), is_fast: false, is_quick: true }
    }

    fn section<'a>(setup: &'a Setup, name: &'static str, time: Duration) -> Section<'a> {
        Section { setup, name, end: Instant::now() + time, table: Table::new(COLUMNS), notes: Vec::new() }
    }

    /// With these steps a pass.
    fn grid(schedule: ScheduleKind, steps: u32) -> Configuration {
        Configuration::new(Accelerator::Grid, schedule, steps)
    }

    #[test]
    fn a_group_returns_its_own_rows_and_counts_what_its_section_asks_for() {
        let (setup, subject) = (setup(), generated("cornell-box", None).expect("a scene"));
        let mut meshes = section(&setup, "meshes", Duration::from_secs(600));
        let all = [grid(ScheduleKind::Fused, 1), grid(ScheduleKind::Compact, 8), grid(ScheduleKind::Compact, 1)];
        for kind in [RayKind::Primary, RayKind::Random] {
            let rows = meshes.group(&subject, kind, SIZE, all.to_vec());
            assert_eq!((rows.len(), rows.iter().all(|row| row.get("rays_kind") == kind.name())), (3, true), "{rows:?}");
            let counted: Vec<bool> = rows.iter().map(|row| row.number("tests_per_ray").is_some()).collect();
            assert_eq!(counted, [true, false, true]);
            assert!(rows.iter().all(|row| row.get("cells").split('x').count() == 3), "{rows:?}");
        }
        assert_eq!((meshes.table.rows.len(), meshes.notes), (6, Vec::new()));
    }

    #[test]
    fn a_section_whose_time_is_over_measures_nothing_and_says_so() {
        let (setup, subject) = (setup(), generated("cornell-box", None).expect("a scene"));
        let mut late = section(&setup, "steps", Duration::ZERO);
        assert_eq!(late.group(&subject, RayKind::Primary, SIZE, vec![grid(ScheduleKind::Fused, 1)]), []);
        assert_eq!(late.notes, ["omitted: cornell-box of 26 triangles, 8x8 primary: the section's time was over"]);
    }

    #[test]
    fn only_the_papers_schedules_are_replayed_and_only_in_its_tables() {
        let setup = setup();
        let [paper, meshes] = ["paper", "meshes"].map(|name| section(&setup, name, Duration::ZERO).is_replayed());
        let all = [ScheduleKind::First, ScheduleKind::Second, ScheduleKind::Compact, ScheduleKind::Fused];
        assert_eq!(all.map(|schedule| paper(&grid(schedule, 1))), [true, true, false, false]);
        assert_eq!(all.map(|schedule| meshes(&grid(schedule, 1))), [false; 4]);
    }
}
