//! Values of a program's tables as TOML.

use std::fmt::Write as _;

use crate::program::schedule::{Count, Step};

/// A text of TOML.
pub(super) fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => _ = write!(quoted, "\\u{:04X}", c as u32),
            c => quoted.push(c),
        }
    }
    quoted + "\""
}

/// A list.
pub(super) fn list<T>(all: impl IntoIterator<Item = T>, text: impl Fn(T) -> String) -> String {
    format!("[{}]", all.into_iter().map(text).collect::<Vec<_>>().join(", "))
}

/// A table in one line.
pub(super) fn table<'a>(all: impl IntoIterator<Item = (&'a str, String)>) -> String {
    let entries: Vec<String> = all.into_iter().map(|(name, value)| format!("{name} = {value}")).collect();
    format!("{{ {} }}", entries.join(", "))
}

/// A number of TOML that has these bits in a stream.
pub(super) fn number(bits: u32, is_float: bool) -> String {
    if !is_float {
        return bits.to_string();
    }
    let value = f32::from_bits(bits);
    match value.is_finite() {
        true => format!("{value:?}"),
        false => format!("{value:?}").to_lowercase(),
    }
}

fn counted(count: Count) -> String {
    match count.by {
        [] => count.first.to_string(),
        by => table([("first", count.first.to_string()), ("by", list(by, |by| by.to_string()))]),
    }
}

/// Steps, a line for each, so deep inside of others.
pub(super) fn steps(all: &[Step], depth: usize) -> String {
    let indent = "    ".repeat(depth);
    let mut text = String::new();
    for step in all {
        let body = |body: &[Step]| format!("steps = [\n{}{indent}]", steps(body, depth + 1));
        let inside = match step {
            Step::Run(kernel) => format!("run = {}", quoted(kernel.name())),
            Step::RunBy(kernel, count) => format!("run = {}, parameter = {}", quoted(kernel.name()), counted(*count)),
            Step::RunUntilIdle(kernel) => format!("until_idle = {}", quoted(kernel.name())),
            Step::LoopWhileActive(kernels, inner) => {
                format!("while_any = {}, {}", list(kernels, |kernel| quoted(kernel.name())), body(inner))
            }
            Step::RepeatWhileAny(set, inner) => format!("while_any = {}, {}", quoted(set.name), body(inner)),
            Step::Repeat(name, count, inner) => {
                format!("repeat = {}, name = {}, {}", counted(*count), quoted(name), body(inner))
            }
        };
        _ = writeln!(text, "{indent}{{ {inside} }},");
    }
    text
}
