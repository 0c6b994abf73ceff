//! What the sections on offset and scale say.

use super::plots;
use crate::html::data;
use crate::human::field;
use crate::report::page::{Part, number};
use crate::tidy::Row;

/// The robust rows of a stratum.
fn robust<'a>(rows: &'a [Row], stratum: &'static str) -> impl Iterator<Item = &'a Row> {
    rows.iter().filter(move |r| r.is(&[("numerics", "robust"), ("stratum", stratum)]))
}

/// What varies: "offset" or "scale".
fn what(column: &str) -> &'static str {
    if column == "scale" { "scale" } else { "offset" }
}

/// What was done to the scene: "moved" or "scaled".
fn done(column: &str) -> &'static str {
    if column == "scale" { "scaled" } else { "moved" }
}

/// Where a row was measured: "an offset of 1,000,000 extents", "scale 1e20".
fn place(column: &str, row: &Row) -> String {
    let text = row.get(column);
    let shown = if text.contains('e') { text.to_owned() } else { field(column, text) };
    let value = data(text, &shown);
    match (column, text) {
        ("scale", _) => format!("scale {value}"),
        (_, "1") => format!("an offset of {value} extent"),
        _ => format!("an offset of {value} extents"),
    }
}

/// Adds sentences on how tight the predictions are, and on the paper's rules far away.
pub(super) fn say(column: &str, rows: &[Row], part: &mut Part) {
    let (what, done) = (what(column), done(column));
    let ends = |column: &str| {
        let mut all: Vec<(f64, &Row)> = robust(rows, "anywhere").filter_map(|r| Some((r.number(column)?, r))).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        Some((*all.first()?, *all.last()?))
    };
    // Of each place the largest share of a ray's bound: from the smallest to the largest of these.
    let share = |column: &str| {
        let ((_, least), (most, most_row)) = ends(column)?;
        let verdict = match most {
            m if m > 1.0 => " The bound does not hold.",
            m if m < 0.1 => " The bound is too loose.",
            _ => "",
        };
        Some((format!("{} to {}", number(column, least), number(column, most_row)), verdict))
    };
    if let Some((share, verdict)) = share("arithmetic_error_by_bound_largest") {
        part.prose.push(format!(
            "At each {what}, the arithmetic error of t with robust rules, against the rounded scene, is at most {share} of the \
             bound predicted for that ray (1 would reach it).{verdict} The bound of a ray that grazes its triangle may be a \
             thousand times larger than others."
        ));
    }
    if let Some((share, verdict)) = share("forward_error_by_bound_largest") {
        part.prose.push(format!(
            "The forward error, against the scene before it was {done} and rounded, is at most {share} of that ray's \
             bound.{verdict} This bound is Σ |n| · (h(origin) + h(corner)) / |d·n|, summed over the axes, plus the \
             arithmetic bound: n is the triangle's normal, d the ray's direction, and h half a unit in the last place of a \
             coordinate."
        ));
    }
    if let Some((_, (_, row))) = ends("arithmetic_by_depth_rounding") {
        part.prose.push(format!(
            "The largest arithmetic error is at most {} × 2⁻²⁴ × the largest distance, along a ray, of a corner of the triangle \
             it hits.",
            number("arithmetic_by_depth_rounding", row)
        ));
    }
    let papers = papers(column, rows);
    if !papers.is_empty() {
        // Scaling keeps as many digits of a coordinate as it had.
        let is_fewer = column != "scale" && papers.iter().any(|(_, verdict)| *verdict == FEWER);
        let why = match is_fewer {
            true => {
                " Fewer, because rays are judged against the rounded scene, whose coordinates are coarse there; it is no gain \
                 in accuracy."
            }
            false => "",
        };
        let papers: Vec<String> = papers.into_iter().map(|(text, verdict)| format!("{text}: {verdict}")).collect();
        part.prose.push(format!(
            "Paper's rules, wrong per million rays, with exact 95% intervals: {}.{why}",
            papers.join("; ")
        ));
    }
}

const FEWER: &str = "fewer";

/// The paper's rules nearest to the origin, or at scale 1, and farthest from it or at the largest scale: for each stratum
/// the numbers and what they allow to say.
fn papers(column: &str, rows: &[Row]) -> Vec<(String, &'static str)> {
    let mut all = Vec::new();
    for (stratum, words) in [
        ("corners", "at corners"),
        ("edge_middles", "at middles of edges"),
        ("along_edges", "at other points of edges"),
    ] {
        let paper: Vec<&Row> = rows.iter().filter(|r| r.is(&[("numerics", "paper"), ("stratum", stratum)])).collect();
        let near = paper.iter().find(|r| r.number(column) == Some(1.0));
        let Some((near, far)) = near.zip(paper.last()).filter(|(near, far)| near != far) else { continue };
        let value = |row: &Row| {
            format!(
                "{} ({} to {}) at {}",
                number("wrong_per_million", row),
                number("wrong_per_million_low", row),
                number("wrong_per_million_high", row),
                place(column, row)
            )
        };
        let Some(verdict) = compared(near, far) else { continue };
        all.push((format!("{words}, {}, and {}", value(near), value(far)), verdict));
    }
    all
}

/// What the intervals of wrong rays allow to say of a farther place.
fn compared(near: &Row, far: &Row) -> Option<&'static str> {
    let ends = |row: &Row| Some([row.number("wrong_per_million_low")?, row.number("wrong_per_million_high")?]);
    let ([near_low, near_high], [far_low, far_high]) = (ends(near)?, ends(far)?);
    Some(match () {
        () if far_high < near_low => FEWER,
        () if far_low > near_high => "more",
        () => "not distinguishable",
    })
}

pub(super) fn errors_caption(rows: &[Row]) -> String {
    let Some(row) = robust(rows, "anywhere").next() else { return String::new() };
    format!(
        "Errors of t with robust numerics, of up to {} rays in random directions; both errors are of the same rays. \
         Arithmetic: compared with exact hits of the scene as it is after rounding to f32. Forward: compared with exact \
         hits of the scene before it was moved or scaled, so that it includes this rounding; both parts may cancel. \
         No intervals: largest and median of these rays.",
        number("rays", row)
    )
}

pub(super) fn bound_caption(rows: &[Row]) -> String {
    let Some(row) = robust(rows, "anywhere").next() else { return String::new() };
    format!(
        "The largest share of its own bound that the error of a ray reaches, of up to {} rays in random directions, with \
         robust rules. Above 1 the bound would not hold; if no point reaches a tenth, it is too loose.",
        number("rays", row)
    )
}

pub(super) fn wrong_caption(column: &str, rows: &[Row]) -> String {
    let Some(row) = rows.first() else { return String::new() };
    let none = plots::without_wrong(rows);
    let none = match none.is_empty() {
        true => String::new(),
        false => format!(" Not drawn, as no ray was wrong at any {}: {}.", what(column), none.join("; ")),
    };
    let far = match column {
        "scale" => "",
        _ => {
            " Far away, where few different coordinates remain, few wrong rays do not mean a result close to that of the given \
             scene; the next figure and the forward error show that."
        }
    };
    format!(
        "Wrong rays per million of {} in each stratum, with exact 95% intervals (Clopper and Pearson); where none is wrong, \
         the dashed line is the one-sided 95% bound.{none} Rays are compared with the scene after rounding to f32: this tells \
         whether a ray is right for the rounded scene, not whether rounding has changed the scene.{far}",
        number("rays", row)
    )
}

pub(super) fn changed_caption(column: &str, rows: &[Row]) -> String {
    let Some(row) = rows.iter().find(|r| !r.get("changed_rays").is_empty()) else { return String::new() };
    format!(
        "Hits that differ from those in the scene before it was {} and rounded (another triangle, or none), per million of {} \
         rays in random directions, with exact 95% intervals (Clopper and Pearson); where none differs, the dashed line is \
         the one-sided 95% bound. Rounding the scene changes these hits whatever the rules.",
        done(column),
        number("rays", row)
    )
}

#[cfg(test)]
mod tests {
    use super::super::COLUMNS;
    use super::*;

    fn paper(offset: f64, wrong: f64, low: f64, high: f64) -> Row {
        let row = Row::new(COLUMNS).set("numerics", "paper").set("stratum", "corners").set("offset_extents", offset);
        row.set("wrong_per_million", wrong).set("wrong_per_million_low", low).set("wrong_per_million_high", high)
    }

    #[test]
    fn the_paper_loses_fewer_far_away_only_if_intervals_say_so() {
        let of = |far: Row| {
            let rows = [paper(1.0, 201.0, 150.0, 250.0), far];
            papers("offset_extents", &rows).pop().expect("a sentence")
        };
        assert_eq!(of(paper(1e6, 195.0, 140.0, 240.0)).1, "not distinguishable");
        assert_eq!(of(paper(1e6, 600.0, 500.0, 700.0)).1, "more");
        let (text, verdict) = of(paper(1e6, 20.0, 5.0, 60.0));
        let text = crate::html::plain(&text);
        let expected =
            "at corners, 200 (150 to 250) at an offset of 1 extent, and 20 (5 to 60) at an offset of 1,000,000 extents";
        assert_eq!((text.as_str(), verdict), (expected, FEWER));
        assert!(papers("offset_extents", &[paper(1.0, 1.0, 0.0, 2.0)]).is_empty());
    }
}
