//! Signals: the exit code identifies them, no incomplete file remains, and an ignored signal stays ignored.

use std::ffi::OsStr;
use std::fs;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::common::{Place, scene};

/// Signals that end the program, and the shell's exit codes for them: 128 plus the signal's number.
const SIGNALS: [(&str, i32); 3] = [("HUP", 129), ("INT", 130), ("TERM", 143)];

/// Starts the binary with the `ignored` signals ignored and all others reset, since the test runner may ignore some.
fn start(place: &Place, arguments: &[&str], ignored: Option<&str>) -> Child {
    let binary = place.command(&arguments.iter().map(OsStr::new).collect::<Vec<_>>());
    let mut command = if cfg!(target_os = "linux") {
        let mut env = Command::new("env");
        env.arg("--default-signal=HUP,INT,TERM");
        env.args(ignored.map(|signals| format!("--ignore-signal={signals}")));
        env.arg(binary.get_program()).args(binary.get_args()).current_dir(place.path(""));
        env
    } else {
        binary
    };
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the binary starts")
}

fn send(signal: &str, child: &Child) {
    let sent = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status();
    assert!(sent.is_ok_and(|status| status.success()), "SIG{signal}");
}

/// Names of temporary files, which must not remain.
fn temporary(place: &Place) -> Vec<String> {
    place.names().into_iter().filter(|name| name.starts_with(".raystep-")).collect()
}

/// Waits until the program is writing.
fn wait_until_begun(place: &Place, child: &mut Child, has_begun: impl Fn() -> bool) {
    let begin = Instant::now();
    while !has_begun() {
        let end = child.try_wait().expect("a process");
        assert_eq!(end, None, "it ended before it started writing: {:?}", place.names());
        assert!(begin.elapsed() < Duration::from_secs(60), "no temporary file appeared: {:?}", place.names());
        sleep(Duration::from_millis(2));
    }
    assert_eq!(temporary(place).len(), 1, "{:?}", place.names());
    assert_eq!(child.try_wait().expect("a process"), None, "it ended early");
}

/// Sends each signal to a separate run that is writing, and expects its exit code and no remaining files.
fn each_signal_ends(arguments: &[&str], has_begun: impl Fn(&Place) -> bool) {
    for (signal, code) in SIGNALS {
        let place = Place::new();
        let mut child = start(&place, arguments, None);
        wait_until_begun(&place, &mut child, || has_begun(&place));
        send(signal, &child);
        assert_eq!(child.wait().expect("an end").code(), Some(code), "SIG{signal}: {arguments:?}");
        assert_eq!(place.names(), Vec::<String>::new(), "SIG{signal}: {arguments:?}");
    }
}

/// The number of files in the temporary folder.
fn files(place: &Place) -> usize {
    temporary(place).first().map_or(0, |name| fs::read_dir(place.path(name)).map_or(0, Iterator::count))
}

/// Whether the temporary folder has existed for a while: these commands write their files at the end.
fn is_at_work(place: &Place) -> bool {
    let is_there = !temporary(place).is_empty();
    if is_there {
        sleep(Duration::from_millis(150));
    }
    is_there
}

/// A render whose last file is a pipe without a reader, so that its image stays under its temporary name.
fn render_into_pipe(place: &Place, ignored: Option<&str>) -> Child {
    assert!(Command::new("mkfifo").arg(place.path("pipe")).status().is_ok_and(|status| status.success()));
    let file = scene("cornell-box.gltf").display().to_string();
    let render = ["render", &file, "-o", "a.png", "--size", "8x8", "--device", "cpu", "--passes-csv", "pipe"];
    let mut child = start(place, &render, ignored);
    // At the start it only checks whether it can write there; that file is empty.
    let has_bytes = |name: &String| fs::metadata(place.path(name)).is_ok_and(|found| found.len() > 0);
    wait_until_begun(place, &mut child, || temporary(place).iter().any(has_bytes));
    child
}

#[test]
fn a_signal_ends_a_render_that_is_writing() {
    for (signal, code) in SIGNALS {
        let place = Place::new();
        let mut child = render_into_pipe(&place, None);
        send(signal, &child);
        assert_eq!(child.wait().expect("an end").code(), Some(code), "SIG{signal}");
        assert_eq!(place.names(), ["pipe"], "SIG{signal}");
    }
}

#[test]
fn a_signal_ends_a_benchmark() {
    let file = scene("cornell-box.gltf").display().to_string();
    let bench = ["bench", &file, "--sizes", "16x12", "--device", "cpu", "--repeats", "100000", "-o", "out"];
    each_signal_ends(&bench, is_at_work);
}

#[test]
fn a_signal_ends_a_report() {
    let file = scene("teapot.glb").display().to_string();
    each_signal_ends(&["report", &file, "--device", "cpu", "-o", "out"], is_at_work);
}

#[test]
fn a_signal_ends_a_stability_run() {
    each_signal_ends(&["stability", "--device", "cpu", "-o", "out"], is_at_work);
}

/// Small files are created so quickly that one could appear while the folder is being removed.
#[test]
fn a_signal_ends_a_dump_of_many_files() {
    let file = scene("terrain.glb").display().to_string();
    let dump = ["dump", &file, "--pass=all", "--stream=all", "--size=16x16", "--device=cpu", "-o=out"];
    for _ in 0..2 {
        each_signal_ends(&dump, |place| files(place) >= 100);
    }
}

#[test]
fn a_signal_ends_a_dump_of_large_files() {
    let file = scene("terrain.glb").display().to_string();
    let dump = ["dump", &file, "--pass=all", "--stream=all", "--size=200x200", "--device=cpu", "-o=out"];
    each_signal_ends(&dump, |place| files(place) > 0);
}

/// As under `nohup`, or after `trap '' INT`. Other systems have no safe way to find this out.
#[test]
#[cfg(target_os = "linux")]
fn a_signal_that_was_ignored_at_the_start_stays_ignored() {
    let place = Place::new();
    let mut child = render_into_pipe(&place, Some("HUP,INT,TERM"));
    for (signal, _) in SIGNALS {
        send(signal, &child);
    }
    // Longer than it takes to exit.
    sleep(Duration::from_millis(300));
    assert_eq!(child.try_wait().expect("a process"), None, "the ignored signal ended it");
    let passes = fs::read_to_string(place.path("pipe")).expect("text");
    assert!(passes.starts_with("schema_version,"), "{passes}");
    assert_eq!(child.wait().expect("an end").code(), Some(0));
    assert_eq!(place.names(), ["a.png", "pipe"]);

    // The other signals still end it.
    let place = Place::new();
    let mut child = render_into_pipe(&place, Some("HUP"));
    send("HUP", &child);
    sleep(Duration::from_millis(300));
    assert_eq!(child.try_wait().expect("a process"), None, "the ignored signal ended it");
    send("TERM", &child);
    assert_eq!(child.wait().expect("an end").code(), Some(143));
    assert_eq!(place.names(), ["pipe"]);
}
