//! The history of a ray in all formats, against the streams that `dump` writes.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::common::Place;
use crate::dump::npy;
use crate::files::cornell_box;

const SIZE: [usize; 2] = [24, 18];
const PIXEL: [usize; 2] = [7, 11];

/// The rows of a CSV file, by the names of the columns.
pub(crate) fn csv_rows(file: &[u8]) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::ReaderBuilder::new().flexible(false).from_reader(file);
    let names = reader.headers().expect("a header").clone();
    let row =
        |record: csv::StringRecord| names.iter().map(str::to_owned).zip(record.iter().map(str::to_owned)).collect();
    reader.records().map(|record| row(record.expect("as many fields as names"))).collect()
}

/// A stream's values of the pixel after a pass.
fn texel(place: &Place, pass: usize, stream: &str) -> Vec<u32> {
    let (_, shape, words) = npy(&place.read(&format!("dump/pass-{pass:06}.{stream}.npy")));
    let [x, y] = PIXEL;
    (0..shape[0]).map(|layer| words[(layer * SIZE[1] + y) * SIZE[0] + x]).collect()
}

#[test]
fn every_value_of_a_row_is_the_streams_after_its_pass() {
    let place = Place::new();
    let (scene, size, pixel) =
        (cornell_box(), format!("{}x{}", SIZE[0], SIZE[1]), format!("{},{}", PIXEL[0], PIXEL[1]));
    let common = [&*scene, "--size", &size, "--grid", "5,6,7", "--schedule", "second", "--device", "cpu", "--quiet"];
    let trace = |format| {
        place.ok(&[&["trace"], &common[..], &["--pixel", &pixel, "--all-rays", "--format", format]].concat()).stdout
    };
    place.ok(&[&["dump"], &common[..], &["--pass", "all", "--stream", "state,tmax,hit", "-o", "dump"]].concat());
    let (rows, table) = (csv_rows(trace("csv").as_bytes()), trace("table"));
    let json: Value = serde_json::from_str(&trace("json")).expect("JSON");
    let mut steps = 0;
    let json_of_run = &json;
    for ((row, json), line) in rows.iter().zip(json["rows"].as_array().expect("rows")).zip(rows_of(&table).skip(1)) {
        let pass: usize = row["pass"].parse().expect("a number");
        let (state, tmax, hit) =
            (texel(&place, pass, "state"), texel(&place, pass, "tmax"), texel(&place, pass, "hit"));
        let is_walking = ["TRAV", "ISECT_NO_HIT", "ISECT_HIT"].contains(&&*row["state_after"]);
        let cell = [state[2] % 5, state[2] / 5 % 6, state[2] / 30];
        let [x, y, z] = ["cell_after_x", "cell_after_y", "cell_after_z"].map(|name| row[name].parse::<u32>().ok());
        assert_eq!([x, y, z], if is_walking { cell.map(Some) } else { [None; 3] }, "{row:?}");
        assert_eq!(row["index_after"].parse().ok(), is_walking.then_some(state[2]), "{row:?}");
        let shown = if is_walking { format!(" {},{},{} ", cell[0], cell[1], cell[2]) } else { " - ".into() };
        assert!(line.contains(&shown), "{line}");
        if let Some(to) = row["why"].split(" to cell (").nth(1).and_then(|rest| rest.split(')').next()) {
            assert_eq!(to, format!("{}, {}, {}", cell[0], cell[1], cell[2]), "the cell that a step leads to");
            steps += 1;
        }
        for (name, bits) in ["tmax_after_x_traced", "tmax_after_y_traced", "tmax_after_z_traced"].iter().zip(&tmax) {
            let written = row[*name].parse::<f32>();
            // A plane that is never reached is empty; the stream has a large finite number there.
            assert!(written.map_or(f32::from_bits(*bits) > 1e30, |t| t.to_bits() == *bits), "{name} of {row:?}");
        }
        assert_eq!(row["item_after"], state[3].to_string());
        assert_eq!(
            row["t_after_traced"].parse::<f32>().ok().map(f32::to_bits),
            (hit[2] != u32::MAX).then_some(state[1])
        );
        let in_scene = |t: f32| f64::from(t) * json_of_run["t_scale"].as_f64().expect("a number");
        assert_eq!(row["t_after_scene"].parse().ok(), row["t_after_traced"].parse().ok().map(in_scene));
        assert_eq!(row["triangle_after"].parse::<u32>().ok(), Some(hit[2]).filter(|&id| id != u32::MAX));
        // JSON has the same, and the cell that a pass works in.
        let after = &json["after"];
        let number = |value: &Value| value.as_u64().map(|n| n as u32);
        assert_eq!([0, 1, 2].map(|axis| number(&json["cell_after"][axis])), [x, y, z]);
        assert_eq!((&after["state"], number(&after["item"])), (&row["state_after"].as_str().into(), Some(state[3])));
        assert_eq!(
            (&json["state_before"], number(&json["tested"])),
            (&row["state_before"].as_str().into(), row["tested_triangle"].parse().ok())
        );
    }
    assert!(steps > 3, "{steps} steps");
    assert_eq!(
        (rows[1]["kernel"].as_str(), rows[1]["cell_after_x"].is_empty()),
        ("setup", false),
        "setup finds a cell"
    );
    // What a pass leaves is what the next one finds.
    for pair in rows.windows(2) {
        assert_eq!(pair[0]["state_after"], pair[1]["state_before"]);
    }
    let rows = json["rows"].as_array().expect("rows");
    for pair in rows.windows(2).filter(|pair| !pair[1]["cell_before"].is_null()) {
        assert_eq!(pair[0]["cell_after"], pair[1]["cell_before"]);
    }
}

/// The lines of a table from the names of its columns on, below the ray.
fn rows_of(table: &str) -> impl Iterator<Item = &str> {
    table.lines().skip_while(|line| !line.starts_with("pass "))
}

#[test]
fn with_a_tree_the_place_is_a_node() {
    let place = Place::new();
    let scene = cornell_box();
    let trace = |accelerator, format| {
        let common = ["trace", &*scene, "--pixel", "7,11", "--size", "24x18", "--device", "cpu", "--quiet"];
        place.ok(&[&common[..], &["--accelerator", accelerator, "--format", format]].concat()).stdout
    };
    for (accelerator, head) in [("bvh", "node"), ("irregular", "cell"), ("none", "cell")] {
        let (rows, table) = (csv_rows(trace(accelerator, "csv").as_bytes()), trace(accelerator, "table"));
        assert!(rows_of(&table).next().is_some_and(|line| line.contains(&format!("  {head}  "))), "{table}");
        assert!(table.contains(&format!("\n{head}, tmax, item, t and hit are those after the pass\n")), "{table}");
        let has_index = |row: &BTreeMap<String, String>| !row["index_after"].is_empty();
        assert_eq!(rows.iter().any(has_index), accelerator != "none", "{accelerator}");
        assert!(rows.iter().all(|row| row["cell_after_x"].is_empty()), "only a uniform grid has coordinates");
        assert!(!has_index(&rows[0]) && rows.last().is_some_and(|row| !has_index(row)), "outside of the walk");
    }
}

#[test]
fn a_history_with_rays_to_lights_ends_with_the_light_tree() {
    let place = Place::new();
    let scene = cornell_box();
    let trace = |integrator, format| {
        let common = ["trace", &*scene, "--pixel", "8,14", "--size", "24x18", "--device", "cpu", "--quiet"];
        place.ok(&[&common[..], &["--integrator", integrator, "--format", format]].concat()).stdout
    };
    let (table, json) = (trace("shadows", "table"), trace("shadows", "json"));
    let json: Value = serde_json::from_str(&json).expect("JSON");
    let vertices = json["light_tree"]["vertices"].as_array().expect("vertices");
    let color = &json["rows"].as_array().and_then(|rows| rows.last()).expect("rows")["after"]["color"];
    for channel in 0..3 {
        let sum: f64 = vertices.iter().map(|vertex| vertex["contribution"][channel].as_f64().expect("a number")).sum();
        let color = color[channel].as_f64().expect("a number");
        // JSON has the digits of an f32.
        assert!((sum - color).abs() < 1e-6, "channel {channel}: {sum} for {color}");
    }
    let tree = table.split("\nlight tree\n").nth(1).expect("a tree below the rows");
    for vertex in vertices {
        let why = vertex["why"].as_str().expect("words");
        assert!(tree.lines().any(|line| line.ends_with(why)), "{why}: {tree}");
    }
    assert!(vertices.iter().any(|vertex| vertex["kind"] == "light"), "{tree}");
    let rows = |table: &str| rows_of(table).take_while(|line| !line.is_empty()).count();
    assert_eq!(rows(&table), 1 + json["rows"].as_array().map_or(0, Vec::len), "the rows are as without the tree");
    for format in ["table", "json"] {
        assert!(!trace("local", format).contains("light tree") && !trace("local", format).contains("light_tree"));
    }
}

#[test]
fn a_photon_has_a_history_and_a_pixel_tells_which_photons_it_gathers() {
    let place = Place::new();
    let scene = cornell_box();
    let common = [&*scene, "--size", "16x16", "--device", "cpu", "--quiet", "--integrator"];
    let photons = ["photons", "--photons", "2000", "--gather-radius", "60", "--nearest", "20"];
    let of = |more: &[&'static str]| [&["trace"], &common[..], &photons[..], more].concat();
    let trace = |more: &[&'static str]| place.ok(&of(more)).stdout;

    let rows = csv_rows(trace(&["--photon", "7", "--format", "csv"]).as_bytes());
    assert_eq!((&*rows[0]["kernel"], &*rows[0]["state_before"]), ("emit_photons", "PHOTON_UNBORN"));
    let last = rows.last().expect("rows");
    assert_eq!((&*last["kernel"], &*last["state_after"]), ("scatter_photons", "PHOTON_DONE"));
    assert!(rows.windows(2).all(|pair| pair[0]["state_after"] == pair[1]["state_before"]), "{rows:?}");
    let json: Value = serde_json::from_str(&trace(&["--photon", "7", "--format", "json"])).expect("JSON");
    assert_eq!((json["element"]["set"].as_str(), json["element"]["index"].as_u64()), (Some("photons"), Some(7)));
    let first = &json["rows"][0]["after"]["photon"];
    assert!(first["hits"] == 0 && first["power"][0].as_f64().is_some_and(|power| power > 0.0), "{first}");
    let table = trace(&["--photon", "7"]);
    assert!(table.starts_with("element photon 7\n") && table.contains("This photon waited in "), "{table}");

    let table = trace(&["--pixel", "8,14"]);
    for text in ["looks for photons near the hit", " of the map: looked at sorted photons to ", "adds r "] {
        assert!(table.contains(text), "{text}: {table}");
    }
    let json: Value = serde_json::from_str(&trace(&["--pixel", "8,14", "--format", "json"])).expect("JSON");
    let found =
        json["rows"].as_array().expect("rows").iter().filter_map(|row| row["after"]["gather"]["found"].as_u64());
    let found = found.max().expect("a search");
    assert!(found > 0 && table.contains(&format!(" by {found} photon")), "{table}");

    for (wanted, arguments) in [
        ("--photon: this run has ", of(&["--photon", "5000"])),
        (
            "--photon names a photon of --integrator photons: add it",
            [&["trace"], &common[..], &["path", "--photon", "1"]].concat(),
        ),
        ("--print-link: a link has a ray, but no photon", of(&["--photon", "1", "--print-link"])),
    ] {
        place.fails(2, wanted, &arguments);
    }
}
