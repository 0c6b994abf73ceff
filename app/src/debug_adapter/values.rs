//! Variables as a client asks for them: a scope or a composite has a number, by which its parts are found.

use raystep_kernels::Stream;
use raystep_kernels::interpret::{Shown, StreamView, Variable, View};
use raystep_kernels::tables::stream::STATE_TAG;
use serde_json::{Value, json};

/// Most numbers at a place: what an editor asks for more is not shown.
const MOST: usize = 4096;

/// What has a number.
#[derive(Debug, Default)]
pub(super) struct Values(Vec<Vec<Variable>>);

impl Values {
    /// Forgets all: the thread is elsewhere.
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// A number for these variables; 0 for none.
    pub(super) fn number(&mut self, variables: &[Variable]) -> usize {
        if variables.is_empty() || self.0.len() >= MOST {
            return 0;
        }
        self.0.push(variables.to_vec());
        self.0.len()
    }

    /// Some of the variables with a number.
    pub(super) fn list(&mut self, number: usize, first: usize, count: usize) -> Option<Vec<Value>> {
        let own = self.0.get(number.checked_sub(1)?)?.clone();
        let count = if count == 0 { usize::MAX } else { count };
        Some(own.iter().skip(first).take(count).map(|variable| self.shown(variable)).collect())
    }

    /// A variable for `variables`.
    fn shown(&mut self, variable: &Variable) -> Value {
        let reference = self.reference(variable);
        json!({
            "name": variable.name,
            "value": variable.value.told(),
            "type": variable.of,
            "variablesReference": reference,
            "indexedVariables": indexed(variable),
        })
    }

    /// A variable for `evaluate`.
    pub(super) fn result(&mut self, variable: &Variable) -> Value {
        let reference = self.reference(variable);
        json!({ "result": variable.value.told(), "type": variable.of, "variablesReference": reference })
    }

    fn reference(&mut self, variable: &Variable) -> usize {
        match &variable.value {
            Shown::Parts(parts) => self.number(parts),
            _ => 0,
        }
    }
}

/// How many parts an array has, if there are many.
fn indexed(variable: &Variable) -> usize {
    match &variable.value {
        Shown::Parts(parts) if parts.len() > 100 && parts[0].name.starts_with('[') => parts.len(),
        _ => 0,
    }
}

/// The variable that a path as `hit.t` or `row[1][3]` names.
pub(super) fn find<'a>(variables: impl IntoIterator<Item = &'a Variable>, path: &str) -> Option<&'a Variable> {
    let path = path.trim();
    let end = path.find(['.', '[']).unwrap_or(path.len());
    let mut rest = &path[end..];
    let mut found = variables.into_iter().find(|variable| variable.name == path[..end])?;
    while !rest.is_empty() {
        let Shown::Parts(parts) = &found.value else { return None };
        let (name, after) = match rest.strip_prefix('.') {
            Some(after) => after.split_at(after.find(['.', '[']).unwrap_or(after.len())),
            None => rest.split_at(rest.find(']')? + 1),
        };
        found = parts.iter().find(|part| part.name == name)?;
        rest = after;
    }
    Some(found)
}

/// A component of a stream in words.
fn component(
    stream: Stream,
    layer: usize,
    bits: u32,
    states: raystep_kernels::tables::state::States,
    is_tag: bool,
) -> String {
    if is_tag && states.iter().any(|state| state.tag == bits) {
        return states.name(bits).to_owned();
    }
    if stream.is_float_layer(layer) { format!("{:?}", f32::from_bits(bits)) } else { bits.to_string() }
}

/// The element's streams: what they were before the pass, and what they are now if that differs.
pub(super) fn streams(view: &View, program: &raystep_kernels::Program) -> Vec<Variable> {
    let told = |of: &StreamView| {
        let StreamView { stream, layer, before, now } = *of;
        let info = stream.info();
        let is_tag = program.has_states(stream) && layer == STATE_TAG;
        let [before, now] = [before, now].map(|bits| component(stream, layer, bits, program.states, is_tag));
        let value = if of.before == of.now { now } else { format!("{now}, before the pass {before}") };
        let kind = if stream.is_float_layer(layer) { "f32" } else { "u32" };
        let name = format!("{}.{}", info.name, info.layers.get(layer).unwrap_or(&""));
        Variable { name, of: kind.into(), value: Shown::Told(value) }
    };
    view.streams.iter().map(told).collect()
}

#[cfg(test)]
mod tests {
    use raystep_kernels::interpret::Kind;

    use super::*;

    fn scalar(name: &str, bits: u32) -> Variable {
        Variable { name: name.into(), of: "u32".into(), value: Shown::Scalar(Kind::U32, bits) }
    }

    #[test]
    fn a_path_names_a_part() {
        let row = Shown::Parts(vec![scalar("[0]", 3), scalar("[1]", 4)]);
        let hit = Variable {
            name: "hit".into(),
            of: "Hit".into(),
            value: Shown::Parts(vec![
                scalar("id", 7),
                Variable { name: "row".into(), of: "array<u32, 2>".into(), value: row },
            ]),
        };
        let all = [scalar("x", 1), hit];
        let told = |path: &str| find(&all, path).map(|found| found.value.told());
        assert_eq!(told("x"), Some("1".into()));
        assert_eq!(told(" hit.row[1]"), Some("4".into()));
        assert_eq!(told("hit.row"), Some("(3, 4)".into()));
        for wrong in ["", "y", "x.y", "hit.row[2]", "hit.row[", "hit..", "hit.row]1[", "["] {
            assert_eq!(told(wrong), None, "{wrong}");
        }
    }
}
