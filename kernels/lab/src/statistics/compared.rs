//! The one rule by which a time is called faster or slower than another.

use super::interval::Interval;

/// A ratio whose whole interval lies within this factor of 1 is none: both are as fast. Less is within what a restart
/// of the program changes.
pub const EQUIVALENT: f64 = 1.05;

/// What a 95% interval of a ratio of times, this one's to another's, allows to say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compared {
    /// All of it lies below 1.
    Faster,
    /// All of it lies above 1.
    Slower,
    /// It contains 1, and both ends are so near that a difference does not matter: a test of equivalence by both of its
    /// ends (Schuirmann 1987) at 2.5%.
    AsFast,
    /// It contains 1, and much else: which of the two is faster is not known.
    NotDistinguishable,
    /// There is no interval: too few runs.
    Unknown,
}

impl Compared {
    /// By the ends of the interval, if there is one.
    #[must_use]
    pub fn of(ends: Option<[f64; 2]>) -> Self {
        match ends {
            Some([low, high]) if low.is_nan() || high.is_nan() => Self::Unknown,
            Some([_, high]) if high < 1.0 => Self::Faster,
            Some([low, _]) if low > 1.0 => Self::Slower,
            Some([low, high]) if low >= 1.0 / EQUIVALENT && high <= EQUIVALENT => Self::AsFast,
            Some(_) => Self::NotDistinguishable,
            None => Self::Unknown,
        }
    }

    /// By an interval, if there is one.
    #[must_use]
    pub fn of_interval(interval: Option<Interval>) -> Self {
        Self::of(interval.map(|interval| [interval.low, interval.high]))
    }

    /// In words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Faster => "faster",
            Self::Slower => "slower",
            Self::AsFast => "as fast",
            Self::NotDistinguishable => "not distinguishable",
            Self::Unknown => "too few runs to compare",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_an_interval_tells_times_apart_and_only_a_narrow_one_calls_them_alike() {
        use Compared::{AsFast, Faster, NotDistinguishable, Slower, Unknown};
        for (low, high, expected) in [
            (0.8, 0.9, Faster),
            (0.5, 0.999, Faster),
            (1.1, 1.2, Slower),
            (1.001, 1.002, Slower),
            (0.99, 1.01, AsFast),
            (1.0, 1.0, AsFast),
            (1.0, 1.05, AsFast),
            (0.9, 1.01, NotDistinguishable),
            (0.99, 1.2, NotDistinguishable),
            (1.0, 1.2, NotDistinguishable),
            (0.21, 1.79, NotDistinguishable),
            (f64::NAN, 0.5, Unknown),
        ] {
            assert_eq!(Compared::of(Some([low, high])), expected, "{low} to {high}");
        }
        assert_eq!(Compared::of(None), Unknown);
    }
}
