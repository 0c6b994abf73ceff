//! `--traversal`, from the command line.

use crate::common::Place;
use crate::files::cornell_box;

const DDA: [&str; 4] = ["--numerics", "paper", "--traversal", "3d-dda"];

#[test]
fn a_rays_history_has_control_terms_and_says_how_they_decide() {
    let place = Place::new();
    let scene = cornell_box();
    let trace = |more: &[&str]| {
        let all = ["trace", &scene, "--pixel", "12,20", "--size", "32x32", "--device", "cpu"];
        place.ok(&[&all[..], &DDA, more].concat()).stdout
    };
    let table = trace(&["--print-link"]);
    assert!(table.contains("  control  ") && !table.contains("tmax"), "{table}");
    assert!(
        table.contains("no control term is above 0, so z, the driving axis, is next: step -z to cell ("),
        "{table}"
    );
    assert!(table.contains(" is above 0, so x is before z, the driving axis: step -x to cell ("), "{table}");
    let csv = trace(&["--format", "csv"]);
    let mut rows = csv::Reader::from_reader(csv.as_bytes());
    let names = rows.headers().expect("a header").clone();
    let column = |name: &str| names.iter().position(|n| n == name).expect(name);
    let row = rows.records().map(|row| row.expect("a row")).find(|row| &row[column("kernel")] == "traverse_grid");
    let row = row.expect("a step");
    assert_eq!((&row[column("tmax_after_x_traced")], &row[column("control_after_z")]), ("", "0"), "{row:?}");
    assert!(row[column("control_after_x")].parse::<f32>().is_ok_and(|term| term.abs() <= 1.0), "{row:?}");
    let json: serde_json::Value = serde_json::from_str(&trace(&["--format", "json"])).expect("JSON");
    assert!(json["rows"][1]["after"]["control"][0].is_number(), "{json}");
}

#[test]
fn both_walks_are_measured_side_by_side() {
    let place = Place::new();
    let scene = cornell_box();
    let all =
        ["bench", &scene, "--sizes", "16x16", "--repeats", "2", "--device", "cpu", "--numerics", "paper", "--quiet"];
    let ways = ["--accelerators", "grid,bvh", "--traversals", "amanatides-woo,3d-dda", "-o", "out"];
    place.ok(&[&all[..], &ways].concat());
    let summary = place.read("out/summary.csv");
    let mut rows = csv::Reader::from_reader(summary.as_slice());
    let names = rows.headers().expect("a header").clone();
    let column = |name: &str| names.iter().position(|n| n == name).expect(name);
    let [accelerator, walk, hits] = ["accelerator", "traversal", "hits_hash"].map(column);
    let of = |row: csv::StringRecord| (row[accelerator].to_owned(), row[walk].to_owned(), row[hits].to_owned());
    let rows: Vec<(String, String, String)> = rows.records().map(|row| of(row.expect("a row"))).collect();
    let ways: Vec<[&str; 2]> = rows.iter().map(|(accelerator, walk, _)| [accelerator.as_str(), walk]).collect();
    assert_eq!(ways, [["grid", "amanatides-woo"], ["grid", "3d-dda"], ["bvh", "amanatides-woo"]]);
    assert_eq!(rows[0].2, rows[1].2, "the same hits");
    let passes = String::from_utf8(place.read("out/passes.csv")).expect("text");
    assert!(passes.lines().any(|line| line.contains(",3d-dda,")), "{passes}");
}
