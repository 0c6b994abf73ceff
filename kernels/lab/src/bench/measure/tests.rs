//! What a benchmark measures, omits and notes, on the CPU.

use raystep_kernels::{Accelerator, Device, GridSize, Options, ScheduleKind};
use raystep_scenes::generate;

use super::*;
use crate::machine::now_ns;
use crate::reporter::Silent;
use crate::{Hash, RayKind, Subject};

const SIZE: Size = Size { width: 16, height: 12 };

fn meter() -> Meter {
    Meter::new(Machine { device: Device::Cpu(Some(now_ns)), reason: String::new() })
}

fn subject() -> Subject {
    let scene = generate::cornell_box();
    let camera = scene.cameras[0].clone();
    Subject { scene, camera, hash: Hash::default(), file: "a file".into() }
}

/// One step a pass.
fn stepped(accelerator: Accelerator) -> Configuration {
    Configuration::new(accelerator, ScheduleKind::Second, 1)
}

fn wanted(configurations: Vec<Configuration>) -> Wanted {
    Wanted {
        configurations,
        sizes: vec![SIZE],
        rays: vec![RayKind::Primary],
        file: None,
        turns: Turns::of(0, 2),
        longest_run: Duration::MAX,
        until: None,
        is_counted: |_| true,
        is_replayed: |_| false,
        seed: 1,
        tuning: Options::new(RaySource::Given(Vec::new())),
    }
}

fn measured(wanted: &Wanted) -> Result<Measured, Error> {
    crate::bench::measure(wanted, &[subject()], "1-2".into(), &meter(), &Silent)
}

/// Builds what is wanted, and then measures with other limits.
fn measured_with(wanted: &Wanted, limits: &Wanted) -> Measured {
    let (meter, subject) = (meter(), subject());
    let mut bench = Bench::new(wanted, "1-2".into(), &meter, &Silent);
    let (name, kind) = ("a group".into(), "primary".into());
    let group = Group { name, subject: &subject, size: Some(SIZE), kind, ends_early: false };
    bench.group(group, subject.camera_rays(SIZE), &wanted.configurations).expect("configurations");
    bench.wanted = limits;
    bench.finish().expect("rows")
}

#[test]
fn every_configuration_has_its_own_grid() {
    let one = stepped(Accelerator::Grid);
    let of = |size| Configuration { grid: Some(GridSize::Cells(size)), ..one };
    let measured = measured(&wanted(vec![of([3, 4, 5]), one, of([2, 2, 2]), one])).expect("rows");
    let grids: Vec<&str> = measured.rows.iter().map(|row| row.grid.as_str()).collect();
    assert_eq!(grids, ["3,4,5", "auto", "2,2,2", "auto"]);
    let cells: Vec<[i32; 3]> = measured.details.iter().map(|details| details.cells.expect("a grid")).collect();
    assert_eq!((cells[0], cells[2], cells[1] == cells[3]), ([3, 4, 5], [2, 2, 2], true));
    assert!(cells[1] != cells[0] && cells[1] != cells[2], "{cells:?}");
}

#[test]
fn only_wanted_work_is_counted() {
    let is_counted: fn(&Configuration) -> bool = |one| one.accelerator == Accelerator::Bvh;
    let all = [Accelerator::Grid, Accelerator::Bvh].map(stepped).to_vec();
    let measured = measured(&Wanted { is_counted, ..wanted(all) }).expect("rows");
    let counted: Vec<bool> = measured.rows.iter().map(|row| row.tests_per_ray.is_some()).collect();
    assert_eq!(counted, [false, true]);
}

#[test]
fn nothing_is_built_after_the_deadline_and_no_run_is_longer_than_allowed() {
    let one = wanted(vec![stepped(Accelerator::Grid)]);
    let late = Wanted { until: Some(Instant::now()), ..one.clone() };
    assert!(matches!(measured(&late), Err(Error::TimeOver)));
    let slow = Wanted { longest_run: Duration::ZERO, ..one };
    assert!(matches!(measured(&slow), Err(Error::GivenUp)));
}

#[test]
fn after_the_deadline_only_the_fewest_runs_are_made() {
    let turns = Turns { fewest: 1, ..Turns::of(0, 5) };
    let all = [Accelerator::Grid, Accelerator::Bvh].map(stepped).to_vec();
    let wanted = Wanted { turns, ..wanted(all) };
    let late = Wanted { until: Some(Instant::now()), ..wanted.clone() };
    let runs = |limits| measured_with(&wanted, limits).rows.iter().map(|row| row.runs).collect::<Vec<_>>();
    assert_eq!((runs(&wanted), runs(&late)), (vec![5, 5], vec![1, 1]));
}

#[test]
fn a_stopped_configuration_is_noted_and_has_no_hits() {
    let wanted = wanted([Accelerator::Grid, Accelerator::Bvh].map(stepped).to_vec());
    let measured = measured_with(&wanted, &Wanted { longest_run: Duration::ZERO, ..wanted.clone() });
    for (row, note) in measured.rows.iter().zip(&measured.notes) {
        assert_eq!(*note, format!("{}: stopped after 0 timed runs: too slow, or endless", row.name()));
        assert_eq!((row.hits, row.hits_hash.as_str(), row.median_ns), (None, "", None));
    }
    assert_eq!((measured.rows.len(), measured.notes.len()), (2, 2), "{:?}", measured.notes);
}

#[test]
fn hits_are_compared_by_the_same_rules() {
    let (meter, wanted) = (meter(), wanted(Vec::new()));
    let mut bench = Bench::new(&wanted, String::new(), &meter, &Silent);
    let row = |numerics: &str, hits: Option<u64>| {
        let hits_hash = hits.map_or_else(String::new, |hits| hits.to_string());
        SummaryRow { numerics: numerics.into(), hits, hits_hash, runs: 2, ..SummaryRow::default() }
    };
    for row in [row("robust", Some(5)), row("paper", Some(4)), row("robust", None), row("robust", Some(5))] {
        bench.check(&row);
        bench.measured.rows.push(row);
    }
    assert_eq!(bench.measured.notes, Vec::<String>::new());
    bench.check(&SummaryRow { invalid_runs: 1, ..row("robust", Some(6)) });
    let [invalid, different] = &bench.measured.notes[..] else { panic!("{:?}", bench.measured.notes) };
    assert!(invalid.contains("1 of 3 times were invalid"), "{invalid}");
    assert!(different.contains("different hits (6 and 5 rays"), "{different}");
}
