//! `raystep cast`: formats of hits and of rays, and rays that cannot be traced.

use std::fs;
use std::io::{Cursor, Read as _};

use crate::cast::{hits, inside, npy};
use crate::common::{Place, scene};

const HEADER: usize = 256;

fn teapot() -> String {
    scene("teapot.glb").display().to_string()
}

/// A place with rays of which every fifth hits nothing.
fn place(count: usize) -> (Place, Vec<f32>) {
    let place = Place::new();
    let mut rays = inside(count);
    rays.chunks_exact_mut(6).step_by(5).for_each(|ray| ray[..3].fill(1e3));
    fs::write(place.path("rays.npy"), npy(&format!("({count}, 6)"), &rays)).expect("a file");
    (place, rays)
}

fn cast(place: &Place, more: &[&str]) {
    place.ok(&[&["cast", &teapot(), "--device", "cpu", "--batch", "100", "--quiet"], more].concat());
}

#[test]
fn every_format_has_the_same_hits() {
    let (place, _) = place(700);
    for (format, name) in [("structured", "s.npy"), ("plain", "p.npy"), ("npz", "z.npz")] {
        cast(&place, &["--rays-file", "rays.npy", "--output-format", format, "-o", name]);
    }
    let records = hits(&place.read("s.npy"));
    let found = records.iter().filter(|record| record[3] != u32::MAX).count();
    assert!(found > 50 && found < 700, "{found} of 700 rays hit");

    let plain = place.read("p.npy");
    assert!(
        String::from_utf8_lossy(&plain[..HEADER]).contains("'descr': '<f8', 'fortran_order': False, 'shape': (700, 5)")
    );
    let (numbers, rest) = plain[HEADER..].as_chunks::<8>();
    assert_eq!((numbers.len(), rest.len()), (5 * 700, 0));
    for (record, row) in records.iter().zip(numbers.chunks_exact(5)) {
        let row: Vec<f64> = row.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
        let [t, u, v] = [0, 1, 2].map(|i| f64::from(f32::from_bits(record[i])));
        let [triangle, material] = [record[3], record[4]].map(|id| if id == u32::MAX { -1.0 } else { f64::from(id) });
        assert_eq!(row, [t, u, v, triangle, material]);
    }

    let mut zip = zip::ZipArchive::new(Cursor::new(place.read("z.npz"))).expect("a zip file");
    for (field, name) in ["t", "u", "v", "triangle", "material"].iter().enumerate() {
        let mut bytes = Vec::new();
        let mut file = zip.by_name(&format!("{name}.npy")).expect(name);
        assert_eq!(file.compression(), zip::CompressionMethod::Stored, "as numpy.savez writes it");
        file.read_to_end(&mut bytes).expect(name);
        let (words, rest) = bytes[HEADER..].as_chunks::<4>();
        assert!(rest.is_empty());
        let words: Vec<u32> = words.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect();
        assert_eq!(words, records.iter().map(|record| record[field]).collect::<Vec<_>>(), "{name}");
    }
}

#[test]
fn the_name_of_the_output_tells_npz_and_a_wrong_one_is_refused() {
    let (place, _) = place(10);
    cast(&place, &["--rays-file", "rays.npy", "-o", "hits.npz"]);
    assert!(place.read("hits.npz").starts_with(b"PK"));
    let wrong = |format: &str, name: &str, wanted: &str| {
        let arguments = ["cast", &teapot(), "--rays-file", "rays.npy", "--output-format", format, "-o", name];
        place.fails(2, wanted, &arguments);
    };
    wrong("npz", "hits.npy", "expected a name that ends in .npz");
    wrong("plain", "hits.npz", "expected a name that ends in .npy");
    wrong("json", "hits.npy", "expected structured, plain or npz");
}

#[test]
fn rays_of_float64_hit_what_those_of_float32_hit() {
    let (place, rays) = place(300);
    let mut wide = npy("(300, 6)", &[]);
    let kind = wide.windows(3).position(|text| text == b"<f4").expect("a type");
    wide[kind..kind + 3].copy_from_slice(b"<f8");
    wide.extend(rays.iter().flat_map(|&number| f64::from(number).to_le_bytes()));
    fs::write(place.path("wide.npy"), wide).expect("a file");
    cast(&place, &["--rays-file", "rays.npy", "-o", "a.npy"]);
    cast(&place, &["--rays-file", "wide.npy", "-o", "b.npy"]);
    assert!(place.read("a.npy") == place.read("b.npy"));
}

#[test]
fn a_bad_ray_ends_the_cast_or_misses_and_is_counted() {
    let (place, mut rays) = place(500);
    let bad = [7, 123, 499];
    rays[6 * 7 + 1] = f32::NAN;
    rays[6 * 123 + 3..6 * 124].fill(0.0);
    rays[6 * 499] = f32::MAX;
    fs::write(place.path("bad.npy"), npy("(500, 6)", &rays)).expect("a file");
    let arguments = ["cast", &teapot(), "--rays-file", "bad.npy", "--device", "cpu", "--batch", "100"];
    place.fails(1, "ray 7 (counted from 0, of 500)", &[&arguments[..], &["-o", "hits.npy"]].concat());
    let outcome = place.ok(&[&arguments[..], &["--bad-rays", "miss", "-o", "hits.npy"]].concat());
    assert!(outcome.stderr.contains("note: 3 of 500 rays cannot be traced"), "{outcome:?}");
    cast(&place, &["--rays-file", "rays.npy", "-o", "good.npy"]);
    let [all, good] = ["hits.npy", "good.npy"].map(|name| hits(&place.read(name)));
    for (ray, (hit, good)) in all.iter().zip(&good).enumerate() {
        match bad.contains(&ray) {
            true => assert_eq!(*hit, [f32::INFINITY.to_bits(), 0, 0, u32::MAX, u32::MAX], "ray {ray}"),
            false => assert_eq!(hit, good, "ray {ray}"),
        }
    }
}
