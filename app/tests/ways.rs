//! Accelerators and schedules: the same image in every configuration, messages about them, and invalid combinations.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::common::{Place, scene};

const ACCELERATORS: [&str; 4] = ["grid", "bvh", "none", "auto"];
const SCHEDULES: [&str; 4] = ["first", "second", "compact", "fused"];

fn cornell_box() -> String {
    scene("cornell-box.gltf").display().to_string()
}

fn json(place: &Place, name: &str) -> Value {
    serde_json::from_slice(&place.read(name)).expect("JSON")
}

/// Rows of a `passes.csv` by column.
fn passes(place: &Place, name: &str) -> Vec<BTreeMap<String, String>> {
    let file = place.read(name);
    let mut reader = csv::ReaderBuilder::new().flexible(false).from_reader(file.as_slice());
    reader.deserialize().map(|row| row.expect("as many fields as names")).collect()
}

/// The largest difference in a colour channel between two images.
fn furthest(a: &[u8], b: &[u8]) -> u8 {
    let colours = |file| image::load_from_memory(file).expect("a PNG").to_rgb8().into_raw();
    colours(a).iter().zip(colours(b)).map(|(a, b)| a.abs_diff(b)).max().unwrap_or(0)
}

#[test]
fn every_accelerator_with_every_schedule_draws_the_same_image() {
    let place = Place::new();
    for device in ["cpu", "gpu"] {
        let mut first: Option<Vec<u8>> = None;
        for (accelerator, schedule) in ACCELERATORS.iter().flat_map(|a| SCHEDULES.map(|s| (*a, s))) {
            let how = ["--accelerator", accelerator, "--schedule", schedule, "--device", device];
            let files = ["-o", "a.png", "--size", "24x16", "--summary-json", "run.json", "--quiet"];
            place.ok(&[&["render", &cornell_box()], &how[..], &files[..]].concat());
            let run = json(&place, "run.json");
            assert_eq!(run["options"]["accelerator"], accelerator);
            assert_eq!(run["accelerator"], if accelerator == "auto" { "bvh" } else { accelerator });
            assert_eq!((&run["hits"], &run["unfinished"]), (&384.into(), &0.into()), "{how:?}");
            let image = place.read("a.png");
            let first = first.get_or_insert_with(|| image.clone());
            // A GPU's compiler may round differently from kernel to kernel: at most one step of 8 bits.
            let may_round = !run["adapter"].is_null() && run["adapter"]["kind"] != "software";
            assert!(image == *first || may_round && furthest(&image, first) <= 1, "{how:?} draws another image");
        }
    }
}

#[test]
fn a_pass_says_how_many_threads_it_launched() {
    let place = Place::new();
    let (width, height) = (100u64, 70u64);
    let covering = |side: u64| width.next_multiple_of(side) * height.next_multiple_of(side);
    for (device, schedule) in ["cpu", "gpu"].into_iter().flat_map(|d| SCHEDULES.map(|s| (d, s))) {
        // With eight steps per pass there would be too few passes for a whole chunk of 512 rays to finish early and be
        // skipped.
        let steps: &[&str] = if (device, schedule) == ("cpu", "compact") { &["--steps-per-pass", "2"] } else { &[] };
        let how = [&["--size", "100x70", "--device", device, "--schedule", schedule, "--quiet"], steps].concat();
        let files = ["-o", "a.png", "--passes-csv", "passes.csv", "--trace-json", "trace.json"];
        place.ok(&[&["render", &cornell_box()], &how[..], &files[..]].concat());
        let passes = passes(&place, "passes.csv");
        let number = |row: &BTreeMap<String, String>, name: &str| row[name].parse::<u64>().expect("a number");
        let mut fewest = u64::MAX;
        for row in &passes {
            let (rays, threads) = (number(row, "rays_in"), number(row, "threads_launched"));
            let kernel = row["kernel"].as_str();
            match (device, kernel) {
                // Chunks of 512 rays; the last one has 7000 - 13 * 512 = 344 rays.
                ("cpu", _) => {
                    assert!(threads >= rays && [0, 344].contains(&(threads % 512)) && threads <= 7000, "{row:?}");
                }
                ("gpu", "generate" | "fused" | "shade") => assert_eq!(threads, covering(8), "{row:?}"),
                // Rows of eight workgroups of 16 x 16, enough for the list.
                ("gpu", "walk") => assert_eq!(threads, rays.next_multiple_of(8 * 256), "{row:?}"),
                _ => assert_eq!(threads, covering(16), "{row:?}"),
            }
            fewest = fewest.min(threads);
        }
        match (device, schedule) {
            // The launch size follows the rays: their list on a GPU, the chunks with any of them on the CPU.
            (_, "compact") | ("cpu", "first" | "second") => {
                assert!(fewest < 7000, "the last rays need fewer threads: {device} {schedule}: {fewest}");
            }
            // Every pass launches the whole image.
            (_, "fused") | ("gpu", "first" | "second") => assert!(fewest >= 7000, "{device} {schedule}: {fewest}"),
            _ => panic!("{device} {schedule} is not tested"),
        }
        let trace = json(&place, "trace.json");
        let slices = trace["traceEvents"].as_array().expect("events").iter().filter(|e| e["cat"] == "pass");
        let threads: Vec<u64> = slices.map(|e| e["args"]["threads_launched"].as_u64().expect("threads")).collect();
        assert_eq!(threads, passes.iter().map(|row| number(row, "threads_launched")).collect::<Vec<_>>());
    }
}

#[test]
fn render_says_what_was_built() {
    let place = Place::new();
    let one = scene("single-triangle.gltf").display().to_string();
    let file = cornell_box();
    let cases: &[(&str, &[&str], &str, &str)] = &[
        (&file, &["--accelerator", "grid"], "grid      4 x 4 x 9 cells; ", " empty cells, not skipped; "),
        (&file, &["--skip", "on"], "grid      8 x 8 x 19 cells; ", " empty cells, skipped; "),
        (&file, &["--accelerator", "bvh", "--schedule", "compact"], "bvh       binary tree: nodes ", ", depth "),
        (&file, &["--accelerator", "bvh", "--schedule", "fused"], "bvh       eight-wide tree: nodes ", ", depth "),
        (&file, &["--accelerator", "none"], "none      every ray tests every triangle", ""),
        (
            &file,
            &["--accelerator", "auto", "--schedule", "second"],
            "bvh       binary tree: ",
            " (auto: more than 6 triangles)",
        ),
        (&one, &["--accelerator", "auto"], "none      every ray tests every triangle (auto: 6 triangles or fewer ", ""),
    ];
    for (scene, how, start, rest) in cases {
        let view = [scene, "--size", "8x8", "--device", "cpu"];
        let outcome = place.ok(&[&["render", "-o", "a.png"], &view[..], how].concat());
        let is_said = |text: &str| text.lines().any(|l| l.starts_with(start) && l.contains(rest));
        assert!(is_said(&outcome.stderr) && outcome.stderr.contains("plan and structure"), "{how:?}: {outcome:?}");
        assert!(is_said(&place.ok(&[&["plan"], &view[..], how].concat()).stdout), "{how:?}");
    }
}

#[test]
fn summaries_in_json_have_the_grid_or_the_tree() {
    let place = Place::new();
    let summary = |how: &[&str]| {
        let render = ["render", &cornell_box(), "-o", "a.png", "--size", "8x8", "--device", "cpu", "--quiet"];
        place.ok(&[&render[..], &["--counters", "--summary-json", "run.json"], how].concat());
        let plan = ["plan", &cornell_box(), "--size", "8x8", "--device", "cpu", "--quiet", "--json"];
        let plan: Value = serde_json::from_str(&place.ok(&[&plan[..], how].concat()).stdout).expect("JSON");
        let run = json(&place, "run.json");
        for key in ["accelerator", "accelerator_because", "grid", "bvh"] {
            assert!(run.get(key).is_some() && run.get(key) == plan.get(key), "{how:?}: {key}");
        }
        run
    };
    let sum =
        |run: &Value, names: &[&str]| names.iter().filter_map(|name| run["buffer_bytes"][name].as_u64()).sum::<u64>();

    let grid = summary(&["--skip", "on", "--schedule", "compact"]);
    assert_eq!((&grid["accelerator"], &grid["accelerator_because"]), (&"grid".into(), &"--accelerator grid".into()));
    assert_eq!((&grid["grid"]["leaps"], &grid["options"]["skip"]), (&true.into(), &"on".into()));
    assert_eq!(grid["grid"]["bytes"], sum(&grid, &["grid_cells", "grid_items", "grid_distances"]));
    assert!(grid["bvh"].is_null() && grid["grid"]["empty_cells"].is_u64());
    // Counters that a pass of several steps cannot update are unknown.
    assert!(grid["counters"]["repeated_tests"].is_null() && grid["options"]["steps_per_pass"] == 8);
    assert!(grid["seconds"]["plan_and_grid"].is_number());

    let binary = summary(&["--accelerator", "bvh", "--schedule", "second"]);
    assert_eq!((&binary["bvh"]["width"], &binary["bvh"]["references"]), (&2.into(), &26.into()));
    assert_eq!(binary["bvh"]["bytes"], sum(&binary, &["bvh_nodes", "bvh_parents", "bvh_items"]));
    assert!(binary["grid"].is_null() && binary["bvh"]["depth"].as_u64() > Some(3));
    // Repeated tests are not counted with a BVH, but with the grid if it takes single steps.
    assert!(binary["counters"]["repeated_tests"].is_null() && binary["options"]["steps_per_pass"] == 1);
    assert!(summary(&["--schedule", "second"])["counters"]["repeated_tests"].is_u64());

    let wide = summary(&["--accelerator", "auto", "--schedule", "fused"]);
    assert_eq!((&wide["bvh"]["width"], &wide["accelerator_because"]), (&8.into(), &"more than 6 triangles".into()));
    assert_eq!(wide["bvh"]["bytes"], sum(&wide, &["wide_nodes"]));
    assert!(wide["options"]["steps_per_pass"].is_null() && wide["options"]["accelerator"] == "auto");
    assert!(summary(&["--accelerator", "none"])["bvh"].is_null());
}

#[test]
fn what_would_have_no_effect_is_refused() {
    let place = Place::new();
    let file = cornell_box();
    let render = ["render", &file, "-o", "a.png", "--size", "8x8", "--device", "cpu", "--quiet"];
    let cases: &[(&str, &[&str])] = &[
        ("--steps-per-pass 0: expected an integer from 1 to 4096", &["--steps-per-pass", "0"]),
        ("4097: expected an integer from 1 to 4096", &["--steps-per-pass", "4097"]),
        ("99999999999999999999: expected an integer from 1 to 4096", &["--steps-per-pass", "99999999999999999999"]),
        ("use --schedule compact", &["--steps-per-pass", "2", "--schedule", "first"]),
        ("not to fused", &["--steps-per-pass", "8", "--schedule", "fused"]),
        (
            "--skip on applies to a uniform grid, and accelerator bvh has no such grid",
            &["--skip", "on", "--accelerator", "bvh"],
        ),
        ("accelerator auto chooses its own", &["--grid", "8", "--accelerator", "auto"]),
        ("use --numerics robust", &["--skip", "on", "--numerics", "paper"]),
        ("expected auto, on or off", &["--skip", "maybe"]),
        (
            "--max-depth 3 applies to --integrator whitted, path or photons, not to shadows",
            &["--max-depth", "3", "--integrator", "shadows"],
        ),
        ("has at most 8 with --integrator whitted", &["--max-depth", "9", "--integrator", "whitted"]),
        ("--max-depth 65: expected an integer from 0 to 64", &["--max-depth", "65", "--integrator", "path"]),
        ("--strategy bsdf applies to --integrator path, not to local", &["--strategy", "bsdf"]),
        ("--max-depth 9: a photon bounces at most 8 times", &["--max-depth", "9", "--integrator", "photons"]),
        ("--photons 0: expected an integer from 1 to ", &["--photons", "0", "--integrator", "photons"]),
        (
            "--photon-map bitonic applies to --integrator photons, not to path",
            &["--photon-map", "bitonic", "--integrator", "path"],
        ),
    ];
    for (wanted, how) in cases {
        place.fails(2, wanted, &[&render[..], how].concat());
    }
    for how in [
        &["--steps-per-pass", "1", "--schedule", "first"][..],
        &["--steps-per-pass", "4096"],
        &["--skip", "off", "--accelerator", "bvh"],
        &["--max-depth", "0", "--integrator", "whitted"],
        &["--max-depth", "9", "--integrator", "path", "--strategy", "light"],
        &["--integrator", "photons", "--photons", "100", "--photon-map", "bitonic", "--neighbours", "exact"],
    ] {
        place.ok(&[&render[..], how].concat());
    }
    let bench = ["bench", &file, "-o", "out", "--sizes", "8x8", "--device", "cpu", "--repeats", "1"];
    place.fails(
        2,
        "accelerator bvh has no such grid",
        &[&bench[..], &["--skip", "on", "--accelerators", "bvh,none"]].concat(),
    );
    place.ok(&[&bench[..], &["--skip", "on", "--accelerators", "bvh,grid"]].concat());
}

#[test]
fn rough_metal_is_said_to_be_drawn_as_diffuse_where_rays_go_on() {
    let place = Place::new();
    let text = std::fs::read_to_string(scene("single-triangle.gltf")).expect("a scene");
    let metal = r#""materials": [{"name": "brass", "pbrMetallicRoughness": {"metallicFactor": 1, "roughnessFactor": ROUGH}}],
        "meshes": [{"primitives": [{"material": 0, "attributes""#;
    let [rough, smooth] = [("rough", "0.4"), ("smooth", "0")].map(|(name, roughness)| {
        let text = text.replacen(r#""meshes": [{"name": "triangle", "primitives": [{"attributes""#, metal, 1);
        let file = place.path(format!("{name}.gltf"));
        std::fs::write(&file, text.replace("ROUGH", roughness)).expect("a file");
        file.display().to_string()
    });
    let note = "note: material \"brass\" is a rough metal or rough glass, and is drawn as a diffuse surface";
    for (file, integrator, is_told) in
        [(&rough, "path", true), (&rough, "whitted", true), (&rough, "shadows", false), (&smooth, "path", false)]
    {
        let render = ["render", file, "-o", "a.png", "--size", "8x8", "--device", "cpu"];
        let said = place.ok(&[&render[..], &["--integrator", integrator]].concat()).stderr;
        assert_eq!(said.lines().any(|line| line == note), is_told, "{file}, {integrator}: {said}");
    }
}

#[test]
fn several_samples_make_another_picture_and_the_same_one_twice() {
    let place = Place::new();
    let file = cornell_box();
    let render = |name: &str, how: &[&str]| {
        let summary = format!("{name}.json");
        let args = ["render", &file, "-o", name, "--size", "24x20", "--summary-json", &summary];
        let said = place.ok(&[&args[..], how].concat()).stderr;
        let summary: serde_json::Value = serde_json::from_slice(&place.read(&summary)).expect("JSON");
        (image::load_from_memory(&place.read(name)).expect("a picture").to_rgb8(), summary, said)
    };
    let cpu = ["--device", "cpu"];
    let (centre, summary, said) = render("a.png", &cpu);
    assert!(summary["options"]["spp"] == 1 && summary["options"]["sampler"].is_null() && !said.contains("samples"));
    assert_eq!(render("b.png", &["--device", "cpu", "--spp", "1"]).0, centre);
    let (many, summary, said) = render("c.png", &["--device", "cpu", "--spp", "16", "--counters", "--check"]);
    assert!(many != centre && said.contains("samples   16 per pixel, sobol, seed 0"), "{said}");
    let options = &summary["options"];
    assert_eq!((&options["spp"], &options["sampler"], &options["seed"]), (&16.into(), &"sobol".into(), &0.into()));
    assert_eq!(summary["kernels"]["accumulate"]["passes"], 16);
    assert_eq!(summary["kernels"]["generate"]["rays_in"], 16 * 24 * 20);
    assert!(summary["stream_bytes"]["accumulated"] == 5 * 4 * 24 * 20 && summary["check"]["wrong"] == 0);
    // The middle of the back wall is unchanged; edges have intermediate colours.
    let far = |a: &image::Rgb<u8>, b: &image::Rgb<u8>| (0..3).any(|c| a.0[c].abs_diff(b.0[c]) > 40);
    let apart = centre.pixels().zip(many.pixels()).filter(|(a, b)| far(a, b)).count();
    assert!((1..200).contains(&apart), "{apart} of 480 pixels");
    for how in [&cpu[..], &["--device", "gpu"], &["--schedule", "fused"], &["--accelerator", "bvh", "--device", "cpu"]]
    {
        assert_eq!(render("d.png", &[how, &["--spp", "16"]].concat()).0, many, "{how:?}");
    }
    for how in [&["--seed", "1"][..], &["--sampler", "random"]] {
        assert_ne!(render("e.png", &[&cpu[..], &["--spp", "16"], how].concat()).0, many, "{how:?}");
    }
}

#[test]
fn samples_that_cannot_be_are_refused_in_a_line() {
    let place = Place::new();
    let file = cornell_box();
    let render = ["render", &file, "-o", "a.png", "--size", "8x8", "--device", "cpu", "--quiet"];
    for (wanted, how) in [
        ("--spp 0: expected an integer from 1 to 65536", &["--spp", "0"][..]),
        ("65537: expected an integer from 1 to 65536", &["--spp", "65537"]),
        ("--spp x: expected an integer from 1 to 65536", &["--spp", "x"]),
        ("expected sobol or random", &["--spp", "4", "--sampler", "blue"]),
        ("add --spp N", &["--sampler", "random"]),
        ("add --spp N", &["--seed", "7"]),
    ] {
        place.fails(2, wanted, &[&render[..], how].concat());
    }
    let ray = ["trace", &file, "--ray", "0,0,5,0,0,-1", "--size", "8x8", "--device", "cpu"];
    place.fails(2, "--ray is a single ray", &[&ray[..], &["--spp", "2"]].concat());
    place.ok(&[&ray[..], &["--spp", "1"]].concat());
    // The history of a ray continues with the next sample, and the link contains the number of samples.
    let traced =
        place.ok(&["trace", &file, "--pixel", "3,4", "--size", "8x8", "--device", "cpu", "--spp", "3", "--print-link"]);
    for words in ["sample 1: a ray", "sample 3: a ray", "mean of 2 of 3 samples: on to the next", "mean of 3 of 3"] {
        assert!(traced.stdout.contains(words), "{words}: {traced:?}");
    }
    assert!(traced.stderr.contains("spp=3"), "{traced:?}");
    // Hits belong to one sample, so a dump of them comes from a run that shades.
    let dump = ["dump", &file, "-o", "d", "--stream", "hit", "--pass", "last", "--size", "8x8", "--device", "cpu"];
    place.ok(&[&dump[..], &["--spp", "2"]].concat());
    assert!(place.ok(&["plan", &file, "--spp", "2", "--device", "cpu"]).stdout.contains("accumulate"));
    assert!(place.ok(&["plan", &file, "--device", "cpu"]).stdout.contains("needed only with --spp 2 or more"));
}

#[test]
fn what_has_one_pass_is_not_looked_at_pass_by_pass() {
    let place = Place::new();
    let file = cornell_box();
    let fused = ["--schedule", "fused", "--size", "8x8", "--device", "cpu"];
    place.fails(2, "use first, second or compact", &[&["trace", &file, "--pixel", "1,1"], &fused[..]].concat());
    for pass in ["all", "0"] {
        let dump = ["dump", &file, "-o", "d", "--pass", pass];
        place.fails(
            2,
            "use --pass last for its hits, or schedule first, second or compact",
            &[&dump[..], &fused[..]].concat(),
        );
    }
    place.ok(&[&["dump", &file, "-o", "fused", "--stream", "hit"], &fused[..]].concat());
    place.ok(&["dump", &file, "-o", "stepped", "--stream", "hit", "--size", "8x8", "--device", "cpu"]);
    let hit = |folder: &str| {
        let index = json(&place, &format!("{folder}/index.json"));
        let last = index["passes"].as_array().and_then(|p| p.last()).expect("a pass").clone();
        place.read(&format!("{folder}/{}", last["files"][0].as_str().expect("a name")))
    };
    assert!(hit("fused") == hit("stepped"), "the same hits");
}
