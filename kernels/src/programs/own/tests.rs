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
}

/// A change of the manifest or of the kernel, and what is said of it.
#[test]
fn a_mistake_is_told_with_its_place() {
    let manifest = |from: &str, to: &str| {
        assert!(MANIFEST.contains(from), "{from}");
        of(&MANIFEST.replacen(from, to, 1), ADD)
    };
    let cases = [
        ("count = 5", "count = 5000000000", "6:", "u32"),
        ("count = 5", "count = 70000000", "6:", "at most 67108864"),
        ("count = 5", "image = [0, 3]", "6:", "1 to 16384"),
        ("count = 5", "", "6:", "image = [columns, rows], count, per and found"),
        ("count = 5", "count = 5, image = [2, 2]", "6:", "one of"),
        ("count = 5", "found = \"item\"", "6:", "main one"),
        ("type = \"u32\"", "type = \"f64\"", "9:", "f64"),
        ("type = \"u32\"", "type = \"u32\"\nof = \"rays\"", "8:", "no set of elements is named rays"),
        ("type = \"u32\"", "type = \"u32\"\nstart = -1", "8:", "no integer"),
        ("type = \"u32\"", "type = \"u32\"\nstart = [1, 2]", "8:", "1 layers"),
        ("type = \"u32\"", "type = \"u32\"\nstart = { npy = \"none.npy\" }", "8:", "none.npy is not in the folder"),
        ("type = \"u32\"", "type = \"u32\"\nmeaning = \"state\"", "8:", "[states]"),
        ("type = \"u32\"", "type = \"u32\"\ncolour = 3", "10:", "unknown field"),
        ("add = { }", "add = { file = \"other.wgsl\" }", "12:", "other.wgsl is not in the folder"),
        ("add = { }", "add = { over = \"rays\" }", "12:", "no set of elements is named rays"),
        ("add = { }", "add = { takes = [\"GO\"] }", "12:", "no state is named GO"),
        ("add = { }", "\"a-b\" = { file = \"add.wgsl\" }", "12:", "cannot be named"),
        ("run = \"add\"", "run = \"sub\"", "15:", "no kernel is named sub; there are add"),
        ("repeat = 3", "repeat = 2000000", "15:", "1000000 passes"),
        ("repeat = 3", "repeat = 4000000000", "15:", "1000000 passes"),
        (", steps = [{ run = \"add\" }]", "", "15:", "steps"),
        ("run = \"add\"", "until_idle = \"add\"", "15:", "takes no states"),
        ("run = \"add\"", "run = \"add\", repeat = 3", "15:", "one of"),
        ("stream = \"item\"", "stream = \"thing\"", "17:", "no stream is named thing"),
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
    ];
    for (from, to, place, message) in cases {
        let mistake = wgsl(from, to).err().unwrap_or_else(|| panic!("{to}: nothing is wrong")).to_string();
        let is_there = mistake.starts_with(&format!("some/mine/add.wgsl:{place}"));
        assert!(is_there && mistake.contains(message), "{to}: {mistake}");
    }
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
