//! Axes: positions of shares and times, and tick marks.

use raystep_lab::human::round_up;

/// Points at the bottom of a logarithmic axis, between its smallest power of ten and zero.
const TO_NONE: f32 = 14.0;

/// A share in percent, with as many digits as necessary.
pub(super) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent == 0.0 || percent >= 0.995 {
        return format!("{}%", (100.0 * percent).round() / 100.0);
    }
    let digits = (-percent.log10()).ceil() as usize + 1;
    let text = format!("{percent:.digits$}");
    format!("{}%", text.trim_end_matches('0').trim_end_matches('.'))
}

/// The vertical axis: shares of 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shares {
    /// Linear.
    Linear,
    /// Logarithmic, down to 10 to the power of minus this; zero is below it.
    Log(i32),
}

impl Shares {
    /// An axis that resolves one ray out of this many.
    pub(super) fn of(rays: u64, is_log: bool) -> Self {
        if is_log { Self::Log((rays.max(10) as f64).log10().ceil() as i32) } else { Self::Linear }
    }

    /// Height of a share in a plot area of this height, points.
    pub(super) fn above(self, share: f64, height: f32) -> f32 {
        match self {
            Self::Linear => share.clamp(0.0, 1.0) as f32 * height,
            Self::Log(_) if share <= 0.0 => 0.0,
            Self::Log(powers) => {
                let part = (1.0 + share.log10() / f64::from(powers)).clamp(0.0, 1.0);
                TO_NONE + part as f32 * (height - TO_NONE)
            }
        }
    }

    /// Tick marks for a plot area of this height, no closer than the height of their labels.
    pub(super) fn marks(self, height: f32) -> Vec<f64> {
        const APART: f32 = 14.0;
        match self {
            Self::Linear => {
                let parts = [10, 5, 4, 2].into_iter().find(|&parts| height / parts as f32 >= 2.0 * APART).unwrap_or(1);
                (0..=parts).map(|i| f64::from(i) / f64::from(parts)).collect()
            }
            Self::Log(powers) => {
                let room = ((height - TO_NONE) / powers as f32).max(1e-3);
                let every = (APART / room).ceil().max(1.0) as usize;
                let marked = (0..=powers).step_by(every).map(|power| 10f64.powi(-power));
                std::iter::once(0.0).chain(marked).collect()
            }
        }
    }
}

/// The unit of the horizontal axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Unit {
    /// Its name.
    pub(super) name: &'static str,
    /// Smallest units per unit.
    pub(super) of: f64,
}

impl Unit {
    /// Passes.
    pub(super) const PASSES: Self = Self { name: "passes", of: 1.0 };

    /// The unit for times up to this many nanoseconds.
    pub(super) fn of_time(most_ns: f64) -> Self {
        match most_ns {
            ns if ns < 2e6 => Self { name: "µs", of: 1e3 },
            ns if ns < 2e9 => Self { name: "ms", of: 1e6 },
            _ => Self { name: "s", of: 1e9 },
        }
    }

    /// At most `count` round numbers from 0 to `most`, each with its label.
    pub(super) fn marks(self, most: f64, count: usize) -> Vec<(f64, String)> {
        let step = self.step(most, count);
        let digits = (-step.log10()).ceil().max(0.0) as usize;
        let number = (most / self.of / step + 1e-9).floor().max(0.0) as usize;
        (0..=number).map(|i| (i as f64 * step * self.of, format!("{:.digits$}", i as f64 * step))).collect()
    }

    /// 1, 2 or 5 times a power of ten.
    fn step(self, most: f64, count: usize) -> f64 {
        let least = most / self.of / count.max(1) as f64;
        round_up(if self == Self::PASSES { least.max(1.0) } else { least.max(1e-9) })
    }

    /// A time or number of passes, for reading.
    pub(super) fn text(self, value: f64) -> String {
        let value = value / self.of;
        if self == Self::PASSES {
            raystep_lab::text::counted(value, "pass")
        } else {
            format!("{value:.2} {}", self.name)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_read_easily() {
        let texts = [1.0, 0.25, 0.1, 0.01, 0.001, 1e-6, 0.0, 1.0 / 4096.0].map(percent);
        assert_eq!(texts, ["100%", "25%", "10%", "1%", "0.1%", "0.0001%", "0%", "0.024%"]);
    }

    #[test]
    fn a_share_of_one_ray_is_above_the_line_for_none() {
        let log = Shares::of(4096, true);
        assert_eq!(log, Shares::Log(4));
        assert_eq!((log.above(1.0, 100.0), log.above(0.0, 100.0)), (100.0, 0.0));
        assert!(log.above(1.0 / 4096.0, 100.0) > TO_NONE && log.above(1e-9, 100.0) == TO_NONE);
        assert_eq!(log.marks(200.0), [0.0, 1.0, 0.1, 0.01, 0.001, 0.0001]);
        assert_eq!(log.marks(50.0), [0.0, 1.0, 0.01, 0.0001]);
        let linear = Shares::of(4096, false);
        assert_eq!((linear.above(0.5, 100.0), linear.marks(60.0)), (50.0, vec![0.0, 0.5, 1.0]));
        assert_eq!(Shares::of(0, true), Shares::Log(1));
    }

    #[test]
    fn marks_are_round_and_no_more_than_there_is_room_for() {
        let text = |unit: Unit, most, count| unit.marks(most, count).into_iter().map(|m| m.1).collect::<Vec<_>>();
        assert_eq!(text(Unit::of_time(920e3), 920e3, 5), ["0", "200", "400", "600", "800"]);
        assert_eq!(text(Unit::of_time(3.1e6), 3.1e6, 7), ["0.0", "0.5", "1.0", "1.5", "2.0", "2.5", "3.0"]);
        assert_eq!(text(Unit::PASSES, 3.0, 10), ["0", "1", "2", "3"]);
        assert_eq!(text(Unit::PASSES, 73.0, 4), ["0", "20", "40", "60"]);
        assert_eq!(text(Unit::of_time(0.0), 0.0, 4), ["0.000000000"]);
        assert_eq!((Unit::of_time(5e9).text(2.5e9), Unit::PASSES.text(3.0)), ("2.50 s".into(), "3 passes".into()));
    }
}
