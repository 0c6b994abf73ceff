use super::*;
use crate::executor::{DrawTime, Drawing, Rounding};
use crate::options::{Accelerator, ScheduleKind};
use crate::programs::closest_hit::states::{ISECT_HIT, ISECT_NO_HIT, SHADE, TRAV};
use crate::programs::closest_hit::{self, kernels};
use crate::tables::state::StateCounts;

fn run(timer: Option<Timer>) -> RunContext {
    RunContext {
        run_id: "1".into(),
        configuration: "0".into(),
        scene: "a \"b\", c\nd".into(),
        adapter: "cpu".into(),
        width_px: Some(9),
        height_px: Some(8),
        repeat: 0,
        is_warmup: false,
        timer,
        host_run_ns: Some(77),
        choices: Choices { accelerator: Accelerator::Grid, schedule: ScheduleKind::Second, ..Choices::default() },
    }
}

fn pass(duration_ns: Option<u64>) -> Pass {
    let mut counts = StateCounts::none(closest_hit::states::STATES);
    (counts[ISECT_NO_HIT as usize], counts[ISECT_HIT as usize]) = (3, 4);
    (counts[TRAV as usize], counts[SHADE as usize]) = (60, 5);
    Pass {
        index: 2,
        sample: 3,
        iteration: 1,
        rays_in: 72,
        counts,
        threads_launched: 128,
        encode_ns: Some(900),
        begin_ns: duration_ns,
        duration_ns,
        ..Pass::of(kernels::INTERSECT)
    }
}

fn rows(timer: Option<Timer>, duration_ns: Option<u64>, work: Option<CounterSums>) -> Vec<(String, String)> {
    fields(&run(timer), &pass(duration_ns), work)
}

/// The names and fields of the only row.
fn fields(run: &RunContext, pass: &Pass, work: Option<CounterSums>) -> Vec<(String, String)> {
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
    let unknown = ["begin_ns", "duration_ns", "cells_visited", "triangles_tested"];
    for name in unknown.iter().chain(&["clock", "clock_resolution_ns", "valid"]) {
        assert_eq!(value(&row, name), "", "{name}");
    }
    assert_eq!(value(&row, "rays_in"), "72");
    assert_eq!(value(&row, "rays_out"), "65", "7 of 72 are still in the kernel's states");
    assert_eq!(value(&row, "threads_launched"), "128");
}

#[test]
fn a_timed_pass_says_by_which_clock_and_whether_it_worked() {
    let work = CounterSums { cells_visited: 10, triangles_tested: 11, repeated_tests: Some(4) };
    let row = rows(Some(Timer::GpuTimestamp { resolution_ns: 0.5 }), Some(1200), Some(work));
    let expected = [
        ("begin_ns", "0"),
        ("duration_ns", "1200"),
        ("cells_visited", "10"),
        ("triangles_tested", "11"),
        ("repeated_tests", "4"),
        ("encode_ns", "900"),
        ("sample", "3"),
        ("host_run_ns", "77"),
        ("clock", "gpu_timestamp"),
        ("clock_resolution_ns", "0.5"),
        ("valid", "true"),
    ];
    for (name, expected) in expected {
        assert_eq!(value(&row, name), expected, "{name}");
    }
    let row = rows(Some(Timer::CpuClock { resolution_ns: None }), None, None);
    assert_eq!((value(&row, "duration_ns"), value(&row, "valid")), ("", "false"));
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
            ("begin_ns", "0"),
            ("duration_ns", duration),
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
        ("begin_ns", ""),
        ("duration_ns", ""),
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
    let column = COLUMNS.iter().position(|c| c == "begin_ns").expect("a column");
    let begins: Vec<_> = reader.records().map(|r| r.expect("a row")[column].to_owned()).collect();
    assert_eq!(begins, ["", "0", "7", "0", "", "1", "0", "0", "2"]);
}

#[test]
fn after_a_clock_was_set_back_no_begin_is_known() {
    let mut file = Vec::new();
    let mut csv = PassesCsv::new(&mut file).expect("memory");
    let run = run(Some(Timer::GpuTimestamp { resolution_ns: 1.0 }));
    for begin_ns in [900, 910, 3, 990] {
        csv.write(&run, &Pass { begin_ns: Some(begin_ns), ..pass(Some(5)) }, &[], None).expect("memory");
    }
    csv.finish().expect("memory");
    let mut reader = ::csv::Reader::from_reader(file.as_slice());
    let columns = ["begin_ns", "duration_ns"].map(|name| COLUMNS.iter().position(|c| c == name).expect("a column"));
    let times: Vec<_> =
        reader.records().map(|r| columns.map(|column| r.as_ref().expect("a row")[column].to_owned())).collect();
    assert_eq!(times, [["0", "5"], ["10", "5"], ["", "5"], ["", "5"]]);
}

#[test]
fn what_belongs_to_the_pass_is_in_the_row_of_its_last_part() {
    let mut file = Vec::new();
    let mut csv = PassesCsv::new(&mut file).expect("memory");
    let part = |what| {
        let time = DrawTime { what, begin_ns: Some(7), duration_ns: Some(2), fragments: None };
        DrawnPart { time, targets: String::new(), fragments_drawn: 72, bytes_copied: 0 }
    };
    let work = CounterSums { cells_visited: 10, triangles_tested: 11, repeated_tests: Some(4) };
    let run = run(Some(Timer::GpuTimestamp { resolution_ns: 1.0 }));
    csv.write(&run, &pass(Some(4)), &[part(Drawing::Depths), part(Drawing::Draw(0))], Some(work)).expect("memory");
    csv.finish().expect("memory");
    let mut reader = ::csv::Reader::from_reader(file.as_slice());
    let names =
        ["rays_in", "rays_out", "encode_ns", "cells_visited", "triangles_tested", "repeated_tests", "duration_ns"];
    let columns = names.map(|name| COLUMNS.iter().position(|c| c == name).expect("a column"));
    let rows: Vec<_> =
        reader.records().map(|r| columns.map(|column| r.as_ref().expect("a row")[column].to_owned())).collect();
    assert_eq!(rows, [["", "", "", "", "", "", "2"], ["72", "65", "900", "10", "11", "4", "2"]]);
}

#[test]
fn no_text_is_a_formula_in_a_spreadsheet() {
    #[derive(serde::Serialize)]
    struct Row {
        scene: &'static str,
        ratio: f64,
    }
    let mut file = Vec::new();
    let mut csv = writer(&mut file);
    let texts = ["=1+1", "+a", "@cmd", "-x", "-", "-1.5e-3", "+4", "-inf", "a=b", "", "\t=1"];
    csv.write_record(texts).expect("memory");
    csv.flush().expect("memory");
    drop(csv);
    assert_eq!(String::from_utf8_lossy(&file), "'=1+1,'+a,'@cmd,'-x,-,-1.5e-3,+4,-inf,a=b,,'\t=1\r\n");
    let mut file = Vec::new();
    let mut csv = writer(&mut file);
    for ratio in [-0.5, 2.0] {
        csv.serialize(Row { scene: "=a, \"b\"", ratio }).expect("memory");
    }
    csv.flush().expect("memory");
    drop(csv);
    let lines = "scene,ratio\r\n\"'=a, \"\"b\"\"\",-0.5\r\n\"'=a, \"\"b\"\"\",2.0\r\n";
    assert_eq!(String::from_utf8_lossy(&file), lines);
}
