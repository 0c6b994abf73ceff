//! `raystep stop` and `raystep cost`.

use std::fs;

use crate::common::{Place, assert_error};
use crate::files::cornell_box;

const SMALL: [&str; 3] = ["--size", "16x12", "--quiet"];

fn stop(place: &Place, scene: &str, more: &[&str]) -> crate::common::Outcome {
    place.run(&[&["stop", scene], more, &SMALL[..]].concat())
}

/// A program like one of the examples.
fn new(place: &Place, like: &str) {
    place.ok(&["new", "mine", "--like", like]);
}

#[test]
fn the_rays_for_which_a_condition_holds_are_counted_named_and_written() {
    let place = Place::new();
    let at = ["--at", "intersect:57", "--when", "candidate.is_hit && candidate.t < 3.0"];
    let found = stop(&place, &cornell_box(), &[&at[..], &["-o", "rays.csv"]].concat());
    assert_eq!((found.code, &*found.stderr), (Some(0), ""), "{found:?}");
    let lines: Vec<_> = found.stdout.lines().collect();
    assert!(lines[0].starts_with("pass ") && lines[0].contains(", intersect, intersect.wgsl:57: "), "{lines:?}");
    assert_eq!(lines[1], "  if (candidate.is_hit && accepted) {");
    assert!(lines[2].contains("candidate.is_hit = true  candidate.t = "), "{lines:?}");
    let list = fs::read_to_string(place.path("rays.csv")).expect("a list");
    let mut rows = list.lines();
    assert_eq!(rows.next(), Some("element,x,y,reached,held,candidate.is_hit,candidate.t"));
    let rows: Vec<Vec<&str>> = rows.map(|row| row.split(',').collect()).collect();
    let held = rows.iter().filter(|row| row[4] == "1").count();
    assert!(held > 0 && lines[0].ends_with(&format!("holds for {held}")), "{lines:?}");
    for row in rows {
        let number = |at: usize| row[at].parse::<f32>().expect("a number");
        assert!((number(0), row[3]) == (number(1) + 16.0 * number(2), "1"), "{row:?}");
        assert_eq!(row[4] == "1", row[5] == "true" && number(6) < 3.0, "{row:?}");
    }
    // The mask and the array say the same.
    let pass = lines[0].split([' ', ',']).nth(1).expect("a pass").to_owned();
    for output in ["mask.png", "mask.npy"] {
        let again = stop(&place, &cornell_box(), &[&at[..], &["--pass", &pass, "-o", output]].concat());
        assert_eq!((again.code, &again.stdout), (Some(0), &found.stdout), "{again:?}");
    }
    let mask = image::load_from_memory(&place.read("mask.png")).expect("a picture").to_luma8();
    assert_eq!(((mask.width(), mask.height()), mask.pixels().filter(|p| p.0[0] == 255).count()), ((16, 12), held));
    let array = place.read("mask.npy");
    let words =
        array[array.len() - 4 * 192..].chunks(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]));
    assert_eq!(words.sum::<u32>() as usize, held);
}

#[test]
fn lines_of_imported_files_and_of_ones_own_are_found_too() {
    let place = Place::new();
    let found = stop(&place, &cornell_box(), &["--at", "grid_lists.wgsl:1"]);
    assert!(found.code == Some(2) && found.stderr.contains("no statement of"), "{found:?}");
    let source = include_str!("../../kernels/src/programs/closest_hit/intersect.wgsl");
    fs::write(place.path("my.wgsl"), source.replacen("item += 1u;", "item += 1u; // here", 1)).expect("a file");
    let own = ["--kernel", "my.wgsl", "--at", "my.wgsl:64", "--when", "item > 0u"];
    let found = stop(&place, &cornell_box(), &own);
    assert_eq!((found.code, &*found.stderr), (Some(0), ""), "{found:?}");
    assert!(found.stdout.contains("my.wgsl:64") && found.stdout.contains("  item += 1u; // here\n"), "{found:?}");
}

#[test]
fn a_program_of_ones_own_stops_with_barriers_and_for_each_element() {
    let place = Place::new();
    new(&place, "prefix-sum");
    // Two kernels have the file.
    let both = place.run(&["stop", "mine", "--at", "scan.wgsl:30", "--quiet"]);
    assert_error(&both, 2, "choose sum_numbers or sum_blocks with --for", "two kernels");
    let line = include_str!("../programs/prefix-sum/scan.wgsl").lines().position(|l| l.contains("row[1u - now]"));
    let at = format!("scan.wgsl:{}", line.expect("the line") + 1);
    let wanted = [
        "stop",
        "mine",
        "--at",
        &at,
        "--for",
        "sum_numbers",
        "--when",
        "reach == 4u && sum == 8u",
        "--quiet",
        "-o",
        "l.csv",
    ];
    let found = place.ok(&wanted);
    assert!(found.stdout.starts_with("pass 1, sum_numbers, mine/scan.wgsl:"), "{found:?}");
    assert!(
        found.stdout.contains("20000 of 20000 numbers come here") && found.stdout.contains("reach = 4  sum = 8"),
        "{found:?}"
    );
    let list = fs::read_to_string(place.path("l.csv")).expect("a list");
    // Eight turns for each; eight numbers 0, 1, 2, 0, … have the sum 8 if they begin with 1 or with 2 of three.
    let rows: Vec<Vec<&str>> = list.lines().skip(1).map(|row| row.split(',').collect()).collect();
    assert!(rows.len() == 20_000 && rows.iter().all(|row| row[3] == "8"), "{}", rows.len());
    let of = |at: usize| rows[at][4];
    let sum = |at: usize| (at - 7..=at).map(|number| number % 3).sum::<usize>();
    (7..256).for_each(|at| assert_eq!(of(at) == "1", sum(at) == 8, "{at}"));
    let mask = place.run(&["stop", "mine", "--at", &at, "--for", "sum_numbers", "--quiet", "-o", "m.png"]);
    assert_error(&mask, 2, "choose .csv or .npy", "no image");
}

#[test]
fn what_cannot_stop_is_told_with_what_would_be_right() {
    let place = Place::new();
    new(&place, "life");
    let fails = |code, wanted: &str, more: &[&str]| {
        let outcome = place.run(&[&["stop", "mine", "--quiet"], more].concat());
        assert!(outcome.code == Some(code) && outcome.stderr.contains(wanted), "{wanted}: {outcome:?}");
    };
    fails(2, "expected a kernel or its file, and a line", &["--at", "generation"]);
    fails(2, "no kernel of the run has this file", &["--at", "generatoin.wgsl:8"]);
    fails(2, "no statement of generation begins in this line; the next is in line 12", &["--at", "generation:10"]);
    fails(2, "--when, column 1: no definition in scope", &["--at", "generation:18", "--when", "neighbors > 5u"]);
    fails(2, "variables here: alive, id, neighbours, size", &["--at", "generation:18", "--when", "neighbors > 5u"]);
    fails(2, "compare it, as in x == 0", &["--at", "generation:18", "--when", "neighbours"]);
    fails(2, "pass 0: this is a pass of seed", &["--at", "generation:18", "--pass", "0"]);
    fails(2, "the run has 201 passes", &["--at", "generation:18", "--pass", "500"]);
    fails(
        2,
        "generatio: the run has no such kernel; did you mean generation",
        &["--at", "seed:9", "--for", "generatio"],
    );
    fails(
        1,
        "neighbours > 9u holds for none of the 65536 elements that come to this line, in the first 1 pass of generation",
        &["--at", "generation:18", "--when", "neighbours > 9u", "--passes", "1"],
    );
    // An index that is out of range in the condition.
    fails(1, "generation.wgsl:18", &["--at", "generation:18", "--when", "textureLoad(cell, id.xy + 9999u, 0).x == 1u"]);
}

#[test]
fn each_line_has_its_runs_operations_and_bytes() {
    let place = Place::new();
    new(&place, "life");
    let text = fs::read_to_string(place.path("mine/program.toml")).expect("a file");
    fs::write(place.path("mine/program.toml"), text.replace("[256, 256]", "[16, 16]")).expect("written");
    let counted = place.ok(&["cost", "mine", "--for", "generation", "--pass", "1", "--csv", "c.csv", "--quiet"]);
    assert!(counted.stdout.starts_with("generation in pass 1: 256 elements\n"), "{counted:?}");
    let row = |line: usize| {
        let name = format!("mine/generation.wgsl:{line} ");
        let row = counted.stdout.lines().find(|row| row.starts_with(&name)).unwrap_or_else(|| panic!("{counted:?}"));
        row.split_whitespace().map(str::to_owned).collect::<Vec<_>>()
    };
    // Nine cells for each, of four bytes; line 15 adds each to the sum.
    assert_eq!((&row(15)[1][..], &row(15)[3][..], &row(15)[5][..]), ("2304", "2304", "9216"));
    assert_eq!((&row(20)[1][..], &row(20)[6][..]), ("256", "1024"));
    assert!(row(15).join(" ").ends_with("neighbours += textureLoad(cell, there, 0).x;"));
    assert!(counted.stdout.lines().last().is_some_and(|all| all.starts_with("all ")));
    let csv = fs::read_to_string(place.path("c.csv")).expect("a table");
    assert!(csv.starts_with("schema_version,kernel,passes,elements,file,line,line_runs,"), "{csv}");
    assert!(csv.lines().any(|row| row.contains("generation,1,256,mine/generation.wgsl,15,2304,0,9,0,36,0,")), "{csv}");
    let scene = place.ok(&[&["cost", &cornell_box(), "--for", "intersect"], &SMALL[..]].concat());
    assert!(scene.stdout.contains("intersect.wgsl:64 ") && scene.stdout.contains("triangle.wgsl:"), "{scene:?}");
}
