//! `raystep report --bundle` and `--verify`: a bundle is repeated from its own inputs, and changed ones are told.

use std::io::{Cursor, Read as _, Write as _};

use serde_json::Value;
use sha2::{Digest as _, Sha256};
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

use crate::common::{Place, scene};

type Files = Vec<(String, Vec<u8>)>;

fn files_of(bytes: &[u8]) -> Files {
    let mut zip = ZipArchive::new(Cursor::new(bytes)).expect("a ZIP file");
    let count = zip.len();
    let read = |i: usize| {
        let mut file = zip.by_index(i).expect("a file");
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).expect("its bytes");
        (file.name().expect("a name").into_owned(), bytes)
    };
    (0..count).map(read).collect()
}

fn zipped(files: &Files) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        zip.start_file(name, SimpleFileOptions::default()).expect("a file");
        zip.write_all(bytes).expect("memory");
    }
    zip.finish().expect("memory").into_inner()
}

/// The bundle with one file and its entry in the manifest changed.
fn changed(files: &Files, name: &str, change: impl Fn(&str) -> String, is_listed: bool) -> Files {
    let mut files = files.clone();
    let file = files.iter_mut().find(|(n, _)| n == name).expect("a file");
    file.1 = change(std::str::from_utf8(&file.1).expect("text")).into_bytes();
    let (bytes, hash) = (file.1.len(), Sha256::digest(&file.1).iter().map(|b| format!("{b:02x}")).collect::<String>());
    if is_listed {
        let manifest = files.iter_mut().find(|(n, _)| n == "manifest.json").expect("a manifest");
        let mut value: Value = serde_json::from_slice(&manifest.1).expect("JSON");
        let entries = value["files"].as_array_mut().expect("files");
        let entry = entries.iter_mut().find(|entry| entry["path"] == name).expect("an entry");
        (entry["bytes"], entry["sha256"]) = (bytes.into(), hash.into());
        manifest.1 = serde_json::to_vec(&value).expect("JSON");
    }
    files
}

#[test]
fn a_bundle_is_verified_and_a_changed_one_is_told() {
    let place = Place::new();
    let file = scene("cornell-box.gltf").display().to_string();
    let arguments = ["report", &file, "--quick", "--size", "32x32", "--seed", "5", "--section", "choices,rules"];
    let output = ["--device", "cpu", "-o", "out", "--bundle", "out.zip", "--quiet"];
    place.ok(&[&arguments[..], &output].concat());
    let files = files_of(&place.read("out.zip"));
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    for name in ["manifest.json", "redo.sh", "inputs/0/cornell-box.gltf", "report/choices.csv", "report/runs.csv"] {
        assert!(names.contains(&name), "{name} is not in {names:?}");
    }
    let report =
        |name: &str| files.iter().find(|(n, _)| n == &format!("report/{name}")).map(|(_, bytes)| bytes.clone());
    assert_eq!(report("choices.csv"), Some(place.read("out/choices.csv")));
    let manifest: Value = serde_json::from_slice(&files[0].1).expect("JSON");
    assert_eq!((&manifest["machine"]["device"], &manifest["seed"]), (&"cpu".into(), &5.into()));
    assert!(manifest["commit"].as_str().is_some_and(|c| c.len() == 40 || c == "unknown"));

    // Elsewhere: the scene itself is not needed.
    let verified = place.ok(&["report", "--verify", "out.zip", "--quiet"]);
    assert!(verified.stdout.contains("this machine computes alike"), "{verified:?}");
    assert!(verified.stdout.contains("choices.csv: ") && verified.stdout.contains("all the same"), "{verified:?}");

    let verify = |files: &Files, wanted: &str| {
        std::fs::write(place.path("changed.zip"), zipped(files)).expect("a file");
        place.fails(1, wanted, &["report", "--verify", "changed.zip", "--quiet"]);
    };
    let more_wrong = |csv: &str| csv.replacen(",robust,", ",Robust,", 1);
    let csv = "report/choices.csv";
    verify(&changed(&files, csv, more_wrong, false), "report/choices.csv was changed");
    std::fs::write(place.path("changed.zip"), zipped(&changed(&files, csv, more_wrong, true))).expect("a file");
    let differs = place.run(&["report", "--verify", "changed.zip", "--quiet"]);
    assert_eq!(differs.code, Some(1), "{differs:?}");
    assert!(differs.stderr.contains("1 field that does not depend on time differs"), "{differs:?}");
    assert!(differs.stdout.contains("numerics was \"Robust\", is \"robust\""), "{differs:?}");
    let outside = |json: &str| json.replacen("report/choices.csv", "../choices.csv", 1);
    verify(&changed(&files, "manifest.json", outside, false), "../choices.csv lies outside the bundle");
    let larger = |json: &str| json.replacen("\"bytes\": ", "\"bytes\": 99999999999", 1);
    verify(&changed(&files, "manifest.json", larger, false), "larger than --max-memory allows");
    let other = |json: &str| json.replacen("raystep report bundle", "another", 1);
    verify(&changed(&files, "manifest.json", other, false), "it is not a raystep report bundle of version 1");
    std::fs::write(place.path("changed.zip"), "no ZIP file").expect("a file");
    place.fails(1, "it is not a bundle of a report", &["report", "--verify", "changed.zip"]);
    assert_eq!(place.names(), ["changed.zip", "out", "out.zip"], "nothing is left behind");
}

#[test]
fn methods_of_other_programs_stand_in_the_diagram() {
    let place = Place::new();
    let file = scene("cornell-box.gltf").display().to_string();
    std::fs::write(place.path("own.csv"), "method,ns_per_ray,judged_rays,wrong_rays\n<mine>,12.5,1000,3\n")
        .expect("a file");
    let report = ["report", &file, "--quick", "--size", "32x32", "--section", "choices", "--device", "cpu"];
    place.ok(&[&report[..], &["--methods", "own.csv", "-o", "out", "--quiet"]].concat());
    let page = String::from_utf8(place.read("out/index.html")).expect("UTF-8");
    assert!(page.contains("&lt;mine&gt;") && !page.contains("<mine>"));
    assert!(String::from_utf8_lossy(&place.read("out/choices.csv")).contains("choices/own/<mine>"));
    std::fs::write(place.path("own.csv"), "method,ns_per_ray,judged_rays,wrong_rays\nmine,-1,1000,3\n")
        .expect("a file");
    place.fails(
        1,
        "--methods own.csv: row 1, mine: times",
        &[&report[..], &["--methods", "own.csv", "-o", "no"]].concat(),
    );
}
