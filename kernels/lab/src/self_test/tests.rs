//! The lists and the table; `tests/tests/self_test.rs` runs the steps on a device.

use std::collections::BTreeSet;

use raystep_kernels::programs;

use super::*;

/// A finding of the first step of a group.
fn found(results: &mut Results, steps: &[Step], group: Group, finding: Finding) {
    let step = steps.iter().position(|step| step.group == group).expect("every group has steps");
    results.add(step, Outcome { findings: vec![finding], seconds: 0.5, ..Outcome::default() });
}

fn row(results: &Results, group: Group, name: &str) -> Row {
    results.rows().into_iter().find(|row| row.group == group && row.name == name).expect("a row")
}

#[test]
fn every_kernel_of_every_program_has_a_check_and_every_step_serves_checks_that_exist() {
    let checks = checks();
    let names: BTreeSet<_> = checks.iter().map(|check| (check.group, check.name)).collect();
    assert_eq!(names.len(), checks.len(), "names are unique within a group");
    for program in programs::all() {
        let group = if program.course().is_some() { Group::Tracing } else { Group::Building };
        for kernel in program.kernels() {
            assert!(names.contains(&(group, kernel.info().name)), "{:?}", kernel.info().name);
            if group == Group::Tracing && passes::is_drawn(&kernel) {
                assert!(names.contains(&(Group::Drawing, kernel.info().name)), "{:?}", kernel.info().name);
            }
        }
    }
    let steps = steps();
    for step in &steps {
        assert!(!step.checks.is_empty(), "{}", step.name);
        assert!(step.checks.iter().all(|check| names.contains(&(step.group, check))), "{}", step.name);
    }
    let of = |group| steps.iter().filter(move |step| step.group == group).map(|step| &step.name);
    for group in Group::ALL {
        let names: BTreeSet<_> = of(group).collect();
        assert!(!names.is_empty() && names.len() == of(group).count(), "{group:?} has steps of one name each");
        assert!(checks.iter().any(|check| check.group == group), "{group:?}");
    }
    assert!(steps.is_sorted_by_key(|step| step.group), "steps run in the order of the table");
    assert!(checks.iter().all(|check| check.name.chars().count() <= 20 && !check.shows.ends_with('.')));
}

#[test]
fn a_check_is_right_only_if_all_of_its_steps_were_run_and_wrong_by_any_of_them() {
    let steps = steps();
    let name = passes_check();
    let mut results = Results::new(&steps);
    let of =
        |verdict, says: &str| Finding::new(Group::Building, name, verdict, says).counting(&[("configurations", 1)]);
    let building: Vec<usize> = (0..steps.len()).filter(|&i| steps[i].group == Group::Building).collect();
    for &step in &building[1..] {
        results.add(step, Outcome { findings: vec![of(Verdict::Right, "")], seconds: 0.25, ..Outcome::default() });
    }
    results.skip(building[0], "time");
    let partial = row(&results, Group::Building, name);
    assert_eq!((partial.verdict, partial.says.as_str()), (Verdict::NotRun, "1 of 6 runs are left out: time"));
    assert_eq!(partial.counts["configurations"], 5);
    results.add(building[0], Outcome { findings: vec![of(Verdict::Right, "")], ..Outcome::default() });
    assert_eq!(row(&results, Group::Building, name).verdict, Verdict::Right);
    assert_eq!(results.seconds(Group::Building), 1.25);
    assert_eq!(results.usual_seconds(Group::Building), Some(1.25 / 6.0));
    results.note(Group::Building, name, Verdict::Wrong, "broken".into());
    let wrong = row(&results, Group::Building, name);
    assert_eq!(
        (wrong.verdict, wrong.says.as_str(), &wrong.details[..]),
        (Verdict::Wrong, "broken", &["broken".to_owned()][..])
    );
    // A kernel that no run has reached is not right.
    let missing = row(&results, Group::Building, "divide");
    assert_eq!((missing.verdict, missing.says.as_str()), (Verdict::NotRun, "time"));
    let totals = results.totals();
    assert_eq!((totals.checks, totals.wrong, totals.right), (checks().len(), 1, 0));
    assert_eq!(totals.not_run, totals.checks - 1);
}

fn passes_check() -> &'static str {
    steps().iter().find(|step| step.group == Group::Building).expect("steps").checks[0]
}

#[test]
fn the_table_is_at_most_100_columns_wide_and_ends_with_the_totals() {
    let steps = steps();
    let mut results = Results::new(&steps);
    let message = format!("a message of a driver: {} and {}", "word ".repeat(80), "x".repeat(300));
    let failed = Finding::new(Group::Adapter, LIMITS, Verdict::Wrong, "").wrong_by(vec![message.clone()]);
    found(&mut results, &steps, Group::Adapter, failed);
    let walk = Finding::new(Group::Tracing, "walk", Verdict::Right, "").counting(&[
        ("passes", 1),
        ("components", 1_234_567),
        ("tolerated", 5),
        ("undecided", 0),
    ]);
    found(&mut results, &steps, Group::Tracing, walk);
    let shown = text(&results);
    let longest = shown.lines().map(|line| line.chars().count()).max();
    assert_eq!(longest, Some(100), "{shown}");
    assert!(shown.lines().all(|line| line == line.trim_end()));
    assert!(
        shown.contains("walk                1 pass, 1,234,567 values, 5 differ by rounding, 0 undecided\n"),
        "{shown}"
    );
    let Totals { checks, not_run, .. } = results.totals();
    assert!(shown.ends_with(&format!("\n{checks} checks: 1 right, 1 wrong, {not_run} not run\n")), "{shown}");
    assert!(Group::ALL.iter().all(|group| shown.contains(&format!("{} (", group.name()))));
    assert!(!shown.contains(&message), "a long message is cut");
    assert!(details(&results).contains(&message), "and complete among the details");
}

#[test]
fn files_of_several_steps_have_one_head() {
    let mut results = Results::new(&steps());
    for (step, rows) in [(0, "a,b\r\n1,2\r\n"), (1, "a,b\r\n3,4\r\n5,6\r\n")] {
        let files = vec![("x.csv".to_owned(), rows.to_owned())];
        results.add(step, Outcome { files, ..Outcome::default() });
    }
    assert_eq!(results.files()["x.csv"], "a,b\r\n1,2\r\n3,4\r\n5,6\r\n");
}
