//! `passes.csv` against the summary of the same run, and against itself.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::common::Place;
use crate::files::cornell_box;
use crate::history::csv_rows;

type Row = BTreeMap<String, String>;

/// The columns of `passes.csv`.
pub(crate) const COLUMNS: &str = "schema_version,run_id,configuration,scene,accelerator,schedule,numerics,adapter,\
    width_px,height_px,repeat,is_warmup,pass_index,sample,iteration,kernel,begin_ns,duration_ns,encode_ns,rays_in,rays_out,\
    threads_launched,cells_visited,triangles_tested,repeated_tests,clock,clock_resolution_ns,valid,host_run_ns,\
    duration_runs,duration_error_ns,duration_below_ns,mapping,draw,targets,fragments_run,bytes_copied,traversal,\
    loops,scene_data,integrator";

fn sum<'a>(rows: impl IntoIterator<Item = &'a Row>, column: &str) -> u64 {
    let number = |row: &Row| if row[column].is_empty() { 0 } else { row[column].parse().expect("a number") };
    rows.into_iter().map(number).sum()
}

/// Runs, and checks what holds for every file of passes and its summary.
fn render(place: &Place, scene: &str, how: &[&str]) -> (Vec<Row>, Value) {
    let files = ["-o", "a.png", "--passes-csv", "passes.csv", "--summary-json", "run.json", "--counters", "--quiet"];
    place.ok(&[&["render", scene], &files[..], how].concat());
    let rows = csv_rows(&place.read("passes.csv"));
    let run: Value = serde_json::from_slice(&place.read("run.json")).expect("JSON");
    for column in ["cells_visited", "triangles_tested"] {
        assert_eq!(run["counters"][column], sum(&rows, column), "{column} of {how:?}");
    }
    if let Some(repeated) = run["counters"]["repeated_tests"].as_u64() {
        assert_eq!(repeated, sum(&rows, "repeated_tests"), "{how:?}");
    }
    for (kernel, summed) in run["kernels"].as_object().expect("kernels") {
        let own: Vec<&Row> = rows.iter().filter(|row| row["kernel"] == *kernel).collect();
        assert_eq!(summed["rays_in"], sum(own.iter().copied(), "rays_in"), "{kernel} of {how:?}");
        // Between the parts of a pass that is drawn, there is time that is in no row.
        if let Some(duration) = summed["duration_ns"].as_u64().filter(|_| rows[0]["draw"].is_empty()) {
            assert_eq!(duration, sum(own.iter().copied(), "duration_ns"), "{kernel} of {how:?}");
        }
    }
    let last = rows.last().expect("a row");
    assert_eq!(run["passes"], last["pass_index"].parse::<u64>().expect("a number") + 1);
    assert_eq!((&run["run_id"], &run["clock"]), (&last["run_id"].as_str().into(), &last["clock"].as_str().into()));
    assert_eq!(run["host_run_ns"].as_u64(), last["host_run_ns"].parse().ok(), "{how:?}");
    (rows, run)
}

#[test]
fn a_soup_in_several_dispatches_is_counted_once() {
    let place = Place::new();
    place.ok(&["scene", "soup", "--triangles", "1000", "--seed", "3", "-o", "soup.glb"]);
    for device in ["gpu", "cpu"] {
        let how = ["--size", "16x16", "--device", device, "--accelerator", "none", "--schedule", "fused"];
        let (rows, run) = render(&place, "soup.glb", &how);
        // Every ray tests every triangle, in however many dispatches.
        assert_eq!(run["counters"]["triangles_tested"], 256_000, "{device}");
        let fused: Vec<&Row> = rows.iter().filter(|row| row["kernel"] == "fused").collect();
        if device == "gpu" && run["adapter"]["name"].as_str().is_some_and(|name| name.contains("llvmpipe")) {
            let tests: Vec<&str> = fused.iter().map(|row| row["triangles_tested"].as_str()).collect();
            assert_eq!(tests, ["131072", "124928"], "one dispatch allows each ray 512 tests");
        }
    }
}

#[test]
fn counters_and_hits_of_all_samples_are_in_both_files() {
    let place = Place::new();
    let scene = cornell_box();
    for how in [&["--device", "cpu"][..], &["--device", "gpu"], &["--schedule", "fused"], &["--schedule", "first"]] {
        let one = [&["--size", "24x18"], how].concat();
        let (_, single) = render(&place, &scene, &one);
        let (rows, run) = render(&place, &scene, &[&one[..], &["--spp", "5"]].concat());
        assert_eq!((&single["rays"], &run["rays"]), (&432.into(), &(5 * 432).into()));
        // Of a closed box, seen from inside.
        assert_eq!(run["hits"], run["rays"], "{how:?}");
        let samples: Vec<u32> = rows.iter().map(|row| row["sample"].parse().expect("a number")).collect();
        assert!(samples.is_sorted() && samples.first() == Some(&0) && samples.last() == Some(&4), "{samples:?}");
        for sample in 0..5 {
            let own: Vec<&Row> = rows.iter().filter(|row| row["sample"] == sample.to_string()).collect();
            assert_eq!(
                (own[0]["kernel"].as_str(), own.last().map(|row| row["kernel"].as_str())),
                ("generate", Some("accumulate"))
            );
            // About as much as through the pixels' centres.
            let (tests, centre) = (sum(own, "triangles_tested"), single["counters"]["triangles_tested"].as_u64());
            let share = tests as f64 / centre.expect("a number") as f64;
            assert!((0.9..1.1).contains(&share), "{how:?}, sample {sample}: {share}");
        }
    }
    // Around a ball there is nothing.
    place.ok(&["scene", "icosphere", "-o", "ball.glb"]);
    let view = ["--size", "16x16", "--spp", "3", "--eye", "0,0,4", "--look-at", "0,0,0", "--device", "cpu"];
    let (_, run) = render(&place, "ball.glb", &view);
    let hits = run["hits"].as_u64().expect("a number");
    assert!(hits > 0 && hits < 3 * 256, "{hits}");
    let said = place.ok(&[&["render", "ball.glb", "-o", "b.png"], &view[..]].concat()).stderr;
    assert!(said.contains(&format!("rays      768, {hits} hit something\n")), "{said}");
}

#[test]
fn rays_that_leave_a_kernel_enter_another() {
    let place = Place::new();
    let scene = cornell_box();
    for schedule in ["first", "second", "compact", "fused"] {
        let (rows, run) = render(&place, &scene, &["--size", "20x20", "--device", "cpu", "--schedule", schedule]);
        let number = |row: &Row, column: &str| row[column].parse::<u64>().expect("a number");
        // Rays that wait for the kernels of each state: what a pass takes in is what others have sent there.
        assert_eq!(number(&rows[0], "rays_in"), 400, "{schedule}");
        for pair in rows.windows(2).filter(|pair| pair[0]["kernel"] == pair[1]["kernel"]) {
            let stayed = number(&pair[0], "rays_in") - number(&pair[0], "rays_out");
            assert_eq!(number(&pair[1], "rays_in"), stayed, "{schedule}: {pair:?}");
        }
        let last = rows.last().expect("a row");
        assert_eq!((last["kernel"].as_str(), number(last, "rays_out")), ("shade", 400), "{schedule}");
        let loops = schedule == "first" || schedule == "second";
        for row in &rows {
            let is_walk = ["intersect", "traverse_grid"].contains(&&*row["kernel"]);
            assert_eq!(number(row, "iteration") > 0, loops && (is_walk || row["kernel"] == "shade"), "{row:?}");
            assert_eq!((row["clock"].as_str(), row["encode_ns"].as_str()), ("cpu_clock", ""));
        }
        assert_eq!(run["host_run_ns"], sum(&rows, "duration_ns"), "on the CPU, the host's clock is the passes'");
    }
}

#[test]
fn a_gpus_passes_have_the_time_to_record_them() {
    let place = Place::new();
    let (rows, run) = render(&place, &cornell_box(), &["--size", "20x20", "--device", "gpu"]);
    assert!(rows.iter().all(|row| row["encode_ns"].parse::<u64>().is_ok()), "{:?}", rows[0]);
    let host_ns = run["host_run_ns"].as_u64().expect("a number");
    assert!(sum(&rows, "encode_ns") <= host_ns, "recording is a part of what the host does");
    // Drawn passes have rows for their parts; what belongs to the pass is in the last one.
    let drawn = ["--size", "20x20", "--device", "gpu", "--mapping", "fragment", "--schedule", "second"];
    let (parts, _) = render(&place, &cornell_box(), &drawn);
    let whole = parts.iter().filter(|row| !row["rays_in"].is_empty()).count();
    assert!(whole < parts.len() && parts.iter().filter(|row| !row["encode_ns"].is_empty()).count() == whole);
    let passes: std::collections::BTreeSet<&str> = parts.iter().map(|row| row["pass_index"].as_str()).collect();
    assert_eq!(passes.len(), whole);
}

#[test]
fn builds_have_elements_and_no_states() {
    let place = Place::new();
    let build = ["build", &cornell_box(), "--device", "cpu", "--repeats", "3", "--passes-csv", "b.csv", "--quiet"];
    place.ok(&build);
    for row in csv_rows(&place.read("b.csv")) {
        assert_eq!((row["repeat"].as_str(), row["rays_out"].as_str()), ("2", ""), "of the last build: {row:?}");
        // Two digits are sorted by in the first turn of a counted loop.
        let is_of_sort =
            ["histogram", "scatter", "scan_tall", "add_tall"].iter().any(|of| row["kernel"].starts_with(of));
        assert_eq!(row["iteration"], u32::from(is_of_sort).to_string(), "{row:?}");
        assert!(row["rays_in"].parse::<u64>().is_ok(), "{row:?}");
    }
}
