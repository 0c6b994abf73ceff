//! How the conditions of a kernel came out for a ray, in words, from the [interpreter](raystep_kernels::interpret)'s
//! recording.

use raystep_kernels::interpret::{Comparison, Interpreter, Kind, Recording, SiteKind, Value};
use raystep_kernels::shared::constants::INF;

/// A condition that the ray reached.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch {
    /// The condition: an index into the interpreter's sites.
    pub site: usize,
    /// Its line in the composed source, from 0.
    pub line: usize,
    /// The condition, as in the source.
    pub condition: String,
    /// Whether it was true, the last time that it was reached.
    pub is_taken: bool,
    /// How it came out, and what it compared, in one or more lines.
    pub notes: Vec<Note>,
}

/// A line about a condition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// The text.
    pub text: String,
    /// Whether f64 would decide otherwise.
    pub differs: bool,
    /// Whether it is about the values in f64.
    pub is_f64: bool,
}

/// Most comparisons that are told about a condition.
const MOST_TOLD: usize = 8;

/// How one of the interpreter's sites came out; `None` if it was not reached, or is a part of another condition.
#[must_use]
pub fn branch(kernel: &Interpreter, recording: &Recording, site: usize) -> Option<Branch> {
    let about = kernel.sites().get(site).filter(|about| about.kind != SiteKind::ShortCircuit)?;
    let index = recording.last.get(site).copied().flatten()?;
    let decision = recording.decisions.get(index)?;
    let outcome = outcome(kernel, recording, site)?;
    let comparisons = recording.comparisons(kernel, index);
    let because = recording.because(kernel, index).and_then(|index| recording.decisions.get(index));
    let because = because.and_then(|decision| kernel.sites().get(decision.site)).map(|site| site.line + 1);
    let mut notes = Vec::new();
    // Of several comparisons none alone is the outcome.
    if comparisons.len() > 1 {
        notes.push(Note { text: outcome.clone(), differs: decision.differs, is_f64: false });
    }
    for comparison in comparisons.iter().take(MOST_TOLD) {
        let text = in_words(comparison);
        let text = if notes.is_empty() { format!("{outcome}: {text}") } else { text };
        let differs = comparison.holds != comparison.holds_wide;
        notes.push(Note { text, differs, is_f64: false });
        notes.extend(in_f64(comparison).map(|text| Note { text, differs, is_f64: true }));
    }
    if notes.is_empty() {
        notes.push(Note { text: outcome, differs: decision.differs, is_f64: false });
    }
    if let (Some(line), Some(last)) = (because, notes.last_mut()) {
        last.text += &format!("; because of line {line}");
    }
    if comparisons.len() > MOST_TOLD {
        let text = format!("and {} more comparisons", comparisons.len() - MOST_TOLD);
        notes.push(Note { text, differs: false, is_f64: false });
    }
    Some(Branch {
        site,
        line: about.line,
        condition: text_of(kernel.source(), about.span.clone()),
        is_taken: decision.is_taken,
        notes,
    })
}

/// How a site came out, and how often, if it was reached several times; `None` if it was not reached.
pub(crate) fn outcome(kernel: &Interpreter, recording: &Recording, site: usize) -> Option<String> {
    let about = kernel.sites().get(site)?;
    let decision = recording.last.get(site).copied().flatten().and_then(|index| recording.decisions.get(index))?;
    let [taken, not] = recording.counts.get(site).copied()?;
    let outcome = match (about.kind, decision.is_taken) {
        (SiteKind::If | SiteKind::Switch, true) => "taken",
        (SiteKind::If | SiteKind::Switch, false) => "not taken",
        (SiteKind::Loop, true) => "goes on",
        (SiteKind::Loop, false) => "ends",
        (SiteKind::SelectEach, true) => "true for a component",
        (SiteKind::SelectEach, false) => "false for all components",
        (_, true) => "true",
        (_, false) => "false",
    };
    Some(match taken + not {
        1 => outcome.to_owned(),
        all => format!("reached {all} times, {taken} of them true; at last {outcome}"),
    })
}

/// A piece of source in one line.
pub(crate) fn text_of(source: &str, span: std::ops::Range<usize>) -> String {
    source.get(span).unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A comparison with the values of its sides.
fn in_words(comparison: &Comparison) -> String {
    let operator = comparison.operator;
    let side = |i: usize| {
        let mut name = comparison.sides[i].clone();
        if let Some(component) = comparison.component {
            name = format!("{name}.{}", ["x", "y", "z", "w"].get(component).unwrap_or(&"?"));
        }
        let value = number(comparison.values[i]);
        // A literal is its own value, and a long expression says less than its value.
        match name.chars().count() {
            _ if name.trim_end_matches(['u', 'i', 'f']) == value => value,
            _ if name.starts_with("vec") => value,
            0 => value,
            1..=32 => format!("{name} {value}"),
            _ => value,
        }
    };
    format!("{} {operator} {} is {}", side(0), side(1), comparison.holds)
}

/// A comparison of floats with their shadows.
fn in_f64(comparison: &Comparison) -> Option<String> {
    if comparison.values[0].kind != Kind::F32 {
        return None;
    }
    let [a, b] = comparison.values.map(|value| value.wide);
    let text = format!("  in f64: {} {} {}", wide(a), comparison.operator, wide(b));
    match comparison.holds == comparison.holds_wide {
        true => Some(text),
        false => Some(format!("{text} is {}: f64 decides otherwise", comparison.holds_wide)),
    }
}

pub(crate) fn number(value: Value) -> String {
    match value.kind {
        Kind::F32 => {
            let float = f32::from_bits(value.bits);
            match float.abs() {
                size if size == INF => if float > 0.0 { "never" } else { "-never" }.into(),
                size if size != 0.0 && size.is_finite() && !(1e-4..1e7).contains(&size) => format!("{float:e}"),
                _ => float.to_string(),
            }
        }
        Kind::I32 => value.bits.cast_signed().to_string(),
        Kind::Bool => (value.bits != 0).to_string(),
        Kind::U32 if value.bits >> 31 == 1 => format!("{:#x}", value.bits),
        Kind::U32 => value.bits.to_string(),
    }
}

/// A shadow: twelve digits show where it leaves the f32, which has at most nine.
fn wide(value: f64) -> String {
    let size = value.abs();
    if size == f64::from(INF) {
        return if value > 0.0 { "never" } else { "-never" }.into();
    }
    if size != 0.0 && size.is_finite() && !(1e-4..1e7).contains(&size) {
        return format!("{value:.11e}");
    }
    let before = if size >= 1.0 { size.log10() as usize + 1 } else { 1 };
    let text = format!("{value:.*}", 12usize.saturating_sub(before));
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_as_many_digits_as_they_need() {
        let f32 = |float: f32| number(Value { bits: float.to_bits(), kind: Kind::F32, wide: f64::from(float) });
        assert_eq!([0.0, 0.646_017_73, INF, 1e-9].map(f32), ["0", "0.64601773", "never", "1e-9"]);
        assert_eq!(number(Value { bits: u32::MAX, kind: Kind::U32, wide: 0.0 }), "0xffffffff");
        assert_eq!(number(Value { bits: u32::MAX, kind: Kind::I32, wide: 0.0 }), "-1");
        // Three digits more than f32 has.
        assert_eq!(wide(0.646_017_751_234_5), "0.64601775123");
        assert_eq!([0.1 + 0.2, 12.5, 1e-9, f64::from(INF)].map(wide), ["0.3", "12.5", "1.00000000000e-9", "never"]);
    }
}
