//! What the sections on offset and scale say.

use crate::report::page::{Part, number};
use crate::tidy::Row;

/// The robust rows of a stratum.
fn robust<'a>(rows: &'a [Row], stratum: &'static str) -> impl Iterator<Item = &'a Row> {
    rows.iter().filter(move |r| r.is(&[("numerics", "robust"), ("stratum", stratum)]))
}

/// Adds sentences on how tight the predictions are, and on the paper's rules far away.
pub(super) fn say(column: &str, rows: &[Row], part: &mut Part) {
    let ends = |column: &str| {
        let mut all: Vec<(f64, &Row)> = robust(rows, "anywhere").filter_map(|r| Some((r.number(column)?, r))).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        Some((*all.first()?, *all.last()?))
    };
    let share = |column: &str| {
        let ((_, least), (most, most_row)) = ends(column)?;
        let verdict = match most {
            m if m > 1.0 => ": the bound does not hold",
            m if m < 0.1 => ": the bound is too loose",
            _ => "",
        };
        Some(format!("{} to {} of its own bound{verdict}", number(column, least), number(column, most_row)))
    };
    if let Some(share) = share("arithmetic_error_by_bound_largest") {
        part.prose.push(format!(
            "With robust numerics, the arithmetic error of the ray closest to its bound is {share}. Every ray has its own \
             bound: that of a ray that grazes its triangle may be a thousand times larger."
        ));
    }
    if let Some(share) = share("forward_error_by_bound_largest") {
        part.prose.push(format!(
            "The forward error, which includes rounding the scene before tracing, is, for the ray closest to its bound, \
             {share}. This bound follows from half a unit in the last place of each coordinate: |Δt| ≤ Σ |n| · (h(origin) \
             + h(corner)) / |d·n|, plus the arithmetic bound."
        ));
    }
    if let Some((_, (_, row))) = ends("arithmetic_by_depth_rounding") {
        part.prose.push(format!(
            "The largest arithmetic error is at most {} times one rounding, 2⁻²⁴, of the largest depth.",
            number("arithmetic_by_depth_rounding", row)
        ));
    }
    let papers = papers(column, rows);
    if !papers.is_empty() {
        part.prose.push(format!(
            "The paper's rules, each stratum by itself and compared with the rounded scene, with exact 95% intervals: {}.",
            papers.join("; ")
        ));
    }
}

/// The paper's rules nearest to the origin, or at scale 1, and where they differ most from that.
fn papers(column: &str, rows: &[Row]) -> Vec<String> {
    let mut sentences = Vec::new();
    for (stratum, words) in
        [("corners", "corners"), ("edge_middles", "middles of edges"), ("along_edges", "other points of edges")]
    {
        let paper: Vec<&Row> = rows.iter().filter(|r| r.is(&[("numerics", "paper"), ("stratum", stratum)])).collect();
        let near = paper.iter().find(|r| r.number(column) == Some(1.0));
        let Some((near, far)) = near.zip(paper.last()).filter(|(near, far)| near != far) else { continue };
        let value = |row: &Row| {
            format!(
                "{} wrong per million ({} to {})",
                number("wrong_per_million", row),
                number("wrong_per_million_low", row),
                number("wrong_per_million_high", row)
            )
        };
        let Some(verdict) = compared(near, far) else { continue };
        let (near_at, far_at) = (number(column, near), number(column, far));
        sentences.push(format!("{words}, {} at {near_at} and {} at {far_at}: {verdict}", value(near), value(far)));
    }
    sentences
}

/// What the intervals of wrong rays allow to say of a farther place.
fn compared(near: &Row, far: &Row) -> Option<&'static str> {
    let ends = |row: &Row| Some([row.number("wrong_per_million_low")?, row.number("wrong_per_million_high")?]);
    let ([near_low, near_high], [far_low, far_high]) = (ends(near)?, ends(far)?);
    Some(match () {
        () if far_high < near_low => "fewer",
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
        "The largest share of its own bound that the error of a ray reaches, of up to {} rays in random directions, robust \
         numerics. Above 1 the bound would not hold.",
        number("rays", row)
    )
}

pub(super) fn wrong_caption(rows: &[Row]) -> String {
    let Some(row) = rows.first() else { return String::new() };
    format!(
        "Wrong rays per million of {} in each stratum, with exact 95% intervals (Clopper and Pearson); where \
         none is wrong, the dashed line is the one-sided 95% bound. The truth is the scene after rounding to f32: this tells whether a ray is right for the rounded scene, \
         not whether rounding has changed the scene. Far away, where few different coordinates remain, few wrong rays do \
         not mean a result close to that of the given scene; the next figure and the forward error show that.",
        number("rays", row)
    )
}

pub(super) fn changed_caption(rows: &[Row]) -> String {
    let Some(row) = rows.iter().find(|r| !r.get("changed_rays").is_empty()) else { return String::new() };
    format!(
        "The other comparison: rays per million of {} in random directions that hit another triangle than in the scene \
         before it was moved or scaled, or none, with exact 95% intervals (Clopper and Pearson); where none has changed, \
         the dashed line is the one-sided 95% bound. Rounding the scene \
         changes these hits whatever the rules.",
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
        assert!(of(paper(1e6, 195.0, 140.0, 240.0)).ends_with(": not distinguishable"));
        assert!(of(paper(1e6, 20.0, 5.0, 60.0)).ends_with(": fewer"));
        assert!(of(paper(1e6, 600.0, 500.0, 700.0)).ends_with(": more"));
        assert!(papers("offset_extents", &[paper(1.0, 1.0, 0.0, 2.0)]).is_empty());
    }
}
