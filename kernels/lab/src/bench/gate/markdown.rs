//! A gate's result as Markdown, for a pull request.

use std::fmt::Write as _;

use super::{Gate, GateRow, Verdict};
use crate::text::{aligned, visible};

/// The result as Markdown: the answer, a table, and what else there is to say.
#[must_use]
pub fn markdown(gate: &Gate) -> String {
    let mut text = format!("### {}: {}\n\n", in_words(gate.verdict), cell(&gate.because));
    if !gate.rows.is_empty() {
        text +=
            "| configuration | ratio | from | to | this, ms | other, ms | result |\n|---|--:|--:|--:|--:|--:|---|\n";
        gate.rows.iter().for_each(|row| text += &line(row));
        text.push('\n');
    }
    for fault in &gate.faults {
        let _ = writeln!(text, "- {}", cell(fault));
    }
    if !gate.faults.is_empty() {
        text.push('\n');
    }
    for remark in remarks(gate) {
        let _ = writeln!(text, "{}\n", cell(&remark));
    }
    let _ = writeln!(
        text,
        "Time of this build divided by that of {}; limit {}; {} rounds. {}",
        cell(&gate.other),
        gate.at_most,
        gate.rounds,
        gate.method
    );
    text
}

/// The drift that was seen, and how to get an answer if there is none.
#[must_use]
pub fn remarks(gate: &Gate) -> Vec<String> {
    let drift = gate.drift.as_ref().map(|drift| drift_in_words(gate, drift));
    drift.into_iter().chain((gate.verdict == Verdict::Undecided).then(|| needed_in_words(gate))).collect()
}

/// The result as a table for a terminal, with the answer below it.
#[must_use]
pub fn text(gate: &Gate) -> String {
    let head = ["configuration", "result", "ratio", "from", "to", "this ms", "other ms"].map(str::to_owned);
    let row = |row: &GateRow| {
        let [ratio, low, high] =
            [row.times.time_ratio, row.times.time_ratio_low, row.times.time_ratio_high].map(number);
        [row.name.clone(), result(row).join(", "), ratio, low, high, ms(row.median_ns), ms(row.other_median_ns)]
    };
    let lines: Vec<[String; 7]> = std::iter::once(head).chain(gate.rows.iter().map(row)).collect();
    let answer = format!("{}: {}\n", in_words(gate.verdict), gate.because);
    aligned(&lines, 2).concat() + "\n" + &answer + &remarks(gate).iter().map(|r| format!("{r}\n")).collect::<String>()
}

/// The drift in a sentence.
fn drift_in_words(gate: &Gate, drift: &super::drift::Drift) -> String {
    let fixed = drift.fixed_work_ratio.map_or("unknown".into(), |ratio| format!("{ratio:.2}"));
    let judged = if gate.at_most > drift.seen {
        format!("The limit of {} is beyond it, and every interval is widened by it.", gate.at_most)
    } else {
        format!("The limit of {} is within it, so no time is judged: use --against, or a larger limit.", gate.at_most)
    };
    format!(
        "Drift seen: {:.2} (within this run {:.2}, within the other {:.2}, a fixed piece of work took {fixed} times as \
         long as then). {judged}",
        drift.seen, drift.within_this, drift.within_other
    )
}

/// Most repeats that anyone would wait for; it is also the most that the command line takes.
const MOST_REPEATS: u64 = 100_000;

/// How to get an answer.
fn needed_in_words(gate: &Gate) -> String {
    match gate.needed_repeats {
        Some(repeats) if repeats > MOST_REPEATS => {
            format!("More than {MOST_REPEATS} repeats would be needed: the ratio is too near the limit for this noise.")
        }
        Some(repeats) => format!("About {repeats} repeats would decide: --repeats {repeats}."),
        None if gate.drift.is_some() => "More repeats would not decide.".into(),
        None => "The ratio is at the limit: no number of repeats would decide.".into(),
    }
}

fn in_words(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Pass => "Pass",
        Verdict::Fail => "Fail",
        Verdict::Undecided => "Undecided",
    }
}

fn number(value: Option<f64>) -> String {
    value.map_or("–".to_owned(), |v| format!("{v:.3}"))
}

fn ms(ns: Option<f64>) -> String {
    number(ns.map(|ns| ns / 1e6))
}

/// What happened to a row.
fn result(row: &GateRow) -> Vec<String> {
    let times = match (row.times.verdict, row.times.needed_repeats) {
        (Verdict::Fail, _) => Some("slower".to_owned()),
        (Verdict::Pass, _) => row.changed.is_empty().then(|| "within".to_owned()),
        (Verdict::Undecided, None) => Some("undecided".to_owned()),
        (Verdict::Undecided, Some(repeats)) => Some(format!("undecided ({repeats} repeats)")),
    };
    row.changed.iter().cloned().chain(times).collect()
}

fn line(row: &GateRow) -> String {
    let is_bad = row.times.verdict == Verdict::Fail || !row.changed.is_empty();
    let mark = if is_bad { "**" } else { "" };
    let result: Vec<String> = result(row).iter().map(|text| format!("{mark}{}{mark}", cell(text))).collect();
    let [ratio, low, high] = [row.times.time_ratio, row.times.time_ratio_low, row.times.time_ratio_high].map(number);
    let (name, now, then) = (cell(&row.name), ms(row.median_ns), ms(row.other_median_ns));
    format!("| {name} | {ratio} | {low} | {high} | {now} | {then} | {} |\n", result.join(", "))
}

/// Text that stays within its cell and marks nothing up: names of scenes are arbitrary.
fn cell(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in visible(text).chars() {
        match c {
            '<' => escaped += "&lt;",
            '&' => escaped += "&amp;",
            '\\' | '|' | '*' | '_' | '`' | '[' | ']' | '#' => escaped.extend(['\\', c]),
            _ => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::super::tests::gate;
    use super::*;

    #[test]
    fn a_table_says_what_happened_to_each_row() {
        let mut gate = gate(&[(Verdict::Pass, None), (Verdict::Fail, None), (Verdict::Undecided, Some(80))]);
        gate.rows[0].changed.push("other hits, of as many rays (7)".into());
        gate.rows[0].name = "a|b<i>".into();
        gate.faults.push("x: only old has this row".into());
        let text = markdown(&gate.concluded());
        let expected = "\
### Fail: 1 of 3 rows slower than 1.05 times the time of old, 2 with changed results or without a counterpart

| configuration | ratio | from | to | this, ms | other, ms | result |
|---|--:|--:|--:|--:|--:|---|
| a\\|b&lt;i> | 1.200 | 1.100 | – | 1.200 | 1.000 | **other hits, of as many rays (7)** |
| box 8x8 primary, grid fused robust | 1.200 | 1.100 | – | 1.200 | 1.000 | **slower** |
| box 8x8 primary, grid fused robust | 1.200 | 1.100 | – | 1.200 | 1.000 | undecided (80 repeats) |

- x: only old has this row

Time of this build divided by that of old; limit 1.05; 40 rounds. signs
";
        assert_eq!(text, expected);
    }

    #[test]
    fn the_terminal_has_the_same_table() {
        let table = super::text(&gate(&[(Verdict::Pass, None), (Verdict::Undecided, Some(80))]));
        let expected = "\
configuration                       result                  ratio   from  to  this ms  other ms
box 8x8 primary, grid fused robust  within                  1.200  1.100   –    1.200     1.000
box 8x8 primary, grid fused robust  undecided (80 repeats)  1.200  1.100   –    1.200     1.000

Undecided: noise decides neither for 1 of 2 rows
About 80 repeats would decide: --repeats 80.
";
        assert_eq!(table, expected);
    }

    #[test]
    fn an_open_question_says_what_would_answer_it() {
        let open = gate_text(Some(80));
        assert!(open.contains("About 80 repeats would decide: --repeats 80."), "{open}");
        assert!(gate_text(Some(100_001)).contains("More than 100000 repeats would be needed"));
        assert!(gate_text(None).contains("no number of repeats would decide"));
        let drift =
            super::super::drift::Drift { within_this: 1.1, within_other: 1.0, fixed_work_ratio: Some(1.0), seen: 1.1 };
        let mut gate = gate(&[(Verdict::Undecided, None)]);
        gate.drift = Some(drift);
        let text = markdown(&gate);
        assert!(text.contains("Drift seen: 1.10 (within this run 1.10,") && text.contains("is within it"), "{text}");
        gate.at_most = 1.5;
        assert!(markdown(&gate).contains("is beyond it"));
    }

    fn gate_text(needed: Option<u64>) -> String {
        markdown(&gate(&[(Verdict::Undecided, needed)]))
    }
}
