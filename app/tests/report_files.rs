//! What a report's folder contains: every file matches its schema, every number of the page is a field of a file, and
//! every interval can be computed again from the recorded runs and counts.

use std::collections::{BTreeMap, BTreeSet};

use raystep_lab::statistics::interval::{of_median, of_ratio};
use raystep_lab::statistics::proportion::{at_most, exact_interval};
use raystep_lab::tidy::package;

use crate::common::Place;

pub(crate) type Row = BTreeMap<String, String>;
pub(crate) type Tables = BTreeMap<String, Vec<Row>>;

pub(crate) fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} is no number: {row:?}"))
}

/// All CSV files of a report, after checking them against their schema.
pub(crate) fn tables(place: &Place, folder: &str) -> Tables {
    let schema = place.read(&format!("{folder}/datapackage.json"));
    let read = |name: &str| std::fs::read(place.path(folder).join(name)).ok();
    package::check(&schema, read).unwrap_or_else(|e| panic!("{folder}: {e}"));
    let schema: serde_json::Value = serde_json::from_slice(&schema).expect("JSON");
    let resources = schema["resources"].as_array().expect("resources");
    let names: BTreeSet<String> = resources.iter().map(|r| r["path"].as_str().expect("a path").to_owned()).collect();
    let files = std::fs::read_dir(place.path(folder)).expect("the folder");
    let csvs = files.map(|f| f.expect("a file").file_name().to_string_lossy().into_owned());
    assert_eq!(names, csvs.filter(|name| name.ends_with(".csv")).collect(), "all CSV files are described");
    names.into_iter().map(|name| (name.clone(), rows(place, folder, &name))).collect()
}

/// The rows of a file, which must end its lines as RFC 4180 requires.
fn rows(place: &Place, folder: &str, name: &str) -> Vec<Row> {
    let file = place.read(&format!("{folder}/{name}"));
    let lines = file.iter().filter(|&&b| b == b'\n').count();
    assert_eq!(file.windows(2).filter(|w| w == b"\r\n").count(), lines, "{name}");
    let mut reader = csv::ReaderBuilder::new().flexible(false).from_reader(file.as_slice());
    let names: Vec<String> = reader.headers().expect("a header").iter().map(str::to_owned).collect();
    let row = |record: csv::StringRecord| names.iter().cloned().zip(record.iter().map(str::to_owned)).collect();
    reader.records().map(|r| row(r.unwrap_or_else(|e| panic!("{name}: {e}")))).collect()
}

/// The texts between two pieces of markup, at every occurrence.
fn between<'a>(page: &'a str, begin: &str, end: &str) -> Vec<&'a str> {
    page.split(begin).skip(1).filter_map(|rest| rest.split(end).next()).collect()
}

/// The page needs no other files, its numbers are fields of the CSV files, and its plots are files.
pub(crate) fn check_page(place: &Place, folder: &str, tables: &Tables) {
    let page = String::from_utf8(place.read(&format!("{folder}/index.html"))).expect("UTF-8");
    for foreign in ["http:", "https:", "<script", "<link", "src=", "@import", "url("] {
        assert!(!page.contains(foreign), "{foreign} in the page");
    }
    assert!(page.contains("prefers-color-scheme:dark") && page.contains("raystep report"));
    let fields_of = |name: &str| -> BTreeSet<&str> {
        tables[name].iter().flat_map(|row| row.values().map(String::as_str)).collect()
    };
    let all: BTreeSet<&str> = tables.keys().flat_map(|name| fields_of(name)).collect();
    let numbers = |html: &str| between(html, "<data value=\"", "\"").into_iter().map(str::to_owned).collect::<Vec<_>>();
    for value in numbers(&page) {
        assert!(all.contains(value.as_str()), "{value} is in no file");
    }
    for section in between(&page, "<section>", "</section>") {
        // The caption's seed is of the whole report.
        let file = between(section, "Data: <a href=\"", "\"")[0];
        let (fields, about) = (fields_of(file), fields_of("about.csv"));
        for value in numbers(section) {
            assert!(fields.contains(value.as_str()) || about.contains(value.as_str()), "{value} is not in {file}");
        }
    }
    let captions = String::from_utf8(place.read(&format!("{folder}/captions.tex"))).expect("UTF-8");
    let links = between(&page, "<a href=\"", "\"");
    for (kind, begin) in [(".svg", &b"<svg"[..]), (".pdf", b"%PDF-")] {
        let figures: Vec<&&str> = links.iter().filter(|name| name.ends_with(kind)).collect();
        assert_eq!(figures.len(), 2 * page.matches("<svg").count(), "every figure is linked, for one and two columns");
        for name in figures {
            assert!(place.read(&format!("{folder}/{name}")).starts_with(begin), "{name}");
            let stem = name.split("-one-column").next().and_then(|name| name.split("-two-columns").next());
            let caption = format!("\\csname raystep-{}\\endcsname{{", stem.expect("a name"));
            assert!(captions.contains(&caption), "{name} has a caption for LaTeX");
        }
    }
}

fn is_near(a: f64, b: f64) -> bool {
    // Fields have six digits.
    (a - b).abs() <= 1e-5 * a.abs().max(b.abs())
}

/// Intervals of medians, of ratios and of shares, computed again. Returns how many of each there are.
pub(crate) fn check_intervals(tables: &Tables) -> [usize; 3] {
    let about = |name: &str| tables["about.csv"].iter().find(|r| r["name"] == name).map(|r| r["value"].clone());
    let seed: u64 = about("seed").expect("a seed").parse().expect("a number");
    let mut runs: BTreeMap<(String, String), BTreeMap<usize, f64>> = BTreeMap::new();
    for row in &tables["runs.csv"] {
        if let Ok(ns) = row["time_ns"].parse::<f64>() {
            let of = runs.entry((row["scene_hash"].clone(), row["configuration"].clone())).or_default();
            of.insert(row["round"].parse().expect("a round"), ns);
        }
    }
    let mut found = [0; 3];
    let has = |row: &Row, column: &str| row.get(column).is_some_and(|field| !field.is_empty());
    for (name, rows) in tables {
        for row in rows {
            let of = |configuration: &str| runs.get(&(row["scene_hash"].clone(), configuration.to_owned()));
            if has(row, "low_ns") {
                let times: Vec<f64> = of(&row["configuration"]).expect("runs").values().copied().collect();
                let interval = of_median(&times, seed).expect("an interval");
                assert_eq!(row["runs"], times.len().to_string(), "{name}: {row:?}");
                let pairs = [("median_ns", interval.median), ("low_ns", interval.low), ("high_ns", interval.high)];
                for (column, value) in pairs {
                    assert!(is_near(number(row, column), value), "{name}, {column}: {value}, not {row:?}");
                }
                found[0] += 1;
            }
            if has(row, "time_ratio_low") && has(row, "ratio_to") {
                let (own, to) = (of(&row["configuration"]).expect("runs"), of(&row["ratio_to"]).expect("runs"));
                // The fastest choice is found in two of four rounds, and compared in the others, if both have twelve.
                let has_halves = name == "choices.csv" && own.len().min(to.len()) >= 12;
                let is_compared = |round: usize| !has_halves || round % 4 >= 2;
                let pairs = own.iter().filter(|(round, _)| is_compared(**round));
                let pairs: Vec<(f64, f64)> = pairs.filter_map(|(round, ns)| Some((*ns, *to.get(round)?))).collect();
                let interval = of_ratio(&pairs, seed).expect("an interval");
                let ends = [("time_ratio", interval.median), ("time_ratio_low", interval.low)];
                for (column, value) in ends.into_iter().chain([("time_ratio_high", interval.high)]) {
                    assert!(is_near(number(row, column), value), "{name}, {column}: {value}, not {row:?}");
                }
                found[1] += 1;
            }
            if has(row, "wrong_per_million_high") {
                let count = |column: &str| row[column].parse::<u64>().expect("a count");
                let (wrong, of) = (count("wrong_rays"), count("judged_rays"));
                let is_own = row.get("method").is_some_and(|method| !method.is_empty());
                assert!(is_own || wrong == count("missed") + count("false_hits") + count("wrong_hits"), "{row:?}");
                let [low, high] = match wrong {
                    0 => [0.0, at_most(0, of).expect("a bound")],
                    _ => exact_interval(wrong, of).expect("an interval"),
                };
                assert!(is_near(number(row, "wrong_per_million_low"), 1e6 * low), "{name}: {row:?}");
                assert!(is_near(number(row, "wrong_per_million_high"), 1e6 * high), "{name}: {row:?}");
                found[2] += 1;
            }
        }
    }
    found
}
