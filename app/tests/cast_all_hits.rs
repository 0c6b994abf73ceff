//! `raystep cast --all-hits` and `trace --all-hits`: every surface that rays cross.

use std::fs;
use std::io::{Cursor, Read as _};

use crate::cast::{hits, inside, npy};
use crate::common::{Place, scene};

const HEADER: usize = 256;

/// A box from 0 to 1 as OBJ, its faces turned outwards.
const CLOSED: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n\
                      f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";

/// All hits in a file of records: the rays, and the words of each hit.
fn all(file: &[u8]) -> Vec<(u64, [u32; 5])> {
    let header = String::from_utf8_lossy(&file[..HEADER]);
    assert!(header.contains("'descr': [('ray', '<u8'), ('t', '<f4'), "), "{header}");
    let (records, rest) = file[HEADER..].as_chunks::<28>();
    assert!(rest.is_empty() && header.contains(&format!("'shape': ({},)", records.len())), "{header}");
    let word = |record: &[u8; 28], i: usize| u32::from_le_bytes([0, 1, 2, 3].map(|k| record[4 * i + k]));
    let ray = |record: &[u8; 28]| u64::from(word(record, 0)) | u64::from(word(record, 1)) << 32;
    records.iter().map(|record| (ray(record), [2, 3, 4, 5, 6].map(|i| word(record, i)))).collect()
}

fn cast(place: &Place, file: &str, more: &[&str]) -> String {
    place.ok(&[&["cast", file, "--rays-file", "r.npy", "--all-hits"], more].concat()).stdout
}

#[test]
fn every_format_and_device_has_the_same_hits_in_order() {
    let place = Place::new();
    let file = scene("teapot.glb").display().to_string();
    fs::write(place.path("r.npy"), npy("(700, 6)", &inside(700))).expect("a file");
    let said = cast(&place, &file, &["--device", "cpu", "-o", "s.npy"]);
    let records = all(&place.read("s.npy"));
    let most = records.chunk_by(|one, other| one.0 == other.0).map(<[_]>::len).max().expect("hits");
    let begin = format!("700 rays {} hits at most {most} of a ray; ", records.len());
    assert!(said.replace(',', "").starts_with(&begin), "{said}");
    assert!(records.len() > 300 && most > 1, "{said}");
    assert!(records.is_sorted_by(|(ray, hit), (next, then)| {
        ray < next || ray == next && f32::from_bits(hit[0]) <= f32::from_bits(then[0])
    }));
    // The first of each ray is its closest.
    place.ok(&["cast", &file, "--rays-file", "r.npy", "--order", "exact", "--device", "cpu", "-o", "c.npy"]);
    let closest = hits(&place.read("c.npy"));
    let mut firsts = records.chunk_by(|one, other| one.0 == other.0).map(|of_ray| of_ray[0]).peekable();
    for (ray, closest) in closest.into_iter().enumerate() {
        let first = firsts.next_if(|(of, _)| *of == ray as u64);
        assert_eq!(first.map(|(_, hit)| hit), Some(closest).filter(|hit| hit[3] != u32::MAX), "ray {ray}");
    }

    for more in [&["--device", "gpu"][..], &["--device", "cpu", "--batch", "33", "--schedule", "compact"]] {
        cast(&place, &file, &[more, &["-o", "o.npy"]].concat());
        assert!(place.read("o.npy") == place.read("s.npy"), "{more:?}");
    }

    cast(&place, &file, &["--device", "cpu", "--output-format", "plain", "-o", "p.npy"]);
    let plain = place.read("p.npy");
    assert!(String::from_utf8_lossy(&plain[..HEADER]).contains(&format!("'shape': ({}, 6)", records.len())));
    let (numbers, _) = plain[HEADER..].as_chunks::<8>();
    for ((ray, hit), row) in records.iter().zip(numbers.chunks_exact(6)) {
        let row: Vec<f64> = row.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
        let [t, u, v] = [0, 1, 2].map(|i| f64::from(f32::from_bits(hit[i])));
        assert_eq!(row, [*ray as f64, t, u, v, f64::from(hit[3]), f64::from(hit[4])]);
    }

    cast(&place, &file, &["--device", "cpu", "-o", "z.npz"]);
    let mut zip = zip::ZipArchive::new(Cursor::new(place.read("z.npz"))).expect("a zip file");
    let mut read = |name: &str| {
        let mut bytes = Vec::new();
        zip.by_name(name).expect("a field").read_to_end(&mut bytes).expect("bytes");
        bytes.split_off(HEADER)
    };
    let rays: Vec<u8> = records.iter().flat_map(|(ray, _)| ray.to_le_bytes()).collect();
    assert!(read("ray.npy") == rays);
    let triangles: Vec<u8> = records.iter().flat_map(|(_, hit)| hit[3].to_le_bytes()).collect();
    assert!(read("triangle.npy") == triangles);
}

#[test]
fn bad_rays_have_no_hits_and_rays_through_corners_an_even_number() {
    let place = Place::new();
    fs::write(place.path("box.obj"), CLOSED).expect("a file");
    let corners = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|v| v as f32));
    let from = |[x, y, z]: [f32; 3]| move |to: [f32; 3]| [x, y, z, to[0] - x, to[1] - y, to[2] - z];
    let mut rays: Vec<[f32; 6]> = corners.clone().map(from([3.0, 3.0, 3.0])).collect();
    rays.extend(corners.clone().map(from([0.0, 0.5, -2.0])));
    rays.extend(corners.map(from([5.0, 1.0, 0.0])));
    rays[5][4] = f32::NAN;
    fs::write(place.path("r.npy"), npy("(24, 6)", rays.as_flattened())).expect("a file");
    let cast = ["cast", "box.obj", "--rays-file", "r.npy", "--all-hits", "-o", "h.npy", "--device", "cpu"];
    place.fails(1, "ray 5 (counted from 0, of 24)", &cast);
    for batch in ["7", "100"] {
        place.ok(&[&cast[..], &["--bad-rays", "miss", "--batch", batch]].concat());
        let found = all(&place.read("h.npy"));
        assert!(found.len() >= 10, "{found:?}");
        for of_ray in found.chunk_by(|one, other| one.0 == other.0) {
            assert!(of_ray[0].0 != 5 && of_ray.len() == 2, "{of_ray:?}");
        }
    }
}

#[test]
fn what_has_no_list_of_hits_is_refused() {
    let place = Place::new();
    fs::write(place.path("box.obj"), CLOSED).expect("a file");
    fs::write(place.path("r.npy"), npy("(2, 6)", &inside(2))).expect("a file");
    let cast = ["cast", "box.obj", "--rays-file", "r.npy", "--all-hits", "-o"];
    for (wanted, more) in [
        ("--all-hits: it excludes --any-hit", &["h.npy", "--any-hit"][..]),
        ("--all-hits: the paper's rules", &["h.npy", "--numerics", "paper"]),
        ("--all-hits: hits are in the order of exact t", &["h.npy", "--order", "rounded"]),
        ("known only at the end: write to a file, or add --output-format npz", &["-"]),
    ] {
        place.fails(2, wanted, &[&cast[..], more].concat());
    }
    let trace = ["trace", "box.obj", "--all-hits", "--ray", "0.5,0.5,3,0,0,-1", "--format"];
    place.fails(2, "--all-hits: CSV has the passes only", &[&trace[..], &["csv"]].concat());
}

#[test]
fn a_traced_ray_lists_every_surface_that_it_crosses() {
    let place = Place::new();
    fs::write(place.path("box.obj"), CLOSED).expect("a file");
    // Through two corners.
    let trace = ["trace", "box.obj", "--all-hits", "--ray", "3,3,3,-1,-1,-1", "--device", "cpu", "--format"];
    let table = place.ok(&[&trace[..], &["table"]].concat()).stdout;
    let (_, list) = table.split_once("The ray crosses 2 surfaces, in this order:").expect("a list");
    let lines: Vec<Vec<&str>> = list.lines().skip(3).map(|line| line.split_whitespace().collect()).collect();
    assert_eq!((lines[0][..2].to_vec(), lines[1][..2].to_vec()), (vec!["front", "2"], vec!["back", "3"]), "{list}");
    let json = place.ok(&[&trace[..], &["json"]].concat()).stdout;
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(json["all_hits"][1]["t"], 3.0);
    assert_eq!(json["all_hits"][0]["front"], true);
    let missed = place.ok(&["trace", "box.obj", "--all-hits", "--ray", "3,3,3,1,1,1", "--device", "cpu"]).stdout;
    assert!(missed.contains("crosses no surface"), "{missed}");
}
