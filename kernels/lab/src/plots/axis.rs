//! An axis: its range, positions of values, and labels.

/// How values map to positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// Evenly, over the values only: for ratios, whose 0 is as far as infinity.
    Ratio,
    /// Logarithmic; values that are not above 0 are not shown.
    Log,
    /// Logarithmic, with a place for 0 below the lowest decade.
    LogWithZero,
}

impl Scale {
    /// Whether the axis can show a value.
    pub(super) fn has(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Linear | Self::Ratio => true,
                Self::Log => value > 0.0,
                Self::LogWithZero => value >= 0.0,
            }
    }
}

/// What an axis shows.
#[derive(Clone, Debug)]
pub struct Axis {
    /// The label, with its unit.
    pub label: String,
    /// How values map to positions.
    pub scale: Scale,
    /// Formats a value.
    pub text: fn(f64) -> String,
}

/// An axis with its range.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ranged {
    scale: Scale,
    text: fn(f64) -> String,
    /// Range; as logarithms if the scale is logarithmic.
    low: f64,
    high: f64,
}

/// Maximum number of labels.
const MOST: usize = 9;

impl Axis {
    /// An axis with numbers written as short as possible.
    #[must_use]
    pub fn new(label: impl Into<String>, scale: Scale) -> Self {
        Self { label: label.into(), scale, text: short }
    }

    /// The range from the smallest to the largest value that the axis can show.
    pub(super) fn over(&self, values: impl Iterator<Item = f64>) -> Ranged {
        let (scale, text) = (self.scale, self.text);
        let values: Vec<f64> = values.filter(|&v| scale.has(v)).collect();
        let span = |values: &mut dyn Iterator<Item = f64>| {
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (f64::min(l, v), f64::max(h, v)))
        };
        if values.is_empty() {
            return Ranged { scale, text, low: 0.0, high: 1.0 };
        }
        if scale == Scale::Ratio {
            let (low, high) = span(&mut values.into_iter());
            let room = (0.04 * (high - low)).max(0.01);
            return Ranged { scale, text, low: low - room, high: high + room };
        }
        if scale == Scale::Linear {
            let (low, high) = span(&mut values.into_iter());
            // Start at 0 if that is not far.
            let low = if low > 0.0 && (low < 0.6 * high || low == high) { 0.0 } else { low };
            let room = if high > low { 0.04 * (high - low) } else { 0.5 * high.abs().max(1.0) };
            let low = if low == 0.0 { 0.0 } else { low - room };
            return Ranged { scale, text, low, high: high + room };
        }
        let (low, high) = span(&mut values.into_iter().filter(|&v| v > 0.0).map(f64::log10));
        if scale == Scale::LogWithZero {
            // If all values are zero, any decade will do.
            let (low, high) = if low.is_finite() { (low, high) } else { (0.0, 0.0) };
            return Ranged { scale, text, low: (low + 1e-9).floor() - 1.0, high: high + 0.15 };
        }
        let room = (0.04 * (high - low)).max(0.06);
        Ranged { scale, text, low: low - room, high: high + room }
    }
}

impl Ranged {
    /// The position of a value, from 0 to 1.
    pub(super) fn part(&self, value: f64) -> f64 {
        let value = match self.scale {
            Scale::Linear | Scale::Ratio => value,
            Scale::LogWithZero if value <= 0.0 => self.low,
            Scale::Log | Scale::LogWithZero => value.max(f64::MIN_POSITIVE).log10(),
        };
        ((value - self.low) / (self.high - self.low)).clamp(0.0, 1.0)
    }

    /// Values with their labels: as many as fit.
    pub(super) fn ticks(&self, do_fit: impl Fn(&[(f64, String)]) -> bool) -> Vec<(f64, String)> {
        let labelled = |values: Vec<f64>| -> Vec<(f64, String)> {
            let zero = (self.scale == Scale::LogWithZero).then_some(0.0);
            zero.into_iter().chain(values).map(|v| (v, (self.text)(v))).collect()
        };
        let sets = match self.scale {
            Scale::Linear | Scale::Ratio => even([self.low, self.high]),
            Scale::Log | Scale::LogWithZero => self.decades(),
        };
        let mut ticks = Vec::new();
        for set in sets {
            ticks = labelled(set);
            if ticks.len() <= MOST && do_fit(&ticks) {
                return ticks;
            }
        }
        while ticks.len() > 1 && !do_fit(&ticks) {
            ticks = ticks.into_iter().step_by(2).collect();
        }
        ticks
    }

    /// Powers of ten, with some multiples of them, the most first; at last powers with some omitted.
    fn decades(&self) -> Vec<Vec<f64>> {
        // The lowest decade is the place for 0.
        let low = if self.scale == Scale::LogWithZero { self.low + 1.0 } else { self.low };
        let is_in = |v: &f64| (low - 1e-9..=self.high + 1e-9).contains(&v.log10());
        let (first, last) = (self.low.floor() as i32, self.high.ceil() as i32);
        let of = |multiples: &[f64]| -> Vec<f64> {
            let power = |k: i32| multiples.iter().map(move |m| m * 10f64.powi(k));
            (first..=last).flat_map(power).filter(is_in).collect()
        };
        let multiples = [&[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0][..], &[1.0, 2.0, 5.0], &[1.0, 3.0], &[1.0]].map(of);
        let [.., powers] = &multiples;
        // Multiples that include 10⁰, so that 1 is labelled.
        let every = |step: i64| powers.iter().copied().filter(|v| v.log10().round() as i64 % step == 0).collect();
        let fewer: Vec<Vec<f64>> = [2, 3, 5, 10, 20, 50, 100].map(every).into();
        // With 0, one more is enough.
        let is_useful = |set: &Vec<f64>| set.len() > usize::from(self.scale == Scale::Log);
        let mut sets: Vec<Vec<f64>> = multiples.into_iter().chain(fewer).filter(is_useful).collect();
        // Within a decade there may be one of them or none.
        if self.high - low < 1.0 {
            sets.extend(even([low, self.high].map(|power| 10f64.powf(power))).into_iter().filter(is_useful));
        }
        sets
    }
}

/// Multiples of 1, 2 or 5 times a power of ten, the most first.
fn even([low, high]: [f64; 2]) -> Vec<Vec<f64>> {
    // More are not read.
    const MOST_STEPS: f64 = 50.0;
    let of = |parts: f64| -> Vec<f64> {
        let rough = (high - low) / parts;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|&s| s >= rough).unwrap_or(rough);
        let (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
        let count = last - first;
        // Neither where the range is as large as numbers get.
        if !(0.0..=MOST_STEPS).contains(&count) {
            return Vec::new();
        }
        (0..=count as u32).map(|i| (first + f64::from(i)) * step).collect()
    };
    [6.0, 4.0, 3.0, 2.0].map(of).into_iter().filter(|set| !set.is_empty()).collect()
}

/// A number written as short as possible.
fn short(value: f64) -> String {
    let magnitude = value.abs();
    // Multiples of 0.1 are not exact in binary.
    let rounded = format!("{value:.3e}").parse().unwrap_or(value);
    match magnitude {
        0.0 => "0".into(),
        m if !(1e-4..1e9).contains(&m) => format!("{rounded:e}"),
        m if m >= 1e6 => format!("{}M", rounded / 1e6),
        m if m >= 1e4 => format!("{}k", rounded / 1e3),
        _ => format!("{rounded}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: Scale, values: &[f64]) -> Vec<String> {
        let axis = Axis::new("", scale);
        axis.over(values.iter().copied()).ticks(|_| true).into_iter().map(|t| t.1).collect()
    }

    #[test]
    fn labels_are_few_and_round() {
        assert_eq!(labels(Scale::Linear, &[3.0, 97.0]), ["0", "20", "40", "60", "80", "100"]);
        assert_eq!(labels(Scale::Log, &[1.0, 1000.0]), ["1", "3", "10", "30", "100", "300", "1000"]);
        let wide = labels(Scale::Log, &[1e-20, 1e20]);
        assert!(wide.len() <= MOST && wide.contains(&"1".into()) && wide.contains(&"1e-20".into()), "{wide:?}");
        const LONG: [&str; 9] = ["0", "100", "200", "500", "1000", "2000", "5000", "10k", "20k"];
        assert_eq!(labels(Scale::LogWithZero, &[0.0, 0.0]), ["0", "1"]);
        assert_eq!(labels(Scale::LogWithZero, &[0.0, 150.0, 20_000.0]), LONG);
        for (scale, values) in [(Scale::Linear, [0.0, 0.0]), (Scale::Log, [7.0, 7.0]), (Scale::Log, [1.3, 1.9])] {
            let labels = labels(scale, &values);
            assert!((1..=MOST + 1).contains(&labels.len()), "{labels:?}");
        }
    }

    #[test]
    fn values_lie_where_they_should() {
        let log = Axis::new("", Scale::Log).over([1.0, 100.0].into_iter());
        assert!((log.part(10.0) - 0.5).abs() < 1e-12);
        let zero = Axis::new("", Scale::LogWithZero).over([0.0, 100.0].into_iter());
        assert_eq!(zero.part(0.0), 0.0);
        assert!(zero.part(100.0) > zero.part(0.0));
        assert!(!Scale::Log.has(0.0) && Scale::LogWithZero.has(0.0) && !Scale::Linear.has(f64::NAN));
    }
}
