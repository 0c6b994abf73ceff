//! `raystep info --self-test`, from the built binary.

use std::ffi::OsStr;
use std::io::{Cursor, Read as _};

use serde_json::Value;
use zip::ZipArchive;

use crate::common::{Outcome, Place, assert_error, outcome};

/// Enough for the adapter and its arithmetic, not for everything.
const SHORT: [&str; 4] = ["info", "--self-test", "--seconds", "6"];

/// Of a person who is not to be found in any file.
const PERSON: &str = "somebody-private";

fn run(place: &Place, arguments: &[&str], environment: &[(&str, &str)]) -> Outcome {
    let arguments: Vec<&OsStr> = arguments.iter().map(OsStr::new).collect();
    outcome(place.command(&arguments).envs(environment.iter().copied()))
}

fn files_of(bytes: Vec<u8>) -> Vec<(String, String)> {
    let mut zip = ZipArchive::new(Cursor::new(bytes)).expect("a ZIP file");
    let count = zip.len();
    let read = |i: usize| {
        let mut file = zip.by_index(i).expect("a file");
        let mut text = String::new();
        file.read_to_string(&mut text).expect("text");
        (file.name().expect("a name").into_owned(), text)
    };
    (0..count).map(read).collect()
}

/// The numbers of a table's last line with totals: checks, right, wrong.
fn totals(table: &str) -> [u64; 3] {
    let line = table.lines().rfind(|line| line.contains(" checks: ")).expect("a line with the totals");
    let numbers: Vec<u64> = line.split(|c: char| !c.is_ascii_digit()).filter_map(|word| word.parse().ok()).collect();
    [numbers[0], numbers[1], numbers[2]]
}

#[test]
fn what_is_right_is_told_what_does_not_fit_the_time_is_said_and_nothing_private_is_in_the_bundle() {
    let place = Place::new();
    let home = format!("/home/{PERSON}");
    let environment = [("HOME", home.as_str()), ("USER", PERSON), ("LOGNAME", PERSON)];
    let told = run(&place, &[&SHORT[..], &["--bundle", "b.zip"]].concat(), &environment);
    assert_eq!(told.code, Some(0), "{told:?}");
    assert!(told.stderr.contains("wrote b.zip") && place.names() == ["b.zip"], "{told:?}");
    let table = &told.stdout;
    assert!(table.lines().all(|line| line.chars().count() <= 100), "{table}");
    for line in ["  right    limits", "  right    a / b", "  not run  robust rules"] {
        assert!(table.contains(line), "{line} is not in {table}");
    }
    assert!(table.contains("runs are left out: time; --seconds N gives it more"), "{table}");
    let [checks, right, wrong] = totals(table);
    assert!(checks > 80 && right > 10 && wrong == 0, "{table}");

    let files = files_of(place.read("b.zip"));
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names[..4], ["self-test.json", "info.json", "self-test.txt", "details.txt"]);
    assert_eq!(files[2].1, *table);
    let data: Value = serde_json::from_str(&files[0].1).expect("JSON");
    let info: Value = serde_json::from_str(&files[1].1).expect("JSON");
    let rows = data["checks"].as_array().expect("checks");
    assert_eq!((data["totals"]["checks"].as_u64(), rows.len() as u64), (Some(checks), checks));
    assert_eq!(data["totals"]["right"].as_u64(), Some(right));
    for row in rows {
        assert!(row["shows"].as_str().is_some_and(|text| text.len() > 10) && row["verdict"].is_string(), "{row}");
    }
    assert!(
        data["steps"].as_array().is_some_and(|steps| steps.iter().any(|step| step["seconds"].as_f64() > Some(0.0)))
    );
    for path in ["/adapter/name", "/adapter/driver", "/limits/max_buffer_size", "/raystep_version", "/system"] {
        assert!(info.pointer(path).is_some_and(|value| !value.is_null()), "{path}: {info}");
    }
    assert!(info["features"].as_array().is_some_and(|features| !features.is_empty()), "{info}");
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default().trim().to_owned();
    let folder = place.path("").display().to_string();
    for (name, text) in &files {
        let words: Vec<&str> = text.split(|c: char| !c.is_alphanumeric() && c != '-' && c != '_').collect();
        assert!(!text.contains(PERSON) && !text.contains(folder.trim_end_matches('/')), "{name}");
        assert!(host.len() < 3 || !words.contains(&host.as_str()), "{name}: {host}");
        assert!(!text.contains("/home") && !text.contains("/root") && !text.contains(".cargo"), "{name}");
    }
}

#[test]
fn the_same_as_data() {
    let place = Place::new();
    let told = place.ok(&["info", "--self-test", "--seconds", "2", "--json", "--quiet"]);
    let data: Value = serde_json::from_str(&told.stdout).expect("JSON");
    assert_eq!((data["schema_version"].as_u64(), data["totals"]["wrong"].as_u64()), (Some(1), Some(0)));
    let limits = data["checks"].as_array().expect("checks").iter().find(|row| row["name"] == "limits").expect("a row");
    assert_eq!((limits["group"].as_str(), limits["verdict"].as_str()), (Some("adapter"), Some("right")));
    assert_eq!((told.stderr.as_str(), place.names().len()), ("", 0));
}

#[test]
fn without_an_adapter_that_is_told_and_the_exit_code_is_1() {
    let place = Place::new();
    let unknown = place.run(&["info", "--self-test", "--adapter", "Voodoo 2"]);
    let none = run(&place, &["info", "--self-test"], &[("VK_DRIVER_FILES", "/none"), ("VK_ICD_FILENAMES", "/none")]);
    for (told, why) in [(unknown, "no GPU adapter has \"Voodoo 2\" in its name"), (none, "no GPU adapter")] {
        let [checks, right, wrong] = totals(&told.stdout);
        assert!(checks > 80 && (right, wrong) == (0, 1), "{told:?}");
        assert!(told.stdout.starts_with("no device\n") && told.stdout.contains("  WRONG    limits"), "{told:?}");
        assert_error(&Outcome { stdout: String::new(), ..told }, 1, why, "no adapter");
    }
}

#[test]
fn what_cannot_be_meant_is_refused_before_anything_runs() {
    let place = Place::new();
    place.fails(2, "--self-test", &["info", "--bundle", "b.zip"]);
    place.fails(2, "--self-test", &["info", "--adapter", "llvmpipe"]);
    place.fails(2, "cannot be combined with [SCENE]", &["info", "--self-test", "scene.gltf"]);
    place.fails(2, "expected a name that ends in .zip", &["info", "--self-test", "--bundle", "b.json"]);
    place.fails(2, "--seconds", &["info", "--self-test", "--seconds", "0"]);
    place.fails(1, "there is no folder", &["info", "--self-test", "--bundle", "none/b.zip"]);
}

#[test]
#[ignore = "long: all of it takes about a minute"]
fn all_of_it_is_right_and_in_the_bundle() {
    let place = Place::new();
    let told = place.ok(&["info", "--self-test", "--seconds", "600", "--bundle", "b.zip"]);
    assert!(told.stdout.ends_with("raystep works on this adapter.\n"), "{told:?}");
    assert!(!told.stdout.contains("not run"), "{told:?}");
    let files = files_of(place.read("b.zip"));
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).skip(4).collect();
    assert_eq!(names, ["pipelines.csv", "stability.csv", "tmax.csv"]);
    for (name, rows) in [("stability.csv", 47 * 15), ("pipelines.csv", 46)] {
        let text = &files.iter().find(|(of, _)| of == name).expect("a file").1;
        let mut reader = csv::ReaderBuilder::new().flexible(false).from_reader(text.as_bytes());
        let read: Result<Vec<_>, _> = reader.records().collect();
        assert_eq!(read.expect("as many fields as names").len(), rows, "{name}");
    }
}
