//! The value of a texel, in words and numbers.

use raystep_kernels::programs::closest_hit::streams::{RAY_ORIGIN, STATE, STATE_CELL};
use raystep_kernels::scene_data::SceneData;
use raystep_kernels::shared::constants::INF;
use raystep_kernels::tables::stream::{Meaning, STATE_TAG};
use raystep_kernels::{Program, Stream};

use crate::ui::units::{Scale, Units};

/// How more about a state begins.
const TAG: &str = "tag ";

/// A component of a texel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Value {
    /// Its layer.
    pub(super) name: &'static str,
    /// Its value: decimal, or the name of a special one.
    pub(super) text: String,
    /// Its bits.
    pub(super) bits: u32,
    /// More about it: in scene units, or as a cell.
    pub(super) more: Option<String>,
}

/// What texels mean.
pub(super) struct Reader<'a> {
    pub(super) program: &'a Program,
    pub(super) data: &'a SceneData,
    pub(super) stream: Stream,
    /// Scene units per traced unit of length and of t.
    pub(super) scene: Scale,
}

impl<'a> Reader<'a> {
    pub(super) fn new(program: &'a Program, data: &'a SceneData, stream: Stream, t_scale: Option<f64>) -> Self {
        let length = data.units.scene_units_per_stream_unit();
        let scene = Scale::new(Units::Scene, length, data.units.offset.to_array(), t_scale.unwrap_or(length));
        Self { program, data, stream, scene }
    }

    /// A component in readable form.
    pub(super) fn value(&self, layer: usize, bits: u32) -> Value {
        let info = self.stream.info();
        let name = info.layers.get(layer).copied().unwrap_or_default();
        let (text, more) = match self.stream.is_float_layer(layer) {
            true => self.float(layer, f32::from_bits(bits)),
            false => self.integer(layer, bits),
        };
        Value { name, text, bits, more }
    }

    fn float(&self, layer: usize, value: f32) -> (String, Option<String>) {
        let is_t = self.stream.info().meaning.get(layer) == Some(&Meaning::Distance);
        let text = match value {
            v if v.is_nan() => "NaN".into(),
            f32::INFINITY => "+Inf".into(),
            f32::NEG_INFINITY => "−Inf".into(),
            v if is_t && v >= INF => "never".into(),
            v => v.to_string(),
        };
        let is_plain = value.is_finite() && !(is_t && value >= INF);
        let scene = match (is_plain, is_t, self.stream == RAY_ORIGIN) {
            (true, true, _) => Some(self.scene.t(value)),
            (true, _, true) => Some(self.scene.coordinate(layer, value)),
            _ => None,
        };
        (text, scene.map(|scene| format!("{scene} {}", Units::Scene.name())))
    }

    fn integer(&self, layer: usize, bits: u32) -> (String, Option<String>) {
        if self.program.has_states(self.stream) && layer == STATE_TAG {
            let meaning = self.program.states.0.get(bits as usize).map_or("not a state", |state| state.meaning);
            return (self.program.states.name(bits).into(), Some(format!("{TAG}{bits}, {meaning}")));
        }
        let is_id = self.stream.info().meaning.get(layer) == Some(&Meaning::Id);
        let text = if is_id && bits == u32::MAX { "none".into() } else { bits.to_string() };
        let grid = &self.data.grid;
        let is_cell = self.stream == STATE && layer == STATE_CELL && self.data.features.grid;
        let is_there = is_cell && grid.cells.iter().all(|&n| n > 0);
        let cell = is_there.then(|| grid.cell_of_index(bits)).filter(|&cell| grid.is_in_grid(cell));
        (text, cell.map(|[x, y, z]| format!("cell {x},{y},{z}")))
    }
}

/// All components in one line.
pub(super) fn line(values: &[Value], units: Units) -> String {
    let text = |value: &Value| match (&value.more, units) {
        (Some(more), Units::Scene) if more.ends_with(Units::Scene.name()) => format!("{} {more}", value.name),
        (Some(more), _) if more.starts_with(TAG) => format!("{} {} ({})", value.name, value.text, &more[TAG.len()..]),
        (Some(more), _) if more.starts_with("cell ") => format!("{} {} ({})", value.name, value.text, &more[5..]),
        _ => format!("{} {}", value.name, value.text),
    };
    values.iter().map(text).collect::<Vec<_>>().join("   ")
}

#[cfg(test)]
mod tests {
    use raystep_kernels::plan::Plan;
    use raystep_kernels::programs::closest_hit::streams::{HIT, HIT_TRIANGLE, RAY_DIRECTION, STATE_T, TMAX};
    use raystep_kernels::{Limits, Options, RaySource};
    use raystep_scenes::generate;

    use super::*;

    #[test]
    fn values_have_names_and_both_units() {
        let scene = generate::cornell_box();
        let source = RaySource::Camera { camera: scene.cameras[0].clone(), width: 8, height: 8 };
        let (plan, data) = Plan::new(&scene, &Options::new(source), &Limits::CPU).expect("a small scene");
        let by = data.units.scene_units_per_stream_unit();
        let value = |stream: Stream, layer: usize, bits: u32| {
            let value = Reader::new(plan.program, &data, stream, None).value(layer, bits);
            (value.name, value.text, value.more.unwrap_or_default())
        };
        let scene_units = |v: f64| format!("{v} scene units");
        let t = 0.75_f32.to_bits();
        assert_eq!(value(STATE, STATE_T, t), ("t", "0.75".into(), scene_units(0.75 * by)));
        assert_eq!(value(TMAX, 1, INF.to_bits()), ("y", "never".into(), String::new()));
        assert_eq!(value(TMAX, 1, f32::NAN.to_bits()), ("y", "NaN".into(), String::new()));
        assert_eq!(value(RAY_ORIGIN, 0, t), ("x", "0.75".into(), scene_units(0.75 * by)));
        assert_eq!(value(RAY_DIRECTION, 0, f32::NEG_INFINITY.to_bits()), ("x", "−Inf".into(), String::new()));
        assert_eq!(value(HIT, HIT_TRIANGLE, u32::MAX), ("triangle", "none".into(), String::new()));
        let tag = plan.program.states.iter().position(|state| state.name == "TRAV").expect("a state");
        assert_eq!(
            value(STATE, STATE_TAG, tag as u32),
            ("tag", "TRAV".into(), format!("tag {tag}, continues to the next cell or node"))
        );
        let index = data.grid.cell_index([1, 0, 1]);
        assert_eq!(value(STATE, STATE_CELL, index).2, "cell 1,0,1");
        assert_eq!(value(STATE, STATE_CELL, u32::MAX).2, "");
        let reader = Reader::new(plan.program, &data, STATE, Some(8.0));
        let state = [reader.value(STATE_TAG, tag as u32)];
        assert_eq!(line(&state, Units::Scene), format!("tag TRAV ({tag}, continues to the next cell or node)"));
        let values = [reader.value(STATE_T, t), reader.value(STATE_CELL, index)];
        assert_eq!(line(&values, Units::Traced), format!("t 0.75   cell {index} (1,0,1)"));
        assert_eq!(line(&values, Units::Scene), format!("t 6 scene units   cell {index} (1,0,1)"));
    }
}
