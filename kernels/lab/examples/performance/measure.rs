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
use raystep_kernels::{
    Accelerator, AdapterChoice, Device, Gpu, GridSize, Numerics, Options, Plan, RaySource, ScheduleKind, Skip,
};
use raystep_lab::bench::{self, SEED, Wanted};
use raystep_lab::configuration::Configuration;
use raystep_lab::machine::now_ns;
use raystep_lab::meter::{Meter, Turns};
use raystep_lab::paper::{GRID, SECONDS};
use raystep_lab::reporter::Reporter;
use raystep_lab::tidy::{Row, TIMES, Table, count, joined};
use raystep_lab::{Machine, RayKind, Size, Subject, block_on, columns};
use serde_json::{Value, json};

use crate::subjects::{Mesh, generated};
use crate::{Adapter, MeasureArgs, bytes, tdelta};

/// In the order in which they run: the largest scenes last.
pub(crate) const SECTIONS: [&str; 7] = ["paper", "resolution", "steps", "bytes", "tdelta", "meshes", "triangles"];

/// Triangles of the terrain that represents an ordinary scene.
const TERRAIN: u64 = 20_000;

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
        about["seconds"][name] = start.elapsed().as_secs_f64().into();
        let notes = section.notes.into_iter().map(|note| Value::from(format!("{name}: {note}")));
        about["notes"].as_array_mut().into_iter().for_each(|all| all.extend(notes.clone()));
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

fn fused(accelerator: Accelerator) -> Configuration {
    Configuration::new(accelerator, ScheduleKind::Fused, 1)
}

fn compact(accelerator: Accelerator, steps: u32) -> Configuration {
    Configuration::new(accelerator, ScheduleKind::Compact, steps)
}

/// The paper's scene, and a larger one.
pub(crate) fn two_scenes() -> Result<[Subject; 2], String> {
    Ok([generated("cornell-box", None)?, generated("terrain", Some(TERRAIN))?])
}

impl Section<'_> {
    pub(crate) fn is_over(&self) -> bool {
        Instant::now() >= self.end
    }

    /// An empty row.
    pub(crate) fn row(&self) -> Row {
        Row::new(self.table.columns).set("section", self.name)
    }

    /// Measures configurations on the same rays, interleaved. What cannot be measured becomes a note.
    fn group(&mut self, subject: &Subject, kind: RayKind, size: Size, all: Vec<Configuration>) {
        if self.is_over() {
            let scene = &subject.scene;
            let triangles = scene.triangles.len();
            return self.notes.push(format!("{} {triangles} {kind} {size}: the section's time was over", scene.name));
        }
        let setup = self.setup;
        let [each, longest] =
            if setup.is_quick { [0.6, 3.0] } else { setup.choose([0.4, 1.5], [2.0, 20.0], [0.6, 3.0]) };
        let turns = Turns {
            fewest: 1,
            all: Some(self.end.saturating_duration_since(Instant::now())),
            each: Some(Duration::from_secs_f64(each)),
            ..Turns::of(1, setup.repeats())
        };
        let wanted = Wanted {
            configurations: all.clone(),
            sizes: vec![size],
            rays: vec![kind],
            file: None,
            turns,
            longest_run: Duration::from_secs_f64(longest),
            replay: self.name == "paper",
            seed: SEED,
            tuning: Options::new(RaySource::Given(Vec::new())),
        };
        setup.raise_clocks();
        match bench::measure(&wanted, std::slice::from_ref(subject), String::new(), &setup.meter, &Lines) {
            Ok(measured) => {
                for (of, details) in measured.rows.iter().zip(&measured.details) {
                    let threads: u64 = details.passes.iter().map(|pass| pass.threads_launched).sum();
                    let with_ray: u64 = details.passes.iter().map(|pass| u64::from(pass.rays_in)).sum();
                    let row = self.row().with(of).set("threads_launched", threads).set("threads_with_ray", with_ray);
                    let configuration = details.context.configuration.parse().ok().and_then(|i: usize| all.get(i));
                    let cells = configuration.filter(|_| self.name == "paper").and_then(|one| cells(subject, *one));
                    self.table.rows.push(row.set("cells", cells));
                }
                self.notes.extend(measured.notes);
            }
            Err(error) => self.notes.push(format!("{} {size} {kind}: {error}", subject.scene.name)),
        }
    }

    /// The image size for sections that measure only one.
    fn one_size(&self) -> Size {
        let [width, height] = self.setup.choose([1920, 1080], [512, 512], [128, 128]);
        Size { width, height }
    }

    fn paper(&mut self) -> Result<(), String> {
        use Accelerator::{Bvh, Grid, Irregular, None};
        use ScheduleKind::{First, Second};
        let grid = Some(GRID);
        let mut all = Vec::new();
        for numerics in [Numerics::Paper, Numerics::Robust] {
            let of = |accelerator, schedule| Configuration { numerics, ..Configuration::new(accelerator, schedule, 1) };
            for grid in [GRID, GridSize::Auto].map(Some) {
                all.extend([First, Second].map(|schedule| Configuration { grid, ..of(Grid, schedule) }));
            }
            all.push(of(None, Second));
        }
        for one in [compact(Grid, 1), compact(Grid, 8), fused(Grid)] {
            all.extend([one, one.skipping(), Configuration { grid, ..one }]);
        }
        for accelerator in [Bvh, Irregular, None] {
            all.extend([compact(accelerator, 1), compact(accelerator, 8), fused(accelerator)]);
        }
        let subject = generated("cornell-box", Option::None)?;
        for (side, _) in SECONDS.into_iter().take(if self.setup.is_quick { 2 } else { SECONDS.len() }) {
            self.group(&subject, RayKind::Primary, Size { width: side, height: side }, all.clone());
        }
        Ok(())
    }

    fn resolution(&mut self) -> Result<(), String> {
        use Accelerator::{Bvh, Grid};
        // From 0.25 to 8.3 million pixels.
        const SIZES: [[u32; 2]; 7] =
            [[640, 384], [960, 540], [1280, 720], [1920, 1080], [2560, 1440], [3200, 1800], [3840, 2160]];
        const SMALL: [[u32; 2]; 4] = [[128, 96], [256, 192], [320, 240], [512, 384]];
        for subject in &two_scenes()? {
            for &[width, height] in self.setup.choose(&SIZES[..], &SIZES[..4], &SMALL[..]) {
                let all = vec![fused(Bvh), fused(Grid), compact(Bvh, 8), compact(Grid, 8)];
                self.group(subject, RayKind::Primary, Size { width, height }, all);
            }
        }
        Ok(())
    }

    fn steps(&mut self) -> Result<(), String> {
        let steps = |accelerator| [1, 2, 4, 8, 16, 32, 64].map(|steps| compact(accelerator, steps));
        let of = |accelerator| [vec![fused(accelerator)], steps(accelerator).into()].concat();
        for subject in &two_scenes()? {
            let all = [of(Accelerator::Grid), of(Accelerator::Bvh)].concat();
            self.group(subject, RayKind::Primary, self.one_size(), all);
        }
        Ok(())
    }

    /// By kind first: if time runs out, every scene has at least its primary rays.
    fn meshes(&mut self, meshes: &[Mesh]) -> Result<(), String> {
        use Accelerator::{Bvh, Grid, Irregular};
        let of = |one: fn(Accelerator) -> Configuration| [Bvh, Irregular, Grid].map(one);
        let mut all = Vec::new();
        for eight_or_all in [of(fused), of(|accelerator| compact(accelerator, 8))] {
            all.extend(eight_or_all);
            all.push(eight_or_all[2].skipping());
        }
        all.extend(of(|accelerator| compact(accelerator, 1)));
        all.extend(of(|accelerator| Configuration::new(accelerator, ScheduleKind::Second, 1)));
        let mut subjects = vec![generated("cornell-box", None)?];
        for mesh in meshes {
            subjects.push(mesh.read()?);
        }
        for &kind in RayKind::ALL {
            subjects.iter().for_each(|subject| self.group(subject, kind, self.one_size(), all.clone()));
        }
        Ok(())
    }

    fn triangles(&mut self) -> Result<(), String> {
        use Accelerator::{Bvh, Grid, Irregular};
        const COUNTS: [u64; 14] =
            [2, 8, 18, 32, 72, 128, 512, 2_048, 8_192, 32_768, 131_072, 524_288, 2_000_000, 10_000_000];
        /// A run without an accelerator is skipped if it is expected to take longer than this.
        const MOST_NS: f64 = 0.5e9;
        /// Most triangles for which the host builds an irregular grid: it takes some 5 s for a million.
        const MOST_IRREGULAR: u64 = 600_000;
        let fast = if self.setup.is_quick { (131_072, 512) } else { (10_000_000, 1024) };
        let (most, side) = self.setup.choose(fast, (2_000_000, 256), (8_192, 128));
        // The last time without an accelerator, per scene: it is proportional to triangles from a few hundred up.
        let mut last = [None::<(f64, f64)>; 2];
        for count in COUNTS.into_iter().filter(|&count| count <= most) {
            for (scene, last) in ["terrain", "soup"].into_iter().zip(&mut last) {
                if self.is_over() {
                    self.notes.push(format!("{scene} of {count} triangles: the section's time was over"));
                    continue;
                }
                let subject = generated(scene, Some(count))?;
                let triangles = subject.scene.triangles.len() as f64;
                let expected_ns = last.map_or(0.0, |(before, ns)| ns * triangles / before);
                let of_grid = |one: Configuration| Configuration { skip: Skip::Auto, ..one };
                let mut all = vec![of_grid(fused(Grid)), fused(Bvh), of_grid(compact(Grid, 8)), compact(Bvh, 8)];
                all.extend((count <= MOST_IRREGULAR).then(|| fused(Irregular)));
                if expected_ns < MOST_NS {
                    all.push(fused(Accelerator::None));
                } else {
                    let seconds = expected_ns / 1e9;
                    self.notes.push(format!("{scene} of {count} triangles, none: {seconds:.1} s were expected"));
                }
                self.group(&subject, RayKind::Primary, Size { width: side, height: side }, all);
                let none = self.table.rows.last().filter(|row| row.get("accelerator") == "none");
                *last = none.and_then(|row| row.number("median_ns")).map(|ns| (triangles, ns)).or(*last);
            }
        }
        Ok(())
    }
}

/// Cells of the grid that is built, along x, y and z.
fn cells(subject: &Subject, one: Configuration) -> Option<String> {
    let options = one.of(&Options::new(subject.camera_rays(Size { width: 1, height: 1 })));
    let (plan, data) = Plan::new(&subject.scene, &options, &raystep_kernels::Limits::CPU).ok()?;
    plan.features.grid.then(|| data.grid.cells.map(|n| n.to_string()).join("x"))
}
