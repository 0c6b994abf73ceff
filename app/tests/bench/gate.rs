//! `raystep bench --at-most`, against another build and against an earlier benchmark.

use std::path::Path;

use serde_json::Value;

use super::agree::runs_agree;
use super::{cornell_box, rows};
use crate::common::Place;

/// This build.
const THIS: &str = env!("CARGO_BIN_EXE_raystep");

/// A small benchmark on the CPU, with further arguments.
fn bench<'a>(scene: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["bench", scene, "--sizes", "16x12", "--device", "cpu", "--warmups", "1"], more].concat()
}

fn json(place: &Place, name: &str) -> Value {
    serde_json::from_slice(&place.read(name)).expect("JSON")
}

/// Writes an earlier benchmark anew, with some fields changed in all of its rows.
fn edit(place: &Place, from: &str, to: &str, file: &str, change: impl Fn(&str, &str) -> String) {
    std::fs::create_dir_all(place.path(to)).expect("a folder");
    for name in ["summary.csv", "runs.csv"] {
        let bytes = place.read(&format!("{from}/{name}"));
        let (names, rows) = rows(&bytes);
        let mut out = csv::Writer::from_writer(Vec::new());
        out.write_record(&names).expect("memory");
        for row in &rows {
            let value = |column: &String| match name == file {
                true => change(column, &row[column]),
                false => row[column].clone(),
            };
            out.write_record(names.iter().map(value)).expect("memory");
        }
        std::fs::write(place.path(to).join(name), out.into_inner().expect("memory")).expect("a file");
    }
}

#[test]
fn a_build_against_itself_writes_both_builds_rows_and_never_fails() {
    let place = Place::new();
    let file = cornell_box();
    let what = ["--accelerators", "grid,bvh", "--repeats", "16", "--against", THIS, "--at-most", "1000", "-o", "out"];
    let outcome = place.ok(&bench(&file, &what));
    assert!(outcome.stdout.contains("Pass: at most 1000 times as slow as "), "{outcome:?}");
    let (_, summary) = rows(&place.read("out/summary.csv"));
    let ids: Vec<_> = summary.iter().map(|r| (r["configuration"].as_str(), r["build"].as_str())).collect();
    assert_eq!(ids, [("0", "this"), ("1", "this"), ("other-0", "other"), ("other-1", "other")]);
    assert_eq!((summary[0]["ratio_to"].as_str(), summary[2]["ratio_to"].as_str()), ("other-0", ""));
    assert_eq!(summary[0]["hits_hash"], summary[3]["hits_hash"]);
    assert!(!summary[0]["tests_per_ray"].is_empty() && summary[0]["passes"] != "0", "{:?}", summary[0]);
    runs_agree(&place, "out", &summary);
    let gate = json(&place, "out/gate.json");
    // Sixteen rounds in eight sittings, of which the first look takes two.
    let rounds = gate["rounds"].as_u64().expect("rounds");
    assert!(rounds <= 16, "{gate}");
    assert_eq!((&gate["verdict"], gate["rows"].as_array().map(Vec::len)), (&"pass".into(), Some(2)));
    let markdown = String::from_utf8(place.read("out/gate.md")).expect("UTF-8");
    assert!(
        markdown.starts_with("### Pass: at most 1000 times as slow as ")
            && markdown.contains("| configuration | ratio |")
    );
    assert!(!place.path("out/passes.csv").exists());
    // Rounds are paired: every round has both builds of both rows.
    let (_, runs) = rows(&place.read("out/runs.csv"));
    assert_eq!(runs.len() as u64, 4 * rounds);

    // Below any possible ratio, the same build is too slow: the limit was read, and the code is that of failing.
    let twice = ["--repeats", "24", "--against", THIS, "--at-most", "0.01", "-o", "slow"];
    let outcome = place.run(&bench(&file, &twice));
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains("error: 1 of 1 row more than 0.01 times as slow as "), "{outcome:?}");
    assert!(outcome.stderr.contains("fail: cornell-box 16x12 primary, grid compact robust"), "{outcome:?}");
    assert_eq!(json(&place, "slow/gate.json")["verdict"], "fail");

    // Three rounds decide nothing.
    let few = ["--repeats", "3", "--against", THIS, "--at-most", "1.05", "-o", "few"];
    let outcome = place.run(&bench(&file, &few));
    assert_eq!(outcome.code, Some(3), "{outcome:?}");
    assert!(outcome.stderr.contains("undecided: too noisy for 1 of 1 row; "), "{outcome:?}");
    assert_eq!(json(&place, "few/gate.json")["verdict"], "undecided");
}

/// A build that answers as this one, but for one change of its first answer by `sed`.
#[cfg(unix)]
fn changed_build(place: &Place, name: &str, change: &str) -> String {
    use std::os::unix::fs::PermissionsExt as _;
    let path = place.path(name);
    std::fs::write(&path, format!("#!/bin/sh\n'{THIS}' \"$@\" | sed -u '{change}'\n")).expect("a script");
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).expect("permissions");
    path.display().to_string()
}

#[test]
#[cfg(unix)]
fn changed_results_and_other_programs_fail_by_name() {
    let place = Place::new();
    let file = cornell_box();
    let cases = [
        (r#"s/"hits_hash":"[^"]*"/"hits_hash":"x"/"#, "other hits, of as many rays (192)"),
        (r#"s/"tests_per_ray":[0-9.][0-9.]*/"tests_per_ray":0.5/"#, "tests a ray "),
        (r#"s/"adapter":"cpu"/"adapter":"fast"/"#, "measured on cpu, before on fast"),
        (r#"s/"schedule":"compact"/"schedule":"fused"/"#, "has no such row"),
    ];
    for (i, (change, wanted)) in cases.into_iter().enumerate() {
        let (build, folder) = (changed_build(&place, &format!("build-{i}"), change), format!("out-{i}"));
        let what = ["--repeats", "8", "--against", &build, "--at-most", "1000", "-o", &folder];
        let outcome = place.run(&bench(&file, &what));
        assert_eq!(outcome.code, Some(1), "{outcome:?}");
        let failures: Vec<_> = outcome.stderr.lines().filter(|line| line.starts_with("fail: ")).collect();
        assert!(failures.iter().any(|line| line.contains(wanted)), "{wanted}: {outcome:?}");
        let rounds = json(&place, &format!("{folder}/gate.json"))["rounds"].as_u64();
        assert!(rounds <= Some(2), "what has failed is not timed to the end: {rounds:?}");
    }
    let against = |binary: &str| ["--against", binary, "--at-most", "1.05", "-o", "none"].map(str::to_owned);
    let old = "does not speak version 1 of the protocol of 'bench --against'";
    for (binary, wanted) in [("/bin/true", old), ("/bin/echo", old), ("nowhere", "cannot start nowhere: No such file")]
    {
        let arguments = against(binary);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        place.fails(1, wanted, &bench(&file, &arguments));
    }
}

#[test]
fn a_baseline_fails_by_hits_and_counts_and_is_undecided_within_the_drift() {
    let place = Place::new();
    let file = cornell_box();
    let before = ["--accelerators", "grid,bvh", "--repeats", "20"];
    place.ok(&bench(&file, &[&before[..], &["-o", "before"]].concat()));
    let gate = |baseline: &str, at_most: &str, folder: &str| {
        let compare = ["--baseline", baseline, "--at-most", at_most, "-o", folder];
        place.run(&bench(&file, &[&before[..], &compare].concat()))
    };
    let outcome = gate("before", "1.0001", "within");
    assert_eq!(outcome.code, Some(3), "{outcome:?}");
    assert!(outcome.stderr.contains("use --against, or a larger --at-most"), "{outcome:?}");
    assert!(outcome.stdout.contains("1.0001 does not exceed that, so times are not judged"), "{outcome:?}");

    // No drift is as large as 1000, and no build as much slower.
    assert_eq!(gate("before", "1000", "wide").code, Some(0));
    assert!(place.path("wide/passes.csv").exists() && place.path("wide/gate.md").exists());
    edit(&place, "before", "faster", "runs.csv", |column, value| match column {
        "time_ns" => "1".into(),
        _ => value.to_owned(),
    });
    let outcome = gate("faster", "1000", "slow");
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stderr.contains("error: 2 of 2 rows more than 1000 times as slow as faster"), "{outcome:?}");

    for (column, wanted) in [
        ("hits_hash", "other hits, of as many rays (192)"),
        ("cells_per_ray", "cells a ray "),
        ("passes", "passes, before 7"),
        ("scene_hash", "another scene: fnv1a64:"),
        ("adapter", "measured on cpu, before on 7"),
        ("schedule", "before has no such row"),
    ] {
        let folder = format!("by-{column}");
        let changed = place.path("changed");
        if Path::new(&changed).exists() {
            std::fs::remove_dir_all(&changed).expect("a folder");
        }
        edit(&place, "before", "changed", "summary.csv", |name, value| match name == column {
            true => "7".into(),
            false => value.to_owned(),
        });
        let outcome = gate("changed", "1000", &folder);
        assert_eq!(outcome.code, Some(1), "{column}: {outcome:?}");
        let wanted = wanted.replace("before has", "changed has");
        assert_eq!(
            outcome.stderr.lines().filter(|l| l.starts_with("fail: ") && l.contains(&wanted)).count(),
            2,
            "{outcome:?}"
        );
    }
    // Without a limit nothing fails, and changed hits are named.
    edit(&place, "before", "changed", "summary.csv", |name, value| match name {
        "hits_hash" => "7".into(),
        _ => value.to_owned(),
    });
    let outcome = place.ok(&bench(&file, &[&before[..], &["--baseline", "changed", "-o", "shown"]].concat()));
    assert_eq!(outcome.stderr.matches("other hits than in changed (192 and 192 rays").count(), 2, "{outcome:?}");
    assert!(!place.path("shown/gate.json").exists());
}

#[test]
fn a_limit_needs_a_comparison_and_a_comparison_its_limit() {
    let place = Place::new();
    let file = cornell_box();
    let cases: [(&str, &[&str]); 4] = [
        ("--at-most needs a build to compare with", &["--at-most", "1.05"]),
        ("--against needs a limit", &["--against", THIS]),
        ("--at-most 0: expected a ratio of times", &["--at-most", "0", "--against", THIS]),
        ("--baseline", &["--at-most", "2", "--against", THIS, "--baseline", "x"]),
    ];
    for (wanted, arguments) in cases {
        place.fails(2, wanted, &bench(&file, &[arguments, &["-o", "out"]].concat()));
    }
}
