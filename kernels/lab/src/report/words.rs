//! Phrases that sections share: medians with their intervals, in words.

use super::page::number;
use crate::statistics::Compared;
use crate::tidy::Row;

/// A median with its interval: "0.93 (95% interval 0.9 to 0.97)".
pub(super) fn with_interval(column: &str, row: &Row) -> String {
    let [low, high] = ["low", "high"].map(|end| end_of(column, end));
    let median = number(column, row);
    match row.number(&low).zip(row.number(&high)) {
        Some(_) => format!("{median} (95% interval {} to {})", number(&low, row), number(&high, row)),
        None => format!("{median} (no interval: too few runs)"),
    }
}

/// The column of an end of an interval: `low_ns` of `median_ns`, else the column's name with the end after it.
fn end_of(column: &str, end: &str) -> String {
    if column == "median_ns" { format!("{end}_ns") } else { format!("{column}_{end}") }
}

/// Compares a row's time with that of the configuration in `ratio_to`.
pub(super) fn compared(column: &str, row: &Row) -> Compared {
    let [low, high] = ["low", "high"].map(|end| row.number(&end_of(column, end)));
    Compared::of(low.zip(high).map(|(low, high)| [low, high]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLUMNS: &[&str] =
        columns![schema_version time_ratio time_ratio_low time_ratio_high median_ns low_ns high_ns];

    #[test]
    fn a_median_is_told_with_its_interval() {
        let row = Row::new(COLUMNS).set("median_ns", 2e6).set("low_ns", 1e6).set("high_ns", 3e6);
        let text = with_interval("median_ns", &row);
        assert!(text.contains(">2 ms<") && text.contains(">1 ms<") && text.contains(">3 ms<"), "{text}");
        assert!(with_interval("time_ratio", &row.set("time_ratio", 2.0)).contains("no interval"));
    }
}
