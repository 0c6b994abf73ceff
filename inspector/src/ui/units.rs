//! The units that lengths, t and times are shown in.

use egui::Ui;
pub use raystep_kernels::history::units::{Scale, Units, decimals, exact};
use raystep_kernels::named;

use crate::ui::choice::Choices as _;

/// The choice of units. `per_traced` is the number of scene units in a traced unit.
pub(in crate::ui) fn choose(ui: &mut Ui, units: &mut Units, per_traced: f64) {
    let about = format!("1 traced unit = {per_traced} scene units. Streams and kernels are in traced units.");
    for choice in [Units::Scene, Units::Traced] {
        if ui.choice(*units == choice, choice.name()).on_hover_text(&about).clicked() {
            *units = choice;
        }
    }
}

/// A unit of time that suits the longest of some durations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(in crate::ui) enum TimeUnit {
    /// Below 10 ms.
    Micros,
    /// Below 10 s.
    Millis,
    /// Longer.
    Seconds,
}

named!(TimeUnit, Micros "µs", Millis "ms", Seconds "s");

impl TimeUnit {
    /// For durations up to this.
    pub(in crate::ui) fn of(longest_ns: u64) -> Self {
        match longest_ns {
            0..10_000_000 => Self::Micros,
            10_000_000..10_000_000_000 => Self::Millis,
            _ => Self::Seconds,
        }
    }

    /// A duration in it.
    pub(in crate::ui) fn text(self, ns: u64) -> String {
        let ns = ns as f64;
        match self {
            Self::Micros => format!("{:.1}", ns / 1e3),
            Self::Millis => format!("{:.3}", ns / 1e6),
            Self::Seconds => format!("{:.4}", ns / 1e9),
        }
    }

    /// A bound in it, rounded up.
    pub(in crate::ui) fn text_above(self, ns: u64) -> String {
        let digit = match self {
            Self::Micros => 100,
            Self::Millis => 1000,
            Self::Seconds => 100_000,
        };
        self.text(ns.next_multiple_of(digit))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_in_units_for_people() {
        let text = |longest: u64, ns: u64| {
            let unit = TimeUnit::of(longest);
            format!("{} {}", unit.text(ns), unit.name())
        };
        assert_eq!(text(9_999_999, 22_101_500 / 10), "2210.2 µs");
        assert_eq!(text(22_101_500, 22_101_500), "22.102 ms");
        assert_eq!(text(22_101_500, 17_000), "0.017 ms");
        assert_eq!(text(12_000_000_000, 345_000_000), "0.3450 s");
    }
}
