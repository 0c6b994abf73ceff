//! The examples in `docs/adding-a-*.md` still apply to the sources.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use raystep_kernels::Kernel;
use raystep_kernels::compose::compose;
use raystep_kernels::options::features::Features;
use raystep_kernels::program::live;
use raystep_kernels::programs::closest_hit::kernels::{INTERSECT, SHADE, TRAVERSE_GRID};
use raystep_kernels::shader::modules;

/// The text that a hunk replaces, and its replacement.
struct Hunk {
    old: String,
    new: String,
    /// Lines of both, as its head says; `patch` refuses a hunk that has others.
    lines: [usize; 2],
}

/// The numbers of lines in `@@ -255,5 +255,25 @@ …`.
fn lines_of(head: &str) -> [usize; 2] {
    let mut ranges = head.split(' ').skip(1).map(|range| range.split_once(',').map_or("1", |(_, count)| count));
    [(); 2].map(|()| ranges.next().and_then(|count| count.parse().ok()).expect("a range of lines"))
}

/// The hunks of a unified diff, by file.
fn hunks(diff: &str) -> BTreeMap<String, Vec<Hunk>> {
    let mut files: BTreeMap<String, Vec<Hunk>> = BTreeMap::new();
    let mut file = String::new();
    for line in diff.lines() {
        if let Some(name) = line.strip_prefix("+++ b/") {
            file = name.to_owned();
        } else if line.starts_with("--- ") {
        } else if line.starts_with("@@") {
            files.entry(file.clone()).or_default().push(Hunk {
                old: String::new(),
                new: String::new(),
                lines: lines_of(line),
            });
        } else if let Some(hunk) = files.get_mut(&file).and_then(|hunks| hunks.last_mut()) {
            // An editor may have removed the space of an empty line.
            let (kind, text) = if line.is_empty() { (" ", "") } else { line.split_at(1) };
            for (text_of, kinds) in [(&mut hunk.old, " -"), (&mut hunk.new, " +")] {
                if kinds.contains(kind) {
                    *text_of += text;
                    *text_of += "\n";
                }
            }
        }
    }
    files
}

/// The diff in a file of the docs, by file.
fn documented(name: &str) -> BTreeMap<String, Vec<Hunk>> {
    let docs = fs::read_to_string(root().join("docs").join(name)).expect("the docs");
    let diff = docs.split("```diff\n").nth(1).and_then(|rest| rest.split("\n```").next()).expect("a diff");
    let files = hunks(diff);
    for hunk in files.values().flatten() {
        assert_eq!([&hunk.old, &hunk.new].map(|text| text.lines().count()), hunk.lines, "{}", hunk.new);
        assert_ne!(hunk.old, hunk.new);
    }
    files
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn source(name: &str) -> String {
    fs::read_to_string(root().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// Whether a diff makes a file.
fn is_new(hunks: &[Hunk]) -> bool {
    matches!(hunks, [hunk] if hunk.old.is_empty())
}

/// Asserts that a text is at one place of a file.
fn assert_once(name: &str, text: &str) {
    assert_eq!(source(name).matches(text).count(), 1, "{name} has changed where the docs change it:\n{text}");
}

/// The WGSL of a kernel with these options, validated; `changed` are modules with other texts.
fn composed(
    kernel: Kernel,
    name: &str,
    features: &Features,
    is_on: &[&str],
    changed: &BTreeMap<&str, String>,
) -> String {
    let lists = live::lists(&[INTERSECT, TRAVERSE_GRID], features);
    let modules = modules(kernel, features, &lists);
    let source = |name: &str| match changed.get(name) {
        Some(text) => Some(text.as_str()),
        None => modules.iter().find(|(module, _)| *module == name).map(|(_, text)| text.as_ref()),
    };
    let options = features.list();
    let option = |name: &str| {
        let known = options.iter().find(|(n, _)| *n == name).map(|&(_, is_on)| is_on);
        if is_on.contains(&name) { Some(true) } else { known }
    };
    let text = compose(name, name, &source, &option).expect("composes");
    let module = naga::front::wgsl::parse_str(&text).map_err(|e| e.emit_to_string(&text)).expect("WGSL");
    let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), Default::default());
    assert!(validator.validate(&module).is_ok(), "{text}");
    text
}

#[test]
fn the_diff_of_a_kernel_applies_and_its_kernel_is_valid() {
    let files = documented("adding-a-kernel.md");
    let new: Vec<&String> = files.iter().filter(|(_, hunks)| is_new(hunks)).map(|(name, _)| name).collect();
    assert_eq!((files.len(), new.len()), (5, 2), "two new files, and one change in each of three others");
    for (name, hunks) in files.iter().filter(|(name, _)| !new.contains(name)) {
        hunks.iter().for_each(|hunk| assert_once(name, &hunk.old));
    }
    let wgsl = files.iter().find(|(name, _)| name.ends_with(".wgsl")).map(|(_, hunks)| hunks[0].new.clone());
    let changed = BTreeMap::from([("depth_cue", wgsl.expect("a kernel"))]);
    let live = Features { live_lists: true, robust: true, grid: true, ..Features::default() };
    for features in [Features::default(), live] {
        composed(SHADE, "depth_cue", &features, &[], &changed);
    }
}

#[test]
fn the_diff_of_an_option_applies_to_few_files_and_its_kernel_is_valid() {
    let files = documented("adding-an-option.md");
    let of_kernels = |name: &&String| name.contains("/shade");
    assert_eq!(files.keys().filter(|name| !of_kernels(name)).count(), 4, "{:?}", files.keys());
    for (name, hunks) in &files {
        hunks.iter().for_each(|hunk| assert_once(name, &hunk.old));
    }
    let shade = "kernels/src/programs/closest_hit/shade.wgsl";
    let text = files[shade].iter().fold(source(shade), |text, hunk| text.replace(&hunk.old, &hunk.new));
    let changed = BTreeMap::from([("shade", text)]);
    let unlit = composed(SHADE, "shade", &Features::default(), &["unlit"], &changed);
    assert!(unlit.contains("rgb = vec3f(1.0);"), "{unlit}");
}

#[test]
fn the_diff_of_a_program_is_what_the_sources_have() {
    let files = documented("adding-a-program.md");
    let outside: Vec<&String> = files.keys().filter(|name| !name.contains("/programs/sort/")).collect();
    assert_eq!(
        outside,
        ["kernels/src/options/mod.rs", "kernels/src/programs/mod.rs"],
        "a name, and a line of the registry"
    );
    for (name, hunks) in &files {
        match is_new(hunks) {
            true => assert_eq!(source(name), hunks[0].new, "{name}"),
            false => hunks.iter().for_each(|hunk| assert_once(name, &hunk.new)),
        }
    }
    let folder = fs::read_dir(root().join("kernels/src/programs/sort")).expect("a folder");
    assert_eq!(folder.count(), files.len() - outside.len(), "the diff has every file of the program");
}
