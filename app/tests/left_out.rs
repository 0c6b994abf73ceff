//! What the scene does not need, item by item: the report's section `left-out`, and `raystep plan --measure`.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

use crate::common::{Place, scene};

type Row = BTreeMap<String, String>;

/// What the Cornell box does not need with its own camera.
const ITEMS: [&str; 10] = [
    "clipping",
    "ray-padding",
    "normals",
    "textures",
    "vertex-colors",
    "emission",
    "double-sided",
    "many-lights",
    "directional-lights",
    "spot-lights",
];

fn cornell_box() -> String {
    scene("cornell-box.gltf").display().to_string()
}

fn rows(place: &Place, name: &str) -> Vec<Row> {
    let file = place.read(name);
    let mut reader = csv::ReaderBuilder::new().flexible(false).from_reader(file.as_slice());
    let names: Vec<String> = reader.headers().expect("a header").iter().map(str::to_owned).collect();
    let row = |record: csv::StringRecord| names.iter().cloned().zip(record.iter().map(str::to_owned)).collect();
    reader.records().map(|record| row(record.expect("a row"))).collect()
}

fn report(place: &Place, device: &str) -> (Vec<Row>, String) {
    let report = ["report", &cornell_box(), "--quick", "--quiet", "--section", "left-out", "-o", "out"];
    place.ok(&[&report[..], &["--device", device]].concat());
    let page = String::from_utf8(place.read("out/index.html")).expect("UTF-8");
    (rows(place, "out/left_out.csv"), page)
}

fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} is no number: {row:?}"))
}

/// The rows of each structure and schedule: first all items together, then each that the scene does not need.
fn by_way(rows: &[Row]) -> Vec<&[Row]> {
    let ways: Vec<&[Row]> = rows.chunk_by(|a, b| a["schedule"] == b["schedule"]).collect();
    assert_eq!(ways.len(), 2, "a quick report has two ways");
    for way in &ways {
        let items: BTreeSet<&str> = way[1..].iter().map(|row| row["item"].as_str()).collect();
        assert_eq!((way[0]["item"].as_str(), items), ("all", BTreeSet::from(ITEMS)));
        for row in &way[1..] {
            assert!(!row["reason"].is_empty(), "{row:?}");
            // Only the grid has code to clip rays, and only the BVH has boxes.
            let is_changed = match row["item"].as_str() {
                "clipping" => row["accelerator"] == "grid",
                "ray-padding" => row["accelerator"] == "bvh",
                _ => true,
            };
            assert_eq!(row["is_changed"], is_changed.to_string(), "{row:?}");
            assert_eq!(row["because"], if is_changed { "scene" } else { "options" }, "{row:?}");
        }
    }
    ways
}

/// The median ratio of times of two configurations in the rounds that both have.
fn ratio(runs: &[Row], of: &str, to: &str, first_round: usize) -> f64 {
    let times = |name: &str| -> BTreeMap<usize, f64> {
        let of = runs.iter().filter(|run| run["configuration"] == name);
        of.map(|run| (number(run, "round") as usize, number(run, "time_ns"))).collect()
    };
    let (of, to) = (times(of), times(to));
    let ratio = |(round, time): (&usize, &f64)| Some((time / to.get(round)?).ln());
    let mut ratios: Vec<f64> = of.range(first_round..).filter_map(ratio).collect();
    ratios.sort_by(f64::total_cmp);
    assert!(!ratios.is_empty());
    let middle = (ratios.len() - 1) as f64 / 2.0;
    ((ratios[middle.floor() as usize] + ratios[middle.ceil() as usize]) / 2.0).exp()
}

#[test]
fn an_adapter_tells_what_putting_back_each_item_costs() {
    let place = Place::new();
    let (rows, page) = report(&place, "gpu");
    println!("{}", rows[0]["adapter"]);
    let runs = self::rows(&place, "out/runs.csv");
    for way in by_way(&rows) {
        // On a busy machine there may be no time for all of them: then a note says so.
        let changed = way.iter().filter(|row| row["is_changed"] == "true");
        let (late, measured): (Vec<&Row>, Vec<&Row>) = changed.partition(|row| row["runs"].is_empty());
        assert!(measured.len() > 1 && measured[0]["item"] == "all", "{measured:?}");
        assert!(late.is_empty() || page.contains("there was no time to measure"), "{late:?}");
        for row in &measured {
            assert!(number(row, "runs") >= 6.0 && number(row, "differing_hits") == 0.0, "{row:?}");
            let [low, median, high] = ["time_ratio_low", "time_ratio", "time_ratio_high"].map(|c| number(row, c));
            assert!(0.0 < low && low <= median && median <= high, "{row:?}");
            for column in ["first_start_s", "first_start_s_with", "start_s", "start_s_with"] {
                assert!(number(row, column) > 0.0, "{column}: {row:?}");
            }
            // The numbers can be made again from the single runs.
            let (with, without) = (&row["configuration"], &row["ratio_to"]);
            let start = |name: &str| format!("{name}/start");
            for (column, again) in [
                ("time_ratio", ratio(&runs, with, without, 0)),
                ("start_ratio", ratio(&runs, &start(with), &start(without), 1)),
            ] {
                assert!((number(row, column) / again - 1.0).abs() < 1e-4, "{column} is {again}: {row:?}");
            }
        }
        let ratios: Vec<f64> = measured[1..].iter().map(|row| number(row, "time_ratio")).collect();
        assert!(ratios.is_sorted_by(|a, b| a >= b), "{ratios:?}");
        for row in way.iter().filter(|row| row["is_changed"] == "false") {
            assert!(row["time_ratio"].is_empty() && row["buffer_bytes"] == row["buffer_bytes_with"], "{row:?}");
        }
        assert!(number(&way[0], "buffer_bytes_with") > number(&way[0], "buffer_bytes"));
    }
    assert!(page.contains("spot-lights (no spot light)") && page.contains("times as long"), "{page}");
    assert!(place.path("out/cornell-box-left-out-time-one-column.pdf").exists());
}

#[test]
fn without_an_adapter_only_bytes_are_told_and_why() {
    let place = Place::new();
    let (rows, page) = report(&place, "cpu");
    for row in by_way(&rows).concat() {
        let sum = |end: &str| {
            ["stream_bytes", "buffer_bytes"].map(|c| number(&row, &format!("{c}{end}"))).iter().sum::<f64>()
        };
        assert_eq!(number(&row, "added_bytes"), sum("_with") - sum(""), "{row:?}");
        for (column, field) in &row {
            let is_of_times = column.contains("_ratio") || column.contains("start_s") || column == "clock";
            assert!(!is_of_times || field.is_empty(), "{column}: {row:?}");
        }
    }
    const WHY: &str = "kernels are compiled in advance";
    let section = page.split("<section>").nth(1).expect("a section");
    let first = section.split("<p>").nth(2).expect("what it is, and then");
    assert!(first.starts_with("On the CPU, omitting saves memory only") && first.contains(WHY), "{first}");
    assert!(
        page.contains("Everything put back: <b><data value=") && page.contains("Has no effect in this run: clipping.")
    );
    assert!(!page.contains("<figure>") && !page.contains("times as long"));

    let plan = ["plan", &cornell_box(), "--size", "16x16", "--device", "cpu", "--quiet"];
    let text = place.ok(&[&plan[..], &["--measure"]].concat()).stdout;
    let (before, costs) = text.split_once("\nnot needed by the scene").expect("costs");
    assert_eq!(format!("{before}\n").trim_end(), place.ok(&plan).stdout.trim_end(), "the plan itself is the same");
    assert!(costs.lines().nth(1).is_some_and(|line| line.contains(WHY)), "{costs}");
    assert!(costs.contains("no spot light") && !costs.contains("% time"), "{costs}");
    // Everything together has the size that --keep-all has.
    let json = |more: &str| -> Value {
        serde_json::from_str(&place.ok(&[&plan[..], &["--json", more]].concat()).stdout).expect("JSON")
    };
    let (measured, kept) = (json("--measure"), json("--keep-all"));
    let all = &measured["put_back"]["items"][0];
    assert_eq!(all["item"], "all");
    let bytes = |name: &str| all[name].as_u64().expect("bytes");
    assert_eq!(Some(bytes("stream_bytes_with") + bytes("buffer_bytes_with")), kept["bytes"].as_u64());
    assert!(measured["put_back"]["note"].as_str().is_some_and(|note| note.contains(WHY)));
    assert!(all.get("time_ratio").is_none());
}

#[test]
fn a_plan_is_measured_on_an_adapter() {
    let place = Place::new();
    let lights = scene("lights.gltf").display().to_string();
    let plan = ["plan", &lights, "--size", "32x32", "--device", "gpu", "--quiet", "--measure"];
    let json: Value = serde_json::from_str(&place.ok(&[&plan[..], &["--json"]].concat()).stdout).expect("JSON");
    let costs = &json["put_back"];
    println!("{}", costs["adapter"]);
    let items = costs["items"].as_array().expect("a list");
    let names: BTreeSet<&str> = items.iter().filter_map(|item| item["item"].as_str()).collect();
    assert!(names.contains("all") && names.contains("textures"), "{names:?}");
    assert!(!names.contains("spot-lights") && !names.contains("many-lights"), "the scene has them: {names:?}");
    for item in items.iter().filter(|item| item.get("runs").is_some()) {
        assert!(
            item["is_changed"] == true
                && item["runs"].as_u64() >= Some(6)
                && item["time_ratio_low"].as_f64() > Some(0.0),
            "{item}"
        );
        assert_eq!(item["differing_hits"], 0, "{item}");
    }
    // What is omitted for an item has its name.
    let left_out = json["left_out"].as_array().expect("a list");
    let of_textures = left_out.iter().filter(|left| left["item"] == "textures");
    let of_textures: BTreeSet<&str> = of_textures.filter_map(|left| left["what"].as_str()).collect();
    assert_eq!(of_textures, BTreeSet::from(["buffer texcoords", "buffer texels", "buffer textures"]));
    assert!(left_out.iter().any(|left| left["because"] == "options" && left["item"].is_null()));

    let text = place.ok(&plan).stdout;
    let line = |name: &str| text.lines().find(|line| line.trim_start().starts_with(name)).expect("a line");
    assert!(line("all ").contains("time") && line("all ").contains("start"), "{text}");
    assert!(line("textures ").contains("no base colour texture"), "{text}");

    place.fails(2, "--measure: program grid-build", &["plan", &lights, "--program", "grid-build", "--measure"]);
    place.fails(2, "--keep-all", &["plan", &lights, "--keep-all", "--measure"]);
}
