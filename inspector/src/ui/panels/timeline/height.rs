//! The vertical axis: numbers of rays, linear or logarithmic.

use raystep_lab::human::round_up;

/// Points between two labels.
const APART: f32 = 15.0;

/// The vertical axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Height {
    /// The number at its top.
    pub(super) most: u64,
    pub(super) is_log: bool,
}

impl Height {
    /// The part of the height for a number. On a logarithmic axis a single one is visible beside a million.
    pub(super) fn of(self, count: u64) -> f32 {
        if count == 0 || self.most == 0 {
            return 0.0;
        }
        let (count, most) = (count.min(self.most) as f64, self.most as f64);
        let part = if self.is_log { count.ln_1p() / most.ln_1p() } else { count / most };
        part as f32
    }

    /// Round numbers with room for their labels, from the bottom.
    pub(super) fn marks(self, height: f32) -> Vec<u64> {
        if self.is_log {
            let mut marks: Vec<u64> = Vec::new();
            let powers = (0..20).map(|power| 10u64.saturating_pow(power)).take_while(|&mark| mark <= self.most);
            for mark in powers {
                let before = marks.last().map_or(0.0, |&mark| self.of(mark));
                if (self.of(mark) - before) * height >= APART {
                    marks.push(mark);
                }
            }
            return marks;
        }
        let step = round_up(self.most as f64 * f64::from(APART / height.max(1.0))).max(1.0) as u64;
        (1..).map(|i| i * step).take_while(|&mark| mark <= self.most).collect()
    }
}

/// A number for a narrow column: 12, 1.5k, 262k, 2.1M.
pub(super) fn short(count: u64) -> String {
    let (of, unit) = match count {
        0..1000 => return count.to_string(),
        1000..1_000_000 => (1e3, "k"),
        1_000_000..1_000_000_000 => (1e6, "M"),
        _ => (1e9, "G"),
    };
    let value = count as f64 / of;
    let text = if value < 9.95 { format!("{value:.1}") } else { format!("{value:.0}") };
    format!("{}{unit}", text.trim_end_matches(".0"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_ray_is_seen_on_a_logarithmic_axis_only() {
        let [linear, log] = [false, true].map(|is_log| Height { most: 1 << 20, is_log });
        assert_eq!([linear, log].map(|axis| (axis.of(0), axis.of(1 << 20), axis.of(u64::MAX))), [(0.0, 1.0, 1.0); 2]);
        assert!(linear.of(1) < 1e-5 && log.of(1) > 0.04, "{} {}", linear.of(1), log.of(1));
        assert_eq!(linear.of(1 << 19), 0.5);
        assert_eq!(Height { most: 0, is_log: true }.of(3), 0.0);
    }

    #[test]
    fn marks_are_round_and_have_room() {
        let marks = |most, is_log, height| Height { most, is_log }.marks(height);
        assert_eq!(marks(4096, false, 60.0), [2000, 4000]);
        assert_eq!(marks(4096, true, 100.0), [10, 100, 1000]);
        assert_eq!(marks(3, false, 100.0), [1, 2, 3]);
        assert!(marks(0, true, 50.0).is_empty() && marks(0, false, 50.0).is_empty());
        for height in [1.0, 20.0, 500.0] {
            for is_log in [false, true] {
                let axis = Height { most: 262_144, is_log };
                let at: Vec<f32> = axis.marks(height).into_iter().map(|mark| axis.of(mark) * height).collect();
                assert!(at.windows(2).all(|two| two[1] - two[0] >= 0.99 * APART), "{at:?}");
            }
        }
    }

    #[test]
    fn large_numbers_are_abbreviated() {
        let texts = [0, 999, 1000, 1500, 9960, 262_144, 2_100_000, 5_000_000_000].map(short);
        assert_eq!(texts, ["0", "999", "1k", "1.5k", "10k", "262k", "2.1M", "5G"]);
    }
}
