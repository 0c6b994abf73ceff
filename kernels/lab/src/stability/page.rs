//! `stability.html`: one page that needs no other files. Its numbers are the fields of `stability.csv`.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use raystep_kernels::Numerics;

use super::picture::{LEGEND, Picture};
use super::{Outcome, Report, Row, drift, probe, table};
use crate::Error;
use crate::html::{self, escaped};
use crate::plots::{self, Axis, Dash, Draw as _, Mark, Plot, Scale, Series, Stroke};
use crate::stiff;

/// Columns of a case's table, with headings.
const SHOWN: [(&str, &str); 21] = [
    ("numerics", "numerics"),
    ("accelerator", "accelerator"),
    ("schedule", "schedule"),
    ("triangle_test", "triangle test"),
    ("device", "device"),
    ("missed", "missed"),
    ("false_hits", "false"),
    ("wrong_hits", "wrong"),
    ("undecided", "undecided"),
    ("edge_on", "edge-on"),
    ("non_finite", "not finite"),
    ("at_bound", "at bound"),
    ("passes", "passes"),
    ("t_relative", "t, relative"),
    ("t_ulp", "t, ulp"),
    ("u_relative", "u, relative"),
    ("u_ulp", "u, ulp"),
    ("v_relative", "v, relative"),
    ("v_ulp", "v, ulp"),
    ("expected", "expected"),
    ("result", "result"),
];

/// Styles that only this page needs.
const STYLE: &str = "\
figure{display:inline-block;margin:.4rem 1rem .4rem 0;vertical-align:top}figcaption{max-width:16rem}img{image-rendering:\
pixelated;border:1px solid var(--rule);width:16rem}.key{display:inline-block;width:.8em;height:.8em;margin:0 .3em 0 1em;\
vertical-align:middle}.curves figcaption{max-width:27.5rem}figure.plot figcaption{max-width:50rem}details{margin:.5rem 0}\
summary{cursor:pointer}h3{font-size:1rem;margin:1.2rem 0 .2rem}td.w{white-space:normal;min-width:16rem}";

/// The page: a line a case, then what stiff scenes cost, pictures of errors, and everything else folded.
pub(super) fn html(report: &Report) -> Result<String, Error> {
    let outcomes = &report.outcomes;
    let rows = || outcomes.iter().flat_map(|o| &o.rows);
    let (runs, odd) = (rows().count(), rows().filter(|row| !row.is_as_expected()).count());
    let robust = rows().filter(|row| row.variant.numerics == Numerics::Robust);
    let (robust_runs, wrong) = robust.fold((0, 0), |(runs, wrong), row| (runs + 1, wrong + row.wrong_rays()));
    let adapter = rows().find(|row| row.device == "gpu").map(|row| row.field("adapter"));
    let mut page = String::from("<h1>Stability in extreme cases</h1>\n");
    // Writing to a string cannot fail.
    let _ = writeln!(
        page,
        "<p><b>{} of {runs} runs are as expected</b>, in {} cases. With robust rules, {wrong} rays are wrong in \
         {robust_runs} runs. GPU: {}. Every ray is compared with f64 brute force with exact predicates at edges. All \
         numbers are in <code>stability.csv</code>, beside this page; <code>datapackage.json</code> describes its \
         columns.</p>",
        runs - odd,
        outcomes.len(),
        escaped(adapter.unwrap_or("none")),
    );
    summary(&mut page, outcomes);
    if let Some(cost) = &report.cost {
        page += "<h2 id=\"cost\">What stiff scenes cost</h2>\n";
        page += &stiff::html(cost);
    }
    pictures(&mut page, outcomes)?;
    page += "<h2 id=\"cases\">Every run</h2>\n<p class=\"note\">Errors of t, u and v are the largest among hits of the \
             exact triangle: relative to the exact value, and in units in the last place of what the arithmetic rounds. \
             </p>\n";
    outcomes.iter().for_each(|outcome| section(&mut page, outcome));
    walks(&mut page, &report.walks);
    pipelines(&mut page, &report.pipelines);
    Ok(html::page("raystep: stability", &(STYLE.to_owned() + stiff::STYLE + &plots::style()), &page))
}

/// One line per case: errors, undecided rays and the paper's errors, linked to its runs.
fn summary(page: &mut String, outcomes: &[Outcome]) {
    *page += "<div class=\"wide\"><table><tr>";
    for (i, heading) in table::SUMMARY.iter().enumerate() {
        let _ = write!(page, "<th{}>{heading}</th>", if i == 0 { " class=\"l\"" } else { "" });
    }
    *page += "<th class=\"l\">what is traced</th></tr>\n";
    for outcome in outcomes {
        let [name, numbers @ ..] = table::summary(outcome);
        let is_odd = outcome.rows.iter().any(|row| !row.is_as_expected());
        let class = if is_odd { " class=\"odd\"" } else { "" };
        let _ = write!(page, "<tr{class}><td class=\"l\"><a href=\"#{name}\">{name}</a></td>");
        for number in numbers {
            let _ = write!(page, "<td>{number}</td>");
        }
        let _ = writeln!(page, "<td class=\"l w\">{}</td></tr>", escaped(outcome.case.what));
    }
    *page += "</table></div>\n<p class=\"note\">The most of all runs of a case. Robust rules must make no error. \
              <em>Undecided</em> are rays whose hit is not the exact one where f32 cannot tell; <em>undecided limit</em> is \
              how many the error bound allows. The paper's rules, here in f32, must fail where a case says so; elsewhere they \
              may.</p>\n";
}

/// Pictures of all errors, with their colours.
fn pictures(page: &mut String, outcomes: &[Outcome]) -> Result<(), Error> {
    if outcomes.iter().all(|outcome| outcome.pictures.is_empty()) {
        return Ok(());
    }
    *page += "<h2 id=\"errors\">Where the errors are</h2>\n<p>";
    for ([r, g, b], name) in LEGEND {
        let _ = write!(page, "<span class=\"key\" style=\"background:rgb({r},{g},{b})\"></span>{name}");
    }
    *page += "</p>\n";
    for Outcome { case, pictures, .. } in outcomes.iter().filter(|outcome| !outcome.pictures.is_empty()) {
        let _ = writeln!(page, "<h3>{}: {}</h3>", case.name, escaped(case.what));
        pictures.iter().try_for_each(|picture| figure(page, picture))?;
    }
    Ok(())
}

/// A case's runs, folded unless one is not as expected.
fn section(page: &mut String, outcome: &Outcome) {
    let Outcome { case, rows, first_wrong_ray, .. } = outcome;
    let field = |column| rows.first().map_or("0", |row: &Row| row.field(column));
    let _ = write!(
        page,
        "<details{7}><summary>{0}: {1}</summary><p id=\"{0}\">{2} rays, {3} triangles. Truth: {4}.</p>\n\
         <p class=\"note\">Undecided at most {5}: {6}.</p>\n",
        case.name,
        escaped(case.what),
        field("rays"),
        field("triangles"),
        table::truth(case),
        field("undecided_ceiling"),
        escaped(case.undecided.because),
        if rows.iter().all(Row::is_as_expected) { "" } else { " open" },
    );
    let fails: Vec<&str> = case.paper.fails_on.iter().map(|a| a.name()).collect();
    let expected = match fails[..] {
        [] => "nothing is expected of them here".to_owned(),
        _ => format!("must fail in f32 on {}: {}", fails.join(", "), escaped(case.paper.because)),
    };
    let _ = writeln!(page, "<p class=\"note\">The paper's rules: {expected}.</p>");
    if let Some(wrong_ray) = first_wrong_ray {
        let _ = writeln!(page, "<p class=\"fail\">{}</p>", escaped(wrong_ray));
    }
    *page += "<div class=\"wide\"><table><tr>";
    for (column, heading) in SHOWN {
        let _ = write!(page, "<th{}>{heading}</th>", class_of(column));
    }
    *page += "</tr>\n";
    for row in rows {
        *page += if row.is_as_expected() { "<tr>" } else { "<tr class=\"odd\">" };
        for (column, _) in SHOWN {
            let value = escaped(row.field(column));
            let class = if column == "result" && !row.passed { " class=\"fail\"" } else { class_of(column) };
            let _ = write!(page, "<td{class}>{value}</td>");
        }
        *page += "</tr>\n";
    }
    *page += "</table></div></details>\n";
}

fn walks(page: &mut String, walks: &[drift::Walked]) {
    if walks.is_empty() {
        return;
    }
    *page += "<details><summary>tMax along a walk</summary><p id=\"tmax\">The error of tMax over the cells of a walk, in units of \
              2<sup>-24</sup> max(|plane|, |origin|) / |direction|. Robust numerics compute it from the cell each \
              time. All samples are in <code>tmax.csv</code>.</p>\n<table><tr><th class=\"l\">device</th><th \
              class=\"l\">rules</th><th>cells</th><th>largest error</th><th>bound</th></tr>\n";
    for walked in walks {
        let (Some(last), class) = (walked.samples.last(), if walked.is_as_expected() { "" } else { " class=\"odd\"" })
        else {
            continue;
        };
        let bound = if walked.is_bounded() { drift::BOUND.to_string() } else { String::new() };
        let _ = writeln!(
            page,
            "<tr{class}><td class=\"l\">{}</td><td class=\"l\">{}</td><td>{}</td><td>{:.4}</td><td>{bound}</td></tr>",
            walked.place.device,
            escaped(walked.rules.name),
            last.cells,
            walked.largest(),
        );
    }
    *page += "</table>\n";
    if let Some(svg) = walks_plot(walks).inline() {
        let _ = writeln!(page, "<figure class=\"plot\">{svg}</figure>");
    }
    *page += "</details>\n";
}

/// Walks on the first device; CPU walks are the same anyway.
fn walks_plot(walks: &[drift::Walked]) -> Plot {
    let of_first = walks.iter().filter(|walked| walked.place == walks[0].place);
    let mut series: Vec<Series> = (0..)
        .zip(of_first)
        .map(|(color, walked)| {
            let points = walked.samples.iter().map(|s| (f64::from(s.cells), s.error)).collect();
            Series { mark: Mark::None, ..Series::line(walked.rules.name, color, points) }
        })
        .collect();
    // Some curves coincide: dashes show both.
    series.iter_mut().skip(2).for_each(|s| s.stroke = Stroke::Line(Dash::Dashed));
    let ends = series.first().map(|s| s.points.clone()).unwrap_or_default();
    series.push(Series::dashed("bound with robust numerics", 6, ends.iter().map(|p| (p.0, drift::BOUND)).collect()));
    Plot {
        title: "Largest error of tMax over the cells of a walk".into(),
        x: Axis::new("cells visited", Scale::Linear),
        y: Axis::new("error, units of 2⁻²⁴ of the larger of plane and origin", Scale::Log),
        series,
        places: Vec::new(),
    }
}

/// Columns of `pipelines.csv` to show.
const PROBED: [(&str, &str); 11] = [
    ("device", "device"),
    ("pipeline", "pipeline"),
    ("compared_with", "compared with"),
    ("pairs", "pairs"),
    ("other_triangle", "other triangle"),
    ("differing_t", "t differs"),
    ("differing_u", "u differs"),
    ("differing_v", "v differs"),
    ("t_ulp", "t, ulp"),
    ("u_ulp", "u, ulp of 1"),
    ("v_ulp", "v, ulp of 1"),
];

fn pipelines(page: &mut String, rows: &[probe::Row]) {
    if rows.is_empty() {
        return;
    }
    *page += "<details><summary>Pipelines</summary><p id=\"pipelines\">The same pairs of ray and triangle in every pipeline that \
              includes the triangle test: each is compiled separately, and t may differ in its last bits. Grid, BVH \
              and none agree bit for bit if nothing differs here. The rows are those of \
              <code>pipelines.csv</code>.</p>\n<div class=\"wide\"><table><tr>";
    for (column, heading) in PROBED {
        let _ = write!(page, "<th{}>{heading}</th>", class_of(column));
    }
    *page += "</tr>\n";
    for row in rows {
        *page += "<tr>";
        for (column, _) in PROBED {
            let _ = write!(page, "<td{}>{}</td>", class_of(column), escaped(row.field(column)));
        }
        *page += "</tr>\n";
    }
    *page += "</table></div></details>\n";
}

fn figure(page: &mut String, picture: &Picture) -> Result<(), Error> {
    let [width, height] = picture.size();
    let ways = escaped(&picture.ways.join("; "));
    let kind = if picture.is_image { "the image" } else { "directions: longitude across, latitude up" };
    let _ = writeln!(
        page,
        "<figure><img alt=\"errors of {ways}\" width=\"{width}\" height=\"{height}\" style=\"height:auto\" \
         src=\"data:image/png;base64,{}\"><figcaption>{ways} ({kind})</figcaption></figure>",
        BASE64_STANDARD.encode(picture.png()?)
    );
    Ok(())
}

/// Text columns are left-aligned.
fn class_of(column: &str) -> &'static str {
    match column {
        "numerics" | "accelerator" | "schedule" | "triangle_test" | "device" | "pipeline" | "compared_with"
        | "expected" | "result" => " class=\"l\"",
        _ => "",
    }
}
