//! Times with their spread, and ratios of times with intervals.

use raystep_lab::statistics::interval::{FEWEST, Interval, of_ratio};
use raystep_lab::statistics::median;

use super::measure::{Measured, Repeat};

/// Fewest repeats for which a ratio has an interval.
pub const FEWEST_REPEATS: usize = FEWEST;

/// What is timed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Timed<'a> {
    /// All passes of a kernel, on the device's clock.
    Kernel(&'a str),
    /// All passes, on the device's clock.
    Device,
    /// The whole run, on the host's clock.
    Host,
}

impl Timed<'_> {
    fn of(self, repeat: &Repeat) -> Option<u64> {
        match self {
            Self::Kernel(name) => repeat.kernels.iter().find(|(kernel, _)| *kernel == name)?.1,
            Self::Device => repeat.device_ns,
            Self::Host => repeat.host_ns,
        }
    }

    /// Its times, in ns; none unless every repeat has one.
    fn all(self, measured: &Measured) -> Vec<f64> {
        let times: Option<Vec<u64>> = measured.repeats.iter().map(|repeat| self.of(repeat)).collect();
        times.unwrap_or_default().into_iter().map(|ns| ns as f64).collect()
    }
}

/// The median of times, and their range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// The median, ns.
    pub median: f64,
    /// The shortest time, ns.
    pub min: f64,
    /// The longest time, ns.
    pub max: f64,
    /// Number of times.
    pub count: usize,
}

impl Spread {
    /// Of a run; `None` if it has no such times.
    #[must_use]
    pub fn of(timed: Timed<'_>, measured: &Measured) -> Option<Self> {
        let times = timed.all(measured);
        let (min, max) = times.iter().fold((f64::INFINITY, 0.0f64), |(min, max), &t| (min.min(t), max.max(t)));
        Some(Self { median: median(&times)?, min, max, count: times.len() })
    }
}

/// How many times as long a run takes as another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ratio {
    /// The median of the ratios of pairs; of runs that were not measured together, the ratio of their medians.
    pub ratio: f64,
    /// The interval of the median, where runs were measured together, often enough.
    pub interval: Option<Interval>,
    /// Whether the runs were measured together.
    pub is_paired: bool,
}

impl Ratio {
    /// Of a run to the reference; `None` if one of them has no such times, or took none.
    #[must_use]
    pub fn of(timed: Timed<'_>, run: &Measured, reference: &Measured) -> Option<Self> {
        let (ours, theirs) = (timed.all(run), timed.all(reference));
        let is_paired = run.together == reference.together && ours.len() == theirs.len();
        if is_paired {
            let pairs: Vec<(f64, f64)> = ours.into_iter().zip(theirs).collect();
            let ratios: Vec<f64> = pairs.iter().filter(|(_, b)| *b > 0.0).map(|(a, b)| a / b).collect();
            // The seed makes no difference below twenty pairs, and little above.
            let interval = of_ratio(&pairs, 1);
            let ratio = interval.map(|interval| interval.median).or_else(|| median(&ratios))?;
            return Some(Self { ratio, interval, is_paired });
        }
        let ratio = median(&ours)? / median(&theirs).filter(|&ns| ns > 0.0)?;
        Some(Self { ratio, interval: None, is_paired })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(together: u64, times: &[u64]) -> Measured {
        let repeat = |&ns: &u64| Repeat {
            kernels: vec![("walk", Some(ns)), ("shade", None)],
            device_ns: None,
            host_ns: Some(2 * ns),
        };
        Measured { together, repeats: times.iter().map(repeat).collect(), why_no_times: None }
    }

    #[test]
    fn a_spread_is_the_median_and_the_range_of_what_was_timed_every_time() {
        let run = measured(1, &[30, 10, 20, 50, 40]);
        let spread = Spread::of(Timed::Kernel("walk"), &run).expect("times");
        assert_eq!((spread.median, spread.min, spread.max, spread.count), (30.0, 10.0, 50.0, 5));
        assert_eq!(Spread::of(Timed::Host, &run).map(|spread| spread.median), Some(60.0));
        for none in [Timed::Kernel("shade"), Timed::Kernel("absent"), Timed::Device] {
            assert_eq!(Spread::of(none, &run), None, "{none:?}");
        }
        assert_eq!(Spread::of(Timed::Host, &measured(1, &[])), None);
    }

    #[test]
    fn ratios_are_of_pairs_where_runs_took_turns_and_have_an_interval_from_six_on() {
        // The machine is half as fast in the second half: medians alone would see another ratio.
        let (a, b) = (measured(7, &[10, 12, 11, 22, 20, 24]), measured(7, &[5, 6, 5, 11, 10, 12]));
        let ratio = Ratio::of(Timed::Host, &a, &b).expect("a ratio");
        let interval = ratio.interval.expect("an interval");
        assert!(ratio.is_paired && (ratio.ratio - 2.0).abs() < 1e-9, "{ratio:?}");
        assert!((interval.low - 2.0).abs() < 1e-9 && (interval.high - 2.2).abs() < 1e-9, "{interval:?}");
        let five = Ratio::of(Timed::Host, &measured(7, &[10; 5]), &measured(7, &[5; 5])).expect("a ratio");
        assert_eq!((five.ratio, five.interval, five.is_paired), (2.0, None, true));
        let apart = Ratio::of(Timed::Host, &measured(8, &[10; 6]), &b).expect("a ratio");
        assert_eq!((apart.ratio, apart.interval, apart.is_paired), (10.0 / 8.0, None, false));
        assert_eq!(Ratio::of(Timed::Device, &a, &b), None);
        assert_eq!(Ratio::of(Timed::Host, &a, &measured(7, &[0; 6])), None, "the reference takes no time");
    }
}
