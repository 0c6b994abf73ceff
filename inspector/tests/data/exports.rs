//! Exports have the formats of the command line, and file names that every file system accepts.

use std::ops::ControlFlow;

use raystep_inspector::exports::{self, Export};
use raystep_kernels::export::Recorded;
use raystep_kernels::export::csv::{COLUMNS, RunContext, Timer};
use raystep_kernels::export::trace::{Rays, trace};
use raystep_kernels::programs::closest_hit::streams;
use raystep_kernels::{Accelerator, Choices, Device, Renderer, ScheduleKind};
use raystep_scenes::generate;

use crate::data::common::options;

fn run() -> (RunContext, Renderer) {
    let scene = generate::cornell_box();
    let mut options = options(&scene, Accelerator::Grid, ScheduleKind::Second, [9, 7]);
    options.timings = true;
    let renderer =
        pollster::block_on(Renderer::new(&scene, &options, &Device::Cpu(Some(|| 7)))).expect("a small scene");
    let run = RunContext {
        run_id: "1".into(),
        configuration: "0".into(),
        scene: "a/b \"c\"\n深".into(),
        adapter: "cpu".into(),
        width_px: Some(9),
        height_px: Some(7),
        repeat: 0,
        is_warmup: false,
        timer: Some(Timer::CpuClock { resolution_ns: None }),
        host_run_ns: None,
        choices: Choices { accelerator: Accelerator::Grid, schedule: ScheduleKind::Second, ..Choices::default() },
    };
    (run, renderer)
}

fn named(export: &Export) -> String {
    assert!(export.name.chars().all(|c| c.is_alphanumeric() || "-_.".contains(c)), "{export:?}");
    export.file_name()
}

#[test]
fn exports_are_the_command_lines_formats() {
    let (run, mut renderer) = run();
    let history =
        pollster::block_on(trace(&mut renderer, 3, 4, Rays::All, |_| ControlFlow::Continue(()))).expect("a ray");
    let passes = renderer.passes();
    let recorded = Recorded::of(&run, &renderer, &[]);

    let csv = exports::passes_csv(&recorded).expect("CSV");
    assert_eq!(named(&csv), "a-b--c--深.passes.csv");
    let mut reader = csv::Reader::from_reader(csv.bytes.as_slice());
    assert_eq!(reader.headers().expect("a header").iter().collect::<Vec<_>>(), *COLUMNS);
    let rows: Vec<_> = reader.records().map(|r| r.expect("a row")).collect();
    assert_eq!(rows.len(), passes.len());
    assert_eq!((&rows[0][22], &rows[0][3]), ("", "a/b \"c\"\n深"));

    let events = exports::passes_trace(&recorded).expect("JSON");
    assert_eq!(named(&events), "a-b--c--深.trace.json");
    let events: serde_json::Value = serde_json::from_slice(&events.bytes).expect("JSON");
    let slices = events["traceEvents"].as_array().expect("events").iter().filter(|e| e["cat"] == "pass");
    assert_eq!(slices.count(), passes.len());

    let hit = pollster::block_on(renderer.values(streams::HIT)).expect("a stream");
    let npy = exports::stream_npy(&hit, Some(41)).expect("npy");
    assert_eq!((named(&npy).as_str(), npy.bytes.len()), ("pass-000041.hit.npy", 128 + 4 * 3 * 63));
    let exr = exports::stream_exr(&hit, None).expect("EXR");
    assert_eq!((named(&exr).as_str(), &exr.bytes[..4]), ("start.hit.exr", &[0x76, 0x2f, 0x31, 0x01][..]));

    let json = exports::ray_json(&history).expect("JSON");
    assert_eq!(named(&json), "ray-3-4.json");
    let json: serde_json::Value = serde_json::from_slice(&json.bytes).expect("JSON");
    let csv = exports::ray_csv(&history).expect("CSV");
    let mut reader = csv::Reader::from_reader(csv.bytes.as_slice());
    assert_eq!(reader.records().count(), history.rows.len());
    assert_eq!(json["rows"].as_array().map(Vec::len), Some(history.rows.len()));
}
