use std::collections::BTreeMap;

use super::*;
use crate::export::npy;
use crate::options::{Options, RaySource};
use crate::plan::{Limits, Plan};
use crate::program::schedule::Cursor;
use crate::tables::state::Population;
use crate::{Device, Renderer};

const MANIFEST: &str = r#"
[constants]
ADDED = 2

[elements]
items = { count = 5 }

[streams.item]
type = "u32"

[kernels]
add = { }

[schedule]
steps = [{ repeat = 3, name = "round", steps = [{ run = "add" }] }]

[result]
stream = "item"
"#;

const ADD: &str = r"
import package::launch::{BLOCK, element, launch, texel};
import package::program::{ADDED};
@group(0) @binding(0) var item: texture_storage_2d_array<r32uint, read_write>;
@compute @workgroup_size(BLOCK)
fn add(@builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = element(group, groups, lane);
    if (i >= launch.elements) {
        return;
    }
    let at = texel(i, launch.width);
    textureStore(item, at, 0, vec4u(textureLoad(item, at, 0).x + ADDED));
}
";

fn folder(files: &[(&str, &[u8])]) -> Arc<Folder> {
    let files: BTreeMap<String, Vec<u8>> = files.iter().map(|(name, bytes)| ((*name).into(), bytes.to_vec())).collect();
    Arc::new(Folder::new("mine".into(), "some/mine".into(), files).expect("a folder"))
}

fn of(manifest: &str, wgsl: &str) -> Result<Arc<Own>, Box<Mistake>> {
    read(&folder(&[("program.toml", manifest.as_bytes()), ("add.wgsl", wgsl.as_bytes())]))
}

/// What a program that starts from these files leaves in its stream.
fn ran(files: &[(&str, &[u8])], stream: &str) -> StreamData {
    let folder = folder(files);
    let rays = RaySource::Given(Vec::new());
    let options = Options { folder: Some(folder), ..Options::new(rays) };
    let (plan, data) = Plan::new(&Default::default(), &options, &Limits::CPU).expect("a plan");
    let stream = plan.program.stream(stream).expect("a stream");
    pollster::block_on(async {
        let mut renderer = Renderer::from_plan(plan, data, &options, &Device::Cpu(None)).await.expect("a run");
        renderer.run(|_| std::ops::ControlFlow::Continue(())).await.expect("no failure");
        renderer.values(stream).await.expect("values")
    })
}

#[test]
fn a_program_is_read_from_its_files_and_runs() {
    let own = of(MANIFEST, ADD).unwrap_or_else(|mistake| panic!("{mistake}"));
    let mut cursor = Cursor::start();
    let population = Population::default();
    let passes = std::iter::from_fn(|| cursor.next(&own.schedule, &population).map(|kernel| kernel.name()));
    assert_eq!(passes.collect::<Vec<_>>(), ["add"; 3]);
    assert_eq!(own.result.map(|result| (result.stream.name(), result.layer)), Some(("item", Some(0))));
    // The same files are the same program.
    assert!(std::ptr::eq(own.program, of(MANIFEST, ADD).expect("a program").program));
    let data = ran(&[("program.toml", MANIFEST.as_bytes()), ("add.wgsl", ADD.as_bytes())], "item");
    assert_eq!(data.layer(0)[..5], [6; 5]);
}

#[test]
fn streams_begin_with_numbers_and_files() {
    let with = |start: &str, extra: (&str, &[u8])| {
        let manifest = MANIFEST.replace("type = \"u32\"", &format!("type = \"u32\"\nstart = {start}"));
        ran(&[("program.toml", manifest.as_bytes()), ("add.wgsl", ADD.as_bytes()), extra], "item").layer(0)[..5]
            .to_vec()
    };
    assert_eq!(with("7", ("x", b"")), [13; 5]);
    let raw: Vec<u8> = (0..5u32).flat_map(|i| (10 * i).to_le_bytes()).collect();
    assert_eq!(with("{ raw = \"a.bin\" }", ("a.bin", &raw)), [6, 16, 26, 36, 46]);
    let mut array = Vec::new();
    npy::write_bits(&mut array, false, [1, 1, 5], &[1, 2, 3, 4, 5]).expect("written");
    let text = String::from_utf8_lossy(&array[..128]).into_owned();
    assert!(text.contains("(1, 1, 5)"), "{text}");
    // Elements that are no image have one axis.
    let array: Vec<u8> = [array[..128].to_vec(), array[128..].to_vec()].concat();
    let flat = String::from_utf8_lossy(&array[10..128]).replace("(1, 1, 5)", "(5,)     ");
    let array = [&array[..10], flat.as_bytes(), &array[128..]].concat();
    assert_eq!(with("{ npy = \"a.npy\" }", ("a.npy", &array)), [7, 8, 9, 10, 11]);
    let four = MANIFEST.replace("count = 5", "count = 4");
    let four = four.replace("type = \"u32\"", "type = \"u32\"\nstart = { npy = \"a.npy\" }");
    let files = [("program.toml", four.as_bytes()), ("add.wgsl", ADD.as_bytes()), ("a.npy", array.as_slice())];
    let mistake = read(&folder(&files)).err().expect("another shape").to_string();
    assert!(mistake.starts_with("some/mine/program.toml:10:"), "{mistake}");
    assert!(mistake.contains("its shape is (5,): expected (4,), (1, 4) or (4, 1)"), "{mistake}");
}

/// A change of the manifest or of the kernel, and what is said of it.
#[test]
fn a_mistake_is_told_with_its_place() {
    let manifest = |from: &str, to: &str| {
        assert!(MANIFEST.contains(from), "{from}");
        of(&MANIFEST.replacen(from, to, 1), ADD)
    };
    let cases = [
        ("count = 5", "count = 5000000000", "6:", "an integer from 0 to 4294967295"),
        ("count = 5", "count = 70000000", "6:", "at most 67108864"),
        ("count = 5", "image = [0, 3]", "6:", "1 to 16384"),
        ("count = 5", "", "6:", "image = [columns, rows], count, per, found and scene"),
        ("count = 5", "count = 5, image = [2, 2]", "6:", "one of"),
        ("count = 5", "found = \"item\"", "6:", "main one"),
        ("type = \"u32\"", "type = \"f64\"", "9:", "f64"),
        ("type = \"u32\"", "type = \"u32\"\nof = \"rays\"", "8:", "no set of elements is named rays"),
        ("type = \"u32\"", "type = \"u32\"\nstart = -1", "10:", "`start`: expected an integer from 0"),
        ("type = \"u32\"", "type = \"u32\"\nstart = [1, 2]", "10:", "2 numbers, and the stream has 1 layer"),
        ("type = \"u32\"", "type = \"u32\"\nstart = { npy = \"none.npy\" }", "10:", "none.npy is not in the folder"),
        ("type = \"u32\"", "type = \"u32\"\nmeaning = \"state\"", "8:", "[states]"),
        ("type = \"u32\"", "type = \"u32\"\nmeaning = \"integer\"", "", "expected float, distance, light, count,"),
        ("type = \"u32\"", "type = \"u32\"\ncolour = 3", "10:", "unknown field"),
        ("add = { }", "add = 3", "12:", "expected a kernel such as"),
        ("add = { }", "add = { file = \"other.wgsl\" }", "12:", "other.wgsl is not in the folder"),
        ("add = { }", "add = { over = \"rays\" }", "12:", "no set of elements is named rays; the sets are: items"),
        ("add = { }", "add = { takes = [\"GO\"] }", "12:", "no state is named GO"),
        ("add = { }", "\"a-b\" = { file = \"add.wgsl\" }", "12:", "cannot be named"),
        ("run = \"add\"", "run = \"sub\"", "15:", "no kernel is named sub; the kernels are: add"),
        ("repeat = 3", "repeat = 2000000", "15:", "1000000 passes"),
        ("repeat = 3", "repeat = 4000000000", "15:", "1000000 passes"),
        (", steps = [{ run = \"add\" }]", "", "15:", "steps"),
        ("run = \"add\"", "run = \"add\", name = \"a\"", "15:", "`name` is allowed only in a `repeat` step"),
        ("repeat = 3", "repeat = 3, parameter = 1", "15:", "`parameter` is allowed only in a `run` step"),
        ("repeat = 3, name = \"round\"", "run = \"add\"", "15:", "`run` runs one kernel and takes no `steps`"),
        ("repeat = 3", "repeat = \"3\"", "", "expected a number from 0 to 4294967295, or { first"),
        ("run = \"add\"", "until_idle = \"add\"", "15:", "takes no states"),
        ("run = \"add\"", "run = \"add\", repeat = 3", "15:", "one of"),
        ("stream = \"item\"", "stream = \"thing\"", "17:", "no stream is named thing; the streams are: item"),
        ("stream = \"item\"", "stream = \"item\"\nas = \"image\"", "17:", "not the pixels of an image"),
        ("stream = \"item\"", "stream = \"item\"\nrange = [1, 1]", "17:", "two different"),
        ("ADDED = 2", "ADDED = \"two\"", "3:", "a constant is a number"),
        ("[elements]", "[elements", "5:", ""),
    ];
    for (from, to, place, message) in cases {
        let mistake = manifest(from, to).err().unwrap_or_else(|| panic!("{to}: nothing is wrong")).to_string();
        let is_there = mistake.starts_with(&format!("some/mine/program.toml:{place}"));
        assert!(is_there && mistake.contains(message), "{to}: {mistake}");
    }
    let wgsl = |from: &str, to: &str| {
        assert!(ADD.contains(from), "{from}");
        of(MANIFEST, &ADD.replacen(from, to, 1))
    };
    let cases = [
        ("@workgroup_size(BLOCK)", "@workgroup_size(8, 8)", "6:", "needs @workgroup_size(BLOCK)"),
        ("@compute", "", "1:1", "no @compute function"),
        ("var item:", "var thing:", "12:", "no definition in scope"),
        ("+ ADDED", "+ 1.5", "12:", ""),
        ("package::launch", "package::launches", "2:", "no module is named package::launches"),
        ("let at", "let at = 1u; let at", "11:", "redefinition"),
        (
            "let at",
            "var big: array<u32, 4000>; big[i] = 1u; let at",
            "11:",
            "the variables of a function take 16000 bytes; WGSL allows 8192",
        ),
        ("textureStore(item, at, 0, vec4u(textureLoad(item, at, 0).x + ADDED));", "", "6:", "it writes no stream"),
    ];
    for (from, to, place, message) in cases {
        let mistake = wgsl(from, to).err().unwrap_or_else(|| panic!("{to}: nothing is wrong")).to_string();
        let is_there = mistake.starts_with(&format!("some/mine/add.wgsl:{place}"));
        assert!(is_there && mistake.contains(message), "{to}: {mistake}");
    }
}

/// A loop over a set whose number is read once would not end.
#[test]
fn a_loop_over_a_counted_set_counts_it_again() {
    let counted = MANIFEST.replace("count = 5 }", "count = 5 }\nleft = { found = \"item\" }");
    let counted = counted.replace("repeat = 3, name = \"round\"", "while_any = \"left\"");
    let mistake = of(&counted, ADD).err().expect("a loop without end").to_string();
    let is_there = mistake.starts_with("some/mine/program.toml:16:");
    assert!(is_there && mistake.contains("needs renews = [\"left\"]"), "{mistake}");
    let renewed = counted.replace("add = { }", "add = { renews = [\"left\"] }");
    of(&renewed, ADD).unwrap_or_else(|mistake| panic!("{mistake}"));
}

#[test]
fn a_mistake_in_the_states_of_a_kernel_is_told_at_the_kernel() {
    let states = "[states]\nGO = { role = \"active\" }\n\n[streams.phase]\ntype = \"u32\"\nmeaning = \"state\"\n\n";
    let manifest =
        MANIFEST.replace("[kernels]\nadd = { }", &format!("{states}[kernels]\nadd = {{ takes = [\"GO\"] }}"));
    let mistake = of(&manifest, ADD).err().expect("no way out of the state").to_string();
    let is_there = mistake.starts_with("some/mine/program.toml:19:");
    assert!(is_there && mistake.ends_with(": kernel add sends nothing on from GO"), "{mistake}");
}

/// A file of a user's that kernels import from has its own places.
#[test]
fn a_mistake_in_an_imported_file_is_told_there() {
    let wgsl = ADD.replace("package::program::{ADDED}", "package::tools::{ADDED}");
    let tools = "// Tools.\nconst ADDED: u32 = 2.5;\n";
    let files =
        [("program.toml", MANIFEST.as_bytes()), ("add.wgsl", wgsl.as_bytes()), ("lib/tools.wgsl", tools.as_bytes())];
    let mistake = read(&folder(&files)).err().expect("a mistake").to_string();
    assert!(mistake.starts_with("some/mine/lib/tools.wgsl:2:"), "{mistake}");
}

const SCENE: &str = r#"
[scene]
file = "cornell-box"

[scene.options]
accelerator = "grid"

[elements]
rays = { scene = "rays" }
triangles = { count = 12 }

[streams.depth]
type = "f32"
start = -1.0

[kernels]
look = { }

[schedule]
steps = [{ run = "look" }]
"#;

const LOOK: &str = r"
import package::camera::{eye_ray};
import package::corners::{vertex};
import package::grid::{grid};
@group(0) @binding(0) var depth: texture_storage_2d_array<r32float, write>;
@compute @workgroup_size(8, 8)
fn look(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= textureDimensions(depth))) {
        return;
    }
    let ray = eye_ray(id.xy);
    textureStore(depth, id.xy, 0, vec4f(ray.direction.x + vertex(3u, 1u).y + f32(grid.cells.z)));
}
";

fn seeing(manifest: &str, wgsl: &str) -> Result<(Plan, crate::scene_data::SceneData, Options), crate::plan::PlanError> {
    let scene = raystep_scenes::generate::cornell_box();
    let rays = RaySource::Camera { camera: scene.cameras[0].clone(), width: 7, height: 5 };
    let folder = folder(&[("program.toml", manifest.as_bytes()), ("look.wgsl", wgsl.as_bytes())]);
    let options = Options { folder: Some(folder), ..Options::new(rays) };
    let (plan, data) = Plan::new(&scene, &options, &Limits::CPU)?;
    Ok((plan, data, options))
}

#[test]
fn a_program_reads_the_scene_that_it_is_run_with() {
    let (plan, data, options) = seeing(SCENE, LOOK).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((plan.width, plan.height, plan.triangles), (7, 5, 30.min(plan.triangles)));
    let [camera, cells, corner] = [data.camera.right[0], data.grid.cells[2] as f32, data.corners::<f32>(3)[1].y];
    let stream = plan.program.stream("depth").expect("a stream");
    let depth = pollster::block_on(async {
        let mut renderer = Renderer::from_plan(plan, data, &options, &Device::Cpu(None)).await.expect("a run");
        renderer.run(|_| std::ops::ControlFlow::Continue(())).await.expect("no failure");
        renderer.values(stream).await.expect("values")
    });
    // From the left to the right edge, in seven pixels.
    let [left, right] = [0, 6].map(|at| depth.get_f32(0, at) - cells - corner);
    assert!((right - left - camera * 12.0 / 7.0).abs() < 1e-4, "{left} {right} {camera}");

    let told = |from: &str, to: &str| {
        let manifest = SCENE.replacen(from, to, 1);
        let wgsl = LOOK.replacen(from, to, 1);
        seeing(&manifest, &wgsl).err().unwrap_or_else(|| panic!("{to}: nothing is wrong")).to_string()
    };
    for (from, to, message) in [
        ("accelerator = \"grid\"", "accelerator = \"tree\"", "program.toml:6:15: accelerator: "),
        ("accelerator = \"grid\"", "speed = 3", "program.toml:6:9: no option of a run is named speed"),
        ("accelerator = \"grid\"", "mapping = \"fragment\"", "compute shaders"),
        ("scene = \"rays\"", "scene = \"photons\"", "closest_hit has rays, and no photons"),
        ("[scene]\nfile = \"cornell-box\"\n\n[scene.options]\naccelerator = \"grid\"", "", "needs a table [scene]"),
        ("accelerator = \"grid\"", "accelerator = \"bvh\"", "this run has no grid: needed only with"),
        (
            "@compute",
            "@group(1) @binding(9) var<storage, read> normals: array<f32>;\nfn n() -> f32 { return normals[0]; }\n@compute",
            "nothing",
        ),
    ] {
        if message == "nothing" {
            continue;
        }
        let error = told(from, to);
        assert!(error.contains(message), "{to}: {error}");
    }
    let normals = LOOK
        .replace("f32(grid.cells.z)", "normals[0]")
        .replace("@compute", "@group(1) @binding(9) var<storage, read> normals: array<f32>;\n@compute");
    let normals = normals.replace("import package::grid::{grid};\n", "");
    let error = seeing(SCENE, &normals).map(|_| ()).expect_err("a flat scene").to_string();
    assert!(error.contains("this run has no normals: no vertex normals"), "{error}");
}

/// Words and lines of manifests and kernels in other places, and numbers that are too large: each is a program or a mistake.
/// `RAYSTEP_FUZZ` is how many; a program is never freed, so a process can have some 100,000.
#[test]
fn damaged_programs_are_mistakes() {
    let count = std::env::var("RAYSTEP_FUZZ").ok().and_then(|count| count.parse().ok()).unwrap_or(1500u64);
    let seed = std::env::var("RAYSTEP_FUZZ_SEED").ok().and_then(|seed| seed.parse().ok()).unwrap_or(1);
    let mut random = fastrand::Rng::with_seed(seed);
    let examples = [("life", "generation"), ("sphere-tracer", "march"), ("grid-walk", "walk"), ("fluid", "relax")];
    let read_file = |name: &str| {
        let path = format!("{}/../app/programs/{name}", env!("CARGO_MANIFEST_DIR"));
        std::fs::read_to_string(path).unwrap_or_default()
    };
    let mut manifests = vec![MANIFEST.to_owned(), SCENE.to_owned()];
    let small = |text: String| {
        ["[256, 256]", "[256, 192]", "[128, 128]"].iter().fold(text, |t, size| t.replace(size, "[8, 6]"))
    };
    manifests.extend(examples.iter().map(|(name, _)| small(read_file(&format!("{name}/program.toml")))));
    let mut kernels = vec![ADD.to_owned(), LOOK.to_owned()];
    kernels.extend(examples.iter().map(|(name, file)| read_file(&format!("{name}/{file}.wgsl"))));
    let words = |texts: &[String]| -> Vec<String> {
        let is_end = |c: char| !(c.is_alphanumeric() || c == '_' || c == '.');
        texts.iter().flat_map(|text| text.split_inclusive(is_end)).map(str::to_owned).collect()
    };
    const NUMBERS: [&str; 9] = ["0", "1", "-1", "4294967295", "4294967296", "1e39", "nan", "\"\"", "[[]]"];
    let damaged = |random: &mut fastrand::Rng, texts: &[String], which: usize, all: &[String]| {
        let mut words = words(&texts[which..=which]);
        for _ in 0..random.usize(0..4) {
            if words.is_empty() {
                break;
            }
            let (at, other) = (random.usize(..words.len()), random.usize(..words.len()));
            match random.u8(..7) {
                0 => words.swap(at, other),
                1 => drop(words.remove(at)),
                2 => words.insert(at, all[random.usize(..all.len())].clone()),
                3 => words[at] = all[random.usize(..all.len())].clone(),
                4 => words[at] = NUMBERS[random.usize(..NUMBERS.len())].to_owned() + " ",
                5 => words.truncate(at.max(1)),
                _ => words[at] = String::from_utf8_lossy(&[random.u8(..), random.u8(..)]).into_owned(),
            }
        }
        words.concat()
    };
    let (of_manifests, of_kernels) = (words(&manifests), words(&kernels));
    let scene = raystep_scenes::generate::cornell_box();
    let rays = RaySource::Camera { camera: scene.cameras[0].clone(), width: 5, height: 4 };
    let (mut right, mut ran) = (0u64, 0u64);
    for _ in 0..count {
        let which = random.usize(..manifests.len());
        let manifest = damaged(&mut random, &manifests, which, &of_manifests);
        let names = ["add", "look", "generation", "march", "walk", "relax"];
        let files: Vec<(String, String)> = names
            .iter()
            .enumerate()
            .map(|(index, name)| (format!("{name}.wgsl"), damaged(&mut random, &kernels, index, &of_kernels)))
            .collect();
        let mut all: Vec<(&str, &[u8])> = vec![("program.toml", manifest.as_bytes())];
        all.extend(files.iter().map(|(name, text)| (name.as_str(), text.as_bytes())));
        let options = Options { folder: Some(folder(&all)), ..Options::new(rays.clone()) };
        let Ok((plan, data)) = Plan::new(&scene, &options, &Limits::CPU) else { continue };
        right += 1;
        if plan.bytes() > 1 << 18 {
            continue;
        }
        ran += 1;
        let _ = pollster::block_on(async {
            let mut renderer = Renderer::from_plan(plan, data, &options, &Device::Cpu(None)).await?;
            for _ in 0..4 {
                renderer.step().await?;
            }
            Ok::<_, crate::RenderError>(())
        });
    }
    println!("{right} of {count} are programs, and {ran} of them small");
    assert!(right > count / 100 && ran > count / 200, "{right} programs, {ran} of them small");
}
