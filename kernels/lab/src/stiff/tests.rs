//! Families on the CPU: what is kept, stopped and reported.

use std::cell::RefCell;
use std::ops::ControlFlow;

use pollster::block_on;
use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::{Device, Options, Renderer};

use super::*;
use crate::machine::now_ns;
use crate::reporter::Silent;

static SMALL: Family = Family {
    name: "layers",
    title: "",
    what: "",
    parameter: "copies",
    points: &[1.0, 2.0],
    stratum: "edges",
    integrator: Integrator::Local,
    max_depth: |_| MAX_DEPTH,
    make: scenes::layers,
};

fn meter() -> Meter {
    Meter::new(Machine { device: Device::Cpu(Some(now_ns)), reason: String::new() })
}

fn wanted() -> Wanted {
    let accelerators = vec![Accelerator::Grid, Accelerator::Bvh, Accelerator::None];
    Wanted { families: vec![&SMALL], accelerators, ..Wanted::new("first".into(), true) }
}

/// Measures; also what was appended to both files.
fn measured(wanted: &Wanted, kept: Kept) -> (Cost, [Vec<u8>; 2]) {
    let files = RefCell::new(kept.files().expect("memory"));
    let mut append = |name: &'static str, lines: &[u8]| {
        files.borrow_mut()[usize::from(name == RUNS)].extend(lines);
        Ok(())
    };
    let cost = measure(wanted, kept, &meter(), &Silent, &mut append).expect("no error");
    (cost, files.into_inner())
}

/// Everything but times and who measured.
fn errors(cost: &Cost) -> Vec<Vec<String>> {
    let is_time = |c: &str| {
        c.ends_with("_ns") || c.ends_with("_s") || c.contains("ratio") || c.contains("interval") || c == "ns_per_ray"
    };
    let is_compared = |c: &&&str| !is_time(c) && !matches!(**c, "run_id" | "runs" | "invalid_runs");
    let fields = |row: &Row| COLUMNS.iter().filter(is_compared).map(|c| row.get(c).to_owned()).collect();
    cost.rows.rows.iter().map(fields).collect()
}

#[test]
fn an_interrupted_measurement_continues_and_finds_the_same_errors() {
    let (whole, files) = measured(&wanted(), Kept::default());
    // At both points the grid with four rules, the BVH with two and none with one, and each with all rules.
    assert_eq!(whole.rows.rows.len(), 2 * (5 + 3 + 2));
    let ids: std::collections::BTreeSet<_> = whole.rows.rows.iter().map(|row| row.get("configuration")).collect();
    assert_eq!(ids.len(), 20);
    assert!(whole.rows.rows.iter().all(|row| row.get("wrong_rays") == "0" || row.get("rule") == "triangle-test"));
    let lost = whole.rows.rows.iter().filter(|row| row.get("rule") == "triangle-test" && row.get("wrong_rays") != "0");
    assert!(lost.count() >= 3, "Möller and Trumbore's test loses rays at edges");
    let runs = whole.runs.rows.iter().filter(|run| run.get("configuration") == whole.rows.rows[0].get("configuration"));
    assert_eq!(runs.count().to_string(), whole.rows.rows[0].get("runs"));

    // Cut off in the middle of the eighth row.
    let ends: Vec<usize> = files[0].iter().enumerate().filter(|(_, b)| **b == b'\n').map(|(i, _)| i + 1).collect();
    let cut = &files[0][..ends[7] + 40];
    let again = Wanted { run_id: "second".into(), ..wanted() };
    let kept = Kept::read(cut, &files[1], &again, &meter().machine).expect("the same settings");
    assert_eq!(kept.count(), 7);
    let (continued, appended) = measured(&again, kept);
    assert_eq!(errors(&continued), errors(&whole));
    let from = |id: &str| continued.rows.rows.iter().filter(|row| row.get("run_id") == id).count();
    assert_eq!((from("first"), from("second")), (7, 13));
    let runs_of = |cost: &Cost, id: &str| cost.runs.rows.iter().filter(|run| run.get("run_id") == id).count();
    assert!(runs_of(&continued, "first") < runs_of(&whole, "first") && runs_of(&continued, "second") >= 13 * 6);
    // What was appended is a finished measurement, which only needs to be read.
    let kept = Kept::read(&appended[0], &appended[1], &again, &meter().machine).expect("the same settings");
    let (read, _) = measured(&again, kept);
    assert_eq!(read.rows.rows, continued.rows.rows);
}

#[test]
fn what_was_measured_otherwise_is_not_continued() {
    let few = Wanted { accelerators: vec![Accelerator::None], ..wanted() };
    let (_, files) = measured(&few, Kept::default());
    let read = |wanted: &Wanted| Kept::read(&files[0], &files[1], wanted, &meter().machine).map(|kept| kept.count());
    assert_eq!(read(&few), Ok(4));
    let refusal = |wanted: Wanted| read(&wanted).expect_err("other settings").to_string();
    assert_eq!(refusal(Wanted { seed: 7, ..few.clone() }), "it has seed 2007, not 7");
    assert_eq!(refusal(Wanted { is_quick: false, ..few.clone() }), "it has is_quick true, not false");
    let schedule = ScheduleKind::Compact;
    assert_eq!(refusal(Wanted { schedule, ..few.clone() }), "it has schedule fused, not compact");
    let other = Kept::read(b"a,b\r\n1,2\r\n", b"", &few, &meter().machine);
    assert_eq!(other.map(|_| ()), Err(KeptError::Columns));
}

#[test]
fn after_its_time_a_family_is_measured_by_one_run_of_few_rays() {
    let (cost, _) = measured(&Wanted { budget: Duration::ZERO, ..wanted() }, Kept::default());
    assert_eq!(cost.rows.rows.len(), 20, "nothing is left out");
    for row in &cost.rows.rows {
        assert_eq!((row.get("runs"), row.get("rays"), row.get("low_ns")), ("1", "64", ""), "{row:?}");
    }
    assert_eq!(cost.notes.len(), 1);
    assert!(cost.notes[0].starts_with("layers: 2 of 2 points"), "{:?}", cost.notes);
}

#[test]
fn a_run_that_takes_too_long_is_stopped_and_says_so() {
    let stopped = Wanted { longest_run: Duration::ZERO, schedule: ScheduleKind::Compact, ..wanted() };
    let (cost, _) = measured(&stopped, Kept::default());
    assert_eq!(cost.rows.rows.len(), 20);
    for row in &cost.rows.rows {
        assert_eq!((row.get("is_lower_bound"), row.get("runs"), row.get("rays")), ("true", "0", "64"), "{row:?}");
        assert!(row.number("ns_per_ray").is_some_and(|ns| ns > 0.0) && row.get("at_bound") != "0", "{row:?}");
    }
    // A fused kernel cannot be stopped: one run of few rays is timed.
    let fused = Wanted { longest_run: Duration::ZERO, ..wanted() };
    let (cost, _) = measured(&fused, Kept::default());
    for row in &cost.rows.rows {
        assert_eq!((row.get("is_lower_bound"), row.get("runs"), row.get("rays")), ("false", "1", "64"), "{row:?}");
        assert_eq!(row.get("at_bound"), "0");
    }
}

#[test]
fn time_to_go_follows_what_was_done() {
    let after = |seconds, measured, left| to_go(Duration::from_secs(seconds), measured, left);
    assert_eq!(after(9, 0, 5), "");
    assert_eq!((after(10, 2, 6), after(10, 1, 60)), (", about 30 s to go".into(), ", about 10 min to go".into()));
}

/// Cells or nodes and triangles per ray, summed: what a ray does, whatever the machine.
fn work_of(workload: &Workload, accelerator: Accelerator) -> f64 {
    let options = Options {
        accelerator,
        grid: workload.grid,
        schedule: ScheduleKind::Fused,
        counters: true,
        shade: false,
        ..Options::new(workload.rays.clone())
    };
    let device = Device::Cpu(None);
    let (scene, counters) = (&workload.scene, streams::COUNTERS);
    let mut renderer = block_on(Renderer::new(scene, &options, &device)).expect("a run");
    block_on(renderer.run(|_| ControlFlow::Continue(()))).expect("passes");
    let counts = block_on(renderer.values(counters)).expect("counters");
    let rays = renderer.plan().rays as usize;
    let sum: u64 = (0..rays).map(|ray| u64::from(counts.get(0, ray)) + u64::from(counts.get(1, ray))).sum();
    sum as f64 / rays as f64
}

/// `auto` never takes a structure through which rays do ten times as much as through the best of those that it weighs.
#[test]
fn auto_is_near_the_best_in_every_family() {
    for family in FAMILIES {
        for &point in family.points {
            let workload = (family.make)(point, 64, 1).expect("a scene");
            let [grid, bvh, auto] =
                [Accelerator::Grid, Accelerator::Bvh, Accelerator::Auto].map(|a| work_of(&workload, a));
            let best = grid.min(bvh).min(workload.scene.triangles.len() as f64);
            println!("{} {point}: grid {grid:.0}, bvh {bvh:.0}, auto {auto:.0}", family.name);
            assert!(auto <= 10.0 * best, "{} at {point}: {auto} for {best}", family.name);
        }
    }
}
