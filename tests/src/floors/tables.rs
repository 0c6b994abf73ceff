//! The floors of the crates, and the circles that are still in them.

use super::KERNELS;

/// The modules of `kernels/src`, lowest first: each may use those in its own line and in the lines before.
pub const FLOORS: &[&[&str]] = &[
    &["numbers"],
    &["shared"],
    &["options"],
    &["tables"],
    &["structures"],
    &["scene_data"],
    &["program"],
    &["compose", "shader"],
    &["fragment", "interpret"],
    &["plan"],
    &["programs"],
    &["executor"],
    &["renderer"],
    &["history"],
    &["export"],
];

/// The floors of folders of modules, as [`FLOORS`], each with its path.
pub const ALL_FLOORS: &[(&str, &[&[&str]])] = &[
    ("raystep_scenes", &[&["scene"], &["generate", "glb"], &["load"]]),
    (KERNELS, FLOORS),
    (
        "raystep_lab",
        &[
            &[
                "bounces",
                "branch",
                "built",
                "compare",
                "compared",
                "configuration",
                "flip",
                "hash",
                "layer_stats",
                "non_finite",
                "outside",
                "passed",
                "png",
                "portions",
                "rough",
                "stops",
                "strategies",
                "structure_stats",
                "structures",
                "text",
                "wait",
                "work",
            ],
            &["lockstep", "machine", "reference", "subject"],
            &["human", "rays", "rounding"],
            &["divergence", "judge", "parity", "plots", "statistics", "watertight"],
            &["meter", "tidy"],
            &["html"],
            &["error", "reporter", "stability", "stiff"],
            &["bench", "check_kernel", "check_program", "intensity", "line_cost", "report", "self_test"],
            &["course", "paper"],
        ],
    ),
    (
        "raystep_inspector",
        &[
            &["command", "dataflow", "names", "ray_text", "source", "versioned", "walk"],
            &["branches", "link", "orbit"],
            &["draw", "exports", "saved", "settings"],
            &["hits", "session"],
            &["lesson", "runs"],
            &["session_file"],
            &["ui"],
        ],
    ),
    (
        "raystep_inspector::ui",
        &[
            &["style"],
            &["choice"],
            &["canvas", "host", "picture", "retained", "scrub", "units"],
            &["mask", "preview", "svg", "thumbs"],
            &["state"],
            &["pane"],
            &["panels"],
            &["keys", "panes"],
            &["desk"],
            &["inspector"],
            &["latency", "offscreen"],
        ],
    ),
    ("raystep", &[&["error", "interrupt"], &["args"], &["link"], COMMAND_LINE, &["api"]]),
];

/// Circles that are still there, by the path of their folder: modules that use each other.
pub const KNOWN_CIRCLES: &[(&str, &[&str])] = &[
    ("raystep_scenes::load", &["check", "json"]),
    ("raystep_kernels::interpret", &["flow", "machine", "pass"]),
    ("raystep_kernels::interpret::pass", &["columns", "group"]),
    ("raystep_lab", &["error", "reporter", "stability", "stiff"]),
    ("raystep_lab::bench", &["runs", "summary"]),
    ("raystep_lab::plots", &["frame", "picture"]),
    (
        "raystep_lab::report",
        &["choices", "grid", "left_out", "moved", "page", "resolved", "rules", "samples", "section", "stiff", "words"],
    ),
    ("raystep_lab::self_test", &["operations", "probe"]),
    ("raystep_lab::stability", &["make", "planes"]),
    ("raystep_lab::stability", &["beside", "page", "report", "table"]),
    ("raystep_lab::work", &["lanes", "visits", "warps"]),
    ("raystep", COMMAND_LINE),
    ("raystep::commands::info::self_test", &["drive", "report"]),
    ("raystep::commands::sweep", &["gather", "page"]),
    ("raystep::window", &["host", "opening"]),
];

/// The modules of the command line, which still use each other.
const COMMAND_LINE: &[&str] = &[
    "cli",
    "commands",
    "debug_adapter",
    "drawing",
    "device",
    "output",
    "process",
    "program_folder",
    "rays_file",
    "scene_file",
    "session",
    "session_file",
    "shard",
    "terminal",
    "threads",
    "usage",
    "window",
];
