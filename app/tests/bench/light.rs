//! `raystep bench --integrators`: light beside hits.

use std::collections::BTreeSet;

use raystep_kernels::options::Integrator;
use serde_json::Value;

use super::agree::{passes_agree, runs_agree};
use super::{Row, bench, cornell_box, is_near, number, rows};
use crate::common::Place;

/// Columns that benchmarks from before light lack.
const LATER: [&str; 5] = ["integrator", "samples_per_s", "secondary_rays", "shadow_rays", "integrator_options"];

#[test]
fn light_is_measured_beside_hits_and_its_rays_are_counted() {
    let place = Place::new();
    let file = cornell_box();
    let all: Vec<&str> = Integrator::ALL.iter().map(|integrator| integrator.name()).collect();
    let ways = ["--accelerators", "grid,bvh", "--schedules", "second,compact,fused"];
    let names = all.join(",");
    let what = ["--integrators", &names, "--photons", "500", "-o", "out"];
    let outcome = place.ok(&bench(&file, &[&ways[..], &what].concat()));
    let (_, summary) = rows(&place.read("out/summary.csv"));
    assert_eq!(summary.len(), 6 * all.len());
    passes_agree(&place, &summary);
    runs_agree(&place, "out", &summary);
    let (_, passes) = rows(&place.read("out/passes.csv"));
    for (place, row) in summary.iter().enumerate() {
        assert_eq!(row["integrator"], all[place % all.len()]);
        let of_row: Vec<&Row> = passes.iter().filter(|pass| pass["configuration"] == row["configuration"]).collect();
        assert!(of_row.iter().all(|pass| pass["integrator"] == row["integrator"]), "{row:?}");
        let rays = number(row, "rays");
        let per_s = |rays: f64| rays / number(row, "median_ns") * 1e9;
        assert!(is_near(number(row, "samples_per_s"), per_s(rays)), "{row:?}");
        // By the passes of the kernels that begin the walks of rays to lights; no walk takes more than one dispatch here.
        let by = |kernels: [&str; 2]| -> f64 {
            let of_kernel = of_row.iter().filter(|pass| kernels.contains(&pass["kernel"].as_str()));
            of_kernel.map(|pass| number(pass, "rays_in")).sum()
        };
        let begun = by(["shadow_setup", "shadow_fused"]);
        if row["integrator"] == "local" {
            assert_eq!([&row["secondary_rays"], &row["shadow_rays"]], ["", ""], "{row:?}");
            assert!(begun == 0.0 && is_near(number(row, "rays_per_s"), per_s(rays)), "{row:?}");
            continue;
        }
        let (secondary, shadow) = (number(row, "secondary_rays"), number(row, "shadow_rays"));
        // One kernel follows whole paths, and its passes do not tell.
        let is_whole = of_row.iter().any(|pass| pass["kernel"] == "fused_path");
        assert!((shadow == begun || is_whole) && shadow > 100.0, "{row:?}");
        assert!(is_near(number(row, "rays_per_s"), per_s(rays + secondary + shadow)), "{row:?}");
        if row["integrator"] == "shadows" {
            assert!(secondary == 0.0 && shadow <= rays, "there is one light: {row:?}");
        }
        let of_photons = by(["photon_setup", "photon_fused"]);
        let has_photons = row["integrator"] == "photons";
        assert_eq!(has_photons, row["integrator_options"].contains(" photons=500 photon_map=scan "), "{row:?}");
        // As they are emitted and at each bounce; those that are emitted fill whole rows.
        assert!(if has_photons { of_photons > 504.0 } else { of_photons == 0.0 }, "{row:?}");
        assert!(secondary >= of_photons, "{row:?}");
        // Every way finds the same.
        let first = &summary[place % all.len()];
        for column in ["hits_hash", "secondary_rays", "shadow_rays"] {
            assert_eq!(row[column], first[column], "{column}: {row:?}");
        }
    }
    for column in ["  integrator  ", "  Msample/s  ", "  shadow rays  "] {
        assert!(outcome.stdout.contains(column), "{column}: {}", outcome.stdout);
    }
    let run: Value = serde_json::from_slice(&place.read("out/run.json")).expect("JSON");
    assert_eq!((&run["options"]["integrators"], &run["options"]["photons"]), (&Value::from(all), &500.into()));
}

/// Without the option nothing is new but columns at the end, and files without those are read.
#[test]
fn hits_are_measured_as_before_and_compared_with_earlier_files() {
    let place = Place::new();
    let file = cornell_box();
    let outcome = place.ok(&bench(&file, &["-o", "before"]));
    assert!(!outcome.stdout.contains("integrator") && !outcome.stdout.contains("Msample"), "{}", outcome.stdout);
    let (names, before) = rows(&place.read("before/summary.csv"));
    assert_eq!((names[names.len() - LATER.len()..].to_vec(), before.len()), (LATER.map(String::from).to_vec(), 1));
    let kernels = |folder: &str| -> BTreeSet<String> {
        let (_, passes) = rows(&place.read(&format!("{folder}/passes.csv")));
        passes.iter().map(|pass| pass["kernel"].clone()).collect()
    };
    assert!(!kernels("before").contains("shade"), "shading is excluded: {:?}", kernels("before"));

    let mut old = csv::Writer::from_writer(Vec::new());
    let is_old = |name: &&String| !LATER.contains(&name.as_str());
    old.write_record(names.iter().filter(is_old)).expect("memory");
    old.write_record(names.iter().filter(is_old).map(|name| &before[0][name])).expect("memory");
    std::fs::write(place.path("before/summary.csv"), old.into_inner().expect("memory")).expect("a file");
    // So slow that times never fail it.
    let gate = ["--baseline", "before", "--at-most", "1000", "-o", "now"];
    let outcome = place.ok(&bench(&file, &gate));
    assert!(outcome.stdout.contains("Pass: at most 1000 times as slow as before (1 row)"), "{}", outcome.stdout);
    let light = ["--integrators", "shadows", "--baseline", "before", "-o", "light"];
    let outcome = place.ok(&bench(&file, &light));
    let note = "note: before has no match for cornell-box 16x12 primary, grid compact robust shadows steps_per_pass=8";
    assert!(outcome.stderr.contains(note), "{}", outcome.stderr);
    assert!(kernels("light").is_superset(&BTreeSet::from(["illuminate".into(), "shadow_walk".into()])));
}

#[test]
fn light_of_other_rays_than_an_images_is_refused() {
    let place = Place::new();
    let file = cornell_box();
    std::fs::write(place.path("rays.f32"), [0; 24]).expect("a file");
    let wanted = "--integrators shadows: light is measured in an image, by primary rays: omit --rays and --rays-file";
    for rays in [["--rays", "primary,bounce"], ["--rays", "shadow"], ["--rays", "random"], ["--rays-file", "rays.f32"]]
    {
        place.fails(2, wanted, &bench(&file, &[&rays[..], &["--integrators", "local,shadows", "-o", "out"]].concat()));
    }
    let idle = "--photons 500 applies to --integrator photons, not to local: omit it";
    place.fails(2, idle, &bench(&file, &["--photons", "500", "-o", "out"]));
    place.fails(2, "--integrators sun: expected local", &bench(&file, &["--integrators", "sun", "-o", "out"]));
}
