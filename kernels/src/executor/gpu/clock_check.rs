//! Whether two clocks agree about the same work.

/// Smallest valid ratio of device time to host time, in the best of several measurements.
const LEAST_SHARE: f64 = 0.5;

/// Largest valid ratio: quartz clocks differ by about 0.01%, and tick periods are reported to about 0.1%.
const MOST_SHARE: f64 = 1.02;

/// The device's and the host's measurement of the same work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClockCheck {
    /// Time between the device's timestamps before and after it; `None` if they were not valid.
    pub device_ns: Option<u64>,
    /// Time from its submission to its end, on the host's clock.
    pub host_ns: u64,
}

/// The host's clock, and what the device's was found to be.
pub(super) struct Clock {
    pub(super) now: fn() -> u64,
    pub(super) check: Option<ClockCheck>,
    pub(super) coarse_step_ns: Option<f64>,
    pub(super) was_rounded: bool,
}

impl ClockCheck {
    /// The device's time as a share of the host's.
    #[must_use]
    pub fn share(&self) -> Option<f64> {
        self.device_ns.filter(|_| self.host_ns > 0).map(|ns| ns as f64 / self.host_ns as f64)
    }

    /// Whether the two agree, so that both measure this work.
    #[must_use]
    pub fn agrees(&self) -> bool {
        self.share().is_some_and(|share| (LEAST_SHARE..=MOST_SHARE).contains(&share))
    }

    /// Difference of the two, in octaves.
    pub(super) fn distance(&self) -> f64 {
        self.share().map_or(f64::INFINITY, |share| share.log2().abs())
    }
}

impl std::fmt::Display for ClockCheck {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ms = |ns: u64| format!("{:.3} ms", ns as f64 / 1e6);
        let device = self.device_ns.map_or("no time".into(), ms);
        write!(f, "{device} of work that took {} on the host's clock", ms(self.host_ns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clocks_agree_where_the_device_counts_most_of_the_hosts_time_and_no_more() {
        let of = |device_ns| ClockCheck { device_ns, host_ns: 10_000_000 };
        for (device_ns, agrees) in [
            (Some(9_900_000), true),
            (Some(10_000_000), true),
            (Some(5_000_001), true),
            // A clock that is a hundred times too slow, and one whose period is reported wrong by a factor of two.
            (Some(100_000), false),
            (Some(4_900_000), false),
            (Some(10_300_000), false),
            (Some(20_000_000), false),
            (Some(0), false),
            (None, false),
        ] {
            assert_eq!(of(device_ns).agrees(), agrees, "{}", of(device_ns));
        }
        assert!(!ClockCheck { device_ns: Some(5), host_ns: 0 }.agrees(), "a host's clock that stands still");
        assert_eq!(of(Some(98_000)).to_string(), "0.098 ms of work that took 10.000 ms on the host's clock");
    }
}
