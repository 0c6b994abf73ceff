//! The answer in a table of a few rows.

use super::super::page::{LeadTable, Part};
use super::super::words::compared;
use super::words::{is_own, name, quickest};
use crate::html::{cell, data};
use crate::human::{digits, field};
use crate::statistics::Compared;
use crate::tidy::Row;

/// What `raystep render` takes by default.
const DEFAULT: [(&str, &str); 3] = [("accelerator", "grid"), ("schedule", "compact"), ("numerics", "robust")];

const NAMES: [&str; 8] =
    ["choice", "time per ray", "× the recommended", "wrong", "per million", "undecided", "structure", "build"];

/// Most methods of other programs.
const MOST_OWN: usize = 6;

/// Adds the table of a few choices: the recommended one, the fastest of every structure, the default, the paper's, and
/// methods of other programs. `is_halved` says whether ratios are of the half of the rounds in which the recommended one
/// was not chosen, where there are enough.
pub(super) fn add(rows: &[Row], is_halved: bool, part: &mut Part) {
    let of = |accelerator| quickest(rows, &[("accelerator", accelerator), ("numerics", "robust")]);
    let wanted = [
        rows.iter().find(|r| r.get("is_recommended") == "true"),
        rows.iter().find(|r| r.get("is_fastest") == "true"),
        of("bvh"),
        of("grid"),
        of("irregular"),
        of("none"),
        quickest(rows, &DEFAULT),
        quickest(rows, &[("numerics", "paper")]),
    ];
    let mut chosen: Vec<&Row> = Vec::new();
    let own = rows.iter().filter(|row| is_own(row)).take(MOST_OWN);
    for row in wanted.into_iter().flatten().chain(own) {
        if !chosen.iter().any(|c| c.get("configuration") == row.get("configuration")) {
            chosen.push(row);
        }
    }
    let ns = |row: &Row| row.number("ns_per_ray").unwrap_or(f64::INFINITY);
    chosen.sort_by(|a, b| ns(a).total_cmp(&ns(b)));
    if !chosen.is_empty() {
        let rows = chosen.iter().map(|row| cells(row)).collect();
        part.lead_table = Some(LeadTable { names: NAMES.to_vec(), rows, note: note(is_halved) });
    }
}

fn cells(row: &Row) -> Vec<String> {
    let of = |column: &str| cell(column, row.get(column));
    let default = if row.is(&DEFAULT) { " (default)" } else { "" };
    let ratio = match (row.get("is_recommended"), compared("time_ratio", row)) {
        ("true", _) => "1".to_owned(),
        (_, Compared::Unknown) => of("time_ratio"),
        _ => format!("{} ({} to {})", of("time_ratio"), of("time_ratio_low"), of("time_ratio_high")),
    };
    vec![
        name(row) + default,
        of("ns_per_ray"),
        ratio,
        format!("{} of {}", of("wrong_rays"), of("judged_rays")),
        per_million(row),
        of("undecided"),
        of("structure_bytes"),
        of("build_s"),
    ]
}

/// The share of wrong rays with its interval; if none was seen, its bound.
fn per_million(row: &Row) -> String {
    const HIGH: &str = "wrong_per_million_high";
    if row.get("wrong_rays") == "0" {
        return data(row.get(HIGH), &format!("≤ {}", field(HIGH, row.get(HIGH))));
    }
    let three_digits = |column: &str| {
        let round = |value: f64| digits(format!("{value:.2e}").parse().unwrap_or(value));
        data(row.get(column), &row.number(column).map_or(String::new(), round))
    };
    let [share, low, high] = ["wrong_per_million", "wrong_per_million_low", HIGH].map(three_digits);
    format!("{share} ({low} to {high})")
}

fn note(is_halved: bool) -> String {
    format!(
        "Choice: --accelerator, --schedule, --numerics; none: no structure, every triangle is tested; default: that of \
         stepping. Ratios are medians of runs made side by side{}, so they differ from the quotient of the times shown; \
         those of other programs are quotients.",
        if is_halved {
            ", in the rounds in which the recommended choice was not chosen (with fewer than twelve: in all)"
        } else {
            ""
        }
    )
}

#[cfg(test)]
mod tests {
    use super::super::COLUMNS;
    use super::*;
    use crate::html::plain;

    #[test]
    fn shares_have_an_interval_and_none_seen_a_bound() {
        let row = |wrong: u64, [share, low, high]: [f64; 3]| {
            Row::new(COLUMNS)
                .set("accelerator", "grid")
                .set("schedule", "compact")
                .set("numerics", "robust")
                .set("wrong_rays", wrong)
                .set("judged_rays", 36_864_u64)
                .set("wrong_per_million", share)
                .set("wrong_per_million_low", low)
                .set("wrong_per_million_high", high)
        };
        let none = cells(&row(0, [0.0, 0.0, 81.2611]));
        assert_eq!([0, 3, 4].map(|i| plain(&none[i])), ["grid, compact, robust (default)", "0 of 36,864", "≤ 82"]);
        let some = cells(&row(13_167, [357_178.0, 352_284.0, 362_094.0]));
        assert_eq!([2, 4].map(|i| plain(&some[i])), ["", "357,000 (352,000 to 362,000)"]);
    }
}
