//! `raystep bench`, from the built binary; its files are read by strict readers.

use std::collections::{BTreeMap, BTreeSet};

use agree::{passes_agree, runs_agree};
use serde_json::Value;

use crate::common::{Place, scene};

mod agree;
mod gate;
mod light;

type Row = BTreeMap<String, String>;

fn cornell_box() -> String {
    scene("cornell-box.gltf").display().to_string()
}

/// A small benchmark on the CPU, with further arguments.
fn bench<'a>(scene: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["bench", scene, "--sizes", "16x12", "--device", "cpu", "--repeats", "6", "--warmups", "1"], more].concat()
}

/// Rows by column; every row has as many fields as there are columns.
fn rows(file: &[u8]) -> (Vec<String>, Vec<Row>) {
    let mut reader = csv::ReaderBuilder::new().flexible(false).from_reader(file);
    let names: Vec<String> = reader.headers().expect("a header").iter().map(str::to_owned).collect();
    let row = |record: csv::StringRecord| names.iter().cloned().zip(record.iter().map(str::to_owned)).collect();
    let rows = reader.records().map(|r| row(r.expect("as many fields as names"))).collect();
    (names, rows)
}

fn number(row: &Row, name: &str) -> f64 {
    row[name].parse().unwrap_or_else(|_| panic!("{name} is {:?}", row[name]))
}

fn is_near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
}

#[test]
fn every_configuration_has_its_row_and_the_files_agree() {
    let place = Place::new();
    let (teapot, file) = (scene("teapot.glb").display().to_string(), cornell_box());
    let what = ["--accelerators", "grid,none", "--schedules", "first,second", "--rays", "primary,bounce,shadow,random"];
    let outcome = place.ok(&bench(&file, &[&[teapot.as_str(), "-o", "out"], &what[..]].concat()));
    assert_eq!(
        outcome.stderr.matches("none is measured once: first and second are the same without a grid").count(),
        1,
        "{outcome:?}"
    );

    let (names, summary) = rows(&place.read("out/summary.csv"));
    assert_eq!(
        names.join(","),
        "schema_version,run_id,configuration,build,scene,scene_hash,triangles,accelerator,schedule,numerics,grid,skip,\
         steps_per_pass,keep_all,rays_kind,seed,adapter,width_px,height_px,rays,build_s,start_s,clock,runs,\
         invalid_runs,median_ns,low_ns,high_ns,min_ns,max_ns,interval_method,interval_level,median_wall_ns,\
         fixed_work_ns,rays_per_s,time_ratio,time_ratio_low,time_ratio_high,ratio_to,passes,useful_steps_per_thread,\
         cells_per_ray,tests_per_ray,repeated_per_ray,structure_bytes,bytes_per_triangle,hits,hits_hash,baseline_ratio,\
         mapping,traversal,integrator,samples_per_s,secondary_rays,shadow_rays,integrator_options"
    );
    let groups: Vec<_> = summary.chunks(3).collect();
    let expected: Vec<_> = ["cornell-box", "teapot"]
        .iter()
        .flat_map(|scene| ["primary", "bounce", "shadow", "random"].map(|kind| (*scene, kind)))
        .collect();
    assert_eq!(groups.len(), expected.len());
    for (group, (scene, kind)) in groups.iter().zip(expected) {
        let ways = [("grid", "first"), ("grid", "second"), ("none", "first")];
        for (row, way) in group.iter().zip(ways) {
            assert_eq!((row["accelerator"].as_str(), row["schedule"].as_str()), way);
            assert_eq!((row["scene"].as_str(), row["rays_kind"].as_str()), (scene, kind));
            assert_eq!((row["width_px"].as_str(), row["height_px"].as_str()), ("16", "12"));
            assert_eq!((row["numerics"].as_str(), row["grid"].as_str()), ("robust", "auto"));
            assert_eq!([&row["skip"], &row["steps_per_pass"], &row["keep_all"]], ["auto", "", "false"]);
            assert_eq!(
                (row["runs"].as_str(), row["invalid_runs"].as_str(), row["adapter"].as_str()),
                ("6", "0", "cpu")
            );
            assert_eq!((row["clock"].as_str(), row["baseline_ratio"].as_str()), ("cpu_clock", ""));
            let [min, low, median, high, max] =
                ["min", "low", "median", "high", "max"].map(|name| number(row, &format!("{name}_ns")));
            assert!(0.0 < min && min <= low && low <= median && median <= high && high <= max, "{row:?}");
            assert_eq!(row["interval_method"], "order_statistics");
            assert!((number(row, "interval_level") - 0.96875).abs() < 1e-9, "{row:?}");
            assert!(median <= number(row, "median_wall_ns"), "passes take longer than the run: {row:?}");
            assert!(is_near(number(row, "rays_per_s"), number(row, "rays") / median * 1e9), "{row:?}");
            assert!(number(row, "build_s") > 0.0 && number(row, "start_s") > 0.0);
            let bytes = number(row, "bytes_per_triangle");
            assert_eq!(bytes == 0.0, way.0 == "none", "{row:?}");
            // The same rays, and the same hits, in every configuration.
            for name in ["rays", "hits", "hits_hash", "scene_hash", "triangles"] {
                assert_eq!(row[name], group[0][name], "{name}");
            }
        }
        // The fastest is compared with itself, the others with it.
        let to: BTreeSet<_> = group.iter().map(|row| row["ratio_to"].as_str()).collect();
        let fastest = group.iter().find(|row| to.contains(row["configuration"].as_str())).expect("one of the group");
        assert!(to.len() == 1 && is_near(number(fastest, "time_ratio"), 1.0), "{fastest:?}");
        let none = &group[2];
        if kind != "shadow" {
            // Without an accelerator every ray tests every triangle, and visits no cells.
            assert_eq!(
                (number(none, "tests_per_ray"), &none["cells_per_ray"]),
                (number(none, "triangles"), &"0.0".into())
            );
        }
        assert!(number(&group[0], "cells_per_ray") > 1.0);
        assert!(number(&group[0], "repeated_per_ray") < number(&group[0], "tests_per_ray"));
        if kind == "primary" || kind == "random" {
            assert_eq!(none["rays"], "192", "one ray per pixel");
        }
    }
    for first in [0, 4] {
        assert_eq!(groups[first + 1][0]["rays"], groups[first][0]["hits"], "one bounce ray per primary hit");
    }
    assert!(
        number(&groups[6][0], "rays") < number(&groups[5][0], "rays"),
        "some of the teapot faces away from its light"
    );
    let hashes: BTreeSet<_> = groups.iter().map(|group| &group[0]["hits_hash"]).collect();
    assert_eq!(hashes.len(), groups.len(), "every kind of ray has different hits");
    assert!(number(&groups[4][0], "hits") < 192.0, "the teapot does not fill the image");

    passes_agree(&place, &summary);
    runs_agree(&place, "out", &summary);
    let run: Value = serde_json::from_slice(&place.read("out/run.json")).expect("JSON");
    assert_eq!((&run["kind"], &run["schema_version"]), (&"raystep bench".into(), &2.into()));
    assert_eq!(run["command_line"][1], "bench");
    assert_eq!((&run["options"]["repeats"], &run["options"]["warmups"]), (&6.into(), &1.into()));
    assert_eq!(run["options"]["sizes"][0], "16x12");
    assert!(run["adapter"].is_null() && run["clock"] == "cpu_clock" && run["timestamp_period_ns"].is_null());
    let configurations = run["configurations"].as_array().expect("configurations");
    let ids: Vec<_> = configurations.iter().map(|c| c["configuration"].as_str().expect("an id")).collect();
    assert_eq!(ids, summary.iter().map(|row| row["configuration"].as_str()).collect::<Vec<_>>());
    assert!(summary.iter().all(|row| run["run_id"] == row["run_id"].as_str()));
    assert!(configurations[0]["shaders"]["intersect"].as_str().is_some_and(|hash| hash.starts_with("fnv1a64:")));
    assert_ne!(configurations[0]["shaders"]["intersect"], configurations[2]["shaders"]["intersect"]);
    // FNV-1a, 64 bits, of cornell-box.gltf, computed by another program; update it if that file changes.
    const HASH: &str = "fnv1a64:ae49c3b13b689522";
    assert_eq!((&run["scenes"][0]["hash"], summary[0]["scene_hash"].as_str()), (&HASH.into(), HASH));

    let titles =
        ["cornell-box (26 triangles), 16x12: 192 primary rays", "teapot (994 triangles), 16x12: 192 random rays"];
    for title in titles {
        assert!(outcome.stdout.contains(title), "{outcome:?}");
    }
    let lines: BTreeSet<usize> =
        outcome.stdout.lines().filter(|l| l.starts_with("  ")).map(|l| l.chars().count()).collect();
    assert_eq!(lines.len(), 1, "all lines have the same length: {}", outcome.stdout);
    assert_eq!(place.names(), ["out"]);
}

#[test]
fn trees_and_passes_of_several_steps_are_described_as_they_are() {
    let place = Place::new();
    let file = cornell_box();
    let what = ["--accelerators", "grid,bvh,none,auto", "--schedules", "second,compact,fused"];
    let outcome = place.ok(&bench(&file, &[&what[..], &["-o", "out"]].concat()));
    let note = "note: cornell-box: auto is bvh: more than 6 triangles";
    assert_eq!(outcome.stderr.matches(note).count(), 1, "{outcome:?}");
    let (_, summary) = rows(&place.read("out/summary.csv"));
    assert_eq!(summary.len(), 12);
    passes_agree(&place, &summary);
    for row in &summary {
        let (accelerator, schedule) = (row["accelerator"].as_str(), row["schedule"].as_str());
        assert_eq!(row["hits_hash"], summary[0]["hits_hash"], "{row:?}");
        let useful = number(row, "useful_steps_per_thread");
        assert!(useful <= 1.0 && (schedule != "fused" || useful == 1.0), "{row:?}");
        assert_eq!(row["steps_per_pass"], if schedule == "compact" { "8" } else { "" });
        // Only the kernel that tests one triangle per pass counts repeated tests, and not with a BVH.
        let looks_back = schedule == "second" && matches!(accelerator, "grid" | "none");
        assert_eq!(row["repeated_per_ray"].is_empty(), !looks_back, "{row:?}");
        let plan = ["plan", &file, "--size", "16x12", "--device", "cpu", "--json", "--accelerator", accelerator];
        let plan = place.ok(&[&plan[..], &["--schedule", schedule]].concat()).stdout;
        let plan: Value = serde_json::from_str(&plan).expect("JSON");
        let buffers = plan["buffers"].as_array().expect("buffers");
        let of_structure =
            |name: &str| ["grid_", "bvh_", "wide_", "packed_"].iter().any(|start| name.starts_with(start));
        let bytes: u64 = buffers
            .iter()
            .filter(|b| b["name"].as_str().is_some_and(of_structure))
            .map(|b| b["bytes"].as_u64().expect("bytes"))
            .sum();
        assert!(is_near(number(row, "bytes_per_triangle"), bytes as f64 / 26.0), "{row:?}");
    }
}

#[test]
fn a_seed_determines_the_rays_and_the_order() {
    let place = Place::new();
    let file = cornell_box();
    for (seed, folder) in [("5", "a"), ("5", "b"), ("6", "c")] {
        let what = ["--accelerators", "grid,bvh", "--rays", "random", "--seed", seed, "-o", folder];
        place.ok(&bench(&file, &what));
    }
    let of = |folder: &str| {
        let (_, summary) = rows(&place.read(&format!("{folder}/summary.csv")));
        let (_, runs) = rows(&place.read(&format!("{folder}/runs.csv")));
        let order: Vec<String> = runs.iter().map(|run| run["place"].clone()).collect();
        (summary[0]["hits_hash"].clone(), summary[0]["seed"].clone(), order)
    };
    assert_eq!(of("a"), of("b"));
    assert_ne!((of("a").0, of("a").2), (of("c").0, of("c").2));
    assert_eq!(of("c").1, "6");
}

#[test]
fn a_baseline_gives_ratios_and_says_what_has_none() {
    let place = Place::new();
    let file = cornell_box();
    place.ok(&bench(&file, &["--accelerators", "grid,none", "--schedules", "second", "-o", "before"]));
    // Change time, device and scene, and remove one row.
    let text = String::from_utf8(place.read("before/summary.csv")).expect("UTF-8");
    let (names, before) = rows(text.as_bytes());
    let mut edited = csv::Writer::from_writer(Vec::new());
    edited.write_record(&names).expect("memory");
    for row in &before {
        let value = |name: &String| match name.as_str() {
            "median_ns" => "1000.0".into(),
            "adapter" => "a faster one".into(),
            "scene_hash" => "0".into(),
            _ => row[name].clone(),
        };
        edited.write_record(names.iter().map(value)).expect("memory");
    }
    std::fs::write(place.path("before/summary.csv"), edited.into_inner().expect("memory")).expect("a file");

    let now =
        bench(&file, &["--accelerators", "grid", "--schedules", "second,first", "--baseline", "before", "-o", "now"]);
    let outcome = place.ok(&now);
    let (_, rows) = rows(&place.read("now/summary.csv"));
    let [second, first] = &rows[..] else { panic!("expected two rows: {rows:?}") };
    assert!(is_near(number(second, "baseline_ratio"), number(second, "median_ns") / 1000.0), "{second:?}");
    assert_eq!(first["baseline_ratio"], "");
    for note in [
        "note: before has no match for cornell-box 16x12 primary, grid first robust",
        "note: before also has cornell-box 16x12 primary, none second robust, which was not measured now",
        "note: before was measured on a faster one, and this is cpu",
        "note: cornell-box has changed since before was measured",
    ] {
        assert_eq!(outcome.stderr.matches(note).count(), 1, "{note}: {outcome:?}");
    }
    assert!(outcome.stdout.contains("to baseline"), "{outcome:?}");
    let cell = format!("  {:.2}\n", number(second, "baseline_ratio"));
    assert!(outcome.stdout.contains(&cell), "{cell:?} in {outcome:?}");
    let run: Value = serde_json::from_slice(&place.read("now/run.json")).expect("JSON");
    assert_eq!(run["options"]["baseline"], "before");
    assert_eq!(run["notes"].as_array().map(Vec::len), Some(4));
}

#[test]
fn a_folder_is_replaced_only_where_a_benchmark_wrote_it() {
    let place = Place::new();
    let file = cornell_box();
    let bench = bench(&file, &["-o", "out"]);
    let outcome = place.ok(&[&bench[..], &["--quiet"]].concat());
    assert_eq!((outcome.stdout.as_str(), outcome.stderr.as_str()), ("", ""));
    let first = place.read("out/summary.csv");
    place.fails(1, "out is not empty", &bench);
    std::fs::write(place.path("out/mine.txt"), "mine").expect("a file");
    let again = place.ok(&[&bench[..], &["--force", "--baseline", "out"]].concat());
    assert!(again.stdout.contains("to baseline"), "the old summary is read before it is replaced: {again:?}");
    assert_ne!(place.read("out/summary.csv"), first);
    assert_eq!(place.read("out/mine.txt"), b"mine");
    let names = std::fs::read_dir(place.path("out")).expect("the folder").map(|e| e.expect("an entry").file_name());
    let names: BTreeSet<_> = names.map(|n| n.to_string_lossy().into_owned()).collect();
    assert_eq!(
        names.into_iter().collect::<Vec<_>>(),
        ["datapackage.json", "mine.txt", "passes.csv", "run.json", "runs.csv", "summary.csv"]
    );

    std::fs::copy(cornell_box(), place.path("out/passes.csv")).expect("a copy");
    let itself = ["bench", "out/passes.csv", "-o", "out", "--force", "--device", "cpu", "--sizes", "8x8"];
    place.fails(2, "out/passes.csv would be replaced, but the scene is read from it", &itself);

    std::fs::write(place.path("out/run.json"), "{}").expect("a file");
    place.fails(1, "that is not from a benchmark", &[&bench[..], &["--force"]].concat());
    assert_eq!(place.read("out/run.json"), b"{}");
}

#[test]
fn what_cannot_be_measured_is_left_out_and_said() {
    let place = Place::new();
    let file = cornell_box();
    let sizes = ["bench", &file, "--size", "8x8,32768x32768,8x8", "--device", "cpu", "--repeats", "1", "-o", "out"];
    let outcome = place.ok(&sizes);
    assert!(outcome.stderr.contains("note: omitted: cornell-box 32768x32768 primary, grid"), "{outcome:?}");
    let (_, measured) = rows(&place.read("out/summary.csv"));
    assert_eq!(measured.len(), 1, "duplicates are measured once");
    let empty = scene("empty.gltf").display().to_string();
    place.fails(1, "no pixel has a ray", &bench(&empty, &["--rays", "bounce,shadow", "-o", "none"]));
    let outcome = place.ok(&bench(&empty, &["--rays", "bounce,random", "-o", "empty"]));
    assert!(outcome.stderr.contains("omitted: empty 16x12 bounce: no pixel has such a ray"), "{outcome:?}");
    let (_, measured) = rows(&place.read("empty/summary.csv"));
    assert_eq!(
        (measured.len(), measured[0]["bytes_per_triangle"].as_str(), &measured[0]["hits"]),
        (1, "", &"0".into())
    );
}

#[test]
fn a_gpu_is_timed_by_its_own_clock_and_hits_the_same() {
    let place = Place::new();
    let file = cornell_box();
    let what = ["--accelerators", "grid,none", "--schedules", "second", "--rays", "primary,bounce"];
    for device in ["cpu", "gpu"] {
        let common = ["bench", &file, "--sizes", "24x16", "--repeats", "2", "--device", device, "-o", device];
        place.ok(&[&common[..], &what[..]].concat());
    }
    let run: Value = serde_json::from_slice(&place.read("gpu/run.json")).expect("JSON");
    println!("{}", run["adapter"]);
    let (_, gpu) = rows(&place.read("gpu/summary.csv"));
    let (_, cpu) = rows(&place.read("cpu/summary.csv"));
    assert_eq!((gpu.len(), cpu.len()), (4, 4));
    for (gpu, cpu) in gpu.iter().zip(&cpu) {
        let has_clock = run["timestamp_period_ns"].is_f64();
        assert_eq!(gpu["clock"], if has_clock { "gpu_timestamp" } else { "host" });
        assert_eq!(run["clock_check"]["agrees"], has_clock, "{}", run["clock_check"]);
        let by_host = ["median_ns", "median_wall_ns"].map(|name| number(gpu, name));
        assert_eq!(by_host[0] == by_host[1], !has_clock, "{gpu:?}");
        assert!(is_near(number(gpu, "rays_per_s"), number(gpu, "rays") / by_host[0] * 1e9), "{gpu:?}");
        assert_eq!((gpu["runs"].as_str(), run["adapter"]["name"] == gpu["adapter"].as_str()), ("2", true));
        assert_eq!(gpu["low_ns"], "", "two runs have no interval");
        // Only hits determine which pixels have a bounce ray.
        assert_eq!((&gpu["rays"], &gpu["hits"]), (&cpu["rays"], &cpu["hits"]));
    }
    assert_eq!(gpu[0]["hits_hash"], gpu[1]["hits_hash"]);
    assert_eq!(gpu[2]["hits_hash"], gpu[3]["hits_hash"]);
}

#[test]
fn wrong_usage_and_unreadable_baselines_are_one_line() {
    let place = Place::new();
    let file = cornell_box();
    let cases: &[(i32, &str, &[&str])] = &[
        (2, "--output", &["bench", &file]),
        (2, "<SCENE>", &["bench", "-o", "out"]),
        (
            2,
            "--rays glossy: expected primary, bounce, shadow or random",
            &["bench", &file, "-o", "out", "--rays", "primary,glossy"],
        ),
        (2, "640x480", &["bench", &file, "-o", "out", "--sizes", "8x8,8"]),
        (2, "expected first, second, compact or fused", &["bench", &file, "-o", "out", "--schedules", "third"]),
        (
            2,
            "--accelerators '': expected auto, grid, irregular, bvh or none",
            &["bench", &file, "-o", "out", "--accelerators", ""],
        ),
        (2, "--repeats 0: expected an integer from 1 to 100000", &["bench", &file, "-o", "out", "--repeats", "0"]),
        (2, "--warmups -1: expected an integer from 0 to 100000", &["bench", &file, "-o", "out", "--warmups", "-1"]),
        (2, "has one camera, number 0", &["bench", &file, "-o", "out", "--camera", "1"]),
        (1, "nothing.glb: No such file", &["bench", &file, "nothing.glb", "-o", "out"]),
        (
            2,
            "has 1073741824; the limit of this device is 67108864",
            &["bench", &file, "-o", "out", "--sizes", "32768x32768", "--device", "cpu", "--quiet"],
        ),
        (1, "there is no folder nowhere", &["bench", &file, "-o", "nowhere/out"]),
        (1, "expected a folder written by 'raystep bench'", &["bench", &file, "-o", "out", "--baseline", "old"]),
        (1, "it is not a file of a benchmark", &["bench", &file, "-o", "out", "--baseline", "bad"]),
        (1, "its schema_version is 1; expected 2", &["bench", &file, "-o", "out", "--baseline", "old-version"]),
    ];
    std::fs::create_dir(place.path("bad")).expect("a folder");
    std::fs::write(place.path("bad/summary.csv"), "a,b\n1\n").expect("a file");
    std::fs::create_dir(place.path("old-version")).expect("a folder");
    std::fs::write(place.path("old-version/summary.csv"), "schema_version,run_id\n1,a\n").expect("a file");
    for (code, wanted, arguments) in cases {
        place.fails(*code, wanted, arguments);
    }
}
