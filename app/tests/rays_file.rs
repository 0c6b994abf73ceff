//! `--rays-file` and `--strata` of `report` and `bench`: the same rays as `cast`, judged by group.

use crate::cast::{hits, inside, npy};
use crate::common::{Place, scene};
use crate::report_files::{check_intervals, check_page, number, tables};

const RAYS: usize = 300;

/// 300 rays, of which every third is of group 7 and the others of group 2.
fn place() -> Place {
    let place = Place::new();
    std::fs::write(place.path("rays.npy"), npy(&format!("({RAYS}, 6)"), &inside(RAYS))).expect("a file");
    let header = format!("{{'descr': '|u1', 'fortran_order': False, 'shape': ({RAYS},), }}\n");
    let length = u16::try_from(header.len()).expect("a short header").to_le_bytes();
    let groups: Vec<u8> = (0..RAYS).map(|ray| if ray % 3 == 0 { 7 } else { 2 }).collect();
    let file = [b"\x93NUMPY\x01\x00".as_slice(), &length, header.as_bytes(), &groups].concat();
    std::fs::write(place.path("groups.npy"), file).expect("a file");
    place
}

#[test]
fn a_report_judges_rays_of_a_file_by_group() {
    let place = place();
    let file = scene("cornell-box.gltf").display().to_string();
    let report = ["report", &file, "--quick", "--device", "cpu", "--section", "choices", "--rays-file", "rays.npy"];
    let output = ["--strata", "groups.npy", "-o", "out", "--rays-csv", "--bundle", "out.zip", "--quiet"];
    place.ok(&[&report[..], &output].concat());
    let tables = tables(&place, "out");
    check_page(&place, "out", &tables);
    assert!(check_intervals(&tables)[2] > 30);
    let page = String::from_utf8(place.read("out/index.html")).expect("UTF-8");
    assert!(page.contains("<data value=\"300\">300</data> rays of a file"), "instead of pixels");
    assert!(!page.contains("start outside"));
    let choices = &tables["choices.csv"];
    for all in choices.iter().filter(|row| row["stratum"] == "all") {
        let of = |stratum: &str| {
            let mut rows = choices.iter().filter(|r| r["configuration"] == all["configuration"]);
            rows.find(|r| r["stratum"] == stratum).expect("a group").clone()
        };
        assert_eq!((number(all, "rays"), number(&of("7"), "rays"), number(&of("2"), "rays")), (300.0, 100.0, 200.0));
        assert_eq!((number(&of("7"), "judged_rays"), number(&of("2"), "judged_rays")), (100.0, 200.0));
        for column in ["judged_rays", "wrong_rays", "undecided"] {
            assert_eq!(number(all, column), number(&of("7"), column) + number(&of("2"), column), "{column}");
        }
    }
    // Single rays are those of the file, in its order.
    place.ok(&["cast", &file, "--rays-file", "rays.npy", "--device", "cpu", "-o", "hits.npy", "--quiet"]);
    let found = hits(&place.read("hits.npy"));
    let of_one = tables["rays.csv"].iter().filter(|r| r["configuration"] == "choices/bvh/fused/robust");
    let mut count = 0;
    for (ray, row) in of_one.enumerate() {
        assert_eq!((row["ray"].as_str(), row["stratum"].as_str()), (&*ray.to_string(), ["7", "2", "2"][ray % 3]));
        let triangle = found[ray][3];
        assert_eq!(row["found_triangle"], if triangle == u32::MAX { String::new() } else { triangle.to_string() });
        count += 1;
    }
    assert_eq!(count, RAYS);
    // The bundle has its rays.
    std::fs::remove_file(place.path("rays.npy")).expect("a file");
    let verified = place.ok(&["report", "--verify", "out.zip", "--quiet"]);
    assert!(verified.stdout.contains("rays.csv: "), "{verified:?}");
}

#[test]
fn a_report_says_why_the_papers_rules_miss_rays_from_outside() {
    let place = Place::new();
    let mut rays = inside(20);
    rays.iter_mut().step_by(6).for_each(|x| *x -= 9.0);
    std::fs::write(place.path("rays.npy"), npy("(20, 6)", &rays)).expect("a file");
    let file = scene("cornell-box.gltf").display().to_string();
    let report = ["report", &file, "--quick", "--device", "cpu", "--section", "choices", "--rays-file", "rays.npy"];
    let said = place.ok(&[&report[..], &["-o", "out"]].concat()).stderr;
    let why = "with a grid, the paper's rules can lose rays that start outside it; here";
    assert!(said.contains(&format!("note: cornell-box, choices: {why} all rays start there")), "{said}");
    let page = String::from_utf8(place.read("out/index.html")).expect("UTF-8");
    assert!(page.contains(" With a grid, they can lose rays that start outside it; here all rays start there."));
    assert!(page.contains(" judged rays cannot show less."), "the limit is raised for so few rays");
    check_page(&place, "out", &tables(&place, "out"));
}

#[test]
fn a_benchmark_traces_rays_of_a_file() {
    let place = place();
    let file = scene("cornell-box.gltf").display().to_string();
    let bench = ["bench", &file, "--accelerators", "grid,bvh", "--repeats", "6", "--device", "cpu", "--rays-file"];
    let outcome = place.ok(&[&bench[..], &["rays.npy", "-o", "out"]].concat());
    assert!(!outcome.stderr.contains("different hits") && !outcome.stderr.contains("fnv1a64"), "{outcome:?}");
    let title = "cornell-box (26 triangles): 300 rays of rays.npy\n";
    assert!(outcome.stdout.starts_with(title) && !outcome.stdout.contains("fnv1a64"), "{outcome:?}");
    let mut reader = csv::Reader::from_path(place.path("out/summary.csv")).expect("a file");
    let names = reader.headers().expect("names").clone();
    let at = |name: &str| names.iter().position(|n| n == name).expect("a column");
    let rows: Vec<csv::StringRecord> = reader.records().collect::<Result<_, _>>().expect("rows");
    assert_eq!(rows.len(), 2);
    for row in &rows {
        assert!(row[at("rays")] == *"300" && row[at("rays_kind")].starts_with("file fnv1a64:"), "{row:?}");
        assert_eq!(row[at("hits_hash")], rows[0][at("hits_hash")]);
    }
    // Two builds trace them, too.
    let against = ["rays.npy", "--against", env!("CARGO_BIN_EXE_raystep"), "--at-most", "1000", "-o", "gate"];
    place.run(&[&bench[..], &against].concat());
    let summary = String::from_utf8(place.read("gate/summary.csv")).expect("UTF-8");
    assert_eq!(summary.matches(",file fnv1a64:").count(), 4, "{summary}");
    for (wanted, more) in [
        ("unexpected argument --strata", &["rays.npy", "--strata", "groups.npy"][..]),
        ("cannot be combined with --rays", &["rays.npy", "--rays", "bounce"]),
        ("expected a name that ends in .npy or .f32", &["rays.txt"]),
    ] {
        place.fails(2, wanted, &[&bench[..], more, &["-o", "no"]].concat());
    }
    place.fails(1, "--rays-file none.npy: ", &[&bench[..], &["none.npy", "-o", "no"]].concat());
}
