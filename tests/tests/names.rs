//! Names of a program's kernels, streams and states appear only in that program and in files about its results.

use std::fs;
use std::path::{Path, PathBuf};

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
    ("the plan of each program", &["kernels/src/plan/mod.rs", "kernels/src/plan/grid_build.rs"]),
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

/// Whether code, ignoring comments and tests, names a module of a program.
fn names_a_program(text: &str) -> bool {
    let code = text.split("#[cfg(test)]\nmod ").next().unwrap_or(text);
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.into_iter().any(|line| line.contains("closest_hit") || line.contains("grid_build"))
}

#[test]
fn only_what_is_about_its_results_names_a_programs_kernels_streams_and_states() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut files = Vec::new();
    for folder in ["kernels/src", "kernels/lab/src", "inspector/src", "app/src"] {
        sources(&root.join(folder), &mut files);
    }
    assert!(files.len() > 300, "{} files", files.len());
    let mut found: Vec<String> = files
        .iter()
        .map(|file| file.strip_prefix(&root).expect("below the root").to_string_lossy().replace('\\', "/"))
        .zip(&files)
        .filter(|(name, _)| !name.starts_with("kernels/src/programs/"))
        .filter(|(_, file)| names_a_program(&fs::read_to_string(file).expect("text")))
        .map(|(name, _)| name)
        .collect();
    found.sort();
    let mut listed: Vec<String> =
        MAY_NAME.iter().flat_map(|(_, files)| files.iter()).map(|file| (*file).to_owned()).collect();
    listed.sort();
    let new: Vec<_> = found.iter().filter(|file| !listed.contains(file)).collect();
    let gone: Vec<_> = listed.iter().filter(|file| !found.contains(file)).collect();
    assert!(
        new.is_empty(),
        "these name a program's kernels, streams or states: ask the plan's program instead: {new:?}"
    );
    assert!(gone.is_empty(), "these no longer do; take them off the list: {gone:?}");
}
