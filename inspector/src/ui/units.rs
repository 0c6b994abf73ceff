//! The units that lengths and t are shown in, and numbers for people.

mod words;

use egui::Ui;
use raystep_kernels::export::trace::Trace;
use raystep_kernels::scene_data::SceneData;
use serde::{Deserialize, Serialize};

pub(in crate::ui) use words::in_units;

/// Units of lengths and of t.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Units {
    /// Those of the streams and kernels: the scene's longest side is in [1, 2).
    Traced,
    /// Those of the scene's file.
    #[default]
    Scene,
}

impl Units {
    /// Their name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Traced => "traced units",
            Self::Scene => "scene units",
        }
    }
}

/// Converts the streams' lengths and t for display.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The units.
    pub units: Units,
    length: f64,
    offset: [f64; 3],
    t: f64,
}

impl Scale {
    /// Traced units.
    pub const TRACED: Self = Self { units: Units::Traced, length: 1.0, offset: [0.0; 3], t: 1.0 };

    /// For lengths and t that are this many times as large in the scene's units, and points that have this offset.
    #[must_use]
    pub fn new(units: Units, length: f64, offset: [f64; 3], t: f64) -> Self {
        match units {
            Units::Traced => Self::TRACED,
            Units::Scene => Self { units, length, offset, t },
        }
    }

    /// For all rays of a camera.
    #[must_use]
    pub fn in_scene(units: Units, data: &SceneData) -> Self {
        let length = data.units.scene_units_per_stream_unit();
        Self::new(units, length, data.units.offset.to_array(), length)
    }

    /// For a ray.
    #[must_use]
    pub fn of(units: Units, life: &Trace) -> Self {
        Self::new(units, life.scene_units_per_stream_unit, life.scene_offset, life.t_scale)
    }

    /// A t of a stream.
    #[must_use]
    pub fn t(&self, t: f32) -> f64 {
        f64::from(t) * self.t
    }

    /// A t in traced units, in more digits than a stream has.
    #[must_use]
    pub fn t64(&self, t: f64) -> f64 {
        t * self.t
    }

    /// A length of a stream.
    #[must_use]
    pub fn length(&self, length: f32) -> f64 {
        f64::from(length) * self.length
    }

    /// A coordinate of a point of a stream.
    #[must_use]
    pub fn coordinate(&self, axis: usize, value: f32) -> f64 {
        self.length(value) + self.offset[axis]
    }

    /// A point of a stream, with the digits that its numbers in the stream have.
    #[must_use]
    pub fn point(&self, point: [f32; 3]) -> [String; 3] {
        let digits = decimals(point.into_iter().map(|c| self.length(c).abs()).fold(0.0, f64::max));
        [0, 1, 2].map(|axis| format!("{:.digits$}", self.coordinate(axis, point[axis])))
    }

    /// A t with all digits that it has in the stream.
    #[must_use]
    pub fn exact_t(&self, t: f32) -> String {
        match self.units {
            Units::Traced => t.to_string(),
            // Scaled by a power of two, it is a float again, which fewer digits tell apart from others.
            Units::Scene => match self.t(t) {
                scaled if f64::from(scaled as f32) == scaled => (scaled as f32).to_string(),
                scaled => scaled.to_string(),
            },
        }
    }
}

/// Decimals that give the largest of some numbers six significant digits.
#[must_use]
pub fn decimals(largest: f64) -> usize {
    if !(largest.is_finite() && largest > 0.0) {
        return 5;
    }
    (5.0 - largest.log10().floor()).clamp(0.0, 12.0) as usize
}

/// The choice of units. `per_traced` is the number of scene units in a traced unit.
pub(in crate::ui) fn choose(ui: &mut Ui, units: &mut Units, per_traced: f64) {
    let about = format!("1 traced unit = {per_traced} scene units. Streams and kernels are in traced units.");
    for choice in [Units::Scene, Units::Traced] {
        if ui.selectable_label(*units == choice, choice.name()).on_hover_text(&about).clicked() {
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

impl TimeUnit {
    /// For durations up to this.
    pub(in crate::ui) fn of(longest_ns: u64) -> Self {
        match longest_ns {
            0..10_000_000 => Self::Micros,
            10_000_000..10_000_000_000 => Self::Millis,
            _ => Self::Seconds,
        }
    }

    /// Its symbol.
    pub(in crate::ui) fn name(self) -> &'static str {
        match self {
            Self::Micros => "µs",
            Self::Millis => "ms",
            Self::Seconds => "s",
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
    fn six_digits_and_no_more() {
        let text = |value: f64| format!("{value:.*}", decimals(value));
        let texts = [0.646_017_73, 1.0, 12.345_678, 123_456.7, 9.9e8, 0.000_123_456_78].map(text);
        assert_eq!(texts, ["0.646018", "1.00000", "12.3457", "123457", "990000000", "0.000123457"]);
        assert_eq!([0.0, f64::NAN, f64::INFINITY, -1.0].map(decimals), [5; 4]);
    }

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

    #[test]
    fn traced_units_keep_the_bits_and_scene_units_are_scaled() {
        let offset = [1e7, 0.0, -4096.0];
        let traced = Scale::new(Units::Traced, 4.0, offset, 8.0);
        assert_eq!((traced.t(0.1), traced.length(0.5), traced.exact_t(0.1)), (f64::from(0.1_f32), 0.5, "0.1".into()));
        assert_eq!(traced.point([0.5, 0.1, -0.125]), ["0.500000", "0.100000", "-0.125000"]);
        let scene = Scale::new(Units::Scene, 4.0, offset, 8.0);
        assert_eq!((scene.t(0.5), scene.length(0.5), scene.exact_t(0.5)), (4.0, 2.0, "4".into()));
        assert_eq!(scene.exact_t(0.1), "0.8", "as many digits as the float has");
        assert_eq!(scene.point([0.5, 0.25, -0.125]), ["10000002.00000", "1.00000", "-4096.50000"]);
    }
}
