//! `raystep report`, from the built binary: its CSV files are read by a strict reader and its page is compared with
//! them; exit codes.

use std::collections::{BTreeMap, BTreeSet};

use crate::common::{Outcome, Place, scene};

type Row = BTreeMap<String, String>;

/// Each file with its columns, as documented in docs/measurements.md.
const FILES: [(&str, &str); 7] = [
    (
        "resolved.csv",
        "schema_version,scene,adapter,accelerator,schedule,numerics,rays,judged_rays,pass_index,kernel,time_ns,\
         resolved_rays,judged_resolved_rays,judged_wrong_rays,judged_undecided_rays,is_last,run_ns,run_ratio,clock",
    ),
    (
        "factors.csv",
        "schema_version,scene,adapter,aim,accelerator,factor,cells_x,cells_y,cells_z,rays,judged_rays,missed,false_hits,\
         wrong_hits,undecided,wrong_rays,wrong_per_million,wrong_per_million_low,wrong_per_million_high,at_bound,passes,\
         repeats,median_ns,low_ns,high_ns,time_ratio,clock",
    ),
    ("moved.csv", MOVED),
    ("scaled.csv", MOVED),
    (
        "grid.csv",
        "schema_version,scene,adapter,accelerator,resolution_factor,is_automatic,cells_x,cells_y,cells_z,cells,leaps,\
         references,structure_bytes,build_s,rays,repeats,median_ns,low_ns,high_ns,ns_per_ray,trace_ratio,view_s,view_with_build_s,\
         paid_off_rays,passes,judged_rays,missed,false_hits,wrong_hits,undecided,wrong_rays,wrong_per_million,\
         wrong_per_million_low,wrong_per_million_high,at_bound,clock",
    ),
    (
        "samples.csv",
        "schema_version,scene,adapter,sampler,samples,width_px,height_px,time_ns,rmse,is_plotted,slope,edge_pixels,\
         edges_rmse,edges_is_plotted,edges_slope,reference_samples,reference_rmse,edges_reference_rmse,clock",
    ),
    (
        "left_out.csv",
        "schema_version,scene,adapter,accelerator,schedule,rays,left_out,put_back,stream_bytes,kept_stream_bytes,\
         buffer_bytes,kept_buffer_bytes,bytes_ratio,started_first,first_start_s,kept_first_start_s,start_s,\
         kept_start_s,start_ratio,repeats,median_ns,kept_median_ns,time_ratio,time_ratio_low,time_ratio_high,differing_hits,first_differing_rays,clock",
    ),
];

const MOVED: &str = "schema_version,scene,adapter,offset_extents,scale,numerics,rays,judged_rays,missed,false_hits,\
    wrong_hits,undecided,wrong_rays,wrong_per_million,wrong_per_million_low,wrong_per_million_high,at_bound,\
    lost_per_million,lost_per_million_low,lost_per_million_high,measured_rays,t_error_extents_largest,\
    t_error_extents_median,t_bound_extents_largest,t_bound_extents_median,t_largest_by_bound,\
    t_error_by_own_bound_largest,t_bound_extents_of_largest_error,t_step_extents_largest,t_largest_by_step,rounding_rays,rounding_error_extents_largest,\
    rounding_error_extents_median,rounding_bound_extents_largest,rounding_bound_extents_median,\
    rounding_largest_by_bound,rounding_error_by_own_bound_largest,rounding_beyond_bound_rays";

fn cornell_box() -> String {
    scene("cornell-box.gltf").display().to_string()
}

/// The rows of a file, which must have these columns and end its lines as RFC 4180 requires.
fn rows(place: &Place, folder: &str, name: &str, columns: &str) -> Vec<Row> {
    let file = place.read(&format!("{folder}/{name}"));
    let lines = file.iter().filter(|&&b| b == b'\n').count();
    assert_eq!(file.windows(2).filter(|w| w == b"\r\n").count(), lines, "{name}");
    let mut reader = csv::ReaderBuilder::new().flexible(false).from_reader(file.as_slice());
    let names: Vec<String> = reader.headers().expect("a header").iter().map(str::to_owned).collect();
    assert_eq!(names.join(","), columns, "{name}");
    let row = |record: csv::StringRecord| names.iter().cloned().zip(record.iter().map(str::to_owned)).collect();
    reader.records().map(|r| row(r.unwrap_or_else(|e| panic!("{name}: {e}")))).collect()
}

fn all_rows(place: &Place, folder: &str) -> BTreeMap<&'static str, Vec<Row>> {
    FILES.iter().map(|(name, columns)| (*name, rows(place, folder, name, columns))).collect()
}

fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} is no number: {row:?}"))
}

/// Whether a column depends on the machine's speed.
fn is_of_time(column: &str) -> bool {
    column.ends_with("_ns")
        || column.ends_with("_s")
        || matches!(
            column,
            "run_ratio" | "time_ratio" | "trace_ratio" | "start_ratio" | "paid_off_rays" | "ns_per_ray" | "repeats"
        )
        || column.starts_with("time_ratio_")
}

/// The texts between two pieces of markup, at every occurrence.
fn between<'a>(page: &'a str, begin: &str, end: &str) -> Vec<&'a str> {
    page.split(begin).skip(1).filter_map(|rest| rest.split(end).next()).collect()
}

/// A section's tables must be rows of its CSV, in order, and the numbers in its prose and legends must be fields of it.
/// Returns the number of rows shown.
fn check_section(section: &str, file: &str, rows: &[&Row]) -> usize {
    let mut shown = 0;
    for table in between(section, "<table>", "</table>") {
        let mut rows = rows.iter();
        let mut lines = between(table, "<tr>", "</tr>").into_iter();
        let cells = |line: &str, tag: &str| -> Vec<String> {
            let end = format!("</{tag}>");
            line.split(&end).filter_map(|cell| cell.rsplit('>').next()).map(str::to_owned).collect()
        };
        let header: Vec<String> =
            cells(lines.next().expect("a header"), "th").iter().map(|c| c.replace(' ', "_")).collect();
        let columns: Vec<&str> = header.iter().filter(|c| !c.is_empty()).map(String::as_str).collect();
        for line in lines {
            let fields = cells(line, "td");
            // Skips rows that the table does not show.
            let is_this = |row: &&&Row| columns.iter().zip(&fields).all(|(column, field)| row[*column] == *field);
            assert!(fields.len() >= columns.len() && rows.any(|row| is_this(&row)), "{file} has no {fields:?}");
            shown += 1;
        }
    }
    let fields: BTreeSet<&str> = rows.iter().flat_map(|row| row.values().map(String::as_str)).collect();
    let legends = between(section, ": slope ", "<").into_iter().map(str::trim);
    for text in between(section, "<b class=\"n\">", "</b>").into_iter().chain(legends) {
        assert!(fields.contains(text), "{text:?} is not in {file}");
    }
    shown
}

/// The page needs no other files, and its numbers are in the CSV files.
fn check_page(place: &Place, folder: &str, tables: &BTreeMap<&'static str, Vec<Row>>) {
    let page = String::from_utf8(place.read(&format!("{folder}/index.html"))).expect("UTF-8");
    for foreign in ["http:", "https:", "<script", "<link", "src=", "@import", "url("] {
        assert!(!page.contains(foreign), "{foreign} in the page");
    }
    assert!(page.contains("prefers-color-scheme:dark") && page.contains("raystep report"));
    let about = rows(place, folder, "about.csv", "schema_version,scene,name,value");
    let mut rows_shown = 0;
    for (i, of_scene) in page.split("<h2 class=\"s\"").skip(1).enumerate() {
        let name = between(of_scene, &format!("id=\"scene-{i}\">"), "</h2>")[0];
        let mut sections = of_scene.split("<h3 id=");
        let head = sections.next().expect("a description of the scene");
        let known: Vec<&str> = about.iter().filter(|r| r["scene"] == name).map(|r| r["value"].as_str()).collect();
        assert_eq!(between(head, "<b class=\"n\">", "</b>"), known, "{name}: triangles, width, height");
        for section in sections {
            let file = between(section, "All of it is in <code>", "</code>")[0];
            let of_file: Vec<&Row> = tables[file].iter().filter(|r| r["scene"] == name).collect();
            rows_shown += check_section(section, file, &of_file);
        }
    }
    assert!(rows_shown > 20 || tables["factors.csv"].is_empty(), "{rows_shown} rows");
    let plots = page.matches("<svg").count();
    let files = std::fs::read_dir(place.path(folder)).expect("the folder");
    let svgs = files.filter(|f| f.as_ref().is_ok_and(|f| f.path().extension().is_some_and(|e| e == "svg"))).count();
    assert_eq!(plots, svgs, "plots in the page and in files differ");
}

/// A quick report on the CPU.
fn quick(place: &Place, more: &[&str]) -> Outcome {
    place.ok(&[&["report", &cornell_box(), "--quick", "--device", "cpu", "-o", "out"], more].concat())
}

#[test]
#[ignore = "long: sh tests/full.sh"]
fn a_second_report_finds_the_same_errors_again() {
    let place = Place::new();
    quick(&place, &["--quiet"]);
    let tables = all_rows(&place, "out");
    let again = quick(&place, &["--force", "--quiet"]);
    assert_eq!((again.stdout.as_str(), again.stderr.as_str()), ("", ""));
    for (name, rows) in all_rows(&place, "out") {
        assert_eq!(rows.len(), tables[name].len(), "{name}");
        for (now, then) in rows.iter().zip(&tables[name]) {
            for (column, value) in now.iter().filter(|(column, _)| !is_of_time(column)) {
                assert_eq!(value, &then[column], "{name}, {column}: {now:?}");
            }
        }
    }
    assert_eq!(place.names(), ["out"]);
}

#[test]
fn a_quick_report_is_complete() {
    let place = Place::new();
    let outcome = quick(&place, &[]);
    assert_eq!(outcome.stdout, "");
    let tables = all_rows(&place, "out");
    for (name, rows) in &tables {
        assert!(!rows.is_empty(), "{name} is empty");
        assert!(
            rows.iter().all(|r| r["schema_version"] == "2" && r["scene"] == "cornell-box" && r["adapter"] == "cpu")
        );
    }
    check_page(&place, "out", &tables);

    let resolved = &tables["resolved.csv"];
    let ways: BTreeSet<_> =
        resolved.iter().map(|r| [r["accelerator"].as_str(), &r["schedule"], &r["numerics"]]).collect();
    assert_eq!(ways.len(), 14, "{ways:?}");
    for way in ways {
        let of: Vec<&Row> =
            resolved.iter().filter(|r| way == [r["accelerator"].as_str(), &r["schedule"], &r["numerics"]]).collect();
        let grows = |column: &str| of.windows(2).all(|w| number(w[0], column) <= number(w[1], column));
        assert!(grows("time_ns") && grows("resolved_rays") && grows("judged_wrong_rays"), "{way:?}");
        let last = of.last().expect("a row");
        assert_eq!((last["is_last"].as_str(), &last["resolved_rays"]), ("true", &last["rays"]), "{way:?}");
        assert!(way[2] != "robust" || last["judged_wrong_rays"] == "0", "{last:?}");
    }

    for row in &tables["factors.csv"] {
        let [low, wrong, high] =
            ["wrong_per_million_low", "wrong_per_million", "wrong_per_million_high"].map(|c| number(row, c));
        assert!(low <= wrong && wrong <= high && high > 0.0, "{row:?}");
        let is_cracked = matches!(row["factor"].as_str(), "without triangle-test" | "paper") && row["aim"] == "edges";
        assert!(!is_cracked || wrong > 0.0, "Möller and Trumbore's test must lose rays at edges: {row:?}");
        assert!(row["factor"] != "robust" || wrong == 0.0, "{row:?}");
    }
    for name in ["moved.csv", "scaled.csv"] {
        for row in tables[name].iter().filter(|r| r["numerics"] == "robust") {
            assert_eq!((row["wrong_rays"].as_str(), row["rounding_beyond_bound_rays"].as_str()), ("0", "0"), "{row:?}");
            assert!(number(row, "t_error_by_own_bound_largest") <= 1.0, "{row:?}");
        }
    }
    assert_eq!((tables["moved.csv"].len(), tables["scaled.csv"].len()), (14, 18));
    assert!(tables["grid.csv"].iter().all(|r| r["wrong_rays"] == "0"));
    assert_eq!(tables["grid.csv"].iter().filter(|r| r["is_automatic"] == "true").count(), 1);
    assert!(tables["left_out.csv"].iter().all(|r| r["differing_hits"] == "0" && r["start_s"].is_empty()));
    for sampler in ["sobol", "random"] {
        let errors: Vec<f64> =
            tables["samples.csv"].iter().filter(|r| r["sampler"] == sampler).map(|r| number(r, "rmse")).collect();
        assert_eq!(tables["samples.csv"][0]["samples"], "2", "measurements start at two samples");
        assert!(errors.len() > 4 && errors.first() > errors.last(), "{sampler}: {errors:?}");
    }

    assert_eq!(place.names(), ["out"]);
}

#[test]
#[ignore = "long: sh tests/full.sh"]
fn the_default_device_reports_too() {
    let place = Place::new();
    place.ok(&["report", &cornell_box(), "--quick", "-o", "default", "--quiet"]);
    check_page(&place, "default", &all_rows(&place, "default"));
}

#[test]
fn an_adapter_reports_too() {
    let place = Place::new();
    let file = cornell_box();
    place.ok(&[
        "report",
        &file,
        "--quick",
        "--device",
        "gpu",
        "--section",
        "resolved,left-out",
        "-o",
        "gpu",
        "--quiet",
    ]);
    let left_out = rows(&place, "gpu", "left_out.csv", FILES[6].1);
    println!("{}", left_out[0]["adapter"]);
    for row in &left_out {
        assert!(
            number(row, "start_s") > 0.0 && number(row, "first_start_s") > 0.0 && number(row, "time_ratio") > 0.0,
            "{row:?}"
        );
        assert_eq!(row["differing_hits"], "0", "{row:?}");
    }
    let resolved = rows(&place, "gpu", "resolved.csv", FILES[0].1);
    let wrong = |r: &&Row| r["numerics"] == "robust" && r["judged_wrong_rays"] != "0";
    assert_eq!(resolved.iter().find(wrong), None);
    assert!(resolved.iter().all(|r| r["clock"] == "gpu_timestamp" || r["clock"] == "host"));
}

#[test]
fn scenes_with_nothing_or_one_triangle_in_them_have_a_page() {
    let place = Place::new();
    let files = ["empty.gltf", "single-triangle.gltf"].map(|name| scene(name).display().to_string());
    let outcome = place.ok(&["report", &files[0], &files[1], "--quick", "--device", "cpu", "-o", "out"]);
    assert!(outcome.stderr.contains("note: empty, factors: the scene has no triangle to aim at"), "{outcome:?}");
    let tables = all_rows(&place, "out");
    check_page(&place, "out", &tables);
    assert!(tables["factors.csv"].iter().all(|r| r["scene"] == "single-triangle"));
    assert!(tables["grid.csv"].iter().any(|r| r["scene"] == "empty" && r["wrong_rays"] == "0"));
}

#[test]
fn a_section_that_fails_is_a_note_and_all_that_fail_are_an_error() {
    let place = Place::new();
    let file = cornell_box();
    let report = ["report", &file, "--quick", "--device", "cpu", "--grid", "4096", "-o", "out", "--section"];
    let outcome = place.ok(&[&report[..], &["factors,scaled"]].concat());
    let wanted = "a grid of 4096 x 4096 x 4096 cells cannot be built";
    assert!(outcome.stderr.contains(&format!("note: cornell-box, factors: --grid: {wanted}")), "{outcome:?}");
    assert!(String::from_utf8_lossy(&place.read("out/index.html")).contains(wanted));
    assert_eq!(rows(&place, "out", "factors.csv", FILES[1].1), Vec::<Row>::new());
    assert_eq!(rows(&place, "out", "scaled.csv", MOVED).len(), 18);
    place.fails(2, wanted, &["report", &file, "--device", "cpu", "--grid", "4096", "-o", "no", "--section", "factors"]);
}

#[test]
fn times_of_other_rays_are_not_compared() {
    let place = Place::new();
    let file = scene("teapot.glb").display().to_string();
    let report = ["report", &file, "--quick", "--device", "cpu", "--section", "grid"];
    let none = |folder: &str| {
        let rows = rows(&place, folder, "grid.csv", FILES[4].1);
        assert!(rows.iter().all(|r| r["at_bound"] == "0" && r["wrong_rays"] == "0" && !r["median_ns"].is_empty()));
        (rows.iter().find(|r| r["accelerator"] == "none").expect("a row").clone(), rows)
    };
    // Testing 994 triangles for each of 4,096 rays is affordable.
    place.ok(&[&report[..], &["-o", "small"]].concat());
    let (row, rows) = none("small");
    assert_eq!(row["rays"], "4096");
    assert!(number(&row, "trace_ratio") > 1.0 && number(&row, "view_s") > 0.0, "{row:?}");
    assert!(rows.iter().any(|r| !r["paid_off_rays"].is_empty()));
    // For 20,000 rays it is not.
    let outcome = place.ok(&[&report[..], &["--size", "200x100", "-o", "large"]].concat());
    assert!(outcome.stderr.contains("the number of rays after which a structure pays off is unknown"), "{outcome:?}");
    let (row, rows) = none("large");
    for column in ["trace_ratio", "view_s", "view_with_build_s"] {
        assert_eq!(row[column], "", "{column}");
    }
    assert!(rows.iter().all(|r| r["paid_off_rays"].is_empty()));
}

#[test]
fn a_section_alone_replaces_what_an_earlier_report_wrote() {
    let place = Place::new();
    let file = cornell_box();
    let report = ["report", &file, "--quick", "--device", "cpu", "-o", "out", "--section"];
    place.ok(&[&report[..], &["moved,grid"]].concat());
    std::fs::write(place.path("out/mine.txt"), "mine").expect("a file");
    place.fails(1, "out is not empty", &[&report[..], &["grid"]].concat());
    place.ok(&[&report[..], &["grid", "--force"]].concat());
    let names = std::fs::read_dir(place.path("out")).expect("the folder").map(|e| e.expect("an entry").file_name());
    let names: BTreeSet<_> = names.map(|n| n.to_string_lossy().into_owned()).collect();
    let expected = ["about.csv", "grid.csv", "index.html", "mine.txt", "plot-001.svg", "plot-002.svg", "plot-003.svg"];
    assert_eq!(names.into_iter().collect::<Vec<_>>(), expected);
    std::fs::write(place.path("out/index.html"), "<p>mine</p>").expect("a file");
    place.fails(1, "not from a report", &[&report[..], &["grid", "--force"]].concat());
    assert_eq!(place.read("out/index.html"), b"<p>mine</p>");
}

#[test]
fn wrong_usage_and_unreadable_scenes_are_one_line() {
    let place = Place::new();
    let file = cornell_box();
    let cases: &[(i32, &str, &[&str])] = &[
        (2, "--output", &["report", &file]),
        (2, "<SCENE>", &["report", "-o", "out"]),
        (2, "--section speed: expected resolved, factors", &["report", &file, "-o", "out", "--section", "speed"]),
        (2, "640x480", &["report", &file, "-o", "out", "--size", "8"]),
        (2, "has one camera, number 0", &["report", &file, "-o", "out", "--camera", "1"]),
        (1, "nothing.glb: No such file", &["report", &file, "nothing.glb", "-o", "out"]),
        (1, "there is no folder nowhere", &["report", &file, "-o", "nowhere/out"]),
    ];
    for (code, wanted, arguments) in cases {
        place.fails(*code, wanted, arguments);
    }
}
