//! Kernels as fragment programs, from the command line.

use std::collections::BTreeMap;

use crate::common::Place;
use crate::files::cornell_box;

const SMALL: [&str; 5] = ["--size", "20x16", "--device", "gpu", "--quiet"];

/// The rows of a file by the names of their columns.
fn rows(bytes: &[u8]) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::ReaderBuilder::new().flexible(false).from_reader(bytes);
    let names = reader.headers().expect("a header").clone();
    let named = |record: csv::StringRecord| {
        names.iter().zip(&record).map(|(name, value)| (name.to_owned(), value.to_owned())).collect()
    };
    reader.records().map(|record| named(record.expect("as many fields as names"))).collect()
}

#[test]
fn a_picture_is_the_same_and_every_draw_has_a_row() {
    let place = Place::new();
    let scene = cornell_box();
    place.ok(&[&["render", &scene, "-o", "a.png", "--schedule", "second"], &SMALL[..]].concat());
    let drawn = ["render", &scene, "-o", "b.png", "--mapping", "fragment", "--passes-csv", "b.csv"];
    place.ok(&[&drawn, &SMALL[..]].concat());
    assert!(place.read("a.png") == place.read("b.png"), "the pictures differ");
    let all = rows(&place.read("b.csv"));
    let of = |pass: &str| -> Vec<_> {
        let of_pass = all.iter().filter(|row| row["pass_index"] == pass);
        of_pass.map(|row| [&*row["kernel"], &row["draw"], &row["targets"], &row["bytes_copied"]]).collect()
    };
    assert_eq!(
        of("0"),
        [
            ["generate", "0", "state", "5120"],
            ["generate", "1", "ray_origin", "0"],
            ["generate", "2", "ray_direction", "0"],
            ["generate", "3", "hit", "0"],
            ["generate", "4", "state", "0"],
        ]
    );
    // The hit is read, for the order of hits at the same t.
    let state_and_hit = "10240";
    let intersect = [["intersect", "0", "hit state", state_and_hit], ["intersect", "1", "hit", "0"]];
    assert_eq!(of("2"), [&intersect[..], &[["intersect", "2", "state", "0"]]].concat());
    for row in &all {
        assert_eq!((&*row["mapping"], &*row["schema_version"]), ("fragment", "4"));
        let threads = if row["bytes_copied"] == "0" { "320" } else { "0" };
        assert_eq!((&*row["threads_launched"], &*row["fragments_run"]), (threads, ""), "{row:?}");
        assert!(row["duration_ns"].parse::<u64>().is_ok(), "{row:?}");
    }
    place.ok(&[&drawn[..], &["--trace-json", "b.json"], &SMALL[..]].concat());
    let json: serde_json::Value = serde_json::from_slice(&place.read("b.json")).expect("JSON");
    let events = json["traceEvents"].as_array().expect("events");
    let draws: Vec<_> = events.iter().filter(|event| event["cat"] == "draw").collect();
    assert_eq!((&draws[0]["name"], &draws[0]["args"]["bytes_copied"]), (&"copy state".into(), &5120.into()));
    assert_eq!((&draws[4]["name"], &draws[4]["args"]["fragments_drawn"]), (&"draw state".into(), &320.into()));
    assert!(draws.iter().all(|draw| draw["tid"] == 4) && draws.len() > 100, "{} draws", draws.len());
    let counted = ["--cull", "early-z", "--until", "count", "--count-fragments"];
    place.ok(&[&drawn, &counted[..], &SMALL[..]].concat());
    let all = rows(&place.read("b.csv"));
    let draws = all.iter().filter(|row| row["bytes_copied"] == "0");
    // A driver may count whole blocks of texels.
    assert!(draws.clone().all(|row| row["fragments_run"].parse::<u64>().is_ok_and(|n| n <= 8 * 320)), "{all:?}");
    assert!(draws.clone().any(|row| row["targets"] == "depth") && draws.count() > 100);
}

#[test]
fn a_rays_history_and_dumped_streams_are_the_same() {
    let place = Place::new();
    let scene = cornell_box();
    let trace = |mapping: &[&str]| {
        let all = ["trace", &scene, "--pixel", "7,9", "--format", "csv", "--schedule", "second"];
        let out = place.ok(&[&all[..], mapping, &["--size", "20x16", "--device", "gpu"]].concat()).stdout;
        // A query finds out with a pass more that a kernel has no rays, so the passes are numbered otherwise.
        let without_number = |line: &str| line.split_once(',').map(|(_, rest)| rest.to_owned()).expect("columns");
        out.lines().map(without_number).collect::<Vec<_>>()
    };
    let computed = trace(&[]);
    assert_eq!(trace(&["--mapping", "fragment"]), computed);
    assert!(computed.len() > 5, "{computed:?}");
    let dump = |name: &str, mapping: &[&str]| {
        let all = ["dump", &scene, "--pass", "last", "--stream", "all", "-o", name, "--schedule", "second"];
        place.ok(&[&all[..], mapping, &SMALL[..]].concat());
    };
    dump("a", &[]);
    dump("b", &["--mapping", "fragment", "--update", "swap", "--targets", "many"]);
    let files: Vec<_> =
        std::fs::read_dir(place.path("a")).expect("a folder").map(|e| e.expect("a file").file_name()).collect();
    let arrays = files.iter().filter(|name| name.to_string_lossy().ends_with(".npy"));
    assert!(arrays.clone().count() >= 6, "{files:?}");
    for name in arrays {
        let read = |folder: &str| std::fs::read(place.path(folder).join(name)).expect("an array");
        assert!(read("a") == read("b"), "{name:?} differs");
    }
}

#[test]
fn what_cannot_be_drawn_is_refused_in_a_line() {
    let place = Place::new();
    let scene = cornell_box();
    let fails = |wanted: &str, more: &[&str]| {
        place.fails(2, wanted, &[&["render", &scene, "-o", "a.png", "--size", "8x8"], more].concat());
    };
    let fragment = ["--mapping", "fragment"];
    let with = |more: &[&'static str]| [&fragment[..], more].concat();
    fails("no lists of live rays: use --schedule second or first", &with(&["--schedule", "compact"]));
    fails("use --schedule second or first, not fused", &with(&["--schedule", "fused"]));
    fails("draws on a GPU: use --device gpu", &with(&["--device", "cpu"]));
    fails("takes one sample per pixel", &with(&["--spp", "4"]));
    fails("--update swap needs --cull none", &with(&["--update", "swap", "--cull", "discard"]));
    fails("--cull none needs --until count", &with(&["--cull", "none", "--until", "query"]));
    fails("--targets is for fragment programs: omit it, or add --mapping fragment", &["--targets", "many"]);
    fails("--count-fragments requires --passes-csv <F> as well", &with(&["--count-fragments"]));
    let counted = ["--count-fragments", "--passes-csv", "p.csv"];
    fails("add --mapping fragment --until count", &counted);
    fails("add --mapping fragment --until count", &with(&counted));
    let bench = ["bench", &scene, "-o", "b", "--mappings"];
    place.fails(2, "such as fragment+many+early-z", &[&bench[..], &["fragment+swap+discard"]].concat());
    place.fails(2, "add --schedules second", &[&bench[..], &["fragment"]].concat());
}

#[test]
fn mappings_are_measured_side_by_side() {
    let place = Place::new();
    let scene = cornell_box();
    let what = ["--schedules", "second,fused", "--mappings", "compute,fragment+many", "--replay", "--repeats", "2"];
    let outcome = place.ok(&[&["bench", &scene, "-o", "b", "--sizes", "12x8", "--warmups", "0"], &what[..]].concat());
    let found: Vec<_> = rows(&place.read("b/summary.csv"))
        .iter()
        .map(|row| [row["schedule"].clone(), row["mapping"].clone()])
        .collect();
    assert_eq!(found, [["second", "compute"], ["second", "fragment+many"], ["fused", "compute"]]);
    assert!(outcome.stdout.contains("second    fragment+many"), "{outcome:?}");
    assert!(!outcome.stderr.contains("different hits"), "{outcome:?}");
    let passes = rows(&place.read("b/passes.csv"));
    let draws = passes.iter().filter(|row| row["targets"] == "hit state" && row["bytes_copied"] == "0");
    assert!(draws.count() > 10, "draws have their rows");
}

#[test]
fn the_plan_lists_the_draws() {
    let place = Place::new();
    let scene = cornell_box();
    let arguments =
        ["plan", &scene, "--size", "20x16", "--mapping", "fragment", "--cull", "early-z", "--device", "gpu"];
    let text = place.ok(&arguments).stdout;
    for line in [
        "draws (targets one, update copy, cull early-z, until query)",
        "    copy  hit, state                   10.0 KiB",
        "    depth from state                   drawn where it is 0.0234375",
        "    draw  state                        reads ray_origin, ray_direction, state, tmax, hit",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    let json = place.ok(&[&arguments[..], &["--json"]].concat()).stdout;
    let plan: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let kernels = plan["draws"]["kernels"].as_array().expect("kernels");
    let draws: Vec<_> = kernels.iter().map(|kernel| kernel["draws"].as_array().map_or(0, Vec::len)).collect();
    assert_eq!(draws, [4, 2, 2, 2, 2], "kernels times outputs: {plan}");
    let computed = place.ok(&["plan", &scene, "--json"]).stdout;
    assert!(!computed.contains("draws"), "{computed}");
}

/// Where there are no compute shaders, nothing has to be asked for; what is asked for, and cannot be, is refused.
#[test]
#[cfg_attr(not(target_os = "linux"), ignore = "needs the OpenGL of Mesa, or another one with EGL")]
fn an_adapter_that_only_draws_has_defaults_of_its_own() {
    let place = Place::new();
    let scene = cornell_box();
    let render = |name, more: &[&'static str]| {
        let on = ["render", &scene, "-o", name, "--size", "20x16", "--adapter", "opengl"];
        place.ok(&[&on, more].concat()).stderr
    };
    let told = render("a.png", &[]);
    let note =
        "has no compute shaders, so kernels are drawn: --mapping fragment --scene-data textures --schedule second";
    let notes: Vec<_> = told.lines().filter(|line| line.contains("compute shaders")).collect();
    assert!(matches!(notes[..], [line] if line.starts_with("note: ") && line.ends_with(note)), "{told}");
    let told = render("b.png", &["--mapping", "fragment", "--scene-data", "textures", "--schedule", "second"]);
    assert!(!told.contains("compute shaders"), "{told}");
    assert!(place.read("a.png") == place.read("b.png"), "the pictures differ");
    let told = render("c.png", &["--schedule", "first", "--accelerator", "bvh", "--mapping", "fragment"]);
    assert!(told.contains("--scene-data textures --schedule first"), "{told}");
    let wants = "use --mapping fragment --scene-data textures";
    for (refused, why) in [
        (&["--mapping", "compute"][..], wants),
        (&["--scene-data", "buffers"], wants),
        (&["--mapping", "fragment", "--until", "count"], wants),
        (&["--schedule", "compact"], "use --schedule second or first, not compact"),
        (&["--spp", "2"], "takes one sample per pixel"),
    ] {
        let on = ["render", &scene, "-o", "d.png", "--size", "20x16", "--adapter", "opengl", "--quiet"];
        place.fails(1, why, &[&on, refused].concat());
    }
}
