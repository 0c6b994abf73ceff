//! The example in `docs/adding-a-kernel.md` still applies to the sources.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

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

#[test]
fn the_documented_diff_applies_and_its_kernel_is_valid() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let docs = fs::read_to_string(root.join("docs/adding-a-kernel.md")).expect("the docs");
    let diff = docs.split("```diff\n").nth(1).and_then(|rest| rest.split("\n```").next()).expect("a diff");
    let files = hunks(diff);
    for hunk in files.values().flatten() {
        assert_eq!([&hunk.old, &hunk.new].map(|text| text.lines().count()), hunk.lines, "{}", hunk.new);
    }
    let is_new = |hunks: &[Hunk]| matches!(hunks, [hunk] if hunk.old.is_empty());
    let new: Vec<&String> = files.iter().filter(|(_, hunks)| is_new(hunks)).map(|(name, _)| name).collect();
    assert_eq!((files.len(), new.len()), (5, 2), "two new files, and one change in each of three others");
    for (name, hunks) in files.iter().filter(|(name, _)| !new.contains(name)) {
        let source = fs::read_to_string(root.join(name)).expect("a source");
        for hunk in hunks {
            assert_eq!(
                source.matches(&hunk.old).count(),
                1,
                "{name} has changed where the docs insert code:\n{}",
                hunk.old
            );
            assert_ne!(hunk.old, hunk.new);
        }
    }
    let wgsl = files.iter().find(|(name, _)| name.ends_with(".wgsl")).map(|(_, hunks)| hunks[0].new.clone());
    let wgsl = wgsl.expect("a kernel");
    for features in
        [Features::default(), Features { live_lists: true, robust: true, grid: true, ..Features::default() }]
    {
        let lists = live::lists(&[INTERSECT, TRAVERSE_GRID], &features);
        let modules = modules(SHADE, &features, &lists);
        let source = |name: &str| match name {
            "depth_cue" => Some(wgsl.as_str()),
            name => modules.iter().find(|(module, _)| *module == name).map(|(_, text)| text.as_ref()),
        };
        let options = features.list();
        let option = |name: &str| options.iter().find(|(n, _)| *n == name).map(|&(_, is_on)| is_on);
        let text = compose("depth_cue", "depth_cue", &source, &option).expect("composes");
        let module = naga::front::wgsl::parse_str(&text).map_err(|e| e.emit_to_string(&text)).expect("WGSL");
        let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), Default::default());
        assert!(validator.validate(&module).is_ok(), "{text}");
    }
}
