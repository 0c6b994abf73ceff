//! `raystep report`, from the built binary: its CSV files are read by a strict reader and its page is compared with
//! them; exit codes.

use std::collections::BTreeSet;

use raystep_lab::tidy::is_of_time;

use crate::common::{Outcome, Place, scene};
use crate::report_files::{Row, check_intervals, check_page, number, tables};

fn cornell_box() -> String {
    scene("cornell-box.gltf").display().to_string()
}

/// A quick report on the CPU.
fn quick(place: &Place, more: &[&str]) -> Outcome {
    place.ok(&[&["report", &cornell_box(), "--quick", "--device", "cpu", "-o", "out"], more].concat())
}

#[test]
#[ignore = "long: sh tests/full.sh"]
fn a_second_report_finds_the_same_errors_again() {
    let place = Place::new();
    quick(&place, &["--quiet"]);
    let then = tables(&place, "out");
    let again = quick(&place, &["--force", "--quiet"]);
    assert_eq!((again.stdout.as_str(), again.stderr.as_str()), ("", ""));
    for (name, rows) in tables(&place, "out").into_iter().filter(|(name, _)| name != "runs.csv" && name != "about.csv")
    {
        assert_eq!(rows.len(), then[&name].len(), "{name}");
        for (now, then) in rows.iter().zip(&then[&name]) {
            for (column, value) in now.iter().filter(|(column, _)| !is_of_time(column)) {
                assert_eq!(value, &then[column], "{name}, {column}: {now:?}");
            }
        }
    }
    assert_eq!(place.names(), ["out"]);
}

#[test]
fn a_quick_report_is_complete() {
    let place = Place::new();
    let outcome = quick(&place, &[]);
    let first = outcome.stdout.lines().next().unwrap_or_default();
    assert!(first.starts_with("Use --accelerator ") && !first.contains('<'), "{outcome:?}");
    let tables = tables(&place, "out");
    let run_id = &tables["about.csv"][0]["run_id"];
    for (name, rows) in &tables {
        // No surface of the Cornell box emits light.
        assert_eq!(
            rows.is_empty(),
            name == "strategies.csv" || name == "photon_maps.csv",
            "{name}: {} rows",
            rows.len()
        );
        assert!(rows.iter().all(|r| r["schema_version"] == "2" && r["run_id"] == *run_id), "{name}");
        let is_ours = |r: &Row| r["adapter"] == "cpu" && r["scene_hash"].starts_with("fnv1a64:");
        assert!(name == "about.csv" || rows.iter().all(is_ours), "{name}");
    }
    check_page(&place, "out", &tables);
    let [medians, ratios, shares] = check_intervals(&tables);
    assert!(medians > 20 && ratios > 20 && shares > 60, "{medians} medians, {ratios} ratios, {shares} shares");
    check_choices(&tables["choices.csv"]);
    check_rules(&tables["rules.csv"]);

    assert!(tables["left_out.csv"].iter().all(|r| r["time_ratio"].is_empty() && r["start_s"].is_empty()));
    assert_eq!(place.names(), ["out"]);
}

/// The fastest choice is accurate, the front is not dominated, and robust numerics make no error.
fn check_choices(rows: &[Row]) {
    let fastest: Vec<&Row> = rows.iter().filter(|r| r["is_fastest"] == "true").collect();
    assert_eq!(fastest.len(), 1);
    assert_eq!(fastest[0]["is_accurate"], "true");
    let recommended: Vec<&Row> = rows.iter().filter(|r| r["is_recommended"] == "true").collect();
    assert_eq!(recommended.len(), 1);
    assert_eq!((recommended[0]["is_accurate"].as_str(), recommended[0]["numerics"].as_str()), ("true", "robust"));
    for row in rows {
        assert_eq!((row["rays"].as_str(), row["stratum"].as_str()), ("16384", "all"));
        let within = number(row, "wrong_per_million_high") <= number(row, "most_wrong_per_million");
        assert_eq!(row["is_accurate"] == "true", within, "{row:?}");
        assert!(row["numerics"] != "robust" || row["wrong_rays"] == "0", "{row:?}");
        assert!(number(row, "witness_error_by_bound") <= 1.0, "{row:?}");
        assert!(number(row, "witness_reference_error_by_bound") < 1e-3, "{row:?}");
        let beats = |other: &&Row| {
            number(other, "median_ns") < number(row, "median_ns")
                && number(other, "wrong_rays") <= number(row, "wrong_rays")
        };
        assert!(row["is_front"] != "true" || rows.iter().find(beats).is_none(), "{row:?}");
    }
    let schedules: BTreeSet<_> = rows.iter().map(|r| [&r["accelerator"], &r["schedule"], &r["numerics"]]).collect();
    assert_eq!((schedules.len(), rows.len()), (16, 16));
}

/// Strata add up, robust numerics make no error, the paper's triangle test must lose rays at edges, and where hits are not ordered
/// by exact t, some are undecided.
fn check_rules(rows: &[Row]) {
    assert!(rows.iter().any(|r| r["order"] == "exact") && rows.iter().any(|r| r["rule"] == "exact-order"));
    for row in rows.iter().filter(|r| r["stratum"] == "all") {
        let of = |r: &&Row| r["configuration"] == row["configuration"] && r["stratum"] != "all";
        for column in ["judged_rays", "wrong_rays", "undecided"] {
            let sum: f64 = rows.iter().filter(of).map(|r| number(r, column)).sum();
            assert_eq!(sum, number(row, column), "{column}: {row:?}");
        }
        let is_robust = row["numerics"] == "robust" && row["rule"].is_empty();
        assert!(!is_robust || row["wrong_rays"] == "0" && row["is_needed"].is_empty(), "{row:?}");
        let is_cracked = row["rule"] == "triangle-test" || row["numerics"] == "paper";
        assert!(!is_cracked || row["is_needed"] == "true" && number(row, "p_value_holm") < 0.05, "{row:?}");
        assert!(row["order"] != "exact" || row["undecided"] == "0", "{row:?}");
        let is_of_order = row["rule"] == "exact-order";
        assert!(!is_of_order || row["is_needed"] == "true" && number(row, "undecided") > 0.0, "{row:?}");
        assert!(is_robust || is_of_order || number(row, "p_value_holm") >= number(row, "p_value"), "{row:?}");
    }
}

#[test]
#[ignore = "long: sh tests/full.sh"]
fn the_default_device_reports_too() {
    let place = Place::new();
    place.ok(&["report", &cornell_box(), "--quick", "-o", "default", "--quiet"]);
    check_page(&place, "default", &tables(&place, "default"));
}

#[test]
fn an_adapter_reports_too() {
    let place = Place::new();
    let file = cornell_box();
    place.ok(&["report", &file, "--quick", "--device", "gpu", "--section", "resolved", "-o", "gpu", "--quiet"]);
    let tables = tables(&place, "gpu");
    let resolved = &tables["resolved.csv"];
    println!("{}", resolved[0]["adapter"]);
    let wrong = |r: &&Row| r["numerics"] == "robust" && r["resolved_wrong_rays"] != "0";
    assert_eq!(resolved.iter().find(wrong), None);
    assert!(resolved.iter().all(|r| r["clock"] == "gpu_timestamp" || r["clock"] == "host"));
}

#[test]
fn scenes_with_nothing_or_one_triangle_in_them_have_a_page() {
    let place = Place::new();
    let files = ["empty.gltf", "single-triangle.gltf"].map(|name| scene(name).display().to_string());
    let outcome = place.ok(&["report", &files[0], &files[1], "--quick", "--device", "cpu", "-o", "out"]);
    assert!(outcome.stderr.contains("note: empty, rules: the scene has no triangle to aim at"), "{outcome:?}");
    let page = String::from_utf8(place.read("out/index.html")).expect("UTF-8");
    assert!(page.contains("empty: the scene has no triangles, so there is nothing to compare."));
    let tables = tables(&place, "out");
    check_page(&place, "out", &tables);
    for name in ["choices.csv", "rules.csv"] {
        assert!(tables[name].iter().all(|r| r["scene"] == "single-triangle"), "{name}");
    }
    assert!(tables["grid.csv"].iter().any(|r| r["scene"] == "empty" && r["wrong_rays"] == "0"));
}

#[test]
fn a_section_that_fails_is_a_note_and_all_that_fail_are_an_error() {
    let place = Place::new();
    let file = cornell_box();
    let report = ["report", &file, "--quick", "--device", "cpu", "--grid", "4096", "-o", "out", "--section"];
    let outcome = place.ok(&[&report[..], &["rules,scaled"]].concat());
    let wanted = "a grid of 4096 x 4096 x 4096 cells cannot be built";
    assert!(outcome.stderr.contains(&format!("note: cornell-box, rules: --grid: {wanted}")), "{outcome:?}");
    assert!(String::from_utf8_lossy(&place.read("out/index.html")).contains(wanted));
    let tables = tables(&place, "out");
    assert_eq!((tables["rules.csv"].len(), tables["scaled.csv"].len()), (0, 72));
    place.fails(2, wanted, &["report", &file, "--device", "cpu", "--grid", "4096", "-o", "no", "--section", "rules"]);
}

#[test]
fn a_section_alone_replaces_what_an_earlier_report_wrote() {
    let place = Place::new();
    let file = cornell_box();
    let report = ["report", &file, "--quick", "--device", "cpu", "-o", "out", "--section"];
    place.ok(&[&report[..], &["moved,grid"]].concat());
    std::fs::write(place.path("out/mine.txt"), "mine").expect("a file");
    place.fails(1, "out is not empty", &[&report[..], &["grid"]].concat());
    place.ok(&[&report[..], &["grid", "--force"]].concat());
    let names = std::fs::read_dir(place.path("out")).expect("the folder").map(|e| e.expect("an entry").file_name());
    let names: BTreeSet<_> = names.map(|n| n.to_string_lossy().into_owned()).collect();
    let expected = ["about.csv", "captions.tex", "datapackage.json", "grid.csv", "index.html", "mine.txt", "runs.csv"];
    let figures = ["time", "build", "bytes", "structures", "structures-build"].into_iter().flat_map(|figure| {
        ["one-column.pdf", "one-column.svg", "two-columns.pdf", "two-columns.svg"]
            .map(|kind| format!("cornell-box-grid-{figure}-{kind}"))
    });
    let expected: BTreeSet<String> = figures.chain(expected.map(str::to_owned)).collect();
    assert_eq!(names, expected);
    std::fs::write(place.path("out/index.html"), "<p>mine</p>").expect("a file");
    place.fails(1, "not from a report", &[&report[..], &["grid", "--force"]].concat());
    assert_eq!(place.read("out/index.html"), b"<p>mine</p>");
}

#[test]
fn wrong_usage_and_unreadable_scenes_are_one_line() {
    let place = Place::new();
    let file = cornell_box();
    let cases: &[(i32, &str, &[&str])] = &[
        (2, "--output", &["report", &file]),
        (2, "<SCENE>", &["report", "-o", "out"]),
        (2, "--section speed: expected choices, rules", &["report", &file, "-o", "out", "--section", "speed"]),
        (2, "640x480", &["report", &file, "-o", "out", "--size", "8"]),
        (2, "has one camera, number 0", &["report", &file, "-o", "out", "--camera", "1"]),
        (1, "nothing.glb: No such file", &["report", &file, "nothing.glb", "-o", "out"]),
        (1, "there is no folder nowhere", &["report", &file, "-o", "nowhere/out"]),
    ];
    for (code, wanted, arguments) in cases {
        place.fails(*code, wanted, arguments);
    }
}
