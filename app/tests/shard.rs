//! `--shard` and `raystep merge`: divided work gives what one run gives, and only parts that belong together are merged.

use std::fs;

use crate::common::{Place, scene};

/// Seven blocks of samples, the last of them with four.
const SAMPLES: &str = "100";

fn render(place: &Place, more: &[&str]) {
    let scene = scene("cornell-box.gltf").display().to_string();
    place.ok(&[&["render", &scene, "--spp", SAMPLES, "--size", "24x18", "--device", "cpu", "--quiet"], more].concat());
}

fn part(place: &Place, index: usize, of: usize, more: &[&str]) -> String {
    let name = format!("part-{index}-of-{of}");
    render(place, &[&["--shard", &format!("{index}/{of}"), "-o", &name], more].concat());
    name
}

#[test]
fn a_picture_has_the_same_bytes_in_one_three_and_seven_parts() {
    let place = Place::new();
    render(&place, &["-o", "whole.png"]);
    render(&place, &["-o", "other.png", "--seed", "1"]);
    for of in [1, 3, 7] {
        let mut parts: Vec<String> = (1..=of).map(|index| part(&place, index, of, &[])).collect();
        // In any order.
        parts.reverse();
        let parts: Vec<&str> = parts.iter().map(String::as_str).collect();
        for output in [format!("{of}.png"), format!("{of}.exr")] {
            place.ok(&[&["merge"], &parts[..], &["-o", &output]].concat());
        }
        assert!(place.read(&format!("{of}.png")) == place.read("whole.png"), "{of} parts");
        assert!(place.read(&format!("{of}.exr")) == place.read("1.exr"), "{of} parts, linear");
    }
    assert!(place.read("whole.png") != place.read("other.png"), "other samples give another picture");
    assert_eq!(image::load_from_memory(&place.read("part-1-of-7/so-far.png")).expect("a PNG").width(), 24);
    // The floats are those of one run, too.
    render(&place, &["-o", "whole.exr"]);
    assert!(colors(&place, "whole.exr") == colors(&place, "7.exr"));
}

/// The bits of the colours of an EXR.
fn colors(place: &Place, name: &str) -> Vec<[u32; 4]> {
    let image = exr::prelude::read_first_rgba_layer_from_file(
        place.path(name),
        |size, _| vec![[0u32; 4]; size.area()],
        |pixels, at, (r, g, b, a): (f32, f32, f32, f32)| {
            pixels[at.y() * 24 + at.x()] = [r, g, b, a].map(f32::to_bits);
        },
    );
    image.expect("an EXR").layer_data.channel_data.pixels
}

/// Random paths, too: what decides them depends on the sample's number, not on the part.
#[test]
fn a_picture_of_paths_has_the_same_bits_in_parts() {
    let place = Place::new();
    let paths = ["--integrator", "path", "--spp", "256", "--seed", "9"];
    let scene = scene("lights.gltf").display().to_string();
    let render = |more: &[&str]| {
        place.ok(&[&["render", &scene, "--size", "24x18", "--device", "cpu", "--quiet"], &paths[..], more].concat());
    };
    render(&["-o", "whole.exr"]);
    let parts = ["a", "b", "c", "d", "e"];
    for (index, part) in (1..).zip(parts) {
        render(&["--shard", &format!("{index}/5"), "-o", part]);
    }
    place.ok(&[&["merge"], &parts[..], &["-o", "merged.exr"]].concat());
    assert!(colors(&place, "whole.exr") == colors(&place, "merged.exr"));
    let bits = colors(&place, "whole.exr");
    assert!(bits.iter().filter(|pixel| pixel[0] > bits[0][0]).count() > 24, "a picture");
}

#[test]
fn a_part_that_was_interrupted_costs_its_block_only() {
    let place = Place::new();
    // Numbers that JSON's reader does not read back to the last bit.
    let view = &["--eye", "0,1,4", "--look-at", "0,0,0"];
    let (first, second) = (part(&place, 1, 2, view), part(&place, 2, 2, view));
    place.ok(&["merge", &first, &second, "-o", "a.png"]);
    // As if it had ended in its last block, while it wrote.
    let block = |index| place.path(format!("{second}/block-{index:04}.npy"));
    let (kept, lost) = (fs::metadata(block(4)).expect("a block").modified().expect("a time"), block(5));
    fs::remove_file(&lost).expect("a block");
    place.fails(1, "block-0005.npy is missing, so the part is incomplete", &["merge", &first, &second, "-o", "b.png"]);
    part(&place, 2, 2, view);
    assert_eq!(fs::metadata(block(4)).expect("a block").modified().expect("a time"), kept, "it was traced again");
    place.ok(&["merge", &first, &second, "-o", "b.png"]);
    assert!(place.read("a.png") == place.read("b.png"));
    let whole = fs::read(&lost).expect("a block");
    fs::write(&lost, &whole[..whole.len() - 1]).expect("a file");
    place.fails(1, "block-0005.npy: it is not a block of this image", &["merge", &first, &second, "-o", "b.png"]);
}

#[test]
fn parts_that_do_not_belong_together_are_refused_by_name() {
    let place = Place::new();
    let (first, second) = (part(&place, 1, 2, &[]), part(&place, 2, 2, &[]));
    let refused = |wanted: &str, folders: &[&str]| {
        place.fails(1, wanted, &[&["merge"], folders, &["-o", "no.png"]].concat());
    };
    place.ok(&["merge", &first, "-o", "so-far.png", "--so-far"]);
    assert!(place.read("so-far.png") == place.read(&format!("{first}/so-far.png")));
    refused("part 2/2 is missing: name the folders of all 2 parts", &[&first]);
    refused("are the same part, 1/2", &[&first, &second, &first]);
    refused("differ in number of parts: 2 and 3", &[&first, &part(&place, 2, 3, &[])]);
    let other = |name: &str, more: &[&str]| {
        render(&place, &[&["--shard", "2/2", "-o", name], more].concat());
        name.to_owned()
    };
    refused("differ in seed: 0 and 3", &[&first, &other("seed", &["--seed", "3"])]);
    refused("differ in accelerator: \"auto\" and \"bvh\"", &[&first, &other("bvh", &["--accelerator", "bvh"])]);
    refused("differ in camera", &[&first, &other("eye", &["--eye", "0,1,5", "--look-at", "0,1,0"])]);
    // Written by another version, of another scene, on another device.
    let text = String::from_utf8(place.read(&format!("{second}/shard.json"))).expect("UTF-8");
    let edited = |from: &str, to: &str| {
        assert!(text.contains(from), "{from} in {text}");
        fs::write(place.path(format!("{second}/shard.json")), text.replace(from, to)).expect("a file");
    };
    edited(&format!("\"{}\"", env!("CARGO_PKG_VERSION")), "\"9.9.9\"");
    refused("differ in version of raystep", &[&first, &second]);
    edited("\"cornell-box\"", "\"another\"");
    refused("differ in scene", &[&first, &second]);
    edited("\"device\": \"cpu\"", "\"device\": \"Some GPU\"");
    refused("differ in device: cpu and Some GPU; --mixed allows it", &[&first, &second]);
    place.ok(&["merge", &first, &second, "-o", "mixed.png", "--mixed"]);
    edited("\"of\": 2", "\"of\": 0");
    refused("part 2/0 is invalid", &[&first, &second]);
    edited("\"width\": 24", "\"width\": 4294967295");
    refused("differ in image: 24x18, 100 samples and 4294967295x18, 100 samples", &[&first, &second]);
    edited("{", "[");
    refused("shard.json: it does not describe a part", &[&first, &second]);
    fs::create_dir(place.path("empty")).expect("a folder");
    refused("empty: it has no shard.json", &[&first, "empty"]);
    refused("nowhere: there is no such folder", &["nowhere"]);
    refused("parts 2/3 and 3/3 are missing", &[&part(&place, 1, 3, &[])]);
    // A folder of another part is not continued.
    let scene = scene("cornell-box.gltf").display().to_string();
    let again = ["render", &scene, "--spp", SAMPLES, "--size", "24x18", "--device", "cpu", "-o", &first, "--shard"];
    place.fails(1, "has a part that differs in number of the part", &[&again[..], &["2/2"]].concat());
    place.fails(2, "too few blocks of 16 samples to divide, 7: use at most 7 parts", &[&again[..], &["1/8"]].concat());
    place.fails(2, "--shard cannot be combined with --check", &[&again[..], &["1/2", "--check"]].concat());
}

/// Rows without what only identifies or times a run.
fn rows(file: &[u8], columns: &[&str]) -> Vec<Vec<String>> {
    let mut reader = csv::ReaderBuilder::new().flexible(false).from_reader(file);
    let names = reader.headers().expect("a header").clone();
    let wanted: Vec<usize> =
        columns.iter().map(|column| names.iter().position(|name| name == *column).expect(column)).collect();
    let row = |record: csv::StringRecord| wanted.iter().map(|&i| record[i].to_owned()).collect();
    reader.records().map(|record| row(record.expect("as many fields as names"))).collect()
}

#[test]
fn benchmarks_are_divided_by_scene() {
    let place = Place::new();
    let scenes =
        ["single-triangle.gltf", "cornell-box.gltf", "flat.gltf"].map(|name| scene(name).display().to_string());
    let scenes: Vec<&str> = scenes.iter().map(String::as_str).collect();
    let run = |more: &[&str]| {
        let how = ["--sizes", "16x16", "--repeats", "1", "--warmups", "0", "--accelerators", "grid,bvh", "--quiet"];
        place.ok(&[&["bench"], &scenes[..], &how[..], &["--device", "cpu"], more].concat());
    };
    run(&["-o", "whole"]);
    run(&["-o", "one", "--shard", "1/2"]);
    run(&["-o", "two", "--shard", "2/2"]);
    place.ok(&["merge", "two", "one", "-o", "merged"]);
    let same = ["scene", "scene_hash", "accelerator", "schedule", "rays", "passes"];
    let [whole, merged] = ["whole", "merged"].map(|name| rows(&place.read(&format!("{name}/summary.csv")), &same));
    assert_eq!(whole.len(), 6);
    assert_eq!(merged, whole);
    let run: serde_json::Value = serde_json::from_slice(&place.read("merged/run.json")).expect("JSON");
    assert_eq!((&run["kind"], run["parts"].as_array().map(Vec::len)), (&"raystep bench".into(), Some(2)));
    let package: serde_json::Value = serde_json::from_slice(&place.read("merged/datapackage.json")).expect("JSON");
    assert_eq!(package["resources"].as_array().map(Vec::len), Some(3));
    fs::write(place.path("two/datapackage.json"), "[]").expect("a file");
    let merge = ["merge", "one", "two", "-o", "again"];
    place.fails(1, "two/datapackage.json: expected a description of tables", &merge);
    place.fails(
        2,
        "too few scenes to divide, 3: use at most 3 parts",
        &[&["bench"], &scenes[..], &["--shard", "1/4", "-o", "x"]].concat(),
    );
}

#[test]
fn cases_are_divided_and_none_is_lost() {
    let place = Place::new();
    let run = |more: &[&str]| {
        let cases = ["--case", "axis-below", "--case", "tiny-detail", "--quick", "--quiet"];
        place.ok(&[&["stability", "--device", "cpu"], &cases[..], more].concat());
    };
    run(&["-o", "whole"]);
    run(&["-o", "one", "--shard", "1/2"]);
    run(&["-o", "two", "--shard", "2/2"]);
    place.ok(&["merge", "one", "two", "-o", "merged"]);
    let same = ["case", "accelerator", "numerics", "device", "rays", "wrong_rays", "undecided", "t_relative", "result"];
    let [whole, merged] = ["whole", "merged"].map(|name| rows(&place.read(&format!("{name}/stability.csv")), &same));
    assert!(whole.len() > 40);
    assert_eq!(merged, whole);
    assert!(
        place.path("merged/stability-1-of-2.html").is_file() && place.path("merged/stability-2-of-2.html").is_file()
    );
}
