//! The picture in `docs/architecture.md`: the crates and the floors of `kernels/src`, the arrows between them, and a
//! run through them. It is drawn from the sources; the test fails if the file differs from the drawing.

mod draw;

use std::collections::BTreeMap;
use std::path::Path;

use raystep_tests::floors::{CRATES, FLOORS, KERNELS, Modules, Names, arrows_of, defines, modules_of, sources};

const FILE: &str = "docs/images/architecture.svg";

/// What to do if the file differs from the drawing.
const AGAIN: &str = "UPDATE_SNAPSHOTS=1 cargo test -p raystep-tests architecture draws it again: look at it";

/// The stops of a frame of `raystep render`, in order.
const STOPS: &[Stop] = &[
    Stop::at(&[("raystep::scene_file", "read")], "bytes of the scene's file"),
    Stop::at(&[("raystep_scenes::load", "load")], "triangles, lights, camera"),
    Stop::at(&[("raystep_kernels::options", "Options")], "what the user asks for"),
    Stop::at(&[("raystep_kernels::programs", "Plan::new")], "what this run needs"),
    Stop::at(&[("raystep_kernels::shader", "Variant::new")], "WGSL and its bindings"),
    Stop::at(&[("raystep_kernels::scene_data", "SceneData::new")], "what buffers hold"),
    Stop::at(&[("raystep_kernels::renderer", "Renderer::from_plan")], "an executor, with streams"),
    Stop::at(&[("raystep_kernels::program::schedule::cursor", "Cursor::guess")], "which kernels are next"),
    Stop::at(
        &[
            ("raystep_kernels::executor::gpu::batch", "GpuExecutor::run"),
            ("raystep_kernels::executor::cpu", "CpuExecutor::run"),
        ],
        "runs them, pass by pass",
    ),
    Stop {
        turns_to: Some(7),
        ..Stop::at(&[("raystep_kernels::programs::closest_hit::walk", "walk")], "a kernel, ray by ray")
    },
    Stop::at(&[("raystep_kernels::renderer::results", "Renderer::image")], "colours, read back"),
    Stop { is_optional: true, ..Stop::at(&[("raystep_kernels::export::exr", "write_image")], "with what was hit") },
    Stop::at(&[("raystep::commands::render", "encode")], "bytes of the PNG"),
];

/// A stop of a run.
struct Stop {
    /// Modules and items; more than one if options select between them.
    items: &'static [(&'static str, &'static str)],
    /// What it makes or does.
    about: &'static str,
    /// The stop at which the run continues if there are more passes.
    turns_to: Option<usize>,
    /// Whether options decide if the run has this stop.
    is_optional: bool,
}

impl Stop {
    const fn at(items: &'static [(&'static str, &'static str)], about: &'static str) -> Self {
        Self { items, about, turns_to: None, is_optional: false }
    }

    fn lines(&self) -> usize {
        self.items.len() + 1
    }

    /// Labels that a reader can search for: names of types, and functions with their modules.
    fn labels(&self) -> impl Iterator<Item = String> {
        self.items.iter().map(|(module, item)| {
            let is_function = item.starts_with(char::is_lowercase);
            let last = module.rsplit("::").next().filter(|last| is_function && last != item);
            last.map_or_else(|| (*item).to_owned(), |last| format!("{last}::{item}"))
        })
    }
}

/// A band of the picture.
struct Row {
    /// Its modules, by their paths.
    modules: Vec<Names>,
    /// Whether it is a floor of the kernels; otherwise it is a crate.
    is_floor: bool,
    /// For each module its name and the modules in it; for a crate, its folder and a description.
    parts: Vec<(String, Vec<String>)>,
}

/// The contents of the picture.
struct Picture {
    /// The bands, highest first.
    rows: Vec<Row>,
    /// For each pair of a row and a lower one: how many names the first uses from the second.
    uses: BTreeMap<(usize, usize), usize>,
    /// The row of each stop.
    stops: Vec<usize>,
}

fn path_of(module: &str) -> Names {
    module.split("::").map(str::to_owned).collect()
}

fn rows(modules: &Modules) -> Vec<Row> {
    let krate = |name: &str, folder: &str, about: &[&str]| {
        let parts = vec![(folder.to_owned(), about.iter().map(|&line| line.to_owned()).collect())];
        Row { modules: vec![path_of(name)], is_floor: false, parts }
    };
    let floor = |names: &&[&str]| {
        let paths: Vec<Names> = names.iter().map(|name| vec![KERNELS.to_owned(), (*name).to_owned()]).collect();
        let inside = |path: &Names| {
            let inner = modules.keys().filter(|module| module.len() == path.len() + 1 && module.starts_with(path));
            inner.filter_map(|module| module.last().cloned()).collect()
        };
        let parts = paths.iter().zip(*names).map(|(path, name)| ((*name).to_owned(), inside(path))).collect();
        Row { modules: paths, is_floor: true, parts }
    };
    let mut rows = vec![
        krate("raystep", "app", &["command line and window"]),
        krate("raystep_inspector", "inspector", &["sessions and panels"]),
        krate("raystep_lab", "lab", &["measures and judges runs"]),
    ];
    rows.extend(FLOORS.iter().rev().map(floor));
    rows.push(krate("raystep_scenes", "scenes", &["reads and generates"]));
    rows
}

fn row_of(module: &[String], rows: &[Row]) -> Option<usize> {
    rows.iter().position(|row| row.modules.iter().any(|path| module.starts_with(path)))
}

impl Picture {
    fn of(modules: &Modules) -> Self {
        let rows = rows(modules);
        let mut uses = BTreeMap::new();
        for arrow in arrows_of(modules) {
            // Arrows to higher floors are left to the test of floors, which rejects them.
            if let (Some(from), Some(to)) = (row_of(&arrow.from, &rows), row_of(&arrow.to, &rows))
                && from < to
            {
                *uses.entry((from, to)).or_insert(0) += 1;
            }
        }
        let row = |stop: &Stop| row_of(&path_of(stop.items[0].0), &rows).expect("a stop is in a crate");
        let stops = STOPS.iter().map(row).collect();
        Self { rows, uses, stops }
    }
}

/// Items of stops that do not exist in the sources.
fn missing(modules: &Modules) -> Vec<String> {
    let items = STOPS.iter().flat_map(|stop| stop.items);
    let is_missing = |(module, item): &&(&str, &str)| !modules.get(&path_of(module)).is_some_and(|m| defines(m, item));
    items.filter(is_missing).map(|(module, item)| format!("{module}: {item}")).collect()
}

fn all_sources() -> Vec<(String, String)> {
    CRATES.iter().flat_map(|(folder, _)| sources(folder)).collect()
}

#[test]
fn the_picture_of_the_architecture_is_what_the_sources_say() {
    let modules = modules_of(&all_sources());
    let missing = missing(&modules);
    assert!(missing.is_empty(), "stops of a run that the sources do not have; change STOPS: {missing:?}");
    let drawn = draw::svg(&Picture::of(&modules)).expect("an SVG");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(FILE);
    if std::env::var("UPDATE_SNAPSHOTS").is_ok_and(|value| !matches!(value.as_str(), "" | "0" | "false")) {
        std::fs::write(&path, drawn).expect("a folder that can be written to");
        return;
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{FILE}: {e}; {AGAIN}"));
    // A checkout may change line ends.
    assert!(kept.lines().eq(drawn.lines()), "{FILE} is not what the sources say; {AGAIN}");
}

#[test]
fn a_renamed_stop_and_a_new_arrow_are_seen() {
    let sources = all_sources();
    let drawn = |modules: &Modules| draw::svg(&Picture::of(modules)).expect("an SVG");
    let changed = |file: &str, change: &dyn Fn(&str) -> String| {
        let mut sources = sources.clone();
        let (_, text) = sources.iter_mut().find(|(name, _)| name == file).expect("a source");
        *text = change(text);
        modules_of(&sources)
    };
    let renamed = changed("kernels/src/programs/mod.rs", &|text| text.replace("pub fn new(", "pub fn make("));
    assert_eq!(missing(&renamed), ["raystep_kernels::programs: Plan::new"]);
    let before = drawn(&modules_of(&sources));
    let arrow =
        changed("kernels/src/structures/grid.rs", &|text| format!("{text}\nuse crate::tables::stream::Stream;"));
    assert!(drawn(&arrow) != before, "an arrow from structures to tables");
    let comment = changed("kernels/src/structures/grid.rs", &|text| format!("{text}\n// use crate::plan::Plan;"));
    assert!(drawn(&comment) == before, "a comment is no arrow");
}
