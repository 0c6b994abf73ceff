use crate::programs::closest_hit::{kernels, states};
use std::collections::BTreeSet;

use serde_json::Value;

use super::*;
use crate::executor::{DrawTime, Rounding};
use crate::options::{Accelerator, ScheduleKind};
use crate::tables::state::StateCounts;

fn pass(index: usize, time: Option<(u64, u64)>, shaded: u32) -> Pass {
    let mut counts = StateCounts::none(states::STATES);
    counts[states::SHADE as usize] = shaded;
    counts[states::TRAV as usize] = 10 - shaded;
    let (begin_ns, duration_ns) = time.unzip();
    let of = Pass::of(kernels::INTERSECT);
    Pass { index, iteration: 1, rays_in: 10, counts, threads_launched: 64, begin_ns, duration_ns, ..of }
}

fn run() -> RunContext {
    RunContext {
        run_id: "1".into(),
        configuration: "0".into(),
        scene: "a \"b\"".into(),
        adapter: "cpu".into(),
        width_px: Some(5),
        height_px: Some(2),
        repeat: 0,
        is_warmup: false,
        timer: Some(crate::export::csv::Timer::GpuTimestamp { resolution_ns: 1.0 }),
        host_run_ns: None,
        choices: Choices { accelerator: Accelerator::Grid, schedule: ScheduleKind::Second, ..Choices::default() },
    }
}

fn file(times: &[Option<(u64, u64)>]) -> Value {
    let passes: Vec<_> = times.iter().enumerate().map(|(i, &time)| pass(i, time, (i as u32 / 2).min(10))).collect();
    let text = serde_json::to_string(&trace_events(&run(), &passes, &[])).expect("JSON");
    let file: Value = serde_json::from_str(&text).expect("JSON");
    validate(&file);
    file
}

/// Checks a file against the format's specification: the fields of each kind of event, and that no two slices of a track
/// overlap unless one lies within the other.
fn validate(file: &Value) {
    let mut tracks: BTreeMap<u64, Vec<[i64; 2]>> = BTreeMap::new();
    for event in file["traceEvents"].as_array().expect("events") {
        check(event);
        if event["ph"] == "X" {
            let (begin, duration) = (ns(&event["ts"]), ns(&event["dur"]));
            tracks.entry(event["tid"].as_u64().expect("a track")).or_default().push([begin, begin + duration]);
        }
    }
    for (track, slices) in tracks {
        for (i, a) in slices.iter().enumerate() {
            for b in &slices[..i] {
                let is_apart = a[1] <= b[0] || b[1] <= a[0];
                let is_nested = b[0] <= a[0] && a[1] <= b[1] || a[0] <= b[0] && b[1] <= a[1];
                assert!(is_apart || is_nested, "{a:?} and {b:?} overlap on track {track}");
            }
        }
    }
}

/// Checks what the format's specification requires of each kind of event.
fn check(event: &Value) {
    let names: Vec<_> = event.as_object().expect("an object").keys().map(String::as_str).collect();
    let is_complete = event["ph"] == "X";
    let all = ["args", "cat", "dur", "name", "ph", "pid", "tid", "ts"];
    assert_eq!(names, all.into_iter().filter(|&n| is_complete || n != "dur").collect::<Vec<_>>(), "{event}");
    assert!(event["ts"].as_f64().is_some_and(|ts| ts >= 0.0), "{event}");
    assert_eq!(event["pid"], 1);
    match event["ph"].as_str() {
        Some("X") => assert!(event["dur"].as_f64().is_some_and(|dur| dur >= 0.0)),
        Some("C") => assert!(event["args"].as_object().is_some_and(|a| a.values().all(Value::is_u64))),
        Some("M") => assert!(event["args"]["name"].is_string()),
        _ => panic!("{event}"),
    }
}

/// Whole nanoseconds.
fn ns(us: &Value) -> i64 {
    (us.as_f64().expect("a time") * 1000.0).round() as i64
}

fn sum(file: &Value, category: &str) -> i64 {
    let events = file["traceEvents"].as_array().expect("events");
    events.iter().filter(|e| e["cat"] == category && e["ph"] == "X").map(|e| ns(&e["dur"])).sum()
}

fn adds_up(file: &Value) {
    let about = |name: &str| ns(&file["otherData"][name]);
    assert_eq!(sum(file, "pass"), about("passes_us"));
    assert_eq!(sum(file, "gap"), about("gaps_us"));
    assert_eq!(about("passes_us") + about("gaps_us") - about("overlaps_us"), about("whole_us"), "{file}");
}

#[test]
fn passes_and_gaps_add_up_to_the_whole() {
    let late = 1 << 60;
    let file = file(&[Some((late, 500)), Some((late + 700, 250)), Some((late + 950, 0)), Some((late + 2000, 3))]);
    adds_up(&file);
    let about = &file["otherData"];
    assert_eq!((&about["whole_us"], &about["gaps_us"]), (&2.003.into(), &1.25.into()));
    assert_eq!((&about["overlaps_us"], &about["passes_without_times"]), (&0.0.into(), &0.into()));
    let events = file["traceEvents"].as_array().expect("events");
    let second = events.iter().find(|e| e["args"]["pass"] == 1).expect("the second pass");
    assert_eq!((&second["ts"], &second["dur"]), (&0.7.into(), &0.25.into()));
    assert_eq!((&second["name"], &second["args"]["rays_in"]), (&"intersect".into(), &10.into()));
    assert_eq!((&second["args"]["iteration"], &second["args"]["rays_out"]), (&1.into(), &10.into()));
    assert_eq!(second["args"]["threads_launched"], 64);
}

#[test]
fn a_repeated_pass_says_how_often_it_ran_and_one_too_short_is_left_out() {
    let rounding = Some(Rounding { runs: 40, error_ns: 7906, below_ns: 120_000 });
    let told = Pass { rounding, ..pass(0, Some((0, 80_000)), 0) };
    let short = Pass { duration_ns: None, ..Pass { rounding, ..pass(1, Some((200_000, 0)), 0) } };
    let events = trace_events(&run(), &[told, short], &[]);
    let slices: Vec<_> = events.trace_events.iter().filter(|event| event.cat == "pass").collect();
    assert_eq!((slices.len(), events.other_data.passes_without_times), (1, 1));
    assert_eq!((&slices[0].args["runs"], &slices[0].args["error_us"]), (&40.into(), &7.906.into()));
}

#[test]
fn a_counter_says_when_it_changes() {
    let file = file(&[Some((0, 10)), Some((20, 10)), Some((40, 10)), Some((60, 10))]);
    let counters: Vec<_> = file["traceEvents"].as_array().expect("events").iter().filter(|e| e["ph"] == "C").collect();
    let rows: Vec<_> = counters
        .iter()
        .map(|e| (e["name"].as_str().expect("a name"), e["ts"].as_f64().expect("a time"), e["args"]["rays"].as_u64()))
        .collect();
    let expected =
        [("rays in TRAV", 0.01, Some(10)), ("rays in TRAV", 0.05, Some(9)), ("rays in SHADE", 0.05, Some(1))];
    assert_eq!(rows, expected);
}

/// Begins of the slices of a category in nanoseconds, with their tracks.
fn slices(file: &Value, category: &str) -> Vec<(i64, u64)> {
    let events = file["traceEvents"].as_array().expect("events").iter().filter(|event| event["cat"] == category);
    events.map(|event| (ns(&event["ts"]), event["tid"].as_u64().expect("a track"))).collect()
}

#[test]
fn overlaps_are_on_further_tracks() {
    let overlapping = file(&[Some((100, 100)), Some((150, 20)), Some((190, 60)), Some((240, 10)), Some((260, 5))]);
    adds_up(&overlapping);
    let about = &overlapping["otherData"];
    assert_eq!((&about["whole_us"], &about["gaps_us"]), (&0.165.into(), &0.01.into()));
    // 20 within the first; 10 shared by the third and the first; 10 shared by the fourth and the third.
    assert_eq!(about["overlaps_us"], 0.04);
    assert_eq!(slices(&overlapping, "pass"), [(0, 1), (50, 11), (90, 11), (140, 1), (160, 1)]);
    let events = overlapping["traceEvents"].as_array().expect("events");
    let names: Vec<_> = events.iter().filter(|event| event["name"] == "thread_name").collect();
    let named = |track: u64| names.iter().find(|event| event["tid"] == track).expect("a name")["args"]["name"].clone();
    assert_eq!([named(1), named(11)], ["passes", "passes, overlapping 1"]);
    // Three at a time, as the device may.
    let many = file(&(0..60).map(|i| Some((i * 10, 25))).collect::<Vec<_>>());
    adds_up(&many);
    let tracks: BTreeSet<u64> = slices(&many, "pass").into_iter().map(|(_, track)| track).collect();
    assert_eq!(tracks.into_iter().collect::<Vec<_>>(), [1, 11, 21]);
}

#[test]
fn draws_that_overlap_are_on_further_tracks() {
    let time = |begin, duration| DrawTime {
        what: Drawing::Depths,
        begin_ns: Some(begin),
        duration_ns: Some(duration),
        fragments: None,
    };
    let part = |time| DrawnPart { time, targets: "depth".into(), fragments_drawn: 10, bytes_copied: 0 };
    let passes = [pass(0, Some((1000, 50)), 0), pass(1, Some((1050, 20)), 0)];
    let parts = [vec![part(time(1000, 30)), part(time(1020, 30))], vec![part(time(1040, 30))]];
    let text = serde_json::to_string(&trace_events(&run(), &passes, &parts)).expect("JSON");
    let file: Value = serde_json::from_str(&text).expect("JSON");
    validate(&file);
    // The last begins before its pass, so where it is is not known.
    assert_eq!(slices(&file, "draw"), [(0, 4), (20, 14)]);
}

#[test]
fn missing_times_are_counted() {
    let holes = file(&[Some((100, 10)), None, Some((50, 10)), Some((u64::MAX, 10)), Some((120, 10))]);
    adds_up(&holes);
    let about = &holes["otherData"];
    assert_eq!((&about["passes_without_times"], &about["whole_us"]), (&3.into(), &0.03.into()));
    let far = file(&[Some((100, 10)), Some((1 << 60, 10)), Some((120, 10)), Some((140, 10))]);
    assert_eq!((slices(&far, "pass").len(), &far["otherData"]["whole_us"]), (3, &0.05.into()));

    let none = file(&[None, None]);
    adds_up(&none);
    assert_eq!((&none["otherData"]["whole_us"], none["traceEvents"].as_array().map(Vec::len)), (&0.0.into(), Some(3)));
}

#[test]
fn a_clock_that_is_set_back_loses_no_pass() {
    let times = [(9000, 10), (9020, 10), (3, 10), (23, 10), (9999, 1), (2, 5), (12, 5)];
    let file = file(&times.map(Some));
    adds_up(&file);
    let about = &file["otherData"];
    assert_eq!((&about["clock_set_back"], &about["passes_without_times"]), (&2.into(), &0.into()));
    let begins: Vec<i64> = slices(&file, "pass").into_iter().map(|(begin, _)| begin).collect();
    // Right after the last pass before, and then as far apart as the clock says.
    assert_eq!(begins, [0, 20, 30, 50, 10_026, 10_027, 10_037]);
}
