//! Formats numbers and tables.

/// Three significant digits; whole numbers below a million in full.
pub(super) fn number(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return if x == 0.0 { "0".into() } else { "–".into() };
    }
    let digits = (2 - x.abs().log10().floor() as i32).clamp(0, 6) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

/// Nanoseconds with a unit.
pub(super) fn time(ns: f64) -> String {
    match ns {
        ns if ns < 1e3 => format!("{} ns", number(ns)),
        ns if ns < 1e6 => format!("{} µs", number(ns / 1e3)),
        ns if ns < 1e9 => format!("{} ms", number(ns / 1e6)),
        ns => format!("{} s", number(ns / 1e9)),
    }
}

/// With k and M from a thousand up.
pub(super) fn count(x: f64) -> String {
    match x {
        x if x < 1e3 => number(x),
        x if x < 1e6 => format!("{}k", number(x / 1e3)),
        x => format!("{}M", number(x / 1e6)),
    }
}

pub(super) fn percent(share: f64) -> String {
    format!("{} %", number(share * 100.0))
}

/// A value or a dash.
pub(super) fn or_dash(value: Option<f64>, text: fn(f64) -> String) -> String {
    value.map_or("–".into(), text)
}

/// A Markdown table; the first column is text, the others are numbers.
pub(super) fn table(columns: &[String], rows: &[Vec<String>]) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let rule: Vec<String> = (0..columns.len()).map(|i| if i == 0 { "---" } else { "---:" }.into()).collect();
    let mut text = line(columns) + &line(&rule);
    rows.iter().for_each(|row| text += &line(row));
    text + "\n"
}

/// Names of columns.
pub(super) fn columns(names: &[&str]) -> Vec<String> {
    names.iter().map(|&name| name.to_owned()).collect()
}

/// Distinct values in order of first appearance.
pub(super) fn distinct<T: PartialEq>(values: impl IntoIterator<Item = T>) -> Vec<T> {
    values.into_iter().fold(Vec::new(), |mut all, value| {
        if !all.contains(&value) {
            all.push(value);
        }
        all
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits_and_a_unit() {
        let texts = [1.0, 12.34, 0.012_345, 123_456.0, 0.0, 100.0].map(number);
        assert_eq!(texts, ["1", "12.3", "0.0123", "123456", "0", "100"]);
        assert_eq!([950.0, 1.5e3, 2.0e6, 79e9].map(time), ["950 ns", "1.5 µs", "2 ms", "79 s"]);
        assert_eq!([26.0, 32_768.0, 1e7].map(count), ["26", "32.8k", "10M"]);
    }
}
