//! Names of a program's kernels, streams and states appear only in that program and in files about its results, and names
//! of options only in their rows.

use std::fs;
use std::path::{Path, PathBuf};

use raystep_kernels::options::rows::ROWS;

/// Files outside `programs/` that may name something of `closest_hit`, and why. The list should only get shorter: all
/// other files use the plan's program, its rows and roles.
const MAY_NAME: &[(&str, &[&str])] = &[
    (
        "how far floats of a ray may be off, along its walk too, and what a ray that differs decides",
        &[
            "kernels/lab/src/divergence.rs",
            "kernels/lab/src/parity.rs",
            "kernels/lab/src/rounding.rs",
            "kernels/lab/src/rounding/judge.rs",
            "kernels/lab/src/rounding/nudge.rs",
            "kernels/lab/src/stability/drift.rs",
        ],
    ),
    (
        "a ray's history, and its walk through cells and nodes",
        &[
            "inspector/src/session/watch/look.rs",
            "inspector/src/ui/panels/structure/slice/path.rs",
            "inspector/src/walk.rs",
            "inspector/src/walk/cells.rs",
            "inspector/src/walk/nodes.rs",
        ],
    ),
    ("panels about rays alone", &["inspector/src/ui/panels/compare.rs"]),
    (
        "what values of a ray mean in words, and how many of its threads do useful work",
        &["inspector/src/ui/inspector/lessons/measured.rs", "inspector/src/ui/panels/stream/values.rs"],
    ),
    (
        "the lists of the grid that was built, and the command that builds it",
        &["kernels/src/renderer/lists.rs", "app/src/commands/build.rs"],
    ),
];

/// Sources of the crates, without test code.
fn sources(folder: &Path, all: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()) {
        if entry.is_dir() {
            sources(&entry, all);
        } else if entry.extension().is_some_and(|e| e == "rs") && entry.file_name().is_some_and(|n| n != "tests.rs") {
            all.push(entry);
        }
    }
}

/// Files outside `kernels/src/options` that may name an option of a run, and why. All others read the rows of options.
const MAY_NAME_OPTIONS: &[(&str, &[&str])] = &[
    (
        "which options a command has, and their defaults there",
        &[
            "app/src/args/choices.rs",
            "app/src/commands/cast.rs",
            "app/src/commands/plan.rs",
            "app/src/commands/render.rs",
            "app/src/commands/run.rs",
        ],
    ),
    ("whether an option was given", &["app/src/commands/dump.rs", "app/src/commands/inspect.rs", "app/src/session.rs"]),
    ("what a command cannot do with a value", &["app/python/src/renderer.rs", "app/src/commands/trace.rs"]),
    ("options of their own with such names", &["app/src/commands/bench/against.rs", "app/src/commands/report.rs"]),
    ("a member of editors' requests", &["app/src/debug_adapter/target.rs"]),
    ("the samples of a part of a picture", &["app/src/commands/render/part.rs"]),
    (
        "options of the other run, and of a part of a link",
        &["inspector/src/link/read.rs", "inspector/src/settings.rs", "inspector/src/ui/panels/compare/settings.rs"],
    ),
    ("the options in the name of a kept run", &["inspector/src/ui/panels/runs/options.rs"]),
    (
        "columns of tables, and words of WGSL",
        &[
            "app/src/commands/bench/programs.rs",
            "app/src/commands/build.rs",
            "app/src/commands/stability.rs",
            "app/src/commands/sweep/page.rs",
            "inspector/src/source/words.rs",
            "inspector/src/ui/panels/passes.rs",
            "inspector/src/ui/panels/timings.rs",
        ],
    ),
];

/// Code without comments and tests.
fn code(text: &str) -> impl Iterator<Item = &str> {
    let code = text.split("#[cfg(test)]\nmod ").next().unwrap_or(text);
    code.lines().filter(|line| !line.trim_start().starts_with("//"))
}

/// Whether code names a module of a program.
fn names_a_program(text: &str) -> bool {
    code(text).any(|line| {
        ["closest_hit", "grid_build", "programs::light", "programs::sort"].iter().any(|name| line.contains(name))
    })
}

/// Whether code has a text that begins with the name of an option.
fn names_an_option(text: &str) -> bool {
    let is_named = |line: &str, name: &str| {
        [format!("\"{name}\""), format!("\"--{name}\""), format!("\"--{name} ")].iter().any(|text| line.contains(text))
    };
    code(text).any(|line| ROWS.iter().any(|row| is_named(line, row.name) || is_named(line, &row.key())))
}

/// Asserts that among the sources of some folders only listed ones name something, and all of these.
fn assert_listed(folders: &[&str], may_name: &[(&str, &[&str])], names: fn(&str) -> bool, instead: &str) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut files = Vec::new();
    for folder in folders {
        sources(&root.join(folder), &mut files);
    }
    assert!(files.len() > 60 * folders.len(), "{} files", files.len());
    let mut found: Vec<String> = files
        .iter()
        .map(|file| file.strip_prefix(&root).expect("below the root").to_string_lossy().replace('\\', "/"))
        .zip(&files)
        .filter(|(name, _)| !name.starts_with("kernels/src/programs/"))
        .filter(|(_, file)| names(&fs::read_to_string(file).expect("text")))
        .map(|(name, _)| name)
        .collect();
    found.sort();
    let mut listed: Vec<String> =
        may_name.iter().flat_map(|(_, files)| files.iter()).map(|file| (*file).to_owned()).collect();
    listed.sort();
    let new: Vec<_> = found.iter().filter(|file| !listed.contains(file)).collect();
    let gone: Vec<_> = listed.iter().filter(|file| !found.contains(file)).collect();
    assert!(new.is_empty(), "{instead}: {new:?}");
    assert!(gone.is_empty(), "these no longer do; take them off the list: {gone:?}");
}

#[test]
fn only_what_is_about_its_results_names_a_programs_kernels_streams_and_states() {
    let folders = ["kernels/src", "kernels/lab/src", "inspector/src", "app/src"];
    let instead = "these name a program's kernels, streams or states: ask the plan's program instead";
    assert_listed(&folders, MAY_NAME, names_a_program, instead);
}

#[test]
fn no_option_of_a_run_is_named_outside_its_row() {
    let folders = ["inspector/src", "app/src", "app/python/src", "app/web/src"];
    assert_listed(&folders, MAY_NAME_OPTIONS, names_an_option, "these name an option: read its row instead");
}
