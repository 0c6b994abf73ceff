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
    /// Categories: value 1 is the first of these names, and so on.
    Names(&'static [&'static str]),
}

impl Scale {
    /// Whether the axis can show a value.
    pub(super) fn has(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Linear | Self::Ratio | Self::Names(_) => true,
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
        if let Scale::Names(names) = scale {
            return Ranged { scale, text, low: 0.5, high: names.len() as f64 + 0.5 };
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
            Scale::Linear | Scale::Ratio | Scale::Names(_) => value,
            Scale::LogWithZero if value <= 0.0 => self.low,
            Scale::Log | Scale::LogWithZero => value.max(f64::MIN_POSITIVE).log10(),
        };
        ((value - self.low) / (self.high - self.low)).clamp(0.0, 1.0)
    }

    /// Values with their labels.
    pub(super) fn ticks(&self) -> Vec<(f64, String)> {
        let mut values = match self.scale {
            Scale::Names(names) => return (1..).map(f64::from).zip(names.iter().map(|&n| n.to_owned())).collect(),
            Scale::Linear | Scale::Ratio => self.even(),
            Scale::Log | Scale::LogWithZero => self.decades(),
        };
        if self.scale == Scale::LogWithZero {
            values.insert(0, 0.0);
        }
        values.into_iter().map(|v| (v, (self.text)(v))).collect()
    }

    /// Multiples of 1, 2 or 5 times a power of ten.
    fn even(&self) -> Vec<f64> {
        let rough = (self.high - self.low) / 6.0;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|&s| s >= rough).unwrap_or(rough);
        let (first, last) = ((self.low / step - 1e-9).ceil() as i64, (self.high / step + 1e-9).floor() as i64);
        (first..=last).map(|i| i as f64 * step).collect()
    }

    /// Powers of ten; with 2 and 5 times these if there are few, with some omitted if there are many.
    fn decades(&self) -> Vec<f64> {
        // The lowest decade is the place for 0.
        let low = if self.scale == Scale::LogWithZero { self.low + 1.0 } else { self.low };
        let is_in = |v: &f64| (low - 1e-9..=self.high + 1e-9).contains(&v.log10());
        let (first, last) = (self.low.floor() as i32, self.high.ceil() as i32);
        let of = |multiples: &[f64]| -> Vec<f64> {
            let power = |k: i32| multiples.iter().map(move |m| m * 10f64.powi(k));
            (first..=last).flat_map(power).filter(is_in).collect()
        };
        for multiples in [&[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0][..], &[1.0, 2.0, 5.0], &[1.0, 3.0]] {
            let ticks = of(multiples);
            if ticks.len() <= MOST {
                return ticks;
            }
        }
        let powers = of(&[1.0]);
        let every = powers.len().div_ceil(MOST);
        // Multiples that include 10⁰, so that 1 is labelled.
        powers.into_iter().filter(|v| v.log10().round() as i64 % every as i64 == 0).collect()
    }
}

/// A number written as short as possible.
fn short(value: f64) -> String {
    let magnitude = value.abs();
    // Multiples of 0.1 are not exact in binary.
    let rounded = format!("{value:.3e}").parse().unwrap_or(value);
    match magnitude {
        0.0 => "0".into(),
        m if !(1e-4..1e6).contains(&m) => format!("{rounded:e}"),
        m if m >= 1e4 => format!("{}k", rounded / 1e3),
        _ => format!("{rounded}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: Scale, values: &[f64]) -> Vec<String> {
        let axis = Axis::new("", scale);
        axis.over(values.iter().copied()).ticks().into_iter().map(|t| t.1).collect()
    }

    #[test]
    fn labels_are_few_and_round() {
        assert_eq!(labels(Scale::Linear, &[3.0, 97.0]), ["0", "20", "40", "60", "80", "100"]);
        assert_eq!(labels(Scale::Log, &[1.0, 1000.0]), ["1", "3", "10", "30", "100", "300", "1000"]);
        let wide = labels(Scale::Log, &[1e-20, 1e20]);
        assert!(wide.len() <= MOST && wide.contains(&"1".into()) && wide.contains(&"1e-20".into()), "{wide:?}");
        const LONG: [&str; 9] = ["0", "100", "200", "500", "1000", "2000", "5000", "10k", "20k"];
        assert_eq!(labels(Scale::LogWithZero, &[0.0, 0.0]), ["0", "1"]);
        assert_eq!(labels(Scale::Names(&["a", "b"]), &[1.0]), ["a", "b"]);
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
