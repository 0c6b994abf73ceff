//! That the files of a benchmark agree with each other and with their schema.

use std::collections::{BTreeMap, BTreeSet};

use raystep_lab::tidy::package::check;
use serde_json::Value;

use super::{Row, is_near, number, rows};
use crate::common::Place;

/// `passes.csv` has one run of each configuration, which must agree with `summary.csv`.
pub(super) fn passes_agree(place: &Place, summary: &[Row]) {
    let (_, passes) = rows(&place.read("out/passes.csv"));
    let mut of: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
    for pass in &passes {
        assert_eq!(pass["run_id"], summary[0]["run_id"]);
        of.entry(&pass["configuration"]).or_default().push(pass);
    }
    assert_eq!(of.len(), summary.len());
    for row in summary {
        let passes = &of[row["configuration"].as_str()];
        assert_eq!(passes.len().to_string(), row["passes"]);
        let sum = |name: &str| passes.iter().map(|pass| number(pass, name)).sum::<f64>();
        assert!(is_near(number(row, "useful_steps_per_thread"), sum("rays_in") / sum("threads_launched")), "{row:?}");
        for (i, pass) in passes.iter().enumerate() {
            assert_eq!((pass["pass_index"].as_str(), pass["valid"].as_str()), (i.to_string().as_str(), "true"));
            assert_eq!((pass["repeat"].as_str(), pass["is_warmup"].as_str()), ("0", "false"));
            // Passes name the structure that they had, a configuration the one that was asked for.
            let is_same = row["accelerator"] == "auto" || pass["accelerator"] == row["accelerator"];
            assert!(is_same && pass["accelerator"] != "auto", "{pass:?}");
            assert_eq!(pass["schedule"], row["schedule"]);
        }
        assert_eq!(passes[0]["begin_ns"], "0", "each run starts at 0");
    }
}

/// `runs.csv` has every counted run, from which the numbers of `summary.csv` follow, and the schema fits all files.
pub(super) fn runs_agree(place: &Place, folder: &str, summary: &[Row]) {
    let (_, runs) = rows(&place.read(&format!("{folder}/runs.csv")));
    let mut places: BTreeMap<(&str, &str), BTreeSet<&str>> = BTreeMap::new();
    for row in summary {
        let runs: Vec<&Row> = runs.iter().filter(|run| run["configuration"] == row["configuration"]).collect();
        assert_eq!((runs.len().to_string(), &runs[0]["clock"]), (row["runs"].clone(), &row["clock"]));
        let times = |name: &str| {
            let mut times: Vec<f64> = runs.iter().map(|run| number(run, name)).collect();
            times.sort_by(f64::total_cmp);
            (times.len() == 6).then(|| (times[2] + times[3]) / 2.0).map(|median| (times[0], median, times[5]))
        };
        if let Some((min, median, max)) = times("time_ns") {
            assert!(is_near(median, number(row, "median_ns")), "{row:?}");
            assert_eq!((min, max), (number(row, "min_ns"), number(row, "max_ns")));
            assert!(times("fixed_work_ns").is_some_and(|(_, median, _)| is_near(median, number(row, "fixed_work_ns"))));
            assert!(times("wall_ns").is_some_and(|(_, median, _)| is_near(median, number(row, "median_wall_ns"))));
        }
        for (round, run) in runs.iter().enumerate() {
            assert_eq!((&run["run_id"], &run["round"]), (&row["run_id"], &round.to_string()));
            places.entry((&run["sitting"], &run["round"])).or_default().insert(&run["place"]);
        }
    }
    assert!(places.values().all(|of_round| of_round.len() == summary.len()), "two runs at one place: {places:?}");
    let schema = place.read(&format!("{folder}/datapackage.json"));
    let read = |name: &str| std::fs::read(place.path(format!("{folder}/{name}"))).ok();
    assert_eq!(check(&schema, read), Ok(()));
    let schema: Value = serde_json::from_slice(&schema).expect("JSON");
    let fields = schema["resources"].as_array().expect("files").iter().flat_map(|file| {
        file["schema"]["fields"].as_array().expect("fields").iter().filter(|field| field["description"].is_null())
    });
    assert_eq!(fields.count(), 0, "every column is described");
}
