//! Files written by the binary, read by other readers.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Cursor;

use exr::prelude::{FlatSamples, ReadChannels as _, ReadLayers as _};
use serde_json::Value;

use crate::common::{Place, scene};

pub(crate) fn cornell_box() -> String {
    scene("cornell-box.gltf").display().to_string()
}

pub(crate) fn channels(file: Vec<u8>) -> BTreeMap<String, FlatSamples> {
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(file))
        .expect("a valid EXR");
    image.layer_data.channel_data.list.into_iter().map(|c| (c.name.to_string(), c.sample_data)).collect()
}

pub(crate) fn floats<'a>(channels: &'a BTreeMap<String, FlatSamples>, name: &str) -> &'a [f32] {
    match &channels[name] {
        FlatSamples::F32(values) => values,
        other => panic!("{name} is {other:?}"),
    }
}

#[test]
fn render_writes_the_png_that_a_reader_reads() {
    let place = Place::new();
    let outcome = place.ok(&["render", &cornell_box(), "-o", "box.png", "--size", "64x48", "--device", "cpu"]);
    assert!(outcome.stderr.contains("triangles 26") && outcome.stderr.contains("--device cpu"), "{outcome:?}");
    let image = image::load_from_memory(&place.read("box.png")).expect("a PNG").to_rgb8();
    assert_eq!(image.dimensions(), (64, 48));
    let (left, right) = (image.get_pixel(1, 24), image.get_pixel(62, 24));
    assert!(
        left[0] > 2 * left[1] && right[1] > right[0],
        "red wall at the left, green at the right: {left:?} {right:?}"
    );
    assert_eq!(place.names(), ["box.png"]);
}

#[test]
fn quiet_is_quiet() {
    let place = Place::new();
    let outcome = place.ok(&["render", &cornell_box(), "-o", "box.png", "--size", "8x8", "--quiet", "--device", "cpu"]);
    assert_eq!((outcome.stdout.as_str(), outcome.stderr.as_str()), ("", ""));
}

#[test]
fn exr_carries_what_each_ray_hit() {
    let place = Place::new();
    place.ok(&["render", &cornell_box(), "-o", "box.exr", "--size", "32x32", "--quiet", "--device", "cpu"]);
    let channels = channels(place.read("box.exr"));
    let names: Vec<_> = channels.keys().map(String::as_str).collect();
    let expected = ["A", "Albedo.B", "Albedo.G", "Albedo.R", "B", "G", "Hit.Bary.U", "Hit.Bary.V", "Hit.T.V"];
    assert_eq!(names[..9], expected);
    assert_eq!(names[9..], ["Hit.TriId.V", "Normal.X", "Normal.Y", "Normal.Z", "R", "Samples.V", "Z"]);
    let FlatSamples::U32(ids) = &channels["Hit.TriId.V"] else { panic!("ids are not UINT") };
    assert!(ids.iter().all(|&id| id < 26), "every pixel of the closed box hits one of its triangles");
    // The centre of the top half shows the back wall, which faces the viewer.
    let centre = 12 * 32 + 20;
    let normal = ["Normal.X", "Normal.Y", "Normal.Z"].map(|n| floats(&channels, n)[centre].abs());
    assert_eq!(normal, [0.0, 0.0, 1.0]);
    let albedo = ["R", "G", "B"].map(|n| floats(&channels, &format!("Albedo.{n}"))[16 * 32 + 1]);
    assert_eq!(albedo, [0.65, 0.05, 0.05], "the red wall at the left");
    assert_eq!(channels["Samples.V"], FlatSamples::U32(vec![1; 32 * 32]));
    assert_eq!(floats(&channels, "Z"), floats(&channels, "Hit.T.V"));
    let depth = floats(&channels, "Z")[centre];
    assert!((1.0..10.0).contains(&depth), "depth {depth} is not in scene units");
    let (u, v) = (floats(&channels, "Hit.Bary.U"), floats(&channels, "Hit.Bary.V"));
    assert!(u.iter().zip(v).all(|(u, v)| *u >= 0.0 && *v >= 0.0 && u + v <= 1.0001));
}

/// Layers by bounce add up to the colour, and are the differences of pictures with fewer bounces.
#[test]
fn exr_carries_light_by_bounce() {
    let place = Place::new();
    let file = scene("lights.gltf").display().to_string();
    let render = |output: &str, depth: &str, more: &[&str]| {
        let sized = ["--size", "24x16", "--spp", "18", "--seed", "5", "--quiet", "--device", "cpu"];
        let path = ["--integrator", "path", "--max-depth", depth, "-o", output];
        place.ok(&[&["render", &file], &sized[..], &path[..], more].concat());
        channels(place.read(output))
    };
    let depths = ["0", "1", "2", "3", "4"].map(|depth| render("whole.exr", depth, &[]));
    let layered = render("layered.exr", "4", &["--by-bounce"]);
    assert_eq!(layered.len(), depths[4].len() + 5 * 3);
    let layers = ["Emitted", "Direct", "Indirect.2", "Indirect.3", "Indirect.4"];
    for channel in ["R", "G", "B"] {
        let wholes = depths.each_ref().map(|channels| floats(channels, channel));
        let parts = layers.map(|layer| floats(&layered, &format!("{layer}.{channel}")));
        assert_eq!(floats(&layered, channel), wholes[4], "the colour is that of a run without layers");
        assert_eq!(parts[0], wholes[0]);
        for i in 0..24 * 16 {
            for bounce in 1..5 {
                let part = parts[bounce][i];
                assert_eq!(part, wholes[bounce][i] - wholes[bounce - 1][i]);
                // Light is added: what is below 0 is the rounding of 18 samples' mean.
                assert!(part >= -1e-6 * wholes[4][i], "{} of pixel {i}: {part}", layers[bounce]);
            }
            let sum: f32 = parts.iter().map(|part| part[i]).sum();
            assert!((sum - wholes[4][i]).abs() <= 1e-6 * wholes[4][i], "pixel {i}: {sum}, not {}", wholes[4][i]);
        }
        let most = parts.map(|part| part.iter().fold(0.0f32, |most, v| most.max(*v)));
        assert!(most.iter().all(|most| *most > 1e-3), "{most:?}");
    }
}

#[test]
fn passes_csv_reads_strictly_and_adds_up() {
    let place = Place::new();
    let arguments = ["--size", "32x24", "--device", "cpu", "--counters", "--quiet"];
    let files = ["-o", "a.png", "--passes-csv", "passes.csv", "--summary-json", "run.json"];
    place.ok(&[&["render", &cornell_box()], &files[..], &arguments[..]].concat());
    let (bytes, json) = (place.read("passes.csv"), place.read("run.json"));
    let mut reader = csv::ReaderBuilder::new().flexible(false).from_reader(bytes.as_slice());
    let names = reader.headers().expect("a header").clone();
    assert_eq!(names.iter().collect::<Vec<_>>().join(","), crate::passes::COLUMNS);
    let column = |name: &str| names.iter().position(|n| n == name).expect("a column");
    let rows: Vec<_> = reader.records().map(|r| r.expect("as many fields as names")).collect();
    let sum = |name: &str| rows.iter().map(|r| r[column(name)].parse::<u64>().expect("a number")).sum::<u64>();
    for (i, row) in rows.iter().enumerate() {
        assert_eq!(row[column("pass_index")], i.to_string());
        assert_eq!((&row[column("clock")], &row[column("valid")]), ("cpu_clock", "true"));
        assert_eq!(&row[column("encode_ns")], "", "unknown values are empty");
        assert!(["256", "512", "768"].contains(&&row[column("threads_launched")]), "chunks of 512 and 256: {row:?}");
    }
    assert_eq!(&rows[0][column("begin_ns")], "0", "the first pass is the start of the run");
    assert_eq!((&rows[0][column("rays_in")], &rows[0][column("rays_out")]), ("768", "768"));
    let run: Value = serde_json::from_slice(&json).expect("JSON");
    assert_eq!(run["passes"], rows.len());
    assert_eq!(run["run_id"], rows[0][column("run_id")]);
    assert_eq!(run["scene_units_per_stream_unit"], 4.0);
    let options = &run["options"];
    assert_eq!((&options["grid"], &options["counters"]), (&"auto".into(), &true.into()));
    assert_eq!(options["scene_path"], cornell_box());
    assert_eq!(run["counters"]["triangles_tested"], sum("triangles_tested"));
    assert_eq!(run["counters"]["cells_visited"], sum("cells_visited"));
    assert!(run["kernels"]["walk"]["duration_ns"].is_u64());
    assert_eq!((&run["triangles"], &run["rays"], &run["hits"]), (&26.into(), &768.into(), &768.into()));
    assert_eq!(run["stream_bytes"]["hit"], 768 * 12);
    assert!(run["seconds"]["trace"].as_f64().is_some_and(|s| s > 0.0) && run["adapter"].is_null());
}

#[test]
fn trace_json_loads_as_trace_events_and_adds_up() {
    let place = Place::new();
    for device in ["cpu", "gpu"] {
        let files = ["-o", "a.png", "--trace-json", "trace.json", "--passes-csv", "passes.csv"];
        place.ok(&[&["render", &cornell_box(), "--size", "24x16", "--device", device], &files[..]].concat());
        let trace: Value = serde_json::from_slice(&place.read("trace.json")).expect("JSON");
        let events = trace["traceEvents"].as_array().expect("events");
        let slices =
            |category: &str| events.iter().filter(|e| e["cat"] == category && e["ph"] == "X").collect::<Vec<_>>();
        let sum = |slices: &[&Value]| slices.iter().map(|e| e["dur"].as_f64().expect("a length")).sum::<f64>();
        let about = |name: &str| trace["otherData"][name].as_f64().expect("a number");
        let bytes = place.read("passes.csv");
        let mut reader = csv::ReaderBuilder::new().flexible(false).from_reader(bytes.as_slice());
        let rows: Vec<_> = reader.records().map(|r| r.expect("a row")).collect();
        if trace["otherData"]["clock"] == "host" {
            // The adapter's clock is unreliable: the run as a whole has a time, but no pass.
            assert_eq!((device, slices("pass").len(), slices("run").len()), ("gpu", 0, 1));
            assert_eq!(about("passes_without_times") as usize, rows.len());
            assert!((sum(&slices("run")) * 1000.0 - about("host_run_ns")).abs() < 1.0 && about("host_run_ns") > 0.0);
            continue;
        }
        assert_eq!(slices("pass").len(), rows.len(), "{device}: every pass has its time");
        for (slice, row) in slices("pass").iter().zip(&rows) {
            assert_eq!(
                (&slice["name"], &slice["args"]["rays_in"]),
                (&row[15].into(), &row[19].parse::<u64>().expect("rays").into())
            );
            let begin_ns: f64 = row[16].parse().expect("a time");
            assert!((slice["ts"].as_f64().expect("a time") * 1000.0 - begin_ns).abs() < 0.01);
        }
        let whole = sum(&slices("pass")) + sum(&slices("gap")) - about("overlaps_us");
        assert!((whole - about("whole_us")).abs() < 1e-3 && whole > 0.0, "{device}: {whole} {}", about("whole_us"));
        // Every ray ends in DONE, and the last value of that counter shows it.
        let done = events.iter().rfind(|e| e["ph"] == "C" && e["name"] == "rays in DONE").expect("a counter");
        assert_eq!(done["args"]["rays"], 24 * 16);
    }
}

/// The same rule for all files: the adapter's clock if it is reliable, otherwise the host's time of the whole run.
#[test]
fn a_gpus_times_are_true_or_the_hosts() {
    let place = Place::new();
    let files = ["-o", "a.png", "--passes-csv", "passes.csv", "--summary-json", "run.json"];
    let base = ["render", &cornell_box(), "--size", "64x64", "--device", "gpu"];
    let outcome = place.ok(&[&base[..], &files[..]].concat());
    let info: Value = serde_json::from_str(&place.ok(&["info", "--json"]).stdout).expect("JSON");
    let run: Value = serde_json::from_slice(&place.read("run.json")).expect("JSON");
    let adapters = info["adapters"].as_array().expect("adapters");
    let adapter = adapters.iter().find(|a| a["name"] == run["adapter"]["name"]).expect("the adapter");
    let clock = &adapter["clock"];
    println!("{clock}");
    let bytes = place.read("passes.csv");
    let mut reader = csv::ReaderBuilder::new().flexible(false).from_reader(bytes.as_slice());
    let names = reader.headers().expect("a header").clone();
    let column = |name: &str| names.iter().position(|n| n == name).expect("a column");
    let rows: Vec<_> = reader.records().map(|r| r.expect("a row")).collect();
    let trace_ns = run["seconds"]["trace"].as_f64().expect("seconds") * 1e9;
    let is_true = rows[0][column("clock")] == *"gpu_timestamp";
    for row in &rows {
        let times = ["begin_ns", "duration_ns", "host_run_ns"].map(|name| !row[column(name)].is_empty());
        let (valid, source) = (&row[column("valid")], &row[column("clock")]);
        if is_true {
            assert_eq!((times, valid, source), ([true, true, true], "true", "gpu_timestamp"), "{row:?}");
        } else {
            assert_eq!((times, valid, source), ([false, false, true], "false", "host"), "{row:?}");
            let host_ns: f64 = row[column("host_run_ns")].parse().expect("a time");
            // All of the run's submissions, and little else.
            assert!(host_ns <= trace_ns && host_ns > 0.1 * trace_ns, "{host_ns} of {trace_ns} ns");
            assert_eq!(run["host_run_ns"], row[column("host_run_ns")].parse::<u64>().expect("a time"));
        }
    }
    if is_true {
        let sum: f64 = rows.iter().map(|r| r[column("duration_ns")].parse::<f64>().expect("a time")).sum();
        assert!(sum <= trace_ns, "{sum} of {trace_ns} ns");
    }
    assert_eq!(outcome.stderr.contains("passes have no times, a run has the host's"), !is_true, "{outcome:?}");
    assert_eq!(run["clock"], if is_true { "gpu_timestamp" } else { "host" });
    assert!(clock["host_ns"].as_u64() >= Some(1_000_000), "{clock}");
    // The clock is checked again in this run, and the result must be the same.
    assert_eq!(clock["agrees"], is_true, "{clock}");
}

#[test]
fn without_timers_the_time_is_null() {
    let place = Place::new();
    place.ok(&[
        "render",
        &cornell_box(),
        "-o",
        "a.png",
        "--summary-json",
        "run.json",
        "--size",
        "8x8",
        "--device",
        "cpu",
    ]);
    let run: Value = serde_json::from_slice(&place.read("run.json")).expect("JSON");
    let fused = run["kernels"]["fused"].as_object().expect("a kernel");
    assert!(fused["duration_ns"].is_null() && run["counters"].is_null());
}

#[test]
fn the_gpu_and_the_twins_draw_the_same_image() {
    let place = Place::new();
    let draw = |device: &str| {
        let (name, summary) = (format!("{device}.png"), format!("{device}.json"));
        let render = ["render", &cornell_box(), "-o", &name, "--device", device, "--size", "40x30"];
        place.ok(&[&render[..], &["--summary-json", &summary]].concat());
        let run: Value = serde_json::from_slice(&place.read(&summary)).expect("JSON");
        assert_eq!(run["device"], device, "it ran on another device");
        let image = image::load_from_memory(&place.read(&name)).expect("a PNG").to_rgb8();
        assert_eq!(image.dimensions(), (40, 30), "{device}");
        let colours: BTreeSet<_> = image.pixels().map(|p| p.0).collect();
        assert!(colours.len() > 100, "{device}: a picture of {} colours", colours.len());
        (image, run)
    };
    let ((cpu, on_cpu), (gpu, on_gpu)) = (draw("cpu"), draw("gpu"));
    println!("{}", on_gpu["adapter"]);
    assert!(on_cpu["adapter"].is_null() && on_gpu["adapter"]["name"].is_string(), "{on_gpu}");
    // Mesa's software Vulkan rounds as the twins do. Elsewhere a shaded value may round the other way, and is then off
    // by one step of 8 bits.
    let may_round = on_gpu["adapter"]["kind"] != "software";
    let furthest = cpu.as_raw().iter().zip(gpu.as_raw()).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(furthest.is_some_and(|furthest| furthest <= u8::from(may_round)), "{furthest:?}");
}

#[test]
fn scene_makes_and_converts_files_that_render() {
    let place = Place::new();
    place.ok(&["scene", "soup", "--triangles", "50", "--seed", "3", "-o", "soup.glb"]);
    std::fs::write(place.path("one.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("a file");
    place.ok(&["scene", "convert", "one.obj", "-o", "one.glb"]);
    for (name, triangles) in [("soup.glb", "triangles  50\n"), ("one.glb", "triangles  1\n")] {
        assert!(place.ok(&["info", name]).stdout.contains(triangles), "{name}");
        let outcome = place.ok(&["render", name, "-o", "x.png", "--size", "16x16", "--device", "cpu", "--check"]);
        assert!(outcome.stdout.contains("0 missed, 0 false, 0 wrong"), "{outcome:?}");
        let about: Value = serde_json::from_str(&place.ok(&["info", name, "--json"]).stdout).expect("JSON");
        let expected: Vec<_> = about["notes"]
            .as_array()
            .expect("notes")
            .iter()
            .map(|n| format!("note: {}", n.as_str().expect("text")))
            .collect();
        let said: Vec<_> = outcome.stderr.lines().filter(|l| l.starts_with("note: ")).collect();
        assert!(!said.is_empty() && said == expected, "each note once: {outcome:?}");
    }
}
