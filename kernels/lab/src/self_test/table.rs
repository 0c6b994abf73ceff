//! The table as text, in lines of at most 100 columns.

use super::{Group, Results, Row, Totals, Verdict};
use crate::human::grouped;
use crate::text::counted;

/// Longest line.
const COLUMNS: usize = 100;

/// Most characters that are said of a check; all of a driver's message is among the details.
const MOST_SAID: usize = 240;

/// Width of the verdicts.
const VERDICT: usize = 7;

/// The table, and a last line with the totals.
#[must_use]
pub fn text(results: &Results) -> String {
    let (rows, mut text) = (results.rows(), String::new());
    for group in Group::ALL {
        let rows: Vec<&Row> = rows.iter().filter(|row| row.group == group).collect();
        let width = rows.iter().map(|row| row.name.chars().count()).max().unwrap_or(0);
        text += &format!("{} ({:.1} s)\n", group.name(), results.seconds(group));
        for row in rows {
            let head = format!("  {:<VERDICT$}  {:<width$}  ", row.verdict.name(), row.name);
            text += &wrapped(&head, &outcome(row));
        }
        text.push('\n');
    }
    text + &format!("{}\n", results.totals())
}

/// Everything that is wrong or differs, a paragraph a check; empty if nothing does.
#[must_use]
pub fn details(results: &Results) -> String {
    let mut text = String::new();
    for row in results.rows().iter().filter(|row| !row.details.is_empty()) {
        text += &format!("{}: {} ({})\n", row.group.name(), row.name, row.shows);
        row.details.iter().for_each(|line| text += &format!("  {line}\n"));
        text.push('\n');
    }
    text
}

impl std::fmt::Display for Totals {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {} right, {} wrong", counted(self.checks, "check"), self.right, self.wrong)?;
        for (count, words) in
            [(self.not_run, "not run"), (self.information, "for information"), (self.not_applicable, "not applicable")]
        {
            if count > 0 {
                write!(f, ", {count} {words}")?;
            }
        }
        Ok(())
    }
}

/// What is said of a check: what was found, and of how much.
fn outcome(row: &Row) -> String {
    let (counts, mut says) = (counts(row), row.says.clone());
    if let Some((cut, _)) = says.char_indices().nth(MOST_SAID) {
        says.truncate(cut);
        says += " …";
    }
    match (says.as_str(), counts.as_str()) {
        ("", counts) => counts.to_owned(),
        (says, "") => says.to_owned(),
        (says, counts) if matches!(row.verdict, Verdict::Wrong | Verdict::NotRun) => format!("{says} ({counts})"),
        (says, counts) => format!("{counts}: {says}"),
    }
}

fn counts(row: &Row) -> String {
    let number = |name: &str| row.counts.get(name).copied();
    let of = |name: &str, noun: &str| number(name).map(|count| plural(count, noun));
    // Numbers of passes come with those of values.
    let first = [
        of("configurations", "configuration"),
        of("cases", "case"),
        of("pipelines", "pipeline"),
        of("runs", "run"),
        of("passes", "pass"),
        of("components", "value"),
        of("values", "value"),
        of("hits", "hit"),
    ];
    let mut parts: Vec<String> = first.into_iter().flatten().collect();
    let others = [("tolerated", "differ by rounding"), ("undecided", "undecided"), ("differing", "differ in some bit")];
    for (name, words) in others {
        parts.extend(number(name).map(|count| format!("{} {words}", grouped(count))));
    }
    parts.join(", ")
}

fn plural(count: u64, noun: &str) -> String {
    let text = counted(count, noun);
    match text.split_once(' ') {
        Some((_, noun)) => format!("{} {noun}", grouped(count)),
        None => text,
    }
}

/// A line that begins so, continued below its text where it is too long.
fn wrapped(head: &str, text: &str) -> String {
    let indent = head.chars().count();
    let room = COLUMNS.saturating_sub(indent).max(20);
    let (mut lines, mut line) = (Vec::new(), String::new());
    for word in text.split(' ').flat_map(|word| pieces(word, room)) {
        if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > room {
            lines.push(std::mem::take(&mut line));
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line += &word;
    }
    lines.push(line);
    let all = lines.iter().enumerate().map(|(i, line)| match i {
        0 => format!("{head}{line}"),
        _ => format!("{:indent$}{line}", ""),
    });
    all.map(|line| line.trim_end().to_owned() + "\n").collect()
}

/// A word in pieces that fit a line.
fn pieces(word: &str, room: usize) -> Vec<String> {
    let letters: Vec<char> = word.chars().collect();
    letters.chunks(room).map(|piece| piece.iter().collect()).collect()
}
