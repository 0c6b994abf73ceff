//! A gate's result as Markdown, for a pull request.

use std::fmt::Write as _;

use super::{Gate, GateRow, Verdict};
use crate::text::{aligned, visible};

/// The result as Markdown: the answer, a table, and what else there is to say.
#[must_use]
pub fn markdown(gate: &Gate) -> String {
    let mut text = format!("### {}: {}\n\n", in_words(gate.verdict), cell(&gate.because));
    if !gate.rows.is_empty() {
        text += "| configuration | ratio | lower bound | upper bound | this, ms | other, ms | result |\n\
             |---|--:|--:|--:|--:|--:|---|\n";
        gate.rows.iter().for_each(|row| text += &line(row));
        text.push('\n');
    }
    for fault in &gate.faults {
        let _ = writeln!(text, "- {}", cell(fault));
    }
    if !gate.faults.is_empty() {
        text.push('\n');
    }
    if let Some(drift) = &gate.drift {
        let _ = writeln!(text, "{}\n", cell(&drift_in_words(gate, drift)));
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

/// The result as a table for a terminal, and below it the drift, and the answer if it is a pass: otherwise, the error that
/// the command ends with has it.
#[must_use]
pub fn text(gate: &Gate) -> String {
    let head =
        ["configuration", "result", "ratio", "lower bound", "upper bound", "this ms", "other ms"].map(str::to_owned);
    let row = |row: &GateRow| {
        let [ratio, low, high] =
            [row.times.time_ratio, row.times.time_ratio_low, row.times.time_ratio_high].map(number);
        [row.name.clone(), result(row).join(", "), ratio, low, high, ms(row.median_ns), ms(row.other_median_ns)]
    };
    let lines: Vec<[String; 7]> = std::iter::once(head).chain(gate.rows.iter().map(row)).collect();
    let answer = (gate.verdict == Verdict::Pass).then(|| format!("{}: {}", in_words(gate.verdict), gate.because));
    let drift = gate.drift.as_ref().map(|drift| drift_in_words(gate, drift));
    let below: Vec<String> = answer.into_iter().chain(drift).map(|line| line + "\n").collect();
    let space = if below.is_empty() { "" } else { "\n" };
    aligned(&lines, 2).concat() + space + &below.concat()
}

/// The drift in a sentence.
fn drift_in_words(gate: &Gate, drift: &super::drift::Drift) -> String {
    let fixed = drift.fixed_work_ratio.map_or("unknown".into(), |ratio| format!("{ratio:.2}"));
    let judged = match gate.at_most > drift.seen {
        true => "exceeds that, so times are judged, with intervals widened by it",
        false => "does not exceed that, so times are not judged",
    };
    format!(
        "The machine drifted by a factor of {:.2} since the baseline (within this run {:.2}, within the baseline {:.2}, a fixed \
         piece of work took {fixed} times as long as then); {} {judged}.",
        drift.seen, drift.within_this, drift.within_other, gate.at_most
    )
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
### Fail: 1 of 3 rows more than 1.05 times as slow as old, 2 with changed results or without a counterpart

| configuration | ratio | lower bound | upper bound | this, ms | other, ms | result |
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
configuration                       result                  ratio  lower bound  upper bound  this ms  other ms
box 8x8 primary, grid fused robust  within                  1.200        1.100            –    1.200     1.000
box 8x8 primary, grid fused robust  undecided (80 repeats)  1.200        1.100            –    1.200     1.000
";
        assert_eq!(table, expected);
        let passed = super::text(&gate(&[(Verdict::Pass, None)]));
        assert!(passed.ends_with("1.000\n\nPass: at most 1.05 times as slow as old (1 row)\n"), "{passed}");
    }

    #[test]
    fn an_open_question_says_what_would_answer_it() {
        let open = gate_text(Some(80));
        assert!(
            open.starts_with("### Undecided: too noisy for 1 of 1 row; --repeats 80 would probably decide\n"),
            "{open}"
        );
        assert!(gate_text(Some(100_001)).contains("; more than 100000 repeats would be needed"));
        assert!(gate_text(None).contains("; no number of repeats would decide"));
        let drift =
            super::super::drift::Drift { within_this: 1.1, within_other: 1.0, fixed_work_ratio: Some(1.0), seen: 1.1 };
        let mut gate = gate(&[(Verdict::Undecided, None)]);
        gate.drift = Some(drift);
        let text = markdown(&gate.clone().concluded());
        assert!(text.contains("drifted by a factor of 1.10 since the baseline (within this run 1.10,"), "{text}");
        assert!(
            text.contains("; 1.05 does not exceed that") && text.contains("; use --against, or a larger"),
            "{text}"
        );
        gate.at_most = 1.5;
        let text = markdown(&gate.concluded());
        assert!(text.contains("; 1.5 exceeds that") && text.contains("; more repeats would not decide"), "{text}");
    }

    fn gate_text(needed: Option<u64>) -> String {
        markdown(&gate(&[(Verdict::Undecided, needed)]))
    }
}
