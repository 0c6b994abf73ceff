//! `raystep cast`: what it hits, what it refuses, and its pipes.

use std::ffi::OsStr;
use std::fs;
use std::io::{Read as _, Write as _};
use std::process::{Child, Stdio};

use serde_json::Value;

use crate::common::{Outcome, Place, assert_error, scene};

/// Bytes of the header of hits, and of a hit.
const HEADER: usize = 256;
const HIT: usize = 20;

fn cornell_box() -> String {
    scene("cornell-box.gltf").display().to_string()
}

/// An npy file of float32 with this shape.
pub(crate) fn npy(shape: &str, numbers: &[f32]) -> Vec<u8> {
    let header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}\n");
    let length = u16::try_from(header.len()).expect("a short header");
    let data = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    [b"\x93NUMPY\x01\x00".to_vec(), length.to_le_bytes().to_vec(), header.into_bytes(), data].concat()
}

fn write(place: &Place, name: &str, bytes: &[u8]) {
    fs::write(place.path(name), bytes).expect("a file");
}

/// Numbers in a stream of a dump: layer by layer.
fn dumped(place: &Place, stream: &str) -> Vec<u32> {
    let index: Value = serde_json::from_slice(&place.read("d/index.json")).expect("JSON");
    let passes = index["passes"].as_array().expect("passes");
    let files = passes.last().expect("a pass")["files"].as_array().expect("files");
    let mut names = files.iter().filter_map(Value::as_str);
    let name = names.find(|name| name.ends_with(&format!("{stream}.npy"))).expect("the stream");
    let file = place.read(&format!("d/{name}"));
    file[128..].chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

/// Words of the hits in a file: t, u, v, triangle, material.
pub(crate) fn hits(file: &[u8]) -> Vec<[u32; 5]> {
    let word = |hit: &[u8], i: usize| u32::from_le_bytes([hit[4 * i], hit[4 * i + 1], hit[4 * i + 2], hit[4 * i + 3]]);
    file[HEADER..].chunks_exact(HIT).map(|hit| [0, 1, 2, 3, 4].map(|i| word(hit, i))).collect()
}

/// Origins and directions of random-looking rays inside of the box, six numbers each.
pub(crate) fn inside(count: usize) -> Vec<f32> {
    let number = |i: usize| ((i * 7919 + 13) % 1999) as f32 / 1000.0 - 1.0;
    (0..count).flat_map(|ray| [0, 1, 2, 3, 4, 5].map(|k| number(6 * ray + k) * if k < 3 { 0.5 } else { 1.0 })).collect()
}

/// The same with eight numbers each.
fn eight(six: &[f32], t_min: f32, t_max: f32) -> Vec<f32> {
    six.chunks_exact(6).flat_map(|r| [r[0], r[1], r[2], t_min, r[3], r[4], r[5], t_max]).collect()
}

#[test]
fn hits_are_those_of_a_dump_of_the_same_rays_bit_for_bit() {
    for device in ["cpu", "gpu"] {
        let place = Place::new();
        let common = ["--device", device, "--accelerator", "bvh", "--quiet"];
        let streams = ["--stream", "ray_origin,ray_direction,state,hit", "--pass", "last", "-o", "d"];
        let dump = ["dump", &cornell_box(), "--size", "48x40", "--schedule", "second"];
        place.ok(&[&dump[..], &streams, &common].concat());
        let [origins, directions, state, hit] =
            ["ray_origin", "ray_direction", "state", "hit"].map(|stream| dumped(&place, stream));
        let index: Value = serde_json::from_slice(&place.read("d/index.json")).expect("JSON");
        // A power of two, so that nothing is rounded.
        let scale = index["scene_units_per_stream_unit"].as_f64().expect("a number") as f32;
        let rays = 48 * 40;
        let of = |stream: &[u32], layer: usize, ray: usize| f32::from_bits(stream[layer * rays + ray]);
        let given: Vec<f32> = (0..rays)
            .flat_map(|ray| {
                let ([ox, oy, oz], [dx, dy, dz]) = (
                    [0, 1, 2].map(|axis| of(&origins, axis, ray) * scale),
                    [0, 1, 2].map(|axis| of(&directions, axis, ray)),
                );
                [ox, oy, oz, dx, dy, dz]
            })
            .collect();
        write(&place, "rays.npy", &npy("(1920, 6)", &given));
        place.ok(&[&["cast", &cornell_box(), "--rays-file", "rays.npy", "-o", "hits.npy"], &common[..]].concat());
        let cast = hits(&place.read("hits.npy"));
        assert_eq!(cast.len(), rays);
        let mut found = 0;
        for (ray, &[t, u, v, triangle, material]) in cast.iter().enumerate() {
            assert_eq!(triangle, hit[2 * rays + ray], "{device}, ray {ray}");
            if triangle == u32::MAX {
                assert_eq!((f32::from_bits(t), material), (f32::INFINITY, u32::MAX), "{device}, ray {ray}");
            } else {
                found += 1;
                let expected = [(of(&state, 1, ray) * scale).to_bits(), hit[ray], hit[rays + ray]];
                assert_eq!([t, u, v], expected, "{device}, ray {ray}");
                assert!(material < 100, "{device}, ray {ray}: {material}");
            }
        }
        assert!(found > rays / 2, "{device}: {found} rays hit");
    }
}

#[test]
fn formats_batches_schedules_and_pipes_change_nothing() {
    let place = Place::new();
    let six = inside(3000);
    write(&place, "six.npy", &npy("(3000, 6)", &six));
    write(&place, "eight.npy", &npy("(3000, 8)", &eight(&six, 0.0, f32::INFINITY)));
    let raw: Vec<u8> = eight(&six, f32::NAN, -1.0).iter().flat_map(|number| number.to_le_bytes()).collect();
    write(&place, "raw.f32", &raw);
    write(&place, "raw", &raw);
    let cast = |rays: &str, more: &[&str]| {
        place.ok(&[&["cast", &cornell_box(), "--rays-file", rays, "-o", "h.npy", "--device", "cpu"], more].concat())
    };
    let said = cast("six.npy", &[]).stdout;
    assert!(said.starts_with("3,000 rays, ") && said.contains(" rays/s on CPU"), "{said}");
    let expected = place.read("h.npy");
    assert_eq!(expected.len(), HEADER + 3000 * HIT);
    let header = String::from_utf8_lossy(&expected[10..HEADER]).into_owned();
    assert!(header.starts_with("{'descr': [('t', '<f4'), ") && header.contains("'shape': (3000,), }"), "{header}");
    assert!(header.ends_with(" \n"), "{header:?}");
    for (rays, more) in [
        ("six.npy", &["--batch", "1500"][..]),
        ("six.npy", &["--batch", "1999", "--quiet"]),
        ("six.npy", &["--schedule", "compact"]),
        ("six.npy", &["--accelerator", "grid", "--schedule", "first"]),
        ("eight.npy", &[]),
        ("raw.f32", &["--batch", "7"]),
        ("raw", &["--format", "f32", "--count", "3000"]),
    ] {
        let said = cast(rays, more).stdout;
        assert!(place.read("h.npy") == expected, "{rays} {more:?}");
        assert_eq!(said.is_empty(), more.contains(&"--quiet"), "{said}");
    }
    let npy = place.read("six.npy");
    assert!(piped(&place, &npy, &["-o", "-"]).0 == expected);
    assert!(piped(&place, &npy, &["-o", "-", "--batch", "100"]).0 == expected);
    assert!(piped(&place, &raw, &["-o", "-", "--format", "f32", "--count", "3000"]).0 == expected);
    // A file's header is completed at the end.
    piped(&place, &raw, &["-o", "p.npy", "--format", "f32", "--batch", "1000"]);
    assert!(place.read("p.npy") == expected);
    assert_eq!(hits(&expected).iter().filter(|hit| hit[3] != u32::MAX).count() as u64, first_number(&said, 1));
}

/// The number at this place among those of a text, such as `3,000`.
fn first_number(text: &str, place: usize) -> u64 {
    let words =
        text.split(|c: char| !(c.is_ascii_digit() || c == ',')).filter(|w| w.starts_with(|c: char| c.is_ascii_digit()));
    words.map(|word| word.replace(',', "")).nth(place).and_then(|word| word.parse().ok()).expect("a number")
}

fn start(place: &Place, more: &[&str]) -> Child {
    let file = cornell_box();
    let arguments = [&["cast", &file, "--rays-file", "-", "--device", "cpu"], more].concat();
    let mut command = place.command(&arguments.iter().map(OsStr::new).collect::<Vec<_>>());
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the binary starts")
}

/// What it writes to standard output and error for these bytes on standard input.
fn piped(place: &Place, bytes: &[u8], more: &[&str]) -> (Vec<u8>, String) {
    let mut child = start(place, more);
    let mut input = child.stdin.take().expect("a pipe");
    let bytes = bytes.to_vec();
    let writer = std::thread::spawn(move || drop(input.write_all(&bytes)));
    let output = child.wait_with_output().expect("an end");
    writer.join().expect("the writer");
    assert_eq!(output.status.code(), Some(0), "{more:?}: {}", String::from_utf8_lossy(&output.stderr));
    (output.stdout, String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn intervals_and_any_hit_are_obeyed() {
    let place = Place::new();
    let six = inside(2000);
    let cast = |numbers: &[f32], more: &[&str]| {
        write(&place, "r.npy", &npy("(2000, 8)", numbers));
        let rays = ["cast", &cornell_box(), "--rays-file", "r.npy", "-o", "h.npy", "--device", "cpu"];
        place.ok(&[&rays[..], more].concat());
        hits(&place.read("h.npy"))
    };
    let whole = cast(&eight(&six, 0.0, f32::INFINITY), &[]);
    let near = cast(&eight(&six, 0.0, 0.7), &[]);
    let far = cast(&eight(&six, 0.7, f32::INFINITY), &[]);
    let blocked = cast(&eight(&six, 0.0, 0.7), &["--any-hit"]);
    let (mut within, mut behind) = (0, 0);
    for ray in 0..2000 {
        let t = f32::from_bits(whole[ray][0]);
        let is_near = t < 0.7;
        within += usize::from(is_near);
        assert_eq!(near[ray][3] != u32::MAX, is_near, "ray {ray} at {t}");
        assert!(!is_near || near[ray] == whole[ray], "ray {ray} at {t}");
        assert_eq!(blocked[ray][3] != u32::MAX, is_near, "any hit, ray {ray} at {t}");
        assert!(f32::from_bits(far[ray][0]) > 0.7, "ray {ray}");
        assert!(is_near || far[ray] == whole[ray], "ray {ray} at {t}");
        behind += usize::from(is_near && far[ray][3] != u32::MAX);
    }
    assert!((200..1800).contains(&within) && behind > 20, "{within} within, {behind} behind");
}

#[test]
fn what_cannot_be_cast_is_told_by_number_and_leaves_nothing() {
    let place = Place::new();
    let file = cornell_box();
    let good = inside(10);
    let with = |place: usize, number: f32| {
        let mut numbers = good.clone();
        numbers[place] = number;
        npy("(10, 6)", &numbers)
    };
    let mut still = good.clone();
    still[6 * 4 + 3..6 * 5].fill(0.0);
    let wide = npy("(10, 6)", &good);
    let half = String::from_utf8_lossy(b"'<f2'").into_owned();
    let retyped = |descr: &str| {
        let header = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': (10, 6), }}\n");
        let length = (header.len() as u16).to_le_bytes();
        [b"\x93NUMPY\x01\x00".to_vec(), length.to_vec(), header.into_bytes(), vec![0; 480]].concat()
    };
    for (name, bytes, wanted) in [
        ("shape.npy", npy("(12, 5)", &good), "shape.npy: its shape is (12, 5): expected (N, 6) or (N, 8)"),
        ("type.npy", retyped(&half), "type '<f2': expected '<f4'"),
        ("nan.npy", with(6 * 7 + 1, f32::NAN), "ray 7 (counted from 0, of 10): a component is not finite"),
        ("infinite.npy", with(6 * 2 + 4, f32::INFINITY), "ray 2 (counted from 0, of 10): a component is not finite"),
        ("still.npy", npy("(10, 6)", &still), "ray 4 (counted from 0, of 10): its direction is 0"),
        ("far.npy", with(6 * 9, 1e20), "ray 9 (counted from 0, of 10): its origin is too far"),
        ("short.npy", wide[..wide.len() - 30].to_vec(), "ends 18 bytes into ray 8 (counted from 0, of 10)"),
        ("long.npy", [&wide[..], &[0]].concat(), "goes on after its 10 rays"),
        ("text.npy", b"these are no rays".to_vec(), "does not begin with"),
        ("empty.npy", Vec::new(), "does not begin with"),
        ("odd.f32", vec![0; 100], "100 bytes is not a whole number of rays (32 bytes each)"),
    ] {
        write(&place, name, &bytes);
        // In one batch, and with the error in a later one.
        for batch in ["3", "1000"] {
            let cast = ["cast", &file, "--rays-file", name, "-o", "h.npy", "--device", "cpu", "--batch", batch];
            place.fails(1, wanted, &cast);
        }
    }
    write(&place, "rays.npy", &wide);
    write(&place, "rays", &wide);
    fs::create_dir(place.path("folder.npy")).expect("a folder");
    let cast = |rays: &'static str, more: &[&'static str]| {
        [&["cast", &file, "--rays-file", rays, "--device", "cpu"], more]
            .concat()
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>()
    };
    for (code, wanted, arguments) in [
        (2, "--rays-file rays: expected a name that ends in .npy or .f32", cast("rays", &["-o", "h.npy"])),
        (1, "nothing.npy: No such file", cast("nothing.npy", &["-o", "h.npy"])),
        (1, "folder.npy: it is a folder", cast("folder.npy", &["-o", "h.npy"])),
        (2, "--output h.csv: expected a name that ends in .npy", cast("rays.npy", &["-o", "h.csv"])),
        (1, "there is no folder nowhere", cast("rays.npy", &["-o", "nowhere/h.npy"])),
        (2, "rays.npy would be replaced", cast("rays.npy", &["-o", "rays.npy"])),
        (2, "--any-hit: the paper's rules", cast("rays.npy", &["-o", "h.npy", "--any-hit", "--numerics", "paper"])),
        (2, "--batch 0: expected an integer from 1", cast("rays.npy", &["-o", "h.npy", "--batch", "0"])),
        (2, "--format csv: expected npy or f32", cast("rays.npy", &["-o", "h.npy", "--format", "csv"])),
        (2, "add --count N, use npy, or write to a file", cast("-", &["-o", "-", "--format", "f32"])),
        (1, "standard input: not an npy file", cast("-", &["-o", "h.npy"])),
        (2, "--count 10: an npy file contains the number", cast("rays.npy", &["-o", "h.npy", "--count", "10"])),
    ] {
        place.fails(code, wanted, &arguments.iter().map(String::as_str).collect::<Vec<_>>());
    }
    let raw: Vec<u8> = eight(&good, 0.0, 0.0).iter().flat_map(|number| number.to_le_bytes()).collect();
    write(&place, "ten.f32", &raw);
    place.fails(
        1,
        "ends 0 bytes into ray 10 (counted from 0, of 11)",
        &["cast", &file, "--rays-file", "ten.f32", "--count", "11", "-o", "h.npy", "--device", "cpu"],
    );
    place.fails(
        1,
        "goes on after its 9 rays",
        &["cast", &file, "--rays-file", "ten.f32", "--count", "9", "-o", "h.npy", "--device", "cpu"],
    );
}

#[test]
fn a_closed_pipe_ends_it_quietly_and_an_early_error_writes_nothing() {
    let place = Place::new();
    let six = inside(40_000);
    let rays = npy("(40000, 6)", &six);
    let mut child = start(&place, &["-o", "-", "--batch", "100"]);
    let mut input = child.stdin.take().expect("a pipe");
    let mut output = child.stdout.take().expect("a pipe");
    let all = rays.clone();
    let writer = std::thread::spawn(move || drop(input.write_all(&all)));
    let mut first = [0; HEADER];
    output.read_exact(&mut first).expect("a header");
    drop(output);
    let ended = child.wait_with_output().expect("an end");
    writer.join().expect("the writer");
    assert_eq!((ended.status.code(), String::from_utf8_lossy(&ended.stderr).into_owned()), (Some(0), String::new()));

    // The first ray is wrong: not even a header is written.
    let mut wrong = six;
    wrong[0] = f32::NAN;
    let mut child = start(&place, &["-o", "-"]);
    let mut input = child.stdin.take().expect("a pipe");
    let wrong = npy("(40000, 6)", &wrong);
    let writer = std::thread::spawn(move || drop(input.write_all(&wrong)));
    let ended = child.wait_with_output().expect("an end");
    writer.join().expect("the writer");
    let ended = Outcome {
        code: ended.status.code(),
        stdout: String::from_utf8_lossy(&ended.stdout).into_owned(),
        stderr: String::from_utf8_lossy(&ended.stderr).into_owned(),
    };
    assert_error(&ended, 1, "standard input: ray 0 (counted from 0, of 40000)", "a wrong ray");

    // No rays are an empty array.
    let (empty, said) = piped(&place, &npy("(0, 6)", &[]), &["-o", "-"]);
    assert_eq!((empty.len(), said.starts_with("0 rays, 0 hit; ")), (HEADER, true), "{said}");
}

#[test]
fn rays_that_the_papers_rules_miss_are_counted() {
    let place = Place::new();
    let mut six = inside(10);
    // Two start to the left of the box.
    (six[0], six[6 * 7]) = (-9.0, -9.0);
    write(&place, "rays.npy", &npy("(10, 6)", &six));
    let cast = ["cast", &cornell_box(), "--rays-file", "rays.npy", "-o", "h.npy", "--device", "cpu", "--numerics"];
    let said = |more: &[&str]| place.ok(&[&cast[..], more].concat()).stderr;
    let note =
        "note: with a grid, the paper's rules can lose rays that start outside it; here 2 of 10 rays start there";
    let text = said(&["paper", "--accelerator", "grid", "--batch", "3"]);
    assert!(text.contains(note), "{text}");
    for more in [&["robust", "--accelerator", "grid"][..], &["paper", "--accelerator", "bvh"]] {
        let text = said(more);
        assert!(!text.contains("note: the paper's"), "{text}");
    }
}
