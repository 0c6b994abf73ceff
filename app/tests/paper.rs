//! `raystep paper`, and the page that leads from the paper's sections to commands.

use std::fs;

use crate::common::{Place, scene};

fn page() -> String {
    fs::read_to_string(scene("../docs/paper.md")).expect("the page")
}

#[test]
fn the_tables_have_the_papers_numbers_beside_ours() {
    let place = Place::new();
    let run = ["paper", "--device", "cpu", "--repeats", "1", "--section", "tables-2-3", "-o", "out"];
    let done = place.ok(&run);
    // A row for each of the paper's, in its order and with its names.
    let rows: Vec<Vec<&str>> = done.stdout.lines().map(|line| line.split_whitespace().collect()).collect();
    let starts_with = |words: &[&str]| rows.iter().position(|row| row.starts_with(words));
    let wanted: [&[&str]; 14] = [
        &["Table", "2:"],
        &["Strategy", "Resolution", "2004,", "s"],
        &["First", "100x100", "5.5"],
        &["First", "256x256", "22"],
        &["First", "512x512", "79"],
        &["First", "756x756", "170"],
        &["Second", "100x100", "3"],
        &["Second", "256x256", "12.5"],
        &["Second", "512x512", "46"],
        &["Second", "756x756", "100"],
        &["Table", "3:"],
        &["100x100", "1.3"],
        &["256x256", "4.3"],
        &["756x756", "31"],
    ];
    let places: Vec<_> = wanted.iter().map(|words| starts_with(words)).collect();
    assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{places:?}: {}", done.stdout);
    let csv = place.read("out/tables_2_3.csv");
    let mut reader = csv::Reader::from_reader(csv.as_slice());
    let names = reader.headers().expect("names").clone();
    let column = |name: &str| names.iter().position(|n| n == name).expect(name);
    let records: Vec<_> = reader.records().map(|row| row.expect("as many fields as names")).collect();
    assert_eq!(records.len(), 12);
    for row in &records {
        let number = |name: &str| row[column(name)].parse::<f64>().expect(name);
        let ratio = number("paper_s") * 1e9 / number("median_ns");
        assert!((number("paper_by_here") / ratio - 1.0).abs() < 1e-4, "{row:?}");
        // One run has no interval.
        assert_eq!(&row[column("low_ns")], "");
    }
    assert!(place.path("out/datapackage.json").exists() && !place.path("out/table_1.csv").exists());
    place.fails(1, "out is not empty", &run);
    place.ok(&["paper", "--section", "table-1", "--force", "-o", "out"]);
    assert!(
        place.path("out/table_1.csv").exists() && !place.path("out/tables_2_3.csv").exists(),
        "{:?}",
        place.names()
    );
    // Another command's folder stays as it is.
    fs::create_dir(place.path("other")).expect("a folder");
    fs::write(place.path("other/counts.csv"), "a\n").expect("a file");
    place.fails(1, "counts.csv that is not from 'raystep paper'", &["paper", "--force", "-o", "other"]);
}

#[test]
fn intensity_is_printed_and_written_for_any_scene_but_not_for_builds() {
    let place = Place::new();
    let teapot = scene("teapot.glb").display().to_string();
    let plan = ["plan", &teapot, "--size", "8x8", "--device", "cpu", "--quiet"];
    let counted = place.ok(&[&plan[..], &["--intensity", "--intensity-csv", "kernels.csv"]].concat()).stdout;
    assert!(counted.contains("\narithmetic intensity, ") && counted.contains("8x8 rays"), "{counted}");
    assert!(!place.ok(&plan).stdout.contains("arithmetic intensity"));
    let csv = String::from_utf8(place.read("kernels.csv")).expect("UTF-8");
    let json = place.ok(&[&plan[..], &["--intensity", "--json"]].concat()).stdout;
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let kernels = json["intensity"].as_array().expect("kernels");
    assert_eq!(kernels.len() + 1, csv.lines().count());
    assert!(kernels.iter().any(|kernel| kernel["kernel"] == "shade" && kernel["elements"] == 64), "{json:#}");
    let build = [&plan[..], &["--intensity", "--program", "grid-build"]].concat();
    place.fails(2, "--intensity: elements of program grid-build read each other", &build);
}

#[test]
fn the_plan_has_as_many_draws_as_programs_are_counted() {
    let place = Place::new();
    let cornell_box = scene("cornell-box.gltf").display().to_string();
    let plan = ["plan", &cornell_box, "--schedule", "second", "--numerics", "paper", "--grid", "20", "--device", "gpu"];
    let drawn = place.ok(&[&plan[..], &["--mapping", "fragment", "--quiet"]].concat()).stdout;
    let draws = drawn.lines().filter(|line| line.starts_with("    draw ")).count();
    let counts = place.ok(&["paper", "--section", "counts"]).stdout;
    assert!(draws == 12 && counts.contains(&format!("{draws} as fragment programs")), "{draws}: {counts}");
}

#[test]
fn the_page_shows_what_the_commands_print() {
    let place = Place::new();
    for section in ["table-1", "intensity", "counts"] {
        let printed = place.ok(&["paper", "--quiet", "--section", section]).stdout;
        // In a block of code, indented by four spaces.
        let block: String = printed.lines().map(|line| format!("    {line}").trim_end().to_owned() + "\n").collect();
        assert!(page().contains(&block), "docs/paper.md does not show this:\n{block}");
    }
}

/// The command lines of a page: whatever is code, in a block or within a line, and begins with `raystep`.
#[cfg(unix)]
fn command_lines(page: &str) -> Vec<String> {
    let joined = page.replace("\\\n", "");
    let in_blocks = joined.lines().filter(|line| line.starts_with("    raystep ")).map(str::to_owned);
    let in_lines = joined.split('`').skip(1).step_by(2).filter(|code| code.starts_with("raystep ")).map(str::to_owned);
    in_blocks.chain(in_lines).map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect()
}

#[test]
#[cfg(unix)]
fn the_command_lines_of_the_page_run() {
    let lines = command_lines(&page());
    assert!(lines.len() >= 20, "{lines:?}");
    let place = Place::new();
    std::os::unix::fs::symlink(scene(""), place.path("scenes")).expect("a link");
    for line in lines {
        // `small` adds a file for a screenshot, which `--do` needs.
        assert!(!line.contains(" --do ") || line.contains(" --screenshot "), "{line}");
        // The scenes' files: how names are found is tested elsewhere.
        let line =
            line.replace(" cornell-box ", " scenes/cornell-box.gltf ").replace(" teapot ", " scenes/teapot.glb ");
        let line = crate::examples::small(&line);
        // Each stands for itself: another may have written the same folder.
        let output = line.split_once(" -o ").map(|(_, rest)| place.path(rest.split(' ').next().unwrap_or(rest)));
        if let Some(folder) = output.filter(|path| path.is_dir()) {
            fs::remove_dir_all(folder).expect("a folder");
        }
        let result = place.shell(&line);
        assert_eq!(result.code, Some(0), "{line}: {result:?}");
    }
}

/// Lines of Rust below a folder, without tests, comments and blank lines.
fn lines_of_rust(folder: &std::path::Path) -> usize {
    let of_file = |path: &std::path::Path| {
        let text = fs::read_to_string(path).expect("a source");
        let code = text.split("#[cfg(test)]\nmod ").next().unwrap_or(&text);
        let is_code = |line: &&str| !line.trim().is_empty() && !line.trim().starts_with("//");
        code.lines().filter(is_code).count()
    };
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    entries
        .map(|path| match path.extension() {
            _ if path.is_dir() => lines_of_rust(&path),
            Some(end) if end == "rs" => of_file(&path),
            _ => 0,
        })
        .sum()
}

#[test]
fn the_page_says_how_many_lines_of_rust_there_are() {
    let page = page();
    let mut found = 0;
    for line in page.lines().filter(|line| line.starts_with("| `")) {
        let mut cells = line.split('|').skip(1).map(str::trim);
        let (Some(folder), Some(count)) = (cells.next(), cells.next()) else { continue };
        let Ok(said) = count.replace(',', "").parse::<f64>() else { continue };
        let here = lines_of_rust(&scene("..").join(folder.trim_matches('`'))) as f64;
        // Numbers are rounded, and code grows: a tenth.
        assert!((said - here).abs() <= here / 10.0, "{folder}: {said} on the page, {here} here");
        found += 1;
    }
    assert_eq!(found, 5);
}
