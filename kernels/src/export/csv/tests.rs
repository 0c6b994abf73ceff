use super::*;
use crate::executor::Rounding;
use crate::programs::closest_hit::kernels;
use crate::programs::closest_hit::states::{ISECT_HIT, ISECT_NO_HIT, SHADE, TRAV};

fn run(timer: Option<Timer>) -> RunContext {
    RunContext {
        run_id: "1".into(),
        configuration: "0".into(),
        scene: "a \"b\", c\nd".into(),
        accelerator: "grid",
        schedule: "second",
        numerics: "robust",
        traversal: "amanatides-woo",
        mapping: "compute".into(),
        adapter: "cpu".into(),
        width_px: 9,
        height_px: 8,
        repeat: 0,
        is_warmup: false,
        timer,
        host_run_ns: Some(77),
    }
}

fn pass(duration_ns: Option<u64>) -> Pass {
    let mut counts = [0; crate::tables::state::COUNT];
    (counts[ISECT_NO_HIT as usize], counts[ISECT_HIT as usize]) = (3, 4);
    (counts[TRAV as usize], counts[SHADE as usize]) = (60, 5);
    Pass {
        index: 2,
        iteration: 1,
        kernel: kernels::INTERSECT,
        rays_in: 72,
        counts,
        threads_launched: 128,
        begin_ns: duration_ns,
        duration_ns,
        rounding: None,
    }
}

fn rows(timer: Option<Timer>, duration_ns: Option<u64>, work: Option<PassWork>) -> Vec<(String, String)> {
    fields(&run(timer), &pass(duration_ns), work)
}

/// The names and fields of the only row.
fn fields(run: &RunContext, pass: &Pass, work: Option<PassWork>) -> Vec<(String, String)> {
    let mut file = Vec::new();
    let mut csv = PassesCsv::new(&mut file).expect("memory");
    csv.write(run, pass, &[], work).expect("memory");
    csv.finish().expect("memory");
    let mut reader = ::csv::ReaderBuilder::new().flexible(false).from_reader(file.as_slice());
    let names: Vec<String> = reader.headers().expect("a header").iter().map(str::to_owned).collect();
    let row = reader.records().next().expect("a row").expect("as many fields as names");
    names.into_iter().zip(row.iter().map(str::to_owned)).collect()
}

fn value<'a>(row: &'a [(String, String)], name: &str) -> &'a str {
    &row.iter().find(|(n, _)| n == name).expect(name).1
}

#[test]
fn unknown_is_empty_and_odd_names_are_quoted() {
    let row = rows(None, None, None);
    assert_eq!(value(&row, "scene"), "a \"b\", c\nd");
    let unknown = ["gpu_begin_ns", "gpu_duration_ns", "cpu_encode_ns", "cells_visited", "triangles_tested"];
    for name in unknown.iter().chain(&["clock", "clock_resolution_ns", "valid"]) {
        assert_eq!(value(&row, name), "", "{name}");
    }
    assert_eq!(value(&row, "rays_in"), "72");
    assert_eq!(value(&row, "rays_out"), "65", "7 of 72 are still in the kernel's states");
    assert_eq!(value(&row, "threads_launched"), "128");
}

#[test]
fn a_timed_pass_says_by_which_clock_and_whether_it_worked() {
    let work = PassWork { cells_visited: 10, triangles_tested: 11 };
    let row = rows(Some(Timer::GpuTimestamp { resolution_ns: 0.5 }), Some(1200), Some(work));
    let expected = [
        ("gpu_begin_ns", "0"),
        ("gpu_duration_ns", "1200"),
        ("cells_visited", "10"),
        ("triangles_tested", "11"),
        ("clock", "gpu_timestamp"),
        ("clock_resolution_ns", "0.5"),
        ("valid", "true"),
    ];
    for (name, expected) in expected {
        assert_eq!(value(&row, name), expected, "{name}");
    }
    let row = rows(Some(Timer::CpuClock { resolution_ns: None }), None, None);
    assert_eq!((value(&row, "gpu_duration_ns"), value(&row, "valid")), ("", "false"));
    assert_eq!(value(&row, "host_run_ns"), "", "the device's own clock is valid");
}

#[test]
fn by_a_coarse_clock_a_time_has_an_error_and_too_short_a_pass_none() {
    let row = |duration_ns| {
        let rounding = Some(Rounding { runs: 40, error_ns: 7906, below_ns: 120_000 });
        let pass = Pass { rounding, duration_ns, ..pass(Some(90_000)) };
        fields(&run(Some(Timer::GpuTimestamp { resolution_ns: 65_536.0 })), &pass, None)
    };
    for (duration_ns, duration, valid) in [(Some(80_000), "80000", "true"), (None, "", "false")] {
        let row = row(duration_ns);
        let expected = [
            ("gpu_begin_ns", "0"),
            ("gpu_duration_ns", duration),
            ("clock_resolution_ns", "65536"),
            ("valid", valid),
            ("duration_runs", "40"),
            ("duration_error_ns", "7906"),
            ("duration_below_ns", "120000"),
        ];
        for (name, expected) in expected {
            assert_eq!(value(&row, name), expected, "{name}");
        }
    }
    let row = rows(Some(Timer::GpuTimestamp { resolution_ns: 1.0 }), Some(1200), None);
    let unknown = ["duration_runs", "duration_error_ns", "duration_below_ns"].map(|name| value(&row, name));
    assert_eq!(unknown, [""; 3], "the clock is not coarse");
}

#[test]
fn where_the_devices_clock_is_none_only_the_run_has_a_time() {
    let row = rows(Some(Timer::Host { resolution_ns: Some(20.0) }), Some(1200), None);
    let expected = [
        ("gpu_begin_ns", ""),
        ("gpu_duration_ns", ""),
        ("clock", "host"),
        ("clock_resolution_ns", "20"),
        ("valid", "false"),
        ("host_run_ns", "77"),
    ];
    for (name, expected) in expected {
        assert_eq!(value(&row, name), expected, "{name}");
    }
}

#[test]
fn each_run_and_repetition_begins_at_0() {
    let mut file = Vec::new();
    let mut csv = PassesCsv::new(&mut file).expect("memory");
    let clock = Some(Timer::GpuTimestamp { resolution_ns: 1.0 });
    let again = RunContext { repeat: 1, ..run(clock) };
    let other = RunContext { configuration: "1".into(), ..again.clone() };
    for (run, begin_ns) in [
        (&run(clock), [None, Some(1 << 60), Some((1 << 60) + 7)]),
        (&again, [Some(5), None, Some(6)]),
        (&other, [Some(9), Some(9), Some(11)]),
    ] {
        for begin_ns in begin_ns {
            csv.write(run, &Pass { begin_ns, ..pass(begin_ns) }, &[], None).expect("memory");
        }
    }
    csv.finish().expect("memory");
    let mut reader = ::csv::Reader::from_reader(file.as_slice());
    let column = COLUMNS.iter().position(|&c| c == "gpu_begin_ns").expect("a column");
    let begins: Vec<_> = reader.records().map(|r| r.expect("a row")[column].to_owned()).collect();
    assert_eq!(begins, ["", "0", "7", "0", "", "1", "0", "0", "2"]);
}
