//! The sections of `raystep report` on passes, offset, scale, grid resolution, samples, strategies and photon maps, from the
//! built binary.

use std::collections::{BTreeMap, BTreeSet};

use crate::common::{Place, scene};

type Row = BTreeMap<String, String>;

fn rows(place: &Place, file: &str) -> Vec<Row> {
    let bytes = place.read(file);
    let mut reader = csv::ReaderBuilder::new().flexible(false).from_reader(bytes.as_slice());
    reader.deserialize().map(|row| row.unwrap_or_else(|e| panic!("{file}: {e}"))).collect()
}

fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} is no number: {row:?}"))
}

fn is(row: &&Row, wanted: &[(&str, &str)]) -> bool {
    wanted.iter().all(|(column, value)| row[*column] == *value)
}

/// Whether a value lies between the ends of its interval.
fn is_within(row: &Row, column: &str) -> bool {
    let [low, middle, high] = ["_low", "", "_high"].map(|end| number(row, &format!("{column}{end}")));
    low <= middle && middle <= high
}

fn report(place: &Place, file: &str, more: &[&str]) -> String {
    let file = scene(file).display().to_string();
    place.ok(&[&["report", &file, "--quick", "--device", "cpu", "--section"], more].concat()).stderr
}

#[test]
fn passes_end_in_order_and_resolve_all_rays() {
    let place = Place::new();
    report(&place, "cornell-box.gltf", &["resolved", "-o", "out", "--quiet"]);
    let rows = rows(&place, "out/resolved.csv");
    let ways: BTreeSet<&str> = rows.iter().map(|r| r["configuration"].as_str()).collect();
    assert_eq!(ways.len(), 11, "{ways:?}");
    for way in ways {
        let of: Vec<&Row> = rows.iter().filter(|r| r["configuration"] == way).collect();
        let grows = |column: &str| of.windows(2).all(|w| number(w[0], column) <= number(w[1], column));
        assert!(grows("pass_end_ns") && grows("resolved_rays") && grows("resolved_wrong_rays"), "{way:?}");
        let last = of.last().expect("a row");
        assert_eq!((last["is_last"].as_str(), &last["resolved_rays"]), ("true", &last["rays"]), "{way:?}");
        assert!(last["numerics"] != "robust" || last["resolved_wrong_rays"] == "0", "{last:?}");
    }
}

#[test]
fn errors_far_away_are_of_the_same_rays_and_strata_are_apart() {
    let place = Place::new();
    report(&place, "cornell-box.gltf", &["moved,scaled", "-o", "out", "--quiet"]);
    for (name, column, places) in [("moved", "offset_extents", 7), ("scaled", "scale", 9)] {
        let rows = rows(&place, &format!("out/{name}.csv"));
        let strata: BTreeSet<&str> = rows.iter().map(|r| r["stratum"].as_str()).collect();
        assert_eq!(strata.into_iter().collect::<Vec<_>>(), ["along_edges", "anywhere", "corners", "edge_middles"]);
        assert_eq!(rows.len(), places * 2 * 4, "{name}");
        for row in &rows {
            assert!(row["numerics"] != "robust" || row["wrong_rays"] == "0", "{row:?}");
            assert!(is_within(row, "wrong_per_million") && !row[column].is_empty(), "{row:?}");
            assert!(number(row, "arithmetic_error_by_bound_largest") <= 1.0, "{row:?}");
            if row["stratum"] != "anywhere" {
                assert!(row["forward_error_extents_largest"].is_empty() && row["changed_rays"].is_empty(), "{row:?}");
                continue;
            }
            assert!(is_within(row, "changed_per_million"), "{row:?}");
            assert!(row["numerics"] != "robust" || row["beyond_forward_bound_rays"] == "0", "{row:?}");
            // Where nothing is rounded, both are the same error.
            let [arithmetic, forward] =
                ["arithmetic", "forward"].map(|of| number(row, &format!("{of}_error_extents_largest")));
            assert!(name != "scaled" || row["scale"] != "1" || arithmetic == forward, "{row:?}");
        }
        let far = |r: &&Row| is(r, &[("offset_extents", "1000000"), ("stratum", "anywhere"), ("numerics", "robust")]);
        if name == "moved" {
            let far = rows.iter().find(far).expect("a row");
            assert!(
                number(far, "forward_error_extents_median") > 100.0 * number(far, "arithmetic_error_extents_median")
            );
        }
    }
}

#[test]
fn a_resolution_is_selected_once_and_wrong_rays_of_all_pixels_have_no_interval() {
    let place = Place::new();
    report(&place, "cornell-box.gltf", &["grid", "-o", "out", "--quiet"]);
    let rows = rows(&place, "out/grid.csv");
    for column in ["is_selected", "is_automatic"] {
        assert_eq!(rows.iter().filter(|r| r[column] == "true").count(), 1, "{column}");
    }
    let automatic = rows.iter().find(|r| r["is_automatic"] == "true").expect("the automatic grid");
    for row in &rows {
        // All pixels' centres: a census.
        assert_eq!((row["wrong_rays"].as_str(), row["wrong_per_million_high"].as_str()), ("0", ""), "{row:?}");
        assert!(
            number(row, "build_s_min") <= number(row, "build_s")
                && number(row, "build_s") <= number(row, "build_s_max")
        );
        assert_eq!((row["builds"].as_str(), row["build_s_low"].as_str()), ("3", ""), "too few builds for an interval");
        assert!(is_within(row, "time_ratio") && row["ratio_to"] == automatic["configuration"], "{row:?}");
        assert_eq!(row["held_out_time_ratio"].is_empty(), row["is_selected"] != "true", "{row:?}");
        assert!(row["paid_off_rays"].is_empty() || is_within(row, "paid_off_rays"), "{row:?}");
    }
    assert_eq!(number(automatic, "time_ratio"), 1.0);
}

#[test]
fn times_of_other_rays_are_not_compared() {
    let place = Place::new();
    // Testing 994 triangles for each of 20,000 rays is not affordable.
    let said = report(&place, "teapot.glb", &["grid", "--size", "200x100", "-o", "out"]);
    assert!(said.contains("the number of rays after which a structure pays off is unknown"), "{said}");
    let rows = rows(&place, "out/grid.csv");
    let none = rows.iter().find(|r| r["accelerator"] == "none").expect("a row");
    assert!(number(none, "rays") < 20_000.0 && none["time_ratio"].is_empty(), "{none:?}");
    assert!(rows.iter().all(|r| r["paid_off_rays"].is_empty() && !r["median_ns"].is_empty()));
}

#[test]
fn slopes_have_an_interval_over_seeds_and_none_over_few() {
    let place = Place::new();
    for (folder, seeds) in [("ten", "10"), ("three", "3")] {
        report(&place, "cornell-box.gltf", &["samples", "--seeds", seeds, "-o", folder, "--quiet"]);
        let rows = rows(&place, &format!("{folder}/samples.csv"));
        for sampler in ["sobol", "random"] {
            let of = |quantity: &str| {
                let wanted = [("quantity", quantity), ("sampler", sampler), ("pixels", "all")];
                rows.iter().filter(move |row| is(row, &wanted)).collect::<Vec<_>>()
            };
            let errors = of("median_error");
            assert_eq!(errors[0]["samples"], "2", "measurements start at two samples");
            assert!(errors.len() > 4 && number(errors[0], "error") > number(errors[errors.len() - 1], "error"));
            assert_eq!(of("error").len(), errors.len() * seeds.parse::<usize>().expect("a number"));
            assert_eq!(of("slope").iter().map(|r| &r["seed"]).collect::<BTreeSet<_>>().len().to_string(), seeds);
            let slope = of("median_slope")[0];
            assert_eq!(slope["seeds"], seeds);
            assert_eq!(slope["slope_low"].is_empty(), seeds == "3", "{slope:?}");
            assert!(seeds == "3" || is_within(slope, "slope"), "{slope:?}");
            let expected = if sampler == "random" { -0.6..-0.4 } else { -1.2..-0.6 };
            assert!(expected.contains(&number(slope, "slope")), "{slope:?}");
        }
        let time = rows.iter().find(|row| is(row, &[("quantity", "time"), ("sampler", "random")])).expect("a row");
        assert!(is_within(time, "time_ratio") && number(time, "runs") >= 6.0, "{time:?}");
    }
    place.fails(2, "--seeds", &["report", "x.glb", "-o", "no", "--seeds", "0"]);
}

#[test]
fn strategies_are_compared_where_a_surface_emits_light() {
    let place = Place::new();
    place.ok(&["scene", "cornell-lamp", "-o", "lit.glb", "--quiet"]);
    let wanted = ["--quick", "--device", "cpu", "--section", "strategies", "--size", "16x16", "--seeds", "6"];
    place.ok(&[&["report", "lit.glb", "-o", "out", "--quiet"], &wanted[..]].concat());
    let rows = rows(&place, "out/strategies.csv");
    let of = |quantity: &str, strategy: &str| {
        let wanted = [("quantity", quantity), ("path_strategy", strategy)];
        rows.iter().filter(move |row| is(row, &wanted)).collect::<Vec<_>>()
    };
    let last = |strategy: &str| number(of("median_error", strategy).last().expect("a row"), "error");
    for strategy in ["mis", "light", "bsdf"] {
        let medians = of("median_error", strategy);
        assert_eq!(medians.iter().map(|row| row["samples"].as_str()).collect::<Vec<_>>(), ["2", "4", "8", "16", "32"]);
        assert_eq!(of("error", strategy).len(), 6 * 5);
        for column in ["error", "flip"] {
            assert!(medians.windows(2).all(|of| number(of[0], column) > number(of[1], column)), "{strategy}: {column}");
            assert!(medians.iter().all(|row| is_within(row, column) && row["seeds"] == "6"), "{strategy}: {column}");
        }
        assert!(medians.iter().all(|row| row["is_fitted"] == "true"), "{strategy}: {medians:?}");
        let times = of("time", strategy);
        assert_eq!(
            times.iter().map(|row| row["accelerator"].as_str()).collect::<Vec<_>>(),
            ["bvh", "grid", "irregular"]
        );
        for time in times {
            let is_of = |row: &&&Row| row["accelerator"] == time["accelerator"];
            let convergence = of("convergence", strategy);
            let of_structure: Vec<_> = convergence.iter().filter(is_of).collect();
            assert_eq!(of_structure.len(), medians.len());
            for (row, median) in of_structure.iter().zip(&medians) {
                assert_eq!(row["error"], median["error"], "the image does not depend on the structure");
                let expected = number(time, "ns_per_sample") * number(row, "samples");
                assert!((number(row, "image_ns") / expected - 1.0).abs() < 1e-4, "{row:?}");
                assert_eq!(row["same_error_time_ratio"].is_empty(), strategy == "mis", "{row:?}");
                assert!(strategy == "mis" || is_within(row, "same_error_time_ratio"), "{row:?}");
            }
        }
    }
    // A small lamp is rarely hit by chance.
    assert!(last("bsdf") > 2.0 * last("mis") && last("light") < 2.0 * last("mis"));
    let page = String::from_utf8(place.read("out/index.html")).expect("text");
    assert!(page.contains("Error over time, by strategy") && page.contains("FLIP over time, by strategy"));

    report(&place, "cornell-box.gltf", &["strategies", "-o", "none", "--quiet"]);
    assert!(self::rows(&place, "none/strategies.csv").is_empty());
    let page = String::from_utf8(place.read("none/index.html")).expect("text");
    assert!(page.contains("No surface of the scene emits light"));
}

#[test]
fn photons_are_compared_with_paths_where_a_surface_emits_light() {
    let place = Place::new();
    place.ok(&["scene", "cornell-lamp", "-o", "lit.glb", "--quiet"]);
    let wanted = ["--quick", "--device", "cpu", "--section", "photon-maps", "--size", "12x12", "--seeds", "6"];
    place.ok(&[&["report", "lit.glb", "-o", "out", "--quiet", "--seconds", "200"], &wanted[..]].concat());
    let rows = rows(&place, "out/photon_maps.csv");
    let ways: BTreeSet<&str> = rows.iter().map(|row| row["estimator"].as_str()).collect();
    assert_eq!(ways.into_iter().collect::<Vec<_>>(), ["path", "photons direct", "photons final"]);
    for (way, samples) in [("path", 32u32), ("photons direct", 16), ("photons final", 16)] {
        let of = |quantity: &str| {
            let wanted = [("quantity", quantity), ("estimator", way)];
            rows.iter().filter(move |row| is(row, &wanted)).collect::<Vec<_>>()
        };
        let (together, errors, times) = (of("convergence"), of("error"), of("time"));
        assert_eq!(
            (together.len(), errors.len(), times.len()),
            (samples.ilog2() as usize, 6 * together.len(), 1),
            "{way}"
        );
        for row in &together {
            assert_eq!(row["photons_emitted"], if way == "path" { "" } else { "2000" }, "{row:?}");
            for column in ["error", "flip", "bias_squared"] {
                assert!(is_within(row, column), "{column}: {row:?}");
            }
            let expected = number(times[0], "ns_per_sample") * number(row, "samples");
            assert!((number(row, "image_ns") / expected - 1.0).abs() < 1e-4, "{row:?}");
            // The parts add up to the mean square difference from the reference, its own error included.
            let squares = errors.iter().filter(|error| error["samples"] == row["samples"]);
            let squares: Vec<f64> = squares.map(|error| number(error, "rmse").powi(2)).collect();
            let whole = squares.iter().sum::<f64>() / squares.len() as f64;
            let own = number(row, "reference_rmse").powi(2);
            let parts = number(row, "bias_squared") + number(row, "variance") + own;
            assert!(squares.len() == 6 && (parts / whole - 1.0).abs() < 1e-4, "{parts} of {whole}: {row:?}");
        }
        assert!(together.windows(2).all(|of| number(of[0], "variance") > number(of[1], "variance")), "{way}");
        // What is left of a path's error is chance.
        let (first, last) = (together[0], together[together.len() - 1]);
        assert!(way != "path" || number(last, "bias_squared").abs() < 0.25 * number(last, "variance"), "{last:?}");
        assert!(number(last, "error") < number(first, "error"), "{way}");
    }
    let page = String::from_utf8(place.read("out/index.html")).expect("text");
    assert!(page.contains("Error over time, paths and photons") && page.contains("Bias and deviation over time"));

    report(&place, "cornell-box.gltf", &["photon-maps", "-o", "none", "--quiet"]);
    assert!(self::rows(&place, "none/photon_maps.csv").is_empty());
}
