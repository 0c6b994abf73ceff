//! Which rules the scene needs, in words.

use raystep_kernels::{Order, Rule};

use super::super::page::{Part, number};
use super::super::words::compared;
use super::ALL;
use super::figure::compared_rows;
use crate::html::{cell, data};
use crate::statistics::Compared;
use crate::tidy::Row;

/// What is said of a rule for some structures, and for which.
struct Said<'a> {
    rule: &'a str,
    /// Rays that are lost without it, which the order follows.
    count: f64,
    text: String,
    structures: Vec<&'a str>,
}

/// What is said of rules, the largest counts first, once for all structures of which it is true.
fn said<'a>(rows: impl Iterator<Item = &'a Row>, count: fn(&Row) -> f64, text: fn(&Row) -> String) -> Vec<Said<'a>> {
    let mut all: Vec<Said<'a>> = Vec::new();
    for row in rows {
        let (rule, count, text) = (row.get("rule"), count(row), text(row));
        match all.iter_mut().find(|said| said.rule == rule && said.text == text) {
            Some(said) => said.structures.push(row.get("accelerator")),
            None => all.push(Said { rule, count, text, structures: vec![row.get("accelerator")] }),
        }
    }
    all.sort_by(|a, b| b.count.total_cmp(&a.count));
    all
}

/// What leaving a rule out does to the time.
fn change(row: &Row) -> String {
    let percent = || {
        let shown =
            row.number("time_ratio").map_or(String::new(), |ratio| format!("{:.1}%", 100.0 * (ratio - 1.0).abs()));
        data(row.get("time_ratio"), &shown)
    };
    match compared("time_ratio", row) {
        Compared::Unknown => "too few runs to compare times".into(),
        Compared::NotDistinguishable => "time not distinguishable".into(),
        Compared::AsFast => "as fast without it".into(),
        Compared::Faster => format!("leaving it out saves {} of the time", percent()),
        Compared::Slower => format!("leaving it out costs {} more time", percent()),
    }
}

/// Rays that only a run without the rule gets wrong; if it was stopped, those that it did not resolve.
fn lost(row: &Row) -> f64 {
    row.number("wrong_here_only").filter(|n| *n > 0.0).or(row.number("at_bound")).unwrap_or(0.0)
}

const UNRESOLVED: &str = "unresolved";

fn lost_in_words(row: &Row) -> String {
    match row.get("wrong_here_only") {
        "" | "0" => format!("{} {UNRESOLVED}", number("at_bound", row)),
        _ => number("wrong_here_only", row),
    }
}

/// "without triangle-test, 539 of 40,960 rays aimed at … are wrong (grid, bvh)".
fn needed(all: &[Said<'_>], judged: &str) -> String {
    let mut texts: Vec<String> = Vec::new();
    let mut last = "";
    for Said { rule, text, structures, .. } in all {
        let which = if *rule == last { String::new() } else { format!("without <em>{rule}</em>, ") };
        let verb = if text.ends_with(UNRESOLVED) { "" } else { " are wrong" };
        let of = match texts.is_empty() {
            true => format!(" of {judged} rays aimed at edges and cell faces{verb}"),
            false => String::new(),
        };
        texts.push(format!("{which}{text}{of} ({})", structures.join(", ")));
        last = rule;
    }
    texts.join("; ")
}

/// "tmax (leaving it out saves 9.8% of the time: grid); acceptance, cell-growth (time not distinguishable …)".
fn free(all: &[Said<'_>]) -> String {
    let mut groups: Vec<(String, Vec<String>)> = Vec::new();
    for Said { rule, text, structures, .. } in all {
        let text = format!("{text}: {}", structures.join(", "));
        match groups.iter_mut().find(|(of, _)| *of == text) {
            Some((_, rules)) => rules.push(format!("<em>{rule}</em>")),
            None => groups.push((text, vec![format!("<em>{rule}</em>")])),
        }
    }
    let texts = groups.into_iter().map(|(text, rules)| format!("{} ({text})", rules.join(", ")));
    texts.collect::<Vec<_>>().join("; ")
}

/// The sentence; nothing if nothing was compared.
fn sentence(rows: &[Row]) -> Option<String> {
    let is_needed = |row: &&Row| row.get("is_needed") == "true";
    let single = || compared_rows(rows).filter(|row| row.get("numerics") != "paper" && !is_of_order(row));
    let judged = number("judged_rays", single().next()?);
    let lossy = said(single().filter(is_needed), lost, lost_in_words);
    let lossless = said(single().filter(|row| !is_needed(row)), |_| 0.0, change);
    let mut text = match lossy.is_empty() {
        true => format!("None of the rules is needed for {judged} rays aimed at edges and cell faces."),
        false => format!("Needed: {}.", needed(&lossy, &judged)),
    };
    if !lossless.is_empty() {
        let high = |row: &Row| row.number("wrong_per_million_high").unwrap_or(0.0);
        let worst = single().filter(|row| !is_needed(row)).max_by(|a, b| high(a).total_cmp(&high(b)));
        let most = worst.map_or(String::new(), |row| cell("wrong_per_million_high", row.get("wrong_per_million_high")));
        text += &format!(
            " Not needed for these rays: {}. Without any one of these, at most {most} rays per million are wrong \
             (95%).",
            free(&lossless)
        );
    }
    Some(text)
}

/// Whether a row is of hits that are not ordered by exact t, compared with such that are.
fn is_of_order(row: &Row) -> bool {
    row.get("rule") == Rule::ExactOrder.name()
}

/// What the order by exact t is for, and what it costs; nothing if it was not compared.
fn of_order(rows: &[Row]) -> Option<String> {
    let of = || compared_rows(rows).filter(|row| is_of_order(row));
    let judged = number("judged_rays", of().next()?);
    let undecided = |row: &Row| row.number("undecided").unwrap_or(0.0);
    let exact = rows.iter().filter(|row| row.get("order") == Order::Exact.name() && row.get("stratum") == ALL);
    let with = exact.map(undecided).fold(0.0, |all, one| all + one);
    let all = said(of(), undecided, |row| format!("{} ({}", number("undecided", row), change(row)));
    let texts: Vec<String> =
        all.iter().map(|Said { text, structures, .. }| format!("{text}: {})", structures.join(", "))).collect();
    Some(format!(
        "Of {judged} rays, so many hit another triangle than that at the smallest exact t without <em>{}</em>, and {with} \
         with it: {}.",
        Rule::ExactOrder,
        texts.join("; ")
    ))
}

/// Adds the sentences, and how far they go.
pub(super) fn say(rows: &[Row], part: &mut Part) {
    let Some(text) = sentence(rows) else { return };
    part.lead.push(text);
    part.prose.extend(of_order(rows));
    part.prose.push(
        "Leaving out a rule that is not needed here is safe for this scene and these rays only: that none of them was \
         wrong bounds how often one is, it does not exclude it."
            .into(),
    );
    part.prose.push(
        "The paper's rules also differ in what is not measured alone here: the threshold below which a direction counts \
         as parallel to an axis, the test for leaving the grid, which of two hits at one t is taken, and origins outside \
         the grid, where none of these rays starts."
            .into(),
    );
}

#[cfg(test)]
mod tests {
    use super::super::COLUMNS;
    use super::*;
    use crate::html::plain;

    fn row(accelerator: &str, rule: &str, wrong: u64, ratio: [f64; 3]) -> Row {
        let [ratio, low, high] = ratio;
        Row::new(COLUMNS)
            .set("accelerator", accelerator)
            .set("numerics", "robust")
            .set("rule", rule)
            .set("stratum", "all")
            .set("ratio_to", "robust")
            .set("time_ratio", ratio)
            .set("time_ratio_low", low)
            .set("time_ratio_high", high)
            .set("judged_rays", 40_960_u64)
            .set("at_bound", 0_u64)
            .set("wrong_here_only", wrong)
            .set("wrong_per_million_high", if wrong == 0 { 73.1353 } else { 5_000.0 })
            .set("is_needed", wrong > 0)
    }

    #[test]
    fn rules_are_told_by_the_rays_that_are_lost_without_them() {
        let rows = [
            row("grid", "tmax", 0, [0.902, 0.88, 0.97]),
            row("grid", "acceptance", 1, [1.04, 1.02, 1.1]),
            row("grid", "triangle-test", 539, [0.64, 0.62, 0.67]),
            row("grid", "cell-growth", 0, [1.0, 0.9, 1.1]),
            row("bvh", "triangle-test", 539, [0.65, 0.6, 0.7]),
            row("bvh", "box-padding", 156, [0.97, 0.92, 0.99]),
        ];
        let text = plain(&sentence(&rows).expect("a sentence"));
        let expected = "Needed: without triangle-test, 539 of 40,960 rays aimed at edges and cell faces are wrong (grid, \
                        bvh); without box-padding, 156 (bvh); without acceptance, 1 (grid). Not needed for these rays: \
                        tmax (leaving it out saves 9.8% of the time: grid); cell-growth (time not distinguishable: \
                        grid). Without any one of these, at most 74 rays per million are wrong (95%).";
        assert_eq!(text, expected);
        let text = plain(&sentence(&rows[..1]).expect("a sentence"));
        assert!(
            text.starts_with("None of the rules is needed for 40,960 rays aimed at edges and cell faces. Not"),
            "{text}"
        );
        assert_eq!(sentence(&[]), None);
    }

    #[test]
    fn the_order_by_exact_t_is_told_by_the_rays_that_are_undecided_without_it() {
        let row = |accelerator, undecided: u64, ratio| {
            row(accelerator, "exact-order", 0, ratio).set("undecided", undecided).set("is_needed", undecided > 0)
        };
        let rows = [row("grid", 540, [0.5, 0.48, 0.52]), row("bvh", 541, [0.25, 0.2, 0.3])];
        let text = plain(&of_order(&rows).expect("a sentence"));
        let expected = "Of 40,960 rays, so many hit another triangle than that at the smallest exact t without \
                        exact-order, and 0 with it: 541 (leaving it out saves 75.0% of the time: bvh); 540 (leaving it \
                        out saves 50.0% of the time: grid).";
        assert_eq!(text, expected);
        assert_eq!((sentence(&rows), of_order(&[])), (None, None), "no other rule was compared");
    }
}
