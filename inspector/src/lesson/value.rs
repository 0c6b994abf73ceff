//! Values that a text shows.

use std::fmt;

use raystep_kernels::plan::Bytes;
use raystep_lab::human::grouped;

/// Whose clock a time is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// The device's, which is known to be right.
    Device,
    /// The host's: it includes the wait for a device.
    Host,
}

/// A value, as it is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Value {
    text: String,
    number: Option<f64>,
    clock: Option<Clock>,
}

impl Value {
    /// A text.
    #[must_use]
    pub fn text(text: impl Into<String>) -> Self {
        Self { text: text.into(), number: None, clock: None }
    }

    /// A number of things.
    #[must_use]
    pub fn count(count: u64) -> Self {
        Self { text: grouped(count), number: Some(count as f64), clock: None }
    }

    /// A float of a stream, with all its digits.
    #[must_use]
    pub fn single(value: f32) -> Self {
        // No minus before a zero, and no row of zeros.
        let value = value + 0.0;
        let text = if value != 0.0 && value.abs() < 1e-4 { format!("{value:e}") } else { value.to_string() };
        Self { text, number: Some(value.into()), clock: None }
    }

    /// A float of the reference, with all its digits.
    #[must_use]
    pub fn double(value: f64) -> Self {
        Self { text: format!("{value:?}"), number: Some(value), clock: None }
    }

    /// A small difference, with two digits.
    #[must_use]
    pub fn small(value: f64) -> Self {
        let size = value.abs();
        let text = match size {
            0.0 => "0".into(),
            0.001..1000.0 => {
                let digits = (1.0 - size.log10().floor()).max(0.0) as usize;
                format!("{value:.digits$}")
            }
            _ => format!("{value:.1e}"),
        };
        Self { text, number: Some(value), clock: None }
    }

    /// A part of a whole.
    #[must_use]
    pub fn share(part: f64) -> Self {
        let percent = part * 100.0;
        let text = if percent < 9.95 { format!("{percent:.1}%") } else { format!("{percent:.0}%") };
        Self { text, number: Some(part), clock: None }
    }

    /// An amount of memory.
    #[must_use]
    pub fn bytes(bytes: u64) -> Self {
        Self { text: Bytes(bytes).to_string(), number: Some(bytes as f64), clock: None }
    }

    /// A ratio.
    #[must_use]
    pub fn ratio(value: f64) -> Self {
        let digits = match value.abs() {
            size if size >= 100.0 => 0,
            size if size >= 10.0 => 1,
            _ => 2,
        };
        Self { text: format!("{value:.digits$}"), number: Some(value), clock: None }
    }

    /// A time, and whose clock it is from.
    #[must_use]
    pub fn time(ns: u64, clock: Clock) -> Self {
        let whose = match clock {
            Clock::Device => "",
            Clock::Host => " (host time)",
        };
        Self { text: duration(ns) + whose, number: Some(ns as f64), clock: Some(clock) }
    }

    /// The number, if it is one.
    #[must_use]
    pub fn number(&self) -> Option<f64> {
        self.number
    }

    /// Whose clock it is from, if it is a time.
    #[must_use]
    pub fn clock(&self) -> Option<Clock> {
        self.clock
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// A duration in a readable unit.
fn duration(ns: u64) -> String {
    match ns {
        0..1_000_000 => format!("{:.1} µs", ns as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} ms", ns as f64 / 1e6),
        _ => format!("{:.2} s", ns as f64 / 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_readable() {
        let texts = [0, 7, 999, 1000, 65_536, 4_784_128].map(|n| Value::count(n).to_string());
        assert_eq!(texts, ["0", "7", "999", "1,000", "65,536", "4,784,128"]);
        assert_eq!(Value::share(0.0312).to_string(), "3.1%");
        assert_eq!(Value::share(0.998).to_string(), "100%");
        assert_eq!(Value::ratio(6.268).to_string(), "6.27");
        assert_eq!(Value::ratio(62.68).to_string(), "62.7");
        let single = [0.646_017_73, -0.0, 9.536_743e-7].map(|value| Value::single(value).to_string());
        assert_eq!(single, ["0.64601773", "0", "9.536743e-7"]);
        let small = [-0.000_012, 0.0, 0.038_36, -1.26, 12.6, 1e9].map(|value| Value::small(value).to_string());
        assert_eq!(small, ["-1.2e-5", "0", "0.038", "-1.3", "13", "1.0e9"]);
        assert_eq!(Value::time(12_345_678, Clock::Device).to_string(), "12.3 ms");
        assert_eq!(Value::time(12_345_678, Clock::Host).to_string(), "12.3 ms (host time)");
    }
}
