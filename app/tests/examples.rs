//! The examples of the help texts.

use crate::common::{Place, scene};

/// A smaller version of an example for tests: small images, few repeats, one section or case.
pub(crate) fn small(example: &str) -> String {
    let command = example.strip_prefix("raystep ").and_then(|rest| rest.split(' ').next()).unwrap_or_default();
    let has = |option: &str| example.split(' ').any(|word| word == option);
    let with = |option: &'static str, value: &'static str, is_wanted: bool| match example
        .split_once(&format!(" {option} "))
    {
        Some((_, rest)) => Some((format!(" {option} {}", rest.split(' ').next().unwrap_or_default()), option, value)),
        None => is_wanted.then(|| (String::new(), option, value)),
    };
    let is_view =
        matches!(command, "render" | "trace" | "dump" | "plan" | "inspect" | "check-kernel" | "export-program")
            && !has("--link")
            && !has("--lesson");
    // A session has its own size.
    let is_view = is_view && !example.contains(".raystep-session");
    let changes = [
        with("--size", "16x16", is_view || matches!(command, "report" | "bench") || has("my-tracer")),
        with("--pixel", "9,9", false),
        with("--repeats", "1", matches!(command, "bench" | "paper")),
        with("--warmups", "0", command == "bench"),
        with("--window", "480x300", command == "inspect" && !has("--check")),
        with("--screenshot", "shot.png", command == "inspect" && !has("--check")),
        with("--section", if command == "paper" { "table-1" } else { "grid" }, matches!(command, "report" | "paper")),
        with("--family", "t-junctions", has("--cost")),
        with("--triangles", "100", false),
        with("--seconds", "2", has("--self-test")),
        // Any adapter has this in its name.
        with("--adapter", "''", false),
        if has("--list") || has("--case") { None } else { with("--case", "no-triangle", command == "stability") },
    ];
    let quick =
        if matches!(command, "report" | "stability") && !has("--quick") && !has("--list") { " --quick" } else { "" };
    // What follows a pipe or a redirection is not part of the raystep command.
    let end = [" | ", " > "].iter().filter_map(|mark| example.find(mark)).min().unwrap_or(example.len());
    let (mut line, rest) = (example[..end].to_owned() + quick, &example[end..]);
    for (before, option, value) in changes.into_iter().flatten() {
        let after = format!(" {option} {value}");
        if before.is_empty() { line += &after } else { line = line.replace(&before, &after) }
    }
    for pixel in ["pixel=200,260", "pixel=256,256"] {
        line = line.replace(pixel, "pixel=9,9&size=16x16");
    }
    line + rest
}

/// Every example in every help text, in order, in one folder per command, with the repository's scenes.
#[test]
#[cfg(unix)]
fn help_examples_run() {
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicUsize, Ordering};

    let commands = "inspect render trace dump bench cast check-kernel export-program course grade merge report stability sweep plan paper info scene completions";
    let mut helps: Vec<Vec<&str>> = commands.split(' ').map(|name| vec![name]).collect();
    helps.extend([vec![], vec!["scene", "convert"], vec!["scene", "soup"]]);
    // On two threads: most of the time, an example keeps one core busy.
    let (helps, run) = (Mutex::new(helps), AtomicUsize::new(0));
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(help) = { helps.lock().expect("no panic while it is held").pop() } {
                    run.fetch_add(run_examples(&help), Ordering::Relaxed);
                }
            });
        }
    });
    let run = run.into_inner();
    assert!(run >= 50, "{run} examples");
}

/// Runs the examples of a help text and returns their number.
#[cfg(unix)]
fn run_examples(help: &[&str]) -> usize {
    let has_jq = std::process::Command::new("jq").arg("--version").output().is_ok_and(|o| o.status.success());
    let place = Place::new();
    std::os::unix::fs::symlink(scene(""), place.path("scenes")).expect("a link");
    // A ray, for the examples of cast.
    let ray = [0.0f32, 0.0, 0.5, 0.0, 0.25, 0.25, 1.0, 0.0].map(f32::to_le_bytes).concat();
    let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 8), }\n".as_bytes();
    let npy = [b"\x93NUMPY\x01\x00\x3c\x00", header, &ray[..28], &9f32.to_le_bytes()].concat();
    // A saved session and a lesson, for the examples of inspect; a sweep.
    let link = "raystep:1?scene=scenes/teapot.glb&size=16x16&device=cpu";
    let session = serde_json::json!({ "version": 1, "here": { "link": link } }).to_string().into_bytes();
    let lesson: Vec<u8> =
        "# A lesson\n\n## The only step\n\nA text.\n\n```raystep\nopen scene=built-in:cornell-box size=16x16\n```\n"
            .into();
    let kernel = |name: &str| {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../kernels/src/programs/closest_hit");
        std::fs::read(folder.join(name)).expect("a kernel's file")
    };
    let [intersect, setup, walk] = ["intersect.wgsl", "setup.wgsl", "walk.wgsl"].map(kernel);
    let sweep: Vec<u8> = "what = \"stability\"\n[options]\ncase = [\"no-triangle\"]\nquick = true\n".into();
    for (name, bytes) in [
        ("rays.npy", &npy),
        ("shadow.npy", &npy),
        ("primary.f32", &ray),
        ("teapot.raystep-session", &session),
        ("my-lesson.md", &lesson),
        ("sweep.toml", &sweep),
        ("my.wgsl", &intersect),
        ("my-intersect.wgsl", &intersect),
        ("my-setup.wgsl", &setup),
        ("walk.wgsl", &walk),
    ] {
        std::fs::write(place.path(name), bytes).expect("a file");
    }
    std::fs::create_dir(place.path("old")).expect("a folder");
    std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_raystep"), place.path("old/raystep")).expect("a link");
    // Programs of one's own, for the examples of commands that do not make them.
    if matches!(help, ["bench" | "trace" | "plan" | "dump" | "inspect"]) {
        for name in ["my-program", "my-program-before"] {
            place.ok(&["new", name, "--like", "life"]);
        }
    }
    let text = place.ok(&[help, &["--help"]].concat()).stdout;
    let (_, examples) = text.split_once("Examples:\n").expect("examples");
    let (mut of_help, mut folder) = (0, None);
    for line in examples.lines() {
        let Some(line) = line.strip_prefix("  ") else { continue };
        // A line may end with a description.
        let line = line.split("   ").next().unwrap_or(line);
        let line = if has_jq { line } else { line.split(" | jq").next().unwrap_or(line) };
        let line = small(line);
        // An independent example may write the same folder as the one before it: remove that folder first.
        let output = line.split_once(" -o ").map(|(_, rest)| rest.split(' ').next().unwrap_or(rest).to_owned());
        if output.is_some() && output == folder && place.path(output.as_deref().unwrap_or_default()).is_dir() {
            std::fs::remove_dir_all(place.path(output.as_deref().unwrap_or_default())).expect("a folder");
        }
        folder = output;
        let result = place.shell(&line);
        if line == "raystep cornell-box" && cfg!(not(target_os = "macos")) {
            // It opens a window, which this test cannot see: tests/window.sh tests it.
            assert!(result.stderr.starts_with("error: no display"), "{line}: {result:?}");
        } else {
            // One run decides no comparison, and nothing is completed in the exercises.
            let code = match () {
                () if line.contains("--at-most") => 3,
                () if line.starts_with("raystep grade") => 1,
                () => 0,
            };
            assert_eq!(result.code, Some(code), "{line}: {result:?}");
        }
        of_help += 1;
    }
    assert!(of_help > 0, "{help:?} has no example");
    of_help
}
