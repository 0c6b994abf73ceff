//! Files written by `dump`.

use exr::prelude::FlatSamples;
use serde_json::Value;

use crate::common::Place;
use crate::files::{channels, cornell_box, floats};

/// Shape and values of a .npy file, read according to its specification.
pub(crate) fn npy(file: &[u8]) -> (String, Vec<usize>, Vec<u32>) {
    assert_eq!(&file[..8], b"\x93NUMPY\x01\x00");
    let length = usize::from(u16::from_le_bytes([file[8], file[9]]));
    assert_eq!((10 + length) % 64, 0, "the data is not aligned");
    let header = std::str::from_utf8(&file[10..10 + length]).expect("ASCII");
    assert!(header.ends_with('\n') && header.contains("'fortran_order': False"), "{header:?}");
    let between = |start: &str, end: &str| {
        let rest = &header[header.find(start).expect(start) + start.len()..];
        rest[..rest.find(end).expect(end)].to_owned()
    };
    let shape =
        between("'shape': (", ")").trim_end_matches(',').split(", ").map(|n| n.parse().expect("a number")).collect();
    let words = file[10 + length..].chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    (between("'descr': '", "'"), shape, words.collect())
}
#[test]
fn dump_writes_streams_and_an_index_that_names_them() {
    let place = Place::new();
    let outcome = place.ok(&[
        "dump",
        &cornell_box(),
        "-o",
        "out",
        "--pass",
        "last",
        "--stream",
        "hit,state",
        "--format",
        "both",
        "--size",
        "20x10",
        "--grid",
        "4,3,2",
        "--device",
        "cpu",
    ]);
    assert!(outcome.stderr.contains("writing 4 files, "), "the size is announced first: {outcome:?}");
    let index: Value = serde_json::from_slice(&place.read("out/index.json")).expect("JSON");
    let passes = index["passes"].as_array().expect("passes");
    let last = passes.last().expect("a pass");
    assert_eq!(index["scene_units_per_stream_unit"], 4.0);
    assert_eq!((&index["options"]["grid"], &index["options"]["counters"]), (&"4,3,2".into(), &false.into()));
    assert_eq!(index["options"]["scene_path"], cornell_box());
    assert_eq!((&last["kernel"], &last["left_out"]), (&"shade".into(), &Value::Null), "shading changes the state");
    let names: Vec<_> = last["files"].as_array().expect("files").iter().map(|f| f.as_str().expect("a name")).collect();
    let stem = format!("pass-{:06}", passes.len() - 1);
    let expected = ["state.npy", "state.exr", "hit.npy", "hit.exr"].map(|n| format!("{stem}.{n}"));
    assert_eq!(sorted(&names), sorted(&expected.each_ref().map(String::as_str)));

    let (kind, shape, hit) = npy(&place.read(&format!("out/{stem}.hit.npy")));
    assert_eq!((kind.as_str(), shape), ("<u4", vec![3, 10, 20]));
    assert!(hit[400..].iter().all(|&triangle| triangle < 26));
    let channels = channels(place.read(&format!("out/{stem}.hit.exr")));
    assert_eq!(channels["hit.triangle"], FlatSamples::U32(hit[400..].to_vec()));
    let u: Vec<u32> = floats(&channels, "hit.u").iter().map(|u| u.to_bits()).collect();
    assert_eq!(u, hit[..200]);
    assert_eq!(place.names(), ["out"]);
}

fn sorted<'a>(names: &[&'a str]) -> Vec<&'a str> {
    let mut names = names.to_vec();
    names.sort_unstable();
    names
}

/// Passes have the same numbers whichever streams are dumped, and the same as in `trace`.
#[test]
fn passes_keep_their_numbers_whatever_is_dumped() {
    let place = Place::new();
    let common = ["--size", "12x9", "--device", "cpu"];
    let ways = [
        &["--schedule", "compact"][..],
        &["--schedule", "compact", "--steps-per-pass", "8", "--accelerator", "bvh"],
        &["--schedule", "second"],
        &["--schedule", "first", "--accelerator", "none"],
        &["--schedule", "fused"],
        &["--integrator", "shadows", "--schedule", "second"],
        &["--integrator", "path", "--schedule", "compact", "--steps-per-pass", "8"],
        &["--integrator", "photons", "--photons", "50", "--schedule", "compact", "--steps-per-pass", "8"],
    ];
    for (i, way) in ways.into_iter().enumerate() {
        let is_stepped = way != ["--schedule", "fused"];
        let passes = is_stepped.then(|| {
            let trace = ["trace", &cornell_box(), "--pixel", "3,4", "--all-rays", "--format", "json", "--quiet"];
            let life: Value =
                serde_json::from_str(&place.ok(&[&trace[..], &common, way].concat()).stdout).expect("JSON");
            life["passes"].as_u64().expect("a number") as usize
        });
        let mut hits = Vec::new();
        for (streams, left_out) in [
            ("all", &[][..]),
            ("state", &[]),
            ("hit,color", &[]),
            // Where rays go on from hits, all of it is needed to know how many passes there are.
            (
                "hit",
                if way[0] == "--integrator" {
                    &[]
                } else if is_stepped {
                    &["shade"]
                } else {
                    &["generate", "shade"]
                },
            ),
        ] {
            let folder = format!("{i}-{streams}");
            let dump = ["dump", &cornell_box(), "--pass", "last", "--stream", streams, "-o", &folder];
            let outcome = place.ok(&[&dump[..], &common, way].concat());
            let index: Value = serde_json::from_slice(&place.read(&format!("{folder}/index.json"))).expect("JSON");
            let all = index["passes"].as_array().expect("passes");
            let last = all.len() - 1;
            assert_eq!(all.len(), passes.unwrap_or(3), "{way:?} {streams}: as many as trace has");
            let named: Vec<_> = all.iter().filter(|p| !p["left_out"].is_null()).map(|p| p["kernel"].as_str()).collect();
            assert_eq!(named, left_out.iter().map(|k| Some(*k)).collect::<Vec<_>>(), "{way:?} {streams}");
            for (number, pass) in all.iter().enumerate() {
                assert_eq!(pass["index"], number, "{way:?} {streams}");
                let said = format!("pass {number} ({}) is omitted: ", pass["kernel"].as_str().expect("a name"));
                assert_eq!(outcome.stderr.contains(&said), !pass["left_out"].is_null(), "{outcome:?}");
                assert_eq!(pass["rays_in"].is_null(), !pass["left_out"].is_null(), "{way:?} {streams}");
            }
            let hit = format!("pass-{last:06}.hit.npy");
            if streams != "state" {
                hits.push(place.read(&format!("{folder}/{hit}")));
            }
            if is_stepped && streams == "hit" {
                // The last pass also exists by its number, and there is no pass after it.
                let by = |number: usize, folder: &str| {
                    let number = number.to_string();
                    [&["dump", &cornell_box(), "--pass", &number, "--stream", "hit", "-o", folder][..], &common, way]
                        .concat()
                        .into_iter()
                        .map(str::to_owned)
                        .collect::<Vec<_>>()
                };
                let folder = format!("{i}-numbered");
                place.ok(&by(last, &folder).iter().map(String::as_str).collect::<Vec<_>>());
                hits.push(place.read(&format!("{folder}/{hit}")));
                let beyond = by(last + 1, "beyond");
                let message = format!("the run has {} passes, 0 to {last}", last + 1);
                place.fails(2, &message, &beyond.iter().map(String::as_str).collect::<Vec<_>>());
            }
        }
        assert!(hits.iter().all(|hit| *hit == hits[0]), "{way:?}: the hits of the last pass differ");
    }
}

#[test]
fn dump_of_all_passes_ends_as_the_last_one_does() {
    let place = Place::new();
    let common = ["--stream", "all", "--size", "12x9", "--quiet"];
    for device in ["cpu", "gpu"] {
        let (all, last) = (format!("{device}-all"), format!("{device}-last"));
        let base = ["dump", &cornell_box(), "--device", device];
        place.ok(&[&base[..], &common[..], &["--pass", "all", "-o", &all]].concat());
        place.ok(&[&base[..], &common[..], &["--pass", "last", "-o", &last]].concat());
        let index: Value = serde_json::from_slice(&place.read(&format!("{all}/index.json"))).expect("JSON");
        let passes = index["passes"].as_array().expect("passes");
        assert!(passes.iter().all(|p| p["files"].as_array().is_some_and(|f| f.len() == 6)));
        for name in passes.last().expect("a pass")["files"].as_array().expect("files") {
            let name = name.as_str().expect("a name");
            assert_eq!(place.read(&format!("{all}/{name}")), place.read(&format!("{last}/{name}")), "{name}");
        }
        // The index's counts of rays by state agree with the state stream.
        let states = ["UNWRITTEN", "TRAV_SETUP", "TRAV", "ISECT_NO_HIT", "ISECT_HIT", "SHADE", "BACKGROUND", "DONE"];
        let (_, _, state) = npy(&place.read(&format!("{all}/pass-000004.state.npy")));
        for (tag, name) in states.iter().enumerate() {
            let count = state[..108].iter().filter(|&&t| t == tag as u32).count();
            assert_eq!(passes[4]["rays_by_state"][name], count, "{device} {name}");
        }
    }
}

#[test]
fn dump_leaves_a_folder_with_files_alone_unless_forced() {
    let place = Place::new();
    std::fs::create_dir(place.path("out")).expect("a folder");
    let dump = ["dump", &cornell_box(), "-o", "out", "--stream", "hit", "--size", "8x8", "--device", "cpu", "--quiet"];
    place.ok(&dump);
    std::fs::write(place.path("out/mine.txt"), "mine").expect("a file");
    place.fails(1, "out is not empty", &dump);
    // Files that an index should not list are not deleted.
    std::fs::write(place.path("pass-0.npy"), "mine").expect("a file");
    let mut index: Value = serde_json::from_slice(&place.read("out/index.json")).expect("JSON");
    let files = index["passes"][0]["files"].as_array_mut().expect("files");
    files.extend(["../pass-0.npy", "mine.txt"].map(Value::from));
    std::fs::write(place.path("out/index.json"), index.to_string()).expect("a file");
    place.ok(&[&dump[..], &["--force", "--pass", "3"]].concat());
    assert_eq!((place.read("out/mine.txt"), place.read("pass-0.npy")), (b"mine".to_vec(), b"mine".to_vec()));
    let entries = std::fs::read_dir(place.path("out")).expect("the folder");
    let names: Vec<_> = entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    let names: Vec<_> = names.iter().map(String::as_str).collect();
    assert_eq!(sorted(&names), ["index.json", "mine.txt", "pass-000003.hit.npy"], "the first dump's files are deleted");
}

/// Photons, and what is stored of them, are elements of sets of their own.
#[test]
fn photons_are_dumped_with_their_number() {
    let place = Place::new();
    let dump =
        ["dump", &cornell_box(), "--stream", "color,photon_bounce,photon_records,photon_key,photon_first", "-o", "out"];
    let way = ["--integrator", "photons", "--photons", "100", "--max-depth", "3", "--size", "8x6", "--device", "cpu"];
    place.ok(&[&dump[..], &way, &["--quiet"]].concat());
    let index: Value = serde_json::from_slice(&place.read("out/index.json")).expect("JSON");
    assert_eq!((&index["options"]["photons"], &index["options"]["integrator"]), (&100.into(), &"photons".into()));
    let last = index["passes"].as_array().expect("passes").len() - 1;
    let mut counts = Vec::new();
    for stream in index["streams"].as_array().expect("streams") {
        let name = stream["name"].as_str().expect("a name");
        let (_, shape, _) = npy(&place.read(&format!("out/pass-{last:06}.{name}.npy")));
        let count = stream["count"].as_u64().expect("a number") as usize;
        assert_eq!(shape[0], stream["layers"].as_array().expect("layers").len(), "{name}");
        // Whole rows, but for the last one.
        assert!((1..=shape[2]).contains(&(count - (shape[1] - 1) * shape[2])), "{name}: {shape:?}");
        counts.push((stream["elements"].as_str().expect("a set"), count, shape[1] * shape[2] - count));
    }
    // Rows of 16 photons, each of which may be stored at two bounces: at the last one, photons are looked up.
    assert_eq!(counts[..4], [("rays", 48, 0), ("photons", 112, 0), ("photons", 112, 0), ("records", 224, 0)]);
    // Where each cell begins, and where the last one ends: no whole rows.
    let [.., (set, cells, left)] = counts[..] else { panic!("{counts:?}") };
    assert!(counts.len() == 5 && set == "map_cells" && cells > 1 && left > 0, "{counts:?}");
}

/// The scene data of the paper's Figure 5: grid, lists, vertices, materials.
#[test]
fn dump_writes_scene_data_and_where_the_grid_is() {
    let place = Place::new();
    let common = ["dump", &cornell_box(), "--stream", "hit", "--size", "8x8", "--grid", "4,3,2", "--device", "cpu"];
    place.ok(&[&common[..], &["--buffers", "grid_cells,grid_items,vertices,materials", "-o", "out"]].concat());
    let index: Value = serde_json::from_slice(&place.read("out/index.json")).expect("JSON");
    let grid = &index["grid"];
    assert_eq!((&grid["cells"], &index["accelerator"]), (&serde_json::json!([4, 3, 2]), &"grid".into()));
    let number = |value: &Value, axis: usize| value[axis].as_f64().expect("a number");
    let (kind, shape, vertices) = npy(&place.read("out/scene.vertices.npy"));
    assert_eq!((kind.as_str(), shape), ("<f4", vec![26, 3, 3]));
    for (at, &bits) in vertices.iter().enumerate() {
        let (axis, value) = (at % 3, f64::from(f32::from_bits(bits)));
        let (low, width) = (number(&grid["corner"], axis), number(&grid["cell_width"], axis));
        let high = low + number(&grid["cells"], axis) * width;
        assert!((low..=high).contains(&value), "corner {at} at {value} outside of {low} to {high}");
    }
    let [cells, items] = ["cells", "items"].map(|name| npy(&place.read(&format!("out/scene.grid_{name}.npy"))));
    assert_eq!((cells.0.as_str(), &cells.1[..]), ("<u4", &[4 * 3 * 2 + 1][..]));
    assert_eq!((items.1[0], cells.2.last().copied()), (items.2.len(), Some(items.2.len() as u32)));
    assert!(items.2.iter().all(|&triangle| triangle < 26));
    let materials = place.read("out/scene.materials.npy");
    let header = String::from_utf8_lossy(&materials[10..256]).into_owned();
    assert!(header.contains("('base_color', '<f4', (3,))") && header.contains("'shape': (3,)"), "{header}");
    let listed: Vec<_> = index["buffers"].as_array().expect("buffers").iter().map(|b| b["name"].as_str()).collect();
    assert_eq!(listed, ["grid_cells", "grid_items", "vertices", "materials"].map(Some));

    // Replaced with the rest of the dump.
    place.ok(&[&common[..], &["--force", "-o", "out"]].concat());
    assert!(!place.path("out/scene.vertices.npy").exists());
    place.fails(
        2,
        "--buffers normals: this run omits it: no vertex normals",
        &[&common[..], &["--buffers", "normals", "-o", "no"]].concat(),
    );
    place.fails(2, "this run has no such buffer", &[&common[..], &["--buffers", "grid", "-o", "no"]].concat());
}

#[test]
fn colours_are_also_channels_that_viewers_show() {
    let place = Place::new();
    let outcome = place.ok(&[
        "dump",
        &cornell_box(),
        "--stream",
        "color",
        "--size",
        "8x8",
        "--format",
        "exr",
        "--device",
        "cpu",
        "-o",
        "out",
    ]);
    let index: Value = serde_json::from_slice(&place.read("out/index.json")).expect("JSON");
    let passes = index["passes"].as_array().expect("passes");
    let file = passes.last().expect("a pass")["files"][0].as_str().expect("a file");
    let found = channels(place.read(&format!("out/{file}")));
    for (plain, named) in [("R", "color.r"), ("G", "color.g"), ("B", "color.b")] {
        let of = |name: &str| found.get(name).map(|samples| format!("{samples:?}"));
        assert!(of(plain).is_some() && of(plain) == of(named), "{outcome:?}");
    }
}
