//! The units in which lengths and t are shown: those of the streams, or of the scene's file.

use std::borrow::Cow;

use super::{RayState, Trace};
use crate::numbers::named::named;
use crate::scene_data::SceneData;

/// Words of a reason after which a number is a t.
const BEFORE_T: [&str; 8] = ["t", "tmax.x", "tmax.y", "tmax.z", "exit", "t_min", "end", "than"];

/// Units of lengths and of t.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Units {
    /// Those of the streams and kernels: the scene's longest side is in [1, 2).
    Traced,
    /// Those of the scene's file.
    #[default]
    Scene,
}

named!(Units, Traced "traced units", Scene "scene units");

impl Units {
    /// What a t in them is called.
    #[must_use]
    pub fn t_name(self) -> &'static str {
        match self {
            Self::Traced => "t in traced units",
            Self::Scene => "t in scene units",
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
        exact(self.t(t))
    }

    /// A component of the direction, which t is a multiple of.
    #[must_use]
    pub fn direction(&self, component: f32) -> f64 {
        f64::from(component) * (self.length / self.t)
    }

    /// What decides by which face a ray leaves its cell, per axis, and its t.
    #[must_use]
    pub fn numbers(&self, ray: &RayState) -> [Option<f64>; 4] {
        let [x, y, z] = match ray.control {
            // In cells.
            Some(control) => control.map(|term| Some(f64::from(term))),
            None => ray.tmax.map(|t| t.map(|t| self.t(t))),
        };
        [x, y, z, ray.t.map(|t| self.t(t))]
    }

    /// Decimals that give the largest of each of these [numbers](Self::numbers) in a history six significant digits.
    #[must_use]
    pub fn decimals(&self, of: &Trace) -> [usize; 4] {
        let mut largest = [0.0_f64; 4];
        for row in &of.rows {
            for (largest, number) in largest.iter_mut().zip(self.numbers(&row.after)) {
                *largest = number.map_or(*largest, |number| number.abs().max(*largest));
            }
        }
        largest.map(decimals)
    }

    /// The reason of a row, which quotes t in traced units, with every t converted.
    #[must_use]
    pub fn reason(&self, why: &str) -> String {
        let mut before = "";
        let words = why.split(' ').map(|word| {
            let number = word.trim_end_matches([',', ';', ':']);
            let is_t = BEFORE_T.contains(&std::mem::replace(&mut before, word));
            match number.parse::<f32>() {
                Ok(t) if is_t && t.is_finite() => Cow::Owned(self.exact_t(t) + &word[number.len()..]),
                _ => Cow::Borrowed(word),
            }
        });
        words.collect::<Vec<_>>().join(" ")
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

/// All digits of a number. A float scaled by a power of two is a float again, which fewer digits tell apart from others.
#[must_use]
pub fn exact(value: f64) -> String {
    if f64::from(value as f32) == value { (value as f32).to_string() } else { value.to_string() }
}

#[cfg(test)]
mod tests {
    use raystep_scenes::generate;

    use super::*;
    use crate::history::RunSoFar;
    use crate::plan::Plan;
    use crate::{Accelerator, Limits, Numerics, Options, RaySource, ScheduleKind};

    #[test]
    fn six_digits_and_no_more() {
        let text = |value: f64| format!("{value:.*}", decimals(value));
        let texts = [0.646_017_73, 1.0, 12.345_678, 123_456.7, 9.9e8, 0.000_123_456_78].map(text);
        assert_eq!(texts, ["0.646018", "1.00000", "12.3457", "123457", "990000000", "0.000123457"]);
        assert_eq!([0.0, f64::NAN, f64::INFINITY, -1.0].map(decimals), [5; 4]);
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

    #[test]
    fn every_t_is_converted_and_nothing_else() {
        let scale = Scale::new(Units::Scene, 4.0, [0.0; 3], 4.0);
        for (traced, scene) in [
            (
                "tmax.z 0.5 is smallest: step +z to cell (3, 2, 5), which lists 12 triangles",
                "tmax.z 2 is smallest: step +z to cell (3, 2, 5), which lists 12 triangles",
            ),
            ("triangle 7: hit at t 0.25, u 0.5, v 0.125", "triangle 7: hit at t 1, u 0.5, v 0.125"),
            ("list ended: t 0.5 <= exit 0.75, accepted", "list ended: t 2 <= exit 3, accepted"),
            ("triangle 3: hit at t 1.5, not nearer than 0.25", "triangle 3: hit at t 6, not nearer than 1"),
            ("hit at t 0.5, before the ray's t_min 1", "hit at t 2, before the ray's t_min 4"),
            ("equation (1) at triangle 4: r 0.5 g 0.25 b 1.000", "equation (1) at triangle 4: r 0.5 g 0.25 b 1.000"),
            ("1 - u - v = -0.5, outside", "1 - u - v = -0.5, outside"),
        ] {
            assert_eq!(scale.reason(traced), scene);
            assert_eq!(Scale::TRACED.reason(traced), traced);
        }
    }

    /// Numbers with a fraction are a t, a weight of the hit, a determinant, or a colour.
    #[test]
    fn every_fraction_in_a_history_is_known() {
        let scene = generate::cornell_box();
        let scale = Scale::new(Units::Scene, 4.0, [0.0; 3], 4.0);
        let mut fractions = 0;
        for (accelerator, numerics) in [
            (Accelerator::Grid, Numerics::Robust),
            (Accelerator::Grid, Numerics::Paper),
            (Accelerator::Bvh, Numerics::Robust),
        ] {
            let camera = scene.cameras[0].clone();
            let source = RaySource::Camera { camera, width: 16, height: 16 };
            let schedule = ScheduleKind::Second;
            let options = Options { accelerator, numerics, schedule, ..Options::new(source) };
            let (plan, data) = Plan::new(&scene, &options, &Limits::CPU).expect("a small scene");
            let run = RunSoFar { plan: &plan, data: &data, passes: &[], is_complete: false };
            for i in 0..256 {
                let life = run.follow::<f32>([i % 16, i / 16]).expect("a ray");
                for row in &life.rows {
                    let after = scale.reason(&row.why);
                    let pairs = row.why.split(' ').zip(after.split(' '));
                    let mut before = "";
                    for (word, converted) in pairs {
                        let is_fraction =
                            word.contains('.') && word.trim_end_matches([',', ';']).parse::<f32>().is_ok();
                        let is_plain = ["u", "v", "=", "r", "g", "b", "determinant", "below"].contains(&before);
                        fractions += u32::from(is_fraction);
                        assert!(!is_fraction || is_plain == (word == converted), "{before} {word}: {}", row.why);
                        before = word;
                    }
                }
            }
        }
        assert!(fractions > 1000, "{fractions}");
    }
}
