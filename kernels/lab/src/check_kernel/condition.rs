//! The condition that decided about a value, in the words of a message.

use raystep_kernels::interpret::{Comparison, Interpreter, Kind, Recording, Value};
use raystep_kernels::shared::constants::INF;

use crate::branch::{number, outcome};

/// Most comparisons that are told.
const MOST_TOLD: usize = 4;
/// Longer expressions say less than their values.
const LONGEST: usize = 32;

const COMPONENTS: [&str; 4] = ["x", "y", "z", "w"];

/// How one of the interpreter's sites came out, and what it compared, in lines; what decided comes first. `named` is where a
/// user finds a line of the composed source, from 1.
pub(super) fn how(
    kernel: &Interpreter,
    recording: &Recording,
    site: usize,
    named: impl Fn(usize) -> Option<String>,
) -> Option<Vec<String>> {
    let index = recording.last.get(site).copied().flatten()?;
    let is_taken = recording.decisions.get(index)?.is_taken;
    let outcome = outcome(kernel, recording, site)?;
    let mut comparisons = recording.comparisons(kernel, index);
    if let Some(decisive) = decisive(&comparisons, is_taken) {
        let first = comparisons.remove(decisive);
        comparisons.insert(0, first);
    }
    let mut lines = match comparisons.as_slice() {
        [one] => vec![format!("{outcome}: {}", in_words(one))],
        several => std::iter::once(outcome).chain(several.iter().take(MOST_TOLD).map(|one| in_words(one))).collect(),
    };
    let because = recording.because(kernel, index).and_then(|index| recording.decisions.get(index));
    let because = because.and_then(|decision| kernel.sites().get(decision.site)).and_then(|site| named(site.line + 1));
    if let (Some(place), Some(first)) = (because, lines.first_mut()) {
        *first += &format!("; because of {place}");
    }
    if comparisons.len() > MOST_TOLD {
        lines.push(format!("and {} more", comparisons.len() - MOST_TOLD));
    }
    Some(lines)
}

/// The comparison after which a condition's outcome was known, if others came out otherwise: the false one of an `&&`, the
/// true one of an `||`. If it is negated, none equals the outcome, and the last one was evaluated because it matters.
fn decisive(comparisons: &[&Comparison], is_taken: bool) -> Option<usize> {
    if comparisons.iter().all(|comparison| comparison.holds == is_taken) {
        return None;
    }
    let same = comparisons.iter().rposition(|comparison| comparison.holds == is_taken);
    same.or(comparisons.len().checked_sub(1))
}

/// A comparison, with the values of what has a name.
fn in_words(comparison: &Comparison) -> String {
    let [left, right] = [0, 1].map(|i| side(&comparison.sides[i], comparison.component, comparison.values[i]));
    let given: Vec<String> =
        [&left, &right].into_iter().filter_map(|(name, value)| Some(format!("{name} = {}", value.as_ref()?))).collect();
    let with = if given.is_empty() { String::new() } else { format!(", with {}", given.join(" and ")) };
    format!("{} {} {} is {}{with}", left.0, comparison.operator, right.0, comparison.holds)
}

/// What one side is called, and its value, unless that is what it is called.
fn side(text: &str, component: Option<usize>, value: Value) -> (String, Option<String>) {
    let told = told(value);
    // A literal, and this constant, are their own values.
    if component.is_none() && (is_literal(text) || text == "INF") {
        return (text.to_owned(), None);
    }
    if text.is_empty() || text.starts_with("vec") || text.chars().count() > LONGEST {
        return (told, None);
    }
    let name = match component.map(|component| COMPONENTS.get(component).copied().unwrap_or("?")) {
        Some(component) if text.contains(' ') => format!("({text}).{component}"),
        Some(component) => format!("{text}.{component}"),
        None => text.to_owned(),
    };
    (name, Some(told))
}

fn is_literal(text: &str) -> bool {
    let digits = text.strip_prefix('-').unwrap_or(text).replace("e-", "e");
    digits.starts_with(|c: char| c.is_ascii_digit() || c == '.')
        && digits.chars().all(|c| c.is_ascii_alphanumeric() || c == '.')
}

fn told(value: Value) -> String {
    match value.kind {
        Kind::F32 => float(f32::from_bits(value.bits)),
        _ => number(value),
    }
}

/// A float as a reader of the kernel would write it.
pub(super) fn float(value: f32) -> String {
    let size = value.abs();
    if size == INF || size.is_infinite() {
        let name = if size == INF { "INF" } else { "infinity" };
        return if value > 0.0 { name.to_owned() } else { format!("-{name}") };
    }
    if size != 0.0 && size.is_finite() && !(1e-4..1e7).contains(&size) {
        return format!("{value:e}");
    }
    value.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn compared(sides: [&str; 2], values: [f32; 2], operator: &'static str, holds: bool) -> Comparison {
        Comparison {
            sides: sides.map(str::to_owned),
            component: None,
            operator,
            values: values.map(|value| Value { bits: value.to_bits(), kind: Kind::F32, wide: f64::from(value) }),
            holds,
            holds_wide: holds,
            has_constant: false,
        }
    }

    #[test]
    fn only_what_has_a_name_has_a_value() {
        let words = |sides, values, operator| in_words(&compared(sides, values, operator, true));
        assert_eq!(words(["det", "0.0"], [0.25, 0.0], "!="), "det != 0.0 is true, with det = 0.25");
        assert_eq!(words(["t", "INF"], [2.0, INF], "<"), "t < INF is true, with t = 2");
        assert_eq!(words(["t", "nearest_t"], [2.0, INF], "<"), "t < nearest_t is true, with t = 2 and nearest_t = INF");
        assert_eq!(words(["1.0", "-1e-5f"], [1.0, -1e-5], ">"), "1.0 > -1e-5f is true");
        let long = "a.first_component * b.second_component";
        assert_eq!(words([long, "u + v"], [0.5, 0.25], ">"), "0.5 > u + v is true, with u + v = 0.25");
        let mut of_vectors = compared(["here.tmax", "vec3f(0.0)"], [1.5, 0.0], ">", true);
        of_vectors.component = Some(1);
        assert_eq!(in_words(&of_vectors), "here.tmax.y > 0 is true, with here.tmax.y = 1.5");
    }

    #[test]
    fn the_comparison_that_decided_is_told_first() {
        let [holds, fails] = [true, false].map(|holds| compared(["a", "b"], [0.0; 2], "<", holds));
        assert_eq!(decisive(&[&holds, &holds], true), None);
        assert_eq!(decisive(&[&holds, &holds, &fails], false), Some(2));
        assert_eq!(decisive(&[&fails, &holds], true), Some(1));
        // a < b && !(c < d)
        assert_eq!(decisive(&[&holds, &holds], false), Some(1));
        assert_eq!(decisive(&[], false), None);
    }

    #[test]
    fn floats_are_short() {
        let floats = [0.0, -0.0, 0.31, 1e-9, INF, -INF, f32::INFINITY, f32::NAN].map(float);
        assert_eq!(floats, ["0", "-0", "0.31", "1e-9", "INF", "-INF", "infinity", "NaN"]);
    }
}
