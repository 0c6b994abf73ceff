//! `stability.html`: one page that needs no other files. Its numbers are the fields of `stability.csv`.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use raystep_kernels::Numerics;

use super::picture::{LEGEND, Picture};
use super::{Outcome, Report, Row, drift, probe, table};
use crate::Error;
use crate::html::{self, escaped, mark};
use crate::plots::{self, Axis, Dash, Draw as _, Mark, Plot, Scale, Series, Stroke};
use crate::stiff;

/// Styles that only this page needs.
const STYLE: &str = "\
figure{display:inline-block;margin:.4rem 1rem .4rem 0;vertical-align:top}figcaption{max-width:16rem}img{image-rendering:\
pixelated;border:1px solid var(--rule);width:16rem}.key{display:inline-block;width:.8em;height:.8em;margin:0 .3em 0 1em;\
vertical-align:middle}.curves figcaption{max-width:27.5rem}figure.plot figcaption{max-width:50rem}details{margin:.5rem 0}\
summary{cursor:pointer}h3{font-size:1rem;margin:1.2rem 0 .2rem}.w{display:inline-block;white-space:normal;width:16rem}";

/// The page: a line a case, then what stiff scenes cost, pictures of errors, and everything else folded.
pub(super) fn html(report: &Report) -> Result<String, Error> {
    let outcomes = &report.outcomes;
    let rows = || outcomes.iter().flat_map(|o| &o.rows);
    let (runs, odd) = (rows().count(), rows().filter(|row| !row.is_as_expected()).count());
    let robust = rows().filter(|row| row.configuration.numerics == Numerics::Robust);
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
    let names = table::SUMMARY.iter().copied().chain(["what is traced"]);
    let row = |outcome: &Outcome| {
        let [name, numbers @ ..] = table::summary(outcome);
        let what = format!("<span class=\"w\">{}</span>", escaped(outcome.case.what));
        let name = format!("<a href=\"#{name}\">{name}</a>");
        (mark(outcome.rows.iter().all(Row::is_as_expected)), [name].into_iter().chain(numbers).chain([what]).collect())
    };
    *page += &html::table(&names.collect::<Vec<_>>(), &outcomes.iter().map(row).collect::<Vec<_>>(), "");
    *page += "<p class=\"note\">Each number is the maximum over all runs of the case. Robust rules must make no error. \
              <em>Undecided</em> are rays whose hit is not the exact one where f32 cannot tell; <em>undecided limit</em> is \
              how many the error bound allows; of hits that are ordered by exact t, none may be undecided. The paper's rules, here in f32, must fail where a case says so; elsewhere they \
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
    let fails: Vec<&str> = case.paper.fails_on.iter().map(|a| a.name()).collect();
    let expected = match fails[..] {
        [] => "nothing is expected of them here".to_owned(),
        _ => format!("must fail in f32 on {}: {}", fails.join(", "), escaped(case.paper.because)),
    };
    let mut body = format!(
        "<p id=\"{}\">{} rays, {} triangles. Truth: {}.</p>\n<p class=\"note\">Undecided at most {}: {}.</p>\n\
         <p class=\"note\">The paper's rules: {expected}.</p>\n",
        case.name,
        field("rays"),
        field("triangles"),
        table::truth(case),
        field("undecided_ceiling"),
        escaped(case.undecided.because),
    );
    body.extend(first_wrong_ray.iter().map(|ray| format!("<p class=\"fail\">{}</p>\n", escaped(ray))));
    body += &html::of_rows(rows.iter().map(|row| (mark(row.is_as_expected()), &row.fields)));
    let summary = format!("{}: {}", case.name, escaped(case.what));
    *page += &html::folded(&summary, !rows.iter().all(Row::is_as_expected), &body);
}

fn walks(page: &mut String, walks: &[drift::Walked]) {
    let row = |walked: &drift::Walked| {
        let bound = if walked.is_bounded() { drift::BOUND.to_string() } else { String::new() };
        let (device, rules) = (walked.device.kind.to_owned(), escaped(walked.rules.name));
        let cells = walked.samples.last()?.cells.to_string();
        Some((mark(walked.is_as_expected()), vec![device, rules, cells, format!("{:.4}", walked.largest()), bound]))
    };
    let rows: Vec<_> = walks.iter().filter_map(row).collect();
    if rows.is_empty() {
        return;
    }
    let mut body =
        "<p id=\"tmax\">The error of tMax over the cells of a walk, in units of 2<sup>-24</sup> max(|plane|, \
                    |origin|) / |direction|. Robust numerics compute it from the cell each time. All samples are in \
                    <code>tmax.csv</code>.</p>\n"
            .to_owned();
    body += &html::table(&["device", "rules", "cells", "largest error", "bound"], &rows, "");
    body.extend(walks_plot(walks).inline().map(|svg| format!("<figure class=\"plot\">{svg}</figure>\n")));
    *page += &html::folded("tMax along a walk", false, &body);
}

/// Walks on the first device; CPU walks are the same anyway.
fn walks_plot(walks: &[drift::Walked]) -> Plot {
    let of_first = walks.iter().filter(|walked| walked.device == walks[0].device);
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
    Plot::new(
        "Largest error of tMax over the cells of a walk",
        Axis::new("cells visited", Scale::Linear),
        Axis::new("error, units of 2⁻²⁴ of the larger of plane and origin", Scale::Log),
        series,
    )
}

fn pipelines(page: &mut String, rows: &[probe::Row]) {
    if rows.is_empty() {
        return;
    }
    let what = "<p id=\"pipelines\">The same pairs of ray and triangle in every pipeline that includes the triangle test: each \
                is compiled separately, and t may differ in its last bits. Grid, BVH and none agree bit for bit if nothing \
                differs here. The rows are those of <code>pipelines.csv</code>.</p>\n";
    let rows = html::of_rows(rows.iter().map(|row| ("", &row.fields)));
    *page += &html::folded("Pipelines", false, &(what.to_owned() + &rows));
}

fn figure(page: &mut String, picture: &Picture) -> Result<(), Error> {
    let [width, height] = picture.size();
    let runs = escaped(&picture.runs.join("; "));
    let kind = if picture.is_image { "the image" } else { "directions: longitude across, latitude up" };
    let image = format!(
        "<img alt=\"errors of {runs}\" width=\"{width}\" height=\"{height}\" style=\"height:auto\" \
         src=\"data:image/png;base64,{}\">",
        BASE64_STANDARD.encode(picture.png()?)
    );
    *page += &html::figure(&image, &format!("{runs} ({kind})"));
    Ok(())
}
