//! Which rules the scene needs, in words.

use super::super::page::{Part, number};
use super::super::words::{Compared, compared};
use super::figure::compared_rows;
use crate::human::{cell, data};
use crate::tidy::Row;

/// "−20%", or that no difference was measured.
fn change(row: &Row) -> String {
    let percent = |column: &str| {
        let shown = row.number(column).map_or(String::new(), |ratio| {
            let change = 100.0 * (ratio - 1.0);
            if change < 0.0 { format!("−{:.1}%", -change) } else { format!("+{change:.1}%") }
        });
        data(row.get(column), &shown)
    };
    match compared("time_ratio", row) {
        Compared::Unknown => "time not determined".into(),
        Compared::NotDistinguishable => "no measurable time".into(),
        Compared::Faster | Compared::Slower => format!("{} time", percent("time_ratio")),
    }
}

/// The rules of some rows, each once, with what is said of it for each structure.
fn by_rule<'a>(rows: impl Iterator<Item = &'a Row>, said: impl Fn(&Row) -> String) -> Vec<String> {
    let mut rules: Vec<(&str, Vec<String>)> = Vec::new();
    for row in rows {
        let text = format!("{} {}", row.get("accelerator"), said(row));
        match rules.iter_mut().find(|(rule, _)| *rule == row.get("rule")) {
            Some((_, texts)) => texts.push(text),
            None => rules.push((row.get("rule"), vec![text])),
        }
    }
    rules.into_iter().map(|(rule, texts)| format!("<em>{rule}</em> ({})", texts.join(", "))).collect()
}

/// Adds the sentence.
pub(super) fn say(rows: &[Row], part: &mut Part) {
    let is_needed = |row: &&Row| row.get("is_needed") == "true";
    let single = || compared_rows(rows).filter(|row| row.get("numerics") != "paper");
    let needed = by_rule(single().filter(is_needed), |row| number("wrong_here_only", row));
    let free = by_rule(single().filter(|row| !is_needed(row)), change);
    let Some(any) = single().next() else { return };
    let mut text = match needed.is_empty() {
        true => String::from("No rule was needed for rays aimed at this scene's edges and cell faces"),
        false => format!(
            "Rules that this scene needs, with the rays that are wrong without them, of {} aimed at its edges and cell \
             faces: {}",
            number("judged_rays", any),
            needed.join("; ")
        ),
    };
    if !free.is_empty() {
        let bounds = single().filter(|row| !is_needed(row));
        let worst = bounds.max_by(|a, b| {
            let high = |row: &Row| row.number("wrong_per_million_high").unwrap_or(0.0);
            high(a).total_cmp(&high(b))
        });
        let most = worst.map_or(String::new(), |row| cell("wrong_per_million_high", row.get("wrong_per_million_high")));
        text += &format!(". Not needed here: {}; wrong for at most {most} per million", free.join("; "));
    }
    part.lead.push(format!("{text}."));
    part.prose.push(
        "Leaving out a rule that is not needed here is safe for this scene and these rays only: that none of them was \
         wrong bounds how often one is, it does not exclude it."
            .into(),
    );
}
