//! The curves and what they say, as HTML.

use std::fmt::Write as _;

use super::figures::{correlations, curves, over_stiffness};
use super::words::{TIMES_THE_BEST, sentences};
use super::{CSV, Cost, FAMILIES, Family, OWN, RUNS};
use crate::html::{self, escaped};
use crate::plots::{Draw as _, Format, Plot};
use crate::structures::accelerating;
use crate::tidy::Row;

/// Styles that [`html()`] needs.
pub const STYLE: &str = "\
.curves{display:flex;flex-wrap:wrap;gap:.6rem 1.2rem}.curves figure{margin:0;width:27.5rem;max-width:100%}\
.curves figcaption{font-size:.82rem;margin-top:.2rem}";

/// A family's figure with what it says.
pub(crate) struct FamilyPart {
    pub(crate) family: &'static Family,
    pub(crate) curves: Plot,
    pub(crate) sentences: Vec<String>,
}

/// The stiffness numbers of the user's scene by structure.
pub(crate) fn own_numbers(rows: &[Row]) -> Vec<(String, f64)> {
    let own = rows.iter().filter(|row| row.is(&[("family", OWN), ("rule", "")]) && row.get("accelerator") != "none");
    own.filter_map(|row| Some((row.get("accelerator").to_owned(), row.number("stiffness")?))).collect()
}

/// The measured families.
pub(crate) fn parts(rows: &[Row], own: &[(String, f64)]) -> Vec<FamilyPart> {
    let said = sentences(rows);
    let part = |family: &'static Family| {
        let curves = curves(rows, family, own);
        let of_family = said.iter().filter(|(f, _)| f.name == family.name);
        let sentences = of_family.map(|(_, text)| text.clone()).collect();
        curves.picture(Format::Screen).map(|_| FamilyPart { family, curves, sentences })
    };
    FAMILIES.iter().filter_map(part).collect()
}

/// How well the stiffness number predicts cost, as a paragraph.
pub(crate) fn correlation_text(rows: &[Row]) -> String {
    let mut parts = Vec::new();
    for structure in accelerating() {
        if let Some([number, both]) = correlations(rows, structure, "ns_per_ray") {
            parts.push(format!("{structure} {number:.2} ({both:.2} with the work along the line)"));
        }
    }
    match parts[..] {
        [] => String::new(),
        _ => format!(
            "Rank correlation of the stiffness number with the time of a ray, over all scenes: {}. The number is what a \
             structure is expected to visit and test at a random point of a random triangle; it does not know the rays, \
             and so neither grazing angles nor long walks.",
            parts.join("; ")
        ),
    }
}

/// Caption of all families' figures.
pub(crate) const CAPTION: &str = "Above, the median time of a ray with all rules, with its interval where it is wider \
                                  than the dot; dashed, without a rule that makes a threefold difference somewhere. \
                                  Below, wrong rays: dots with all rules, triangles without the rule that loses \
                                  most. Families of light have wrong rays to lights there, and below \
                                  them the largest error of a ray's light, relative to it, against f64.";

/// Curves, words and a table for a page.
#[must_use]
pub fn html(cost: &Cost) -> String {
    let rows = &cost.rows.rows;
    let mut page = String::new();
    let said = sentences(rows);
    let adapter = rows.first().map_or("", |row| row.get("adapter"));
    // Writing to a string cannot fail.
    let _ = write!(
        page,
        "<p>Scenes that get harder in one way, on {}: every structure traces the same random rays. All numbers are in \
         <code>{CSV}</code>, single runs in <code>{RUNS}</code>. {}</p>\n<p>More than {TIMES_THE_BEST} times as slow as \
         the fastest structure at the same point, or as the same structure without a rule:</p>\n",
        escaped(adapter),
        escaped(CAPTION),
    );
    let said: Vec<&String> = said.iter().map(|(_, text)| text).collect();
    page += &if said.is_empty() { "<p>Nothing.</p>\n".to_owned() } else { html::list(&said, "") };
    for note in &cost.notes {
        let _ = writeln!(page, "<p class=\"note\">{}</p>", escaped(note));
    }
    page += "<div class=\"curves\">\n";
    for FamilyPart { family, curves, .. } in parts(rows, &[]) {
        let (what, inline) = (escaped(family.what), curves.inline().unwrap_or_default());
        page += &html::figure(&inline, &format!("{what}; rays to: {}", family.stratum));
    }
    page += "</div>\n";
    let _ = writeln!(page, "<p>{}</p>", escaped(&correlation_text(rows)));
    if let Some(svg) = over_stiffness(rows, &[]).inline() {
        let _ = writeln!(page, "<figure class=\"plot\">{svg}</figure>");
    }
    let with_all_rules = rows.iter().filter(|row| row.get("rule").is_empty());
    let table = html::of_rows(with_all_rules.map(|row| ("", row)));
    page + &html::folded("All points, with all rules", false, &table)
}
