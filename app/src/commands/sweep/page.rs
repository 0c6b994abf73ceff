//! The page of a sweep: what every machine and adapter has done. Times of different adapters are never combined.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use raystep_lab::html::{self, escaped};

use super::drive::Failure;
use super::file::What;
use super::gather::{Row, Table};

/// Columns of a benchmark's rows that, with the job, make a group whose configurations are compared.
const GROUP: [&str; 4] = ["job", "rays_kind", "width_px", "height_px"];

fn field<'a>(row: &'a Row, column: &str) -> &'a str {
    row.get(column).map_or("", String::as_str)
}

fn is_shared(row: &Row) -> bool {
    field(row, "is_shared") == "true"
}

/// The page.
pub(super) fn html(what: What, table: &Table, [done, all]: [usize; 2], failures: &[&Failure]) -> String {
    let mut machines: BTreeMap<[&str; 2], Vec<&Row>> = BTreeMap::new();
    for row in &table.rows {
        machines.entry([field(row, "host"), field(row, "adapter")]).or_default().push(row);
    }
    let title = format!("raystep sweep: {}", what.name());
    // Writing to a string cannot fail.
    let mut page = format!(
        "<h1>{title} <small>{done} of {all} jobs</small></h1>\n<p>Every number is in <a href=\"results.csv\">results.csv</a>, \
         whose columns <a href=\"datapackage.json\">datapackage.json</a> describes; each job's own files are in \
         <code>jobs</code>. Times are compared only within a job, on one machine and adapter. Shared: something else ran \
         on the machine meanwhile; such rows are shown, but not ranked.</p>\n"
    );
    if !failures.is_empty() {
        page += "<h2>Failures</h2>\n<ul>";
        for Failure { name, message } in failures {
            let _ = write!(page, "<li class=\"fail\">{}: {}</li>", escaped(name), escaped(message));
        }
        page += "</ul>\n";
    }
    page += "<h2>Machines</h2>\n";
    let summary: Vec<Vec<String>> = machines
        .iter()
        .map(|([host, adapter], rows)| {
            let jobs = |rows: &[&Row]| rows.iter().map(|row| field(row, "job")).collect::<BTreeSet<_>>().len();
            let shared: Vec<&Row> = rows.iter().copied().filter(|row| is_shared(row)).collect();
            let cells = vec![escaped(host), escaped(adapter), jobs(rows).to_string(), jobs(&shared).to_string()];
            cells.into_iter().chain([result(what, rows)]).collect()
        })
        .collect();
    page += &table_of(&["host", "adapter", "jobs", "shared", "result"], &summary);
    for ([host, adapter], rows) in &machines {
        let _ = writeln!(page, "<h2>{}, {}</h2>", escaped(host), escaped(adapter));
        page += &details(what, rows);
    }
    html::page(&title, "h1 small{font-size:.85rem;font-weight:400;color:var(--dim)}", &page)
}

/// What a machine's rows say, in a phrase.
fn result(what: What, rows: &[&Row]) -> String {
    match what {
        What::Bench => {
            let fastest: Vec<String> = ranked(rows)
                .into_iter()
                .filter(|(_, rank)| *rank == Some(1))
                .map(|(row, _)| format!("{} {}", field(row, "accelerator"), field(row, "schedule")))
                .collect();
            let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
            fastest.iter().for_each(|name| *counts.entry(name).or_default() += 1);
            let mut counts: Vec<(&str, usize)> = counts.into_iter().collect();
            counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
            let phrase = |(name, count): (&str, usize)| format!("{} {count} of {}", escaped(name), fastest.len());
            match counts.is_empty() {
                true => "nothing to rank".into(),
                false => format!("fastest: {}", counts.into_iter().map(phrase).collect::<Vec<_>>().join(", ")),
            }
        }
        What::Stability => {
            let failed = rows.iter().filter(|row| field(row, "result") == "fail" && field(row, "expected") == "pass");
            format!("{} of {} rows fail that must pass", failed.count(), rows.len())
        }
        What::Report => format!("{} rows", rows.len()),
        What::Render => format!("{} images", rows.len()),
    }
}

/// The rows of a benchmark with their ranks in their groups; shared rows have none.
fn ranked<'a>(rows: &[&'a Row]) -> Vec<(&'a Row, Option<usize>)> {
    let mut groups: BTreeMap<[&str; 4], Vec<&'a Row>> = BTreeMap::new();
    for row in rows {
        groups.entry(GROUP.map(|column| field(row, column))).or_default().push(row);
    }
    let time = |row: &Row| field(row, "median_ns").parse::<f64>().unwrap_or(f64::INFINITY);
    let mut all = Vec::new();
    for mut group in groups.into_values() {
        group.sort_by(|a, b| time(a).total_cmp(&time(b)));
        let rank = |(i, row): (usize, &'a Row)| (row, (!is_shared(row) && time(row).is_finite()).then_some(i + 1));
        all.extend(group.into_iter().enumerate().map(rank));
    }
    all
}

/// The rows of one machine and adapter.
fn details(what: What, rows: &[&Row]) -> String {
    let options: BTreeSet<&str> = rows
        .iter()
        .flat_map(|row| row.keys())
        .filter(|column| column.starts_with("option_"))
        .map(String::as_str)
        .collect();
    let text = |row: &Row, columns: &[&str]| -> Vec<String> {
        columns.iter().map(|column| escaped(field(row, column))).collect()
    };
    let names: Vec<String> = options.iter().map(|name| name.replacen("option_", "--", 1).replace('_', "-")).collect();
    let options: Vec<&str> = options.into_iter().collect();
    let mut columns: Vec<&str> = vec!["scene"];
    columns.extend(names.iter().map(String::as_str));
    let lead = |row: &Row| [text(row, &["scene"]), text(row, &options)].concat();
    match what {
        What::Bench => {
            columns.extend(["rays", "size", "configuration", "median, ms", "interval, ms", "rank"]);
            let cells = |(row, rank): (&Row, Option<usize>)| {
                let ms = |column: &str| {
                    field(row, column).parse::<f64>().map_or("?".into(), |ns| format!("{:.4}", ns / 1e6))
                };
                let rank = match rank {
                    Some(1) => "<b>1</b>".into(),
                    Some(rank) => rank.to_string(),
                    None if is_shared(row) => "shared".into(),
                    None => String::new(),
                };
                // Rays from a file have no image.
                let size = match [field(row, "width_px"), field(row, "height_px")] {
                    ["", _] => String::new(),
                    [width, height] => escaped(&format!("{width}×{height}")),
                };
                let own = vec![
                    escaped(field(row, "rays_kind")),
                    size,
                    escaped(&format!(
                        "{} {} {}",
                        field(row, "accelerator"),
                        field(row, "schedule"),
                        field(row, "mapping")
                    )),
                    ms("median_ns"),
                    format!("{} – {}", ms("low_ns"), ms("high_ns")),
                    rank,
                ];
                [lead(row), own].concat()
            };
            table_of(&columns, &ranked(rows).into_iter().map(cells).collect::<Vec<_>>())
        }
        What::Stability => {
            let own = ["device", "accelerator", "numerics", "case", "wrong_rays", "expected", "result"];
            columns.splice(..1, own);
            // What is as expected is in the file.
            let rows = rows.iter().filter(|row| field(row, "result") == "fail" && field(row, "expected") == "pass");
            let cells: Vec<Vec<String>> = rows.map(|row| [text(row, &own), text(row, &options)].concat()).collect();
            if cells.is_empty() { "<p>Nothing unexpected.</p>\n".into() } else { table_of(&columns, &cells) }
        }
        What::Report => {
            columns.extend(["report", "shared"]);
            let jobs: BTreeMap<&str, &Row> = rows.iter().map(|row| (field(row, "job"), *row)).collect();
            let cells = jobs.into_iter().map(|(job, row)| {
                let own = [link(&format!("jobs/{job}/index.html"), job), escaped(field(row, "is_shared"))];
                [lead(row), own.to_vec()].concat()
            });
            table_of(&columns, &cells.collect::<Vec<_>>())
        }
        What::Render => {
            // An image of parts has no time of its own.
            let is_whole = rows.iter().any(|row| !field(row, "trace_s").is_empty());
            let (time, title) = if is_whole { ("trace_s", "trace, s") } else { ("job_s", "all parts, s") };
            columns.extend(["image", title, "hash"]);
            let cells = |row: &&Row| {
                let own = vec![
                    image(field(row, "image"), field(row, "job")),
                    field(row, time).parse::<f64>().map_or(String::new(), |s| format!("{s:.3}")),
                    escaped(field(row, "image_hash")),
                ];
                [lead(row), own].concat()
            };
            table_of(&columns, &rows.iter().map(cells).collect::<Vec<_>>())
        }
    }
}

/// A link to a file below the page.
fn link(path: &str, text: &str) -> String {
    // Names of jobs have no characters that an address would need to escape, but percent signs and letters beyond ASCII.
    format!("<a href=\"{}\">{}</a>", escaped(&path.replace('%', "%25")), escaped(text))
}

/// An image that is a link to itself; browsers show no EXR.
fn image(path: &str, name: &str) -> String {
    if !path.ends_with(".png") {
        return link(path, name);
    }
    let (path, name) = (escaped(&path.replace('%', "%25")), escaped(name));
    format!(
        "<a href=\"{path}\"><img src=\"{path}\" alt=\"{name}\" title=\"{name}\" width=\"192\" loading=\"lazy\"></a>"
    )
}

/// A table of cells that are HTML.
fn table_of(names: &[&str], rows: &[Vec<String>]) -> String {
    let mut html = "<div class=\"wide\"><table><tr>".to_owned();
    names.iter().for_each(|name| html += &format!("<th class=\"l\">{}</th>", escaped(name)));
    html += "</tr>\n";
    for row in rows {
        html += "<tr>";
        row.iter().for_each(|cell| html += &format!("<td class=\"l\">{cell}</td>"));
        html += "</tr>\n";
    }
    html + "</table></div>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_ranked_within_their_job_and_shared_ones_are_not() {
        let row = |job: &str, accelerator: &str, ns: &str, shared: &str| -> Row {
            let fields = [("job", job), ("accelerator", accelerator), ("median_ns", ns), ("is_shared", shared)];
            fields.into_iter().map(|(column, field)| (column.to_owned(), field.to_owned())).collect()
        };
        let rows = [
            row("a", "grid", "200", "false"),
            row("a", "bvh", "9", "false"),
            row("b", "grid", "1", "true"),
            row("b", "bvh", "3", "true"),
            row("c", "grid", "50", "false"),
            row("c", "bvh", "", "false"),
        ];
        let rows: Vec<&Row> = rows.iter().collect();
        let ranks: Vec<_> =
            ranked(&rows).into_iter().map(|(row, rank)| (field(row, "job"), field(row, "accelerator"), rank)).collect();
        let expected = [
            ("a", "bvh", Some(1)),
            ("a", "grid", Some(2)),
            ("b", "grid", None),
            ("b", "bvh", None),
            ("c", "grid", Some(1)),
            ("c", "bvh", None),
        ];
        assert_eq!(ranks, expected);
        assert_eq!(result(What::Bench, &rows), "fastest: bvh  1 of 2, grid  1 of 2");
    }
}
