//! `raystep sweep`: every job once, whatever happens in between.

mod wrong;

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::process::Stdio;

use raystep_lab::tidy::package;
use serde_json::Value;

use crate::common::{Outcome, Place, outcome, scene};

type Row = BTreeMap<String, String>;

/// Two scenes with two structures each.
const PICTURES: &str = "what = \"render\"\nscenes = [\"scenes/*.gltf\"]\nretries = 0\n\
                        [options]\nsize = \"16x16\"\ndevice = \"cpu\"\n[each]\naccelerator = [\"grid\", \"bvh\"]\n";

const JOBS: [&str; 4] = [
    "cornell-box-accelerator-grid",
    "cornell-box-accelerator-bvh",
    "primitives-accelerator-grid",
    "primitives-accelerator-bvh",
];

/// A folder with two scenes and a sweep.
fn place(sweep: &str) -> Place {
    let place = Place::new();
    fs::create_dir(place.path("scenes")).expect("a folder");
    for name in ["cornell-box.gltf", "primitives.gltf"] {
        fs::copy(scene(name), place.path("scenes").join(name)).expect("a scene");
    }
    fs::write(place.path("sweep.toml"), sweep).expect("a file");
    place
}

/// Runs with a folder for temporary files, and so with a machine, of its own.
fn run(place: &Place, arguments: &[&str]) -> Outcome {
    let tmp = place.path("tmp");
    fs::create_dir_all(&tmp).expect("a folder");
    let arguments: Vec<&OsStr> = ["sweep"].iter().chain(arguments).map(OsStr::new).collect();
    outcome(place.command(&arguments).env("TMPDIR", tmp))
}

/// The jobs that are offered to another process, which runs none.
fn offered(place: &Place) -> Vec<Value> {
    let offer = run(place, &["sweep.toml", "-o", "out", "--serve"]);
    let offer: Value = serde_json::from_str(offer.stdout.lines().next().expect("a line")).expect("JSON");
    offer["jobs"].as_array().expect("a list").clone()
}

fn rows(place: &Place) -> Vec<Row> {
    let file = place.read("out/results.csv");
    let schema = place.read("out/datapackage.json");
    package::check(&schema, |name| (name == "results.csv").then(|| file.clone())).expect("a table as its schema says");
    let mut reader = csv::ReaderBuilder::new().flexible(false).from_reader(file.as_slice());
    let names: Vec<String> = reader.headers().expect("a header").iter().map(str::to_owned).collect();
    let row = |record: csv::StringRecord| names.iter().cloned().zip(record.iter().map(str::to_owned)).collect();
    reader.records().map(|record| row(record.expect("as many fields as names"))).collect()
}

/// The file that says how a job ended.
fn ended(place: &Place, job: &str) -> Vec<u8> {
    place.read(&format!("out/jobs/{job}/job.json"))
}

/// The finished jobs, and what should not be among them.
fn folders(place: &Place) -> Vec<String> {
    let entries = fs::read_dir(place.path("out/jobs")).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn every_scene_and_combination_is_a_job_that_runs_once() {
    let place = place(PICTURES);
    let outcome = run(&place, &["sweep.toml", "-o", "out", "--jobs", "2"]);
    assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(0), ""), "{outcome:?}");
    assert!(outcome.stderr.contains("4 of 4: ") && outcome.stderr.contains(": 4 of 4 jobs"), "{outcome:?}");
    let all = rows(&place);
    assert_eq!(all.iter().map(|row| row["job"].as_str()).collect::<Vec<_>>(), JOBS);
    for row in &all {
        let accelerator = row["job"].rsplit_once('-').expect("a name").1;
        assert_eq!(
            [&row["option_accelerator"], &row["adapter"], &row["is_shared"]],
            [accelerator, "cpu", ""],
            "{row:?}"
        );
        assert!(!row["host"].is_empty() && row["rays"] == "256", "{row:?}");
        let picture = place.read(&format!("out/{}", row["image"]));
        assert!(picture.starts_with(b"\x89PNG"), "{row:?}");
    }
    let hash = |i: usize| all[i]["image_hash"].as_str();
    assert!(
        hash(0) == hash(1) && hash(2) == hash(3) && hash(0) != hash(2),
        "structures agree, and scenes differ: {all:?}"
    );
    let page = String::from_utf8(place.read("out/index.html")).expect("UTF-8");
    assert!(JOBS.iter().all(|job| page.contains(&format!("<img src=\"jobs/{job}/image.png\""))), "{page}");

    let before: Vec<Vec<u8>> = JOBS.iter().map(|job| ended(&place, job)).collect();
    let again = run(&place, &["sweep.toml", "-o", "out"]);
    assert!(again.code == Some(0) && again.stderr.contains("4 of 4 jobs are finished already"), "{again:?}");
    assert_eq!(JOBS.map(|job| ended(&place, job)).to_vec(), before);

    // Another scene of the same name: only its jobs run again.
    fs::copy(scene("single-triangle.gltf"), place.path("scenes/primitives.gltf")).expect("a scene");
    let changed = run(&place, &["sweep.toml", "-o", "out"]);
    assert!(changed.code == Some(0) && changed.stderr.contains("2 of 4 jobs are finished already"), "{changed:?}");
    assert_eq!(JOBS.map(|job| ended(&place, job))[..2], before[..2]);
    assert_ne!(rows(&place)[2]["image_hash"], all[2]["image_hash"]);
    assert_eq!(folders(&place).len(), 4);

    // A name with the characters of patterns, and of a folder that has them.
    fs::create_dir(place.path("a[b]")).expect("a folder");
    fs::copy(scene("single-triangle.gltf"), place.path("a[b]/c[d] é?.gltf")).expect("a scene");
    fs::write(place.path("a[b]/one.toml"), PICTURES.replace("scenes/*.gltf", "c[d] é?.gltf")).expect("a file");
    let one = run(&place, &["a[b]/one.toml", "-o", "a[b]/out"]);
    assert_eq!(one.code, Some(0), "{one:?}");
    assert!(place.path("a[b]/out/jobs/c_d__é_-accelerator-grid/image.png").exists());

    // Another sweep, or two programs at once.
    fs::write(place.path("sweep.toml"), PICTURES.replace("16x16", "17x16")).expect("a file");
    let other = run(&place, &["sweep.toml", "-o", "out"]);
    assert!(
        other.code == Some(1) && other.stderr.contains("out contains a sweep with another value of 'options'"),
        "{other:?}"
    );
    fs::write(place.path("sweep.toml"), PICTURES).expect("a file");
    let lock = File::open(place.path("out/sweep.lock")).expect("a file");
    lock.lock().expect("nobody has it");
    let second = run(&place, &["sweep.toml", "-o", "out"]);
    assert!(second.code == Some(1) && second.stderr.contains("is in use by another 'raystep sweep'"), "{second:?}");
    let full = run(&place, &["sweep.toml", "-o", "scenes"]);
    assert!(full.code == Some(1) && full.stderr.contains("scenes is not empty and contains no sweep"), "{full:?}");
}

/// Whether a process runs that names a file in the folder; elsewhere than on Linux, unknown, and so assumed.
#[cfg(unix)]
fn has_job(place: &Place) -> bool {
    let folder = place.path("").to_string_lossy().into_owned();
    let Ok(entries) = fs::read_dir("/proc") else { return true };
    let mut words = entries.flatten().filter_map(|entry| fs::read(entry.path().join("cmdline")).ok());
    words.any(|words| String::from_utf8_lossy(&words).contains(&folder))
}

#[test]
#[cfg(unix)]
fn an_interrupted_sweep_continues() {
    // Each job takes long enough to be interrupted, also on a busy machine.
    let place = place(&PICTURES.replace("\"16x16\"", "\"1024x1024\"\nspp = 4"));
    let mut child = place
        .command(&["sweep", "sweep.toml", "-o", "out"].map(OsStr::new))
        .stderr(Stdio::null())
        .spawn()
        .expect("the binary starts");
    let first = place.path("out/jobs").join(JOBS[0]).join("job.json");
    while !first.exists() || !has_job(&place) {
        assert_eq!(child.try_wait().expect("a process"), None, "it ended before it was interrupted");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    // Not SIGINT, which the test itself ignores if a shell runs it in the background.
    let sent = std::process::Command::new("kill").args(["-TERM", &child.id().to_string()]).status();
    assert!(sent.is_ok_and(|status| status.success()));
    assert_eq!(child.wait().expect("an end").code(), Some(143));
    assert!(!cfg!(target_os = "linux") || !has_job(&place), "the job goes on without the sweep");
    let kept = folders(&place);
    assert!((1..4).contains(&kept.len()) && kept.iter().all(|name| JOBS.contains(&name.as_str())), "{kept:?}");
    // As a killed process would leave it.
    fs::create_dir(place.path("out/jobs/.raystep-killed.part")).expect("a folder");
    fs::write(place.path("out/jobs/.raystep-killed.part.stiff.csv.part"), "").expect("a file");
    let before = ended(&place, JOBS[0]);
    let outcome = run(&place, &["sweep.toml", "-o", "out"]);
    let wanted = format!("{} of 4 jobs are finished already", kept.len());
    assert!(outcome.code == Some(0) && outcome.stderr.contains(&wanted), "{outcome:?}");
    assert_eq!((ended(&place, JOBS[0]), folders(&place).len(), rows(&place).len()), (before, 4, 4));
}

#[test]
fn a_job_that_fails_leaves_the_others() {
    let sweep = PICTURES.replace("retries = 0", "retries = 1") + "camera = [0, 7]\n";
    let place = place(&sweep.replace("scenes/*.gltf", "scenes/cornell-box.gltf"));
    let outcome = run(&place, &["sweep.toml", "-o", "out"]);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    let name = "cornell-box-accelerator-grid-camera-7";
    let why = "--camera 7: the scene has one camera, number 0";
    assert!(outcome.stderr.contains(&format!("fail: {name}: {why}")), "{outcome:?}");
    assert!(
        outcome.stderr.ends_with("error: 2 jobs failed; the same command runs those without results again\n"),
        "{outcome:?}"
    );
    let all = rows(&place);
    assert!(all.len() == 2 && all.iter().all(|row| row["option_camera"] == "0"), "{all:?}");
    let page = String::from_utf8(place.read("out/index.html")).expect("UTF-8");
    assert!(page.contains(name) && page.contains("the scene has one camera"), "{page}");
    let names: Vec<_> = offered(&place).into_iter().map(|job| job["name"].clone()).collect();
    assert_eq!(names, [name, "cornell-box-accelerator-bvh-camera-7"]);
}

#[test]
fn a_picture_in_parts_has_the_bytes_of_one() {
    let sweep =
        PICTURES.replace("scenes/*", "scenes/cornell-box").replace("retries = 0", "parts = 3\nformat = \"png\"");
    let place = place(&sweep.replace("size = \"16x16\"", "size = \"16x16\"\nspp = 60"));
    let outcome = run(&place, &["sweep.toml", "-o", "out", "--jobs", "2"]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert_eq!(folders(&place).len(), 6);
    let all = rows(&place);
    assert_eq!(all.iter().map(|row| row["job"].as_str()).collect::<Vec<_>>(), JOBS[..2]);
    for row in &all {
        let accelerator = row["option_accelerator"].as_str();
        let options =
            ["--size", "16x16", "--spp", "60", "--device", "cpu", "--accelerator", accelerator, "-o", "whole.png"];
        place.ok(&[&["render", "scenes/cornell-box.gltf"][..], &options].concat());
        assert_eq!(place.read(&format!("out/{}", row["image"])), place.read("whole.png"), "{row:?}");
        assert!(row["adapter"].contains("cpu") && !row["host"].is_empty(), "{row:?}");
    }
    let page = String::from_utf8(place.read("out/index.html")).expect("UTF-8");
    let seconds = format!("{:.3}", all[0]["job_s"].parse::<f64>().expect("seconds"));
    assert!(page.contains("all parts, s") && page.contains(&seconds), "{page}");
    // A part that is lost is made again, and no other.
    fs::remove_dir_all(place.path("out/jobs/cornell-box-accelerator-bvh-part-2-of-3")).expect("a folder");
    let again = run(&place, &["sweep.toml", "-o", "out"]);
    assert!(again.code == Some(0) && again.stderr.contains("5 of 6 jobs are finished already"), "{again:?}");
    assert_eq!(rows(&place)[1]["image_hash"], all[1]["image_hash"]);
}

#[test]
#[cfg(unix)]
fn a_picture_is_shown_while_its_parts_are_traced() {
    let sweep = "what = \"render\"\nscenes = [\"scenes/cornell-box.gltf\"]\nretries = 0\nparts = 3\n\
                 [options]\nsize = \"16x16\"\nspp = 60\ndevice = \"cpu\"\n";
    let place = place(sweep);
    // The program, except that the second part is lost after its folder has appeared.
    let lost = "case \"$*\" in *2/3*) \"$0\" \"$@\"; echo lost >&2; exit 1;; esac; exec \"$0\" \"$@\"";
    let words = serde_json::json!(["sh", "-c", lost, env!("CARGO_BIN_EXE_raystep")]).to_string();
    let arguments = ["sweep", "sweep.toml", "-o", "out"].map(OsStr::new);
    let outcome = outcome(place.command(&arguments).env("RAYSTEP_COMMAND", words));
    assert!(outcome.code == Some(1) && outcome.stderr.contains("part-2-of-3: lost"), "{outcome:?}");
    let images = |folder: &str| {
        let entries = fs::read_dir(place.path(folder)).expect("a folder");
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect::<Vec<_>>()
    };
    assert_eq!(images("out/images"), ["so-far"]);
    assert_eq!(images("out/images/so-far"), ["cornell-box.png"]);
    assert_eq!(folders(&place), ["cornell-box-part-1-of-3", "cornell-box-part-3-of-3"]);
    let first = "out/jobs/cornell-box-part-1-of-3/part";
    place.ok(&["merge", "--so-far", first, "-o", "first.png"]);
    assert!(place.read("first.png") == place.read(&format!("{first}/so-far.png")));
    assert_eq!(run(&place, &["sweep.toml", "-o", "out"]).code, Some(0));
    assert_eq!(images("out/images"), ["cornell-box.png"]);
    assert!(place.read("out/images/cornell-box.png") != place.read("first.png"));
}

#[test]
#[cfg(unix)]
fn a_sweep_that_wrote_nothing_yet_begins_again_and_lets_others_see_its_lock() {
    use std::os::unix::fs::PermissionsExt as _;
    // A number that JSON's reader does not read back to the last bit, and a vector.
    let place = place(
        "what = \"bench\"\nscenes = [\"scenes/cornell-box.gltf\"]\n[options]\nsizes = \"8x8\"\nrepeats = 1\n\
         device = \"cpu\"\nfov = 90.33333333333333\neye = [0, 1, 4]\nlook-at = [0.0, 0, 0]\n",
    );
    for folder in ["out", "tmp"] {
        fs::create_dir(place.path(folder)).expect("a folder");
    }
    for file in ["out/sweep.lock", "out/.raystep-1.part"] {
        fs::write(place.path(file), "").expect("a file");
    }
    let mut command = std::process::Command::new("sh");
    command.current_dir(place.path("")).env("TMPDIR", place.path("tmp"));
    let first =
        outcome(command.args(["-c", "umask 077; exec \"$0\" sweep sweep.toml -o out", env!("CARGO_BIN_EXE_raystep")]));
    assert_eq!(first.code, Some(0), "{first:?}");
    let lock = fs::metadata(place.path("tmp/raystep-timed.lock")).expect("a lock");
    assert_eq!(lock.permissions().mode() & 0o777, 0o644);
    let again = run(&place, &["sweep.toml", "-o", "out"]);
    assert!(again.code == Some(0) && again.stderr.contains("1 of 1 jobs are finished already"), "{again:?}");
}

#[test]
fn a_benchmark_of_a_taken_machine_is_shared_and_not_ranked() {
    let sweep = "what = \"bench\"\nscenes = [\"scenes/cornell-box.gltf\"]\nwait_s = 0\n[options]\nsize = [\"8x8\", \"16x16\"]\n\
                 accelerators = [\"grid\", \"bvh\"]\nrepeats = 1\nwarmups = 0\ndevice = \"cpu\"\nreplay = true\nkeep-all = false\n";
    let place = place(sweep);
    fs::create_dir(place.path("tmp")).expect("a folder");
    let lock = File::create(place.path("tmp/raystep-timed.lock")).expect("a file");
    lock.lock().expect("nobody has it");
    let outcome = run(&place, &["sweep.toml", "-o", "out"]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let all = rows(&place);
    // Two sizes and two structures, in one job.
    assert!(
        all.len() == 4 && all.iter().all(|row| row["job"] == "cornell-box" && row["is_shared"] == "true"),
        "{all:?}"
    );
    assert!(all.iter().all(|row| !row["median_ns"].is_empty() && row["scene"] == "cornell-box"), "{all:?}");
    let page = String::from_utf8(place.read("out/index.html")).expect("UTF-8");
    assert!(page.contains("nothing to rank") && page.matches(">shared</td>").count() == 4, "{page}");
    let refused = run(&place, &["sweep.toml", "-o", "out", "--jobs", "2"]);
    assert!(
        refused.code == Some(2) && refused.stderr.contains("measure times and must run one at a time"),
        "{refused:?}"
    );
}

#[test]
fn other_processes_can_run_the_jobs() {
    let place = place("what = \"stability\"\n[options]\ncase = [\"no-triangle\"]\nquick = true\ndevice = \"cpu\"\n");
    let jobs = offered(&place);
    assert_eq!([&jobs[0]["needs_gpu"], &jobs[0]["is_timed"]], [&Value::Bool(false); 2], "{jobs:?}");
    fs::write(place.path("job.json"), jobs[0].to_string()).expect("a file");
    let worker = || {
        let mut worker = place.command(&["sweep", "--run-job", "job.json", "-o", "result"].map(OsStr::new));
        worker.stdin(Stdio::piped()).spawn().expect("the binary starts")
    };
    // One whose sender is gone ends, and leaves nothing.
    let before = place.names();
    let mut orphan = worker();
    drop(orphan.stdin.take());
    assert_eq!((orphan.wait().expect("an end").code(), place.names()), (Some(1), before));
    let mut worker = worker();
    let sender = worker.stdin.take();
    assert_eq!(worker.wait().expect("an end").code(), Some(0));
    drop(sender);

    let mut driver = place.command(&["sweep", "sweep.toml", "-o", "out", "--serve"].map(OsStr::new));
    let mut driver =
        driver.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the binary starts");
    let done = serde_json::json!({ "done": { "name": "stability", "folder": place.path("result") } });
    let wrong = serde_json::json!({ "done": { "name": "stability", "folder": place.path("scenes") } });
    use std::io::Write as _;
    write!(driver.stdin.take().expect("a pipe"), "{wrong}\n{done}\n").expect("it reads");
    let output = driver.wait_with_output().expect("an end");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(errors.contains("failed: stability: its results are incomplete or belong to another job"), "{errors}");
    assert_eq!(output.status.code(), Some(1), "{errors}");
    let all = rows(&place);
    assert!(!all.is_empty() && all.iter().all(|row| row["case"] == "no-triangle"), "{all:?}");
    assert_eq!(offered(&place), [Value::Null; 0]);
    place.fails(1, "nothing.json: No such file", &["sweep", "--run-job", "nothing.json", "-o", "other"]);
}
