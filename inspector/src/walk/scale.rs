//! A scale: round numbers (Heckbert, "Nice numbers for graph labels", Graphics Gems, 1990).

/// Values at round steps within a range, at most `most` of them, with the decimals that tell them apart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ticks {
    /// The values, ascending.
    pub values: Vec<f64>,
    /// Digits after the point.
    pub decimals: usize,
}

/// More digits are noise for a position on a screen.
const MOST_DECIMALS: usize = 9;

impl Ticks {
    /// For a range; empty if it has no length.
    #[must_use]
    pub fn of([from, to]: [f64; 2], most: usize) -> Self {
        let range = to - from;
        if !(range > 0.0 && range.is_finite() && from.is_finite() && most > 0) {
            return Self::default();
        }
        let rough = range / most as f64;
        let decade = 10f64.powf(rough.log10().floor());
        if !(decade > 0.0 && decade.is_finite()) {
            return Self::default();
        }
        let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|n| n * decade).find(|step| *step >= rough);
        let step = step.unwrap_or(10.0 * decade);
        let first = (from / step).ceil();
        // At most one more than asked for: both ends may be round.
        let count = (((to / step).floor() - first + 1.0).max(0.0) as usize).min(most + 1);
        // Fractions are divided by whole numbers: a tenth is no binary number, and its multiples drift.
        let whole = (1.0 / step).round();
        let value = |n: f64| if step < 1.0 && whole.is_finite() { n / whole } else { n * step };
        let values: Vec<f64> = (0..count).map(|i| value(first + i as f64)).collect();
        // Far from 0, the steps are smaller than the numbers can tell apart.
        if values.windows(2).any(|pair| pair[0] >= pair[1]) {
            return Self::default();
        }
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        Self { values, decimals: decimals.min(MOST_DECIMALS) }
    }

    /// A value as text.
    #[must_use]
    pub fn text(&self, value: f64) -> String {
        // No minus before a zero.
        format!("{:.*}", self.decimals, value + 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_few_and_told_apart() {
        for from in [-3.0, 0.0, 0.013, 0.7, 12.0, 4e3, 1e6] {
            for range in [1e-4, 0.03, 0.99, 1.0, 7.3, 250.0, 1e5] {
                for most in [1, 2, 5, 9] {
                    let ticks = Ticks::of([from, from + range], most);
                    let values = &ticks.values;
                    assert!(values.len() <= most + 1, "{from} {range} {most}: {values:?}");
                    assert!(
                        values.iter().all(|v| (from - range * 1e-9..=from + range * (1.0 + 1e-9)).contains(v)),
                        "{values:?}"
                    );
                    let texts: std::collections::BTreeSet<String> = values.iter().map(|&v| ticks.text(v)).collect();
                    assert_eq!(texts.len(), values.len(), "{texts:?}");
                    // A third of the wanted number at least: steps grow by at most 2.5.
                    assert!(values.len() + 1 >= most / 3, "{from} {range} {most}: {values:?}");
                    for (value, text) in values.iter().map(|&v| (v, ticks.text(v))) {
                        // The text is the value, not merely near it.
                        let read: f64 = text.parse().expect("a number");
                        assert!((read - value).abs() <= 1e-9 * value.abs().max(range), "{value} {text}");
                    }
                }
            }
        }
    }

    #[test]
    fn nothing_is_marked_on_a_scale_without_length() {
        for range in [[1.0, 1.0], [2.0, 1.0], [f64::NAN, 1.0], [0.0, f64::INFINITY], [1e300, 1.000_000_000_000_1e300]] {
            let ticks = Ticks::of(range, 5);
            assert!(ticks.values.len() <= 6 && ticks.values.windows(2).all(|p| p[0] < p[1]), "{range:?}");
        }
        assert!(Ticks::of([1.0, 1.0], 5).values.is_empty() && Ticks::of([0.0, 1.0], 0).values.is_empty());
    }
}
