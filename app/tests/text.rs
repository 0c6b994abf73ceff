//! Output of the binary: help, plans, traces, adapters.

use serde_json::Value;

use crate::common::{Place, outcome, scene};

fn cornell_box() -> String {
    scene("cornell-box.gltf").display().to_string()
}

#[test]
fn help_has_examples_everywhere_and_no_argument_is_help() {
    let place = Place::new();
    let top = place.ok(&["--help"]).stdout;
    for name in [
        "inspect",
        "render",
        "trace",
        "dump",
        "bench",
        "build",
        "cast",
        "check-kernel",
        "export-program",
        "stop",
        "cost",
        "debug-adapter",
        "course",
        "grade",
        "merge",
        "report",
        "stability",
        "sweep",
        "plan",
        "paper",
        "info",
        "scene",
        "completions",
    ] {
        assert!(top.contains(&format!("  {name} ")), "{name} is not listed");
        let help = place.ok(&[name, "--help"]).stdout;
        let examples = help.split_once("Examples:\n").map(|(_, examples)| examples);
        assert!(examples.is_some_and(|e| e.contains("  raystep ")), "{name} --help has no example");
    }
    assert!(place.ok(&[]).stdout.contains("Usage: raystep"));
}

#[test]
fn plan_prints_what_is_left_out_and_why() {
    let place = Place::new();
    let text = place.ok(&["plan", &cornell_box(), "--size", "16x16", "--accelerator", "none"]).stdout;
    let [scene, options] =
        ["\nomitted, as the scene does not need it\n", "\nomitted with these options\n"].map(|title| text.find(title));
    let kernels = text.find("\nkernels\n");
    assert!(scene.is_some() && scene < kernels && kernels < options, "what the scene does not need is first: {text}");
    let of_scene = text
        .lines()
        .filter(|line| line.starts_with("  buffer normals ") || line.starts_with("  code for spot lights "));
    assert_eq!(of_scene.count(), 2, "{text}");
    let control = "  stream control: needed only with --accelerator grid --numerics paper --traversal 3d-dda";
    assert!(text.lines().any(|line| line == control), "{text}");
    let tail = &text[options.unwrap_or_default()..];
    let words = tail.split_whitespace().collect::<Vec<_>>().join(" ");
    let irregular = "stream voxel; buffers irregular_map, irregular_cells, irregular_items: needed only with --accelerator \
                     irregular stream";
    assert_eq!(words.matches(irregular).count(), 1, "a line for each option: {tail}");
    assert!(tail.lines().all(|line| line.chars().count() <= 100), "{tail}");
    let json = place.ok(&["plan", &cornell_box(), "--size", "16x16", "--json"]).stdout;
    let plan: Value = serde_json::from_str(&json).expect("JSON");
    let bytes = |list: &str| {
        plan[list].as_array().expect("a list").iter().map(|i| i["bytes"].as_u64().expect("bytes")).sum::<u64>()
    };
    assert_eq!(plan["bytes"], bytes("streams") + bytes("buffers"));
    assert!(
        plan["left_out"]
            .as_array()
            .expect("a list")
            .iter()
            .any(|l| l["what"] == "stream counters" && l["because"] == "options")
    );
    assert_eq!(plan["kernels"][0]["name"], "generate");
}

#[test]
fn trace_tells_a_life_that_ends_at_the_dumped_hit() {
    let place = Place::new();
    let common = ["--size", "32x32", "--device", "cpu", "--quiet"];
    let trace = ["trace", &cornell_box(), "--pixel", "2,25"];
    let json = place.ok(&[&trace[..], &common[..], &["--format", "json"]].concat()).stdout;
    let life: Value = serde_json::from_str(&json).expect("JSON");
    let rows = life["rows"].as_array().expect("rows");
    let last = &rows.last().expect("a row")["after"];
    assert_eq!(last["state"], "DONE");
    place.ok(&[&["dump", &cornell_box(), "--stream", "hit", "-o", "d"], &common[..]].concat());
    let name = place.names();
    assert_eq!(name, ["d"]);
    let index: Value = serde_json::from_slice(&place.read("d/index.json")).expect("JSON");
    let passes = index["passes"].as_array().expect("passes");
    let file = passes.last().expect("a pass")["files"][0].as_str().expect("a name");
    let hit = place.read(&format!("d/{file}"));
    let at = 128 + 4 * (2 * 1024 + 25 * 32 + 2);
    let triangle = u32::from_le_bytes([hit[at], hit[at + 1], hit[at + 2], hit[at + 3]]);
    assert_eq!(last["triangle"], triangle);

    let csv = place.ok(&[&trace[..], &common[..], &["--format", "csv"]].concat()).stdout;
    let mut reader = csv::ReaderBuilder::new().flexible(false).from_reader(csv.as_bytes());
    assert_eq!(reader.records().filter(|r| r.as_ref().is_ok_and(|r| r.len() == 22)).count(), rows.len());
    let table = place.ok(&[&trace[..], &common[..]].concat()).stdout;
    assert!(table.starts_with("ray ") && table.contains("\npass ") && table.contains("TRAV_SETUP"), "{table}");
    assert!(
        table.contains("\nlast  shade ") && table.contains("\nOnly this ray was traced (use --all-rays "),
        "{table}"
    );

    // Other rays are traced on request: the same rows, plus the numbers that depend on them.
    let json = place.ok(&[&trace[..], &common[..], &["--format", "json", "--all-rays"]].concat()).stdout;
    let mut whole: Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!((&life["rays"], &life["passes"], &whole["rays"]), (&1.into(), &Value::Null, &1024.into()));
    place.ok(&[&["dump", &cornell_box(), "--stream", "color", "-o", "e"], &common[..]].concat());
    let index: Value = serde_json::from_slice(&place.read("e/index.json")).expect("JSON");
    assert_eq!(whole["passes"], index["passes"].as_array().expect("passes").len());
    for row in whole["rows"].as_array().expect("rows") {
        assert_eq!(index["passes"][row["pass"].as_u64().expect("a number") as usize]["kernel"], row["kernel"]);
    }
    let last = rows.len() - 1;
    assert_eq!(whole["rows"][last]["pass"], whole["passes"].as_u64().expect("a number") - 1);
    whole["rows"][last]["pass"] = Value::Null;
    assert_eq!(whole["rows"], life["rows"]);
    let table = place.ok(&[&trace[..], &common[..], &["--all-rays"]].concat()).stdout;
    assert!(table.contains(&format!("\n{} passes. This ray waited in ", whole["passes"])), "{table}");
    let first = place.ok(&[&trace[..], &common[..4], &["--schedule", "first"]].concat());
    assert!(first.stderr.contains("note: a ray's passes depend on the other rays here (--schedule first"), "{first:?}");
    assert!(first.stdout.contains(" passes. This ray waited in ") && !first.stdout.contains("last "), "{first:?}");
    let typed = ["trace", &cornell_box(), "--ray", "0,0,5,0,0,-1"];
    let whole = place.ok(&[&typed[..], &common[2..]].concat()).stdout;
    // If the run has a single ray, its passes are known, including those in which it waits for its kernel.
    assert!(whole.contains(" passes. This ray waited in ") && !whole.contains("Only this ray was traced"), "{whole}");
    place.fails(2, "--ray is a single ray: omit one of them", &[&typed[..], &["--all-rays"]].concat());
}

#[test]
fn the_papers_rules_say_that_they_want_the_eye_inside() {
    let place = Place::new();
    let render = ["render", &cornell_box(), "-o", "a.png", "--size", "8x8", "--device", "cpu", "--numerics", "paper"];
    let said = |more: &[&str]| place.ok(&[&render[..], more].concat()).stderr.contains("note: the paper's rules");
    let eye = |eye| ["--eye", eye, "--look-at", "0,0,-0.5"];
    assert!(said(&eye("0,0,9")));
    assert!(!said(&eye("0,0,2")), "the eye is inside");
    assert!(!said(&[&eye("0,0,2")[..], &["--keep-all"]].concat()), "the eye is inside");
    assert!(!said(&[&eye("0,0,9")[..], &["--accelerator", "none"]].concat()), "there is no grid");
}

#[test]
fn a_view_along_up_says_which_up_is_taken() {
    let place = Place::new();
    let said = |more: &[&str]| {
        let plan = ["plan", &cornell_box(), "--size", "8x8", "--device", "cpu"];
        let stderr = place.ok(&[&plan[..], more].concat()).stderr;
        stderr.lines().filter(|l| l.contains("parallel to up")).map(str::to_owned).collect::<Vec<_>>().join("\n")
    };
    let down = ["--eye", "0,0.5,0", "--look-at", "0,0,0"];
    let ahead = ["--eye", "0,0,2", "--look-at", "0,0,0"];
    assert!(said(&down).contains("up (0,1,0): using [0, 0, 1]"), "{}", said(&down));
    assert!(said(&[&ahead[..], &["--up", "0,0,-3"]].concat()).contains("up (0,0,-3): using [0, 1, 0]"));
    assert_eq!(said(&ahead), "");
    assert_eq!(said(&[&down[..], &["--up", "0,0,5"]].concat()), "");
}

/// The number, such as `13` or `1,036`, at the end of a text.
fn last_number(text: &str) -> u64 {
    let digits = text.rsplit(|c: char| !(c.is_ascii_digit() || c == ',')).next().unwrap_or_default();
    digits.replace(',', "").parse().unwrap_or_else(|_| panic!("no number ends {text:?}"))
}

#[test]
fn the_docs_say_how_many_rays_check_counts_as_lost() {
    let docs = std::fs::read_to_string(scene("../docs/numerics.md")).expect("the docs");
    let said = |before: &str| last_number(docs.split_once(before).unwrap_or_else(|| panic!("no {before:?}")).0);
    let place = Place::new();
    let missed = |how: &[&str]| {
        let render = ["render", &cornell_box(), "-o", "a.png", "--numerics", "paper", "--check", "--device", "cpu"];
        let counted = place.ok(&[&render[..], how].concat()).stdout;
        assert!(counted.contains(" 0 false, 0 wrong,"), "{counted}");
        last_number(counted.split_once(" missed").expect("a count").0)
    };
    let (all, between_triangles) = (missed(&["--grid", "20"]), missed(&["--accelerator", "none"]));
    assert_eq!(all, said(" of 262,144 rays"));
    assert_eq!(between_triangles, said(" between triangles"));
    assert_eq!(all - between_triangles, said(" at voxel faces"));
}

#[test]
fn trace_help_says_when_and_in_which_units_values_are() {
    let help = Place::new().ok(&["trace", "--help"]).stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    for words in ["All values are those after the pass, except the state", "say which in their names", "t is depth"] {
        assert!(help.contains(words), "{words}: {help}");
    }
}

#[test]
fn a_ray_typed_in_hex_is_the_ray_typed_in_decimal() {
    let place = Place::new();
    let life = |ray: &str| place.ok(&["trace", &cornell_box(), "--ray", ray, "--device", "cpu", "--quiet"]).stdout;
    let decimal = life("-0.5,0.25,5,0,0,-1");
    assert_eq!(decimal, life("0xbf000000,0x3e800000,0x40a00000,0,0,0xbf800000"));
    assert!(decimal.contains("hit at t"), "{decimal}");
}

#[test]
fn info_and_render_say_that_there_is_no_adapter() {
    let place = Place::new();
    let without = |arguments: &[&str]| {
        let arguments: Vec<_> = arguments.iter().map(std::ffi::OsStr::new).collect();
        outcome(
            place
                .command(&arguments)
                .env("VK_DRIVER_FILES", "/nonexistent")
                .env("VK_ICD_FILENAMES", "/nonexistent")
                .env("__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent"),
        )
    };
    if !cfg!(target_os = "linux") {
        return;
    }
    let info = without(&["info"]);
    assert_eq!(info.code, Some(0), "{info:?}");
    assert!(info.stdout.contains("No GPU adapter was found") && info.stdout.contains("selects the CPU"), "{info:?}");
    let json: Value = serde_json::from_str(&without(&["info", "--json"]).stdout).expect("JSON");
    assert_eq!((&json["device"], json["adapters"].as_array().map(Vec::len)), (&"cpu".into(), Some(0)));
    let render = without(&["render", &cornell_box(), "-o", "a.png", "--size", "8x8"]);
    assert!(render.code == Some(0) && render.stderr.contains("no GPU adapter found; using the CPU"), "{render:?}");
    let gpu = without(&["render", &cornell_box(), "-o", "b.png", "--size", "8x8", "--device", "gpu"]);
    assert!(gpu.code == Some(1) && gpu.stderr.starts_with("error: no GPU adapter "), "{gpu:?}");
    assert_eq!(place.names(), ["a.png"]);
}

#[test]
fn info_lists_the_adapter_that_gpu_uses() {
    let place = Place::new();
    let info: Value = serde_json::from_str(&place.ok(&["info", "--json"]).stdout).expect("JSON");
    let adapters = info["adapters"].as_array().expect("a list");
    let usable: Vec<_> = adapters.iter().filter(|a| a["is_usable"] == true).collect();
    assert!(!usable.is_empty(), "an adapter, if only software, is needed: {info}");
    let name = usable[0]["name"].as_str().expect("a name");
    let outcome =
        place.ok(&["render", &cornell_box(), "-o", "a.png", "--size", "8x8", "--adapter", &name.to_uppercase()]);
    assert!(outcome.stderr.contains(name), "{outcome:?}");
}

#[test]
fn completions_know_every_subcommand_and_value() {
    let place = Place::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = place.ok(&["completions", shell]).stdout;
        let words =
            ["render", "trace", "dump", "bench", "sphere-flake", "robust", "second", "compact", "fused", "bvh", "auto"];
        for word in words.into_iter().chain(["steps-per-pass", "skip", "accelerators", "trace-json", "spp", "sobol"]) {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
}

#[test]
fn scene_list_shows_every_generator_with_its_parameters() {
    let list = Place::new().ok(&["scene", "list"]).stdout;
    for word in ["cornell-box", "soup", "--triangles N", "--seed N", "icosphere", "--subdivisions N"] {
        assert!(list.contains(word), "{word}");
    }
}
