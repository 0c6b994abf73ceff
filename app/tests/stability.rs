//! `raystep stability`, from the built binary: its CSV is read by a strict reader; exit codes.

use std::collections::BTreeMap;

use crate::common::{Place, scene};

type Row = BTreeMap<String, String>;

/// Rows by column; every row has as many fields as there are columns.
fn rows_of(file: &[u8]) -> Vec<Row> {
    let mut reader = csv::ReaderBuilder::new().flexible(false).from_reader(file);
    let names: Vec<String> = reader.headers().expect("a header").iter().map(str::to_owned).collect();
    let row = |record: csv::StringRecord| names.iter().cloned().zip(record.iter().map(str::to_owned)).collect();
    reader.records().map(|r| row(r.expect("as many fields as names"))).collect()
}

/// Two cases in which the paper's numerics fail: one only with the grid, one with every accelerator.
const TWO: [&str; 8] = ["stability", "--case", "axis-below", "--case", "tiny-detail", "--quick", "--device", "cpu"];

#[test]
fn robust_rules_pass_and_the_papers_fail_where_they_must() {
    let place = Place::new();
    let outcome = place.ok(&[&TWO[..], &["-o", "out"]].concat());
    assert!(outcome.stdout.contains("axis-below-1e-3") && !outcome.stdout.contains("NO"), "{outcome:?}");
    let file = place.read("out/stability.csv");
    let lines = file.iter().filter(|&&b| b == b'\n').count();
    assert_eq!(file.windows(2).filter(|w| w == b"\r\n").count(), lines, "lines end as RFC 4180 says");
    let rows = rows_of(&file);
    // In f32, each accelerator with both numerics, fused and contracted, and by exact t in two schedules; in f64 with both
    // numerics. The paper has no rules for an irregular grid.
    assert_eq!(rows.len(), 2 * (12 + 8 + 6 + 3 + 1));
    let page = String::from_utf8(place.read("out/stability.html")).expect("UTF-8");
    for row in &rows {
        let errors: u64 = ["missed", "false_hits", "wrong_hits"].map(|c| row[c].parse::<u64>().expect(c)).iter().sum();
        assert_eq!((errors.to_string(), row["schema_version"].as_str()), (row["wrong_rays"].clone(), "2"));
        let (undecided, ceiling): (u64, u64) =
            (row["undecided"].parse().expect("a count"), row["undecided_ceiling"].parse().expect("a count"));
        let must_fail = row["numerics"] == "paper"
            && row["device"] == "cpu_f32"
            && (row["case"] == "tiny-detail" || row["accelerator"] == "grid");
        let expected = match row["numerics"].as_str() {
            "robust" => "pass",
            _ if must_fail => "fail",
            _ => "any",
        };
        assert_eq!(row["expected"], expected, "{row:?}");
        if row["numerics"] == "robust" {
            assert_eq!((errors, row["non_finite"].as_str(), row["at_bound"].as_str()), (0, "0", "0"), "{row:?}");
            assert!(undecided <= ceiling && row["result"] == "pass", "{row:?}");
            assert!(row["triangle_test"] != "exact" || ceiling == 0, "{row:?}");
        }
        assert!(!must_fail || (errors > 0 && row["result"] == "fail"), "{row:?}");
        assert_eq!((row["rays"].as_str(), row["adapter"].as_str()), ("256", "cpu"));
        for column in ["t_relative", "t_ulp", "u_ulp", "v_relative"] {
            let Ok(value) = row[column].parse() else { continue };
            let cell = format!("<data value=\"{}\">{}</data>", row[column], raystep_lab::human::digits(value));
            assert!(page.contains(&cell), "{column}: no {cell}: {row:?}");
        }
    }
    assert!(page.contains("data:image/png;base64,") && page.matches("<details>").count() == 2);
    assert!(!page.contains("src=\"http") && !page.contains("href=\"http"), "the page refers to other files");

    let again = place.ok(&[&TWO[..], &["-o", "out", "--force", "--quiet"]].concat());
    assert_eq!((again.stdout.as_str(), again.stderr.as_str()), ("", ""));
    let without_id = |mut rows: Vec<Row>| {
        let ids: std::collections::BTreeSet<_> = rows.iter_mut().filter_map(|row| row.remove("run_id")).collect();
        assert_eq!(ids.len(), 1, "one id an invocation");
        (rows, ids)
    };
    let ((first, id), (second, other)) = (without_id(rows), without_id(rows_of(&place.read("out/stability.csv"))));
    assert_eq!(first, second, "the errors differ in the second run");
    assert_ne!(id, other);
    assert_eq!(place.names(), ["out"]);
}

#[test]
fn tmax_is_measured_along_the_long_walk() {
    let place = Place::new();
    let outcome = place.ok(&["stability", "--case", "long-walk", "--quick", "--device", "cpu", "-o", "out"]);
    assert!(outcome.stdout.contains("tMax, cpu_f32 robust: error at most"), "{outcome:?}");
    let rows = rows_of(&place.read("out/tmax.csv"));
    let errors = |rules: [&str; 2]| -> Vec<f64> {
        rows.iter()
            .filter(|r| [&r["numerics"], &r["rule"]] == rules)
            .map(|r| r["error_units"].parse().expect("a number"))
            .collect()
    };
    const ROBUST: [&str; 2] = ["robust", ""];
    // Robust: at most 8 units of 2^-24 in every cell; accumulated: hundreds.
    assert!(errors(ROBUST).len() > 50 && errors(ROBUST).iter().all(|&e| e <= 8.0), "{:?}", errors(ROBUST));
    for rules in [["robust", "tmax"], ["paper", ""]] {
        let [first, .., last] = errors(rules)[..] else { panic!("{rules:?}: few samples") };
        assert!(last > 100.0 && last > 10.0 * first, "{rules:?}: {first} to {last}");
    }
    let page = String::from_utf8(place.read("out/stability.html")).expect("UTF-8");
    assert!(page.contains("tMax along a walk") && !page.contains("id=\"pipelines\""), "pipelines only with all cases");
}

#[test]
fn the_cost_of_a_family_is_measured_and_an_interrupted_measurement_continues() {
    let place = Place::new();
    let few = ["stability", "--case", "no-triangle", "--device", "cpu", "--quick", "--cost"];
    let family = ["--family", "t-junctions", "--accelerator", "bvh", "-o", "out"];
    let arguments = [&few[..], &family].concat();
    place.ok(&arguments);
    assert_eq!(place.names(), ["out"], "nothing unfinished is left");
    let file = place.read("out/stiff.csv");
    let rows = rows_of(&file);
    // Ten points, with all rules and without one of two.
    assert_eq!((rows.len(), rows.iter().filter(|row| row["rule"].is_empty()).count()), (30, 10));
    assert!(rows.iter().all(|row| row["accelerator"] == "bvh" && !row["ns_per_ray"].is_empty()), "{rows:?}");
    let page = String::from_utf8(place.read("out/stability.html")).expect("UTF-8");
    assert!(page.contains("id=\"cost\"") && page.contains("T-junctions"));
    let package: serde_json::Value = serde_json::from_slice(&place.read("out/datapackage.json")).expect("JSON");
    let described: Vec<_> = package["resources"].as_array().expect("files").iter().map(|r| r["path"].clone()).collect();
    assert_eq!(described, ["stability.csv", "tmax.csv", "pipelines.csv", "stiff.csv", "runs.csv"]);

    // As if it had been interrupted after twelve rows: they are not measured again.
    let kept: Vec<&[u8]> = file.split_inclusive(|&b| b == b'\n').take(13).collect();
    std::fs::write(place.path("out.stiff.csv.part"), kept.concat()).expect("a file");
    let other: Vec<&str> = arguments.iter().copied().filter(|a| *a != "--quick").collect();
    place.fails(1, "it has is_quick true, not false; use the same options", &[&other[..], &["--force"]].concat());
    let outcome = place.ok(&[&arguments[..], &["--force"]].concat());
    assert!(outcome.stderr.contains("continuing: 12 results"), "{outcome:?}");
    let again = rows_of(&place.read("out/stiff.csv"));
    assert_eq!(again[..12], rows[..12]);
    for (first, second) in rows.iter().zip(&again).skip(12) {
        assert_ne!(first["run_id"], second["run_id"]);
        for column in ["configuration", "rays", "judged_rays", "wrong_rays", "undecided", "tests_per_ray", "stiffness"]
        {
            assert_eq!(first[column], second[column], "{column}");
        }
    }
    assert_eq!(place.names(), ["out"]);
}

#[test]
fn one_accelerator_without_files_and_the_list_of_cases() {
    let place = Place::new();
    let outcome = place.ok(&[&TWO[..], &["--accelerator", "grid"]].concat());
    let line = outcome.stdout.lines().find(|l| l.starts_with("tiny-detail")).expect("a line a case");
    let cells: Vec<&str> = line.split_whitespace().collect();
    assert_eq!((cells[1], cells[2], cells[5], &cells[7..]), ("256", "0", "0", &["-", "-", "yes"][..]), "{line}");
    assert_ne!(cells[6], "0", "the paper's rules lose rays: {line}");
    assert!(place.names().is_empty());
    let list = place.ok(&["stability", "--list"]).stdout;
    assert!(list.lines().count() > 40 && list.contains("grid,bvh,none"), "{list}");
}

#[test]
fn what_cannot_be_meant_is_refused_before_anything_runs() {
    let place = Place::new();
    place.fails(2, "'raystep stability --list' lists them", &["stability", "--case", "no-such"]);
    place.fails(2, "--device cpu uses none", &["stability", "--device", "cpu", "--adapter", "x"]);
    place.fails(
        2,
        "--accelerator auto: expected grid, irregular, bvh or none",
        &["stability", "--accelerator", "auto"],
    );
    place.fails(2, "--output", &["stability", "--force"]);
    place.fails(2, "--cost", &["stability", "--family", "room"]);
    let file = scene("cornell-box.gltf").display().to_string();
    place.fails(2, "unexpected argument", &["stability", &file]);
    std::fs::write(place.path("stability.csv"), "a,b\r\n").expect("a file");
    place.fails(1, "not from a stability report", &["stability", "--case", "no-triangle", "-o", "."]);
    place.fails(1, "not from a stability report", &["stability", "--case", "no-triangle", "-o", ".", "--force"]);
}
