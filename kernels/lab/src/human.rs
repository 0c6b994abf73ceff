//! Numbers for people, on pages: scaled units and few digits. Every number keeps the field of its CSV file in a `data`
//! element, so that pages can be compared with the files.

/// Three significant digits, with commas between thousands.
#[must_use]
pub fn digits(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude >= 1e15 || (magnitude > 0.0 && magnitude < 1e-4) {
        return format!("{value:.1e}");
    }
    if magnitude >= 100.0 {
        return thousands(value.round());
    }
    let decimals = match magnitude {
        m if m >= 10.0 => 1,
        m if m >= 1.0 => 2,
        0.0 => 0,
        m => (2.0 - m.log10().floor()) as usize,
    };
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A whole number with commas between thousands.
#[must_use]
pub fn thousands(value: f64) -> String {
    let sign = if value < 0.0 { "−" } else { "" };
    format!("{sign}{}", in_groups(&format!("{:.0}", value.abs())))
}

/// A count with commas between thousands.
#[must_use]
pub fn grouped(count: u64) -> String {
    in_groups(&count.to_string())
}

/// Digits in groups of three.
fn in_groups(digits: &str) -> String {
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// 1, 2 or 5 times a power of ten, and at least this: a step of an axis.
#[must_use]
pub fn round_up(least: f64) -> f64 {
    let least = if least.is_finite() { least.max(1e-12) } else { 1.0 };
    let power = 10f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0].map(|m| m * power).into_iter().find(|step| *step >= least * (1.0 - 1e-9)).unwrap_or(10.0 * power)
}

/// A time in the unit that suits it: "120 ns", "4.4 ms".
#[must_use]
pub fn time(ns: f64) -> String {
    let units = [(1e9, "s"), (1e6, "ms"), (1e3, "µs"), (1.0, "ns")];
    let (scale, unit) = units.into_iter().find(|(scale, _)| ns.abs() >= *scale).unwrap_or((1.0, "ns"));
    format!("{} {unit}", digits(ns / scale))
}

/// Bytes in the unit that suits them: "58.4 MiB".
#[must_use]
pub fn bytes(count: f64) -> String {
    let units = [(1024.0 * 1024.0 * 1024.0, "GiB"), (1024.0 * 1024.0, "MiB"), (1024.0, "KiB"), (1.0, "bytes")];
    let (scale, unit) = units.into_iter().find(|(scale, _)| count >= *scale).unwrap_or((1.0, "B"));
    format!("{} {unit}", digits(count / scale))
}

/// Two significant digits: an upper bound is rounded up, a lower one down.
fn two_digits(column: &str, value: f64) -> f64 {
    // What is left of rounding in a quotient that is whole.
    const SLACK: f64 = 1e-9;
    let unit = 10_f64.powf(value.log10().floor() - 1.0);
    let units = value / unit;
    let units = match column {
        c if c.ends_with("_high") || c.starts_with("most_") => (units - SLACK).ceil(),
        c if c.ends_with("_low") => (units + SLACK).floor(),
        _ => units.round(),
    };
    units * unit
}

/// A field in the form that its column's name asks for.
pub(crate) fn field(column: &str, text: &str) -> String {
    let Ok(value) = text.parse::<f64>() else { return text.to_owned() };
    match column.strip_suffix("_with").unwrap_or(column) {
        c if c.ends_with("_ns") || c.starts_with("ns_") => time(value),
        c if c.ends_with("_s") => time(value * 1e9),
        c if c.ends_with("_bytes") || c.contains("_bytes_") => bytes(value),
        c if c.contains("per_million") && value > 0.0 => digits(two_digits(c, value)),
        _ if text.bytes().all(|b| b.is_ascii_digit()) => thousands(value),
        _ => digits(value),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_rounded_outwards() {
        let shown = ["wrong_per_million", "wrong_per_million_low", "wrong_per_million_high", "most_wrong_per_million"];
        assert_eq!(shown.map(|column| field(column, "182.828")), ["180", "180", "190", "190"]);
        assert_eq!(shown.map(|column| field(column, "2970")), ["3,000", "2,900", "3,000", "3,000"]);
        assert_eq!(shown.map(|column| field(column, "81")), ["81"; 4]);
    }

    #[test]
    fn steps_of_axes_are_rounded_up() {
        assert_eq!([0.3, 1.0, 1.2, 4.0, 6.0, 70.0].map(round_up), [0.5, 1.0, 2.0, 5.0, 10.0, 100.0]);
        assert!(round_up(f64::NAN) > 0.0 && round_up(0.0) > 0.0);
    }

    #[test]
    fn numbers_have_few_digits_and_the_unit_that_suits_them() {
        let shown = [0.0, 0.0001234, 0.5, 1.0, 3.15159, 42.0, 120.4, 36864.0, -1516200000.0, 1e-9];
        let expected = ["0", "0.000123", "0.5", "1", "3.15", "42", "120", "36,864", "−1,516,200,000", "1.0e-9"];
        assert_eq!(shown.map(digits), expected);
        let counts = [0, 12, 999, 1000, 262_144, 1_000_000, u64::MAX].map(grouped);
        assert_eq!(counts, ["0", "12", "999", "1,000", "262,144", "1,000,000", "18,446,744,073,709,551,615"]);
        assert_eq!(
            [120.3, 4.43e6, 1.5162e9, 0.5, 23681.6].map(time),
            ["120 ns", "4.43 ms", "1.52 s", "0.5 ns", "23.7 µs"]
        );
        assert_eq!([61_234_567.0, 512.0].map(bytes), ["58.4 MiB", "512 bytes"]);
        assert_eq!(field("judged_rays", "36864"), "36,864");
        assert_eq!(field("build_s", "0.0044"), "4.4 ms");
        assert_eq!(field("accelerator", "bvh"), "bvh");
        assert_eq!(field("median_ns", "120"), "120 ns");
    }
}
