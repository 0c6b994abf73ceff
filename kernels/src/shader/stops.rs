//! Conditions at lines of a kernel: statements that only the interpreter gets, each on the line that it stops at.

use std::fmt::Write as _;
use std::ops::Range;

use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Module, ScalarKind, TypeInner};

use super::{Sourced, Variant};
use crate::compose::{Word, WordKind, blanked, words};

/// Where to stop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stop {
    /// Before which statement, see [`Sourced::statement`].
    pub statement: usize,
    /// The condition, an expression of WGSL; without one the statement is reached or not.
    pub when: Option<String>,
}

/// What is wrong with a condition.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct StopError {
    /// Index of the stop.
    pub stop: usize,
    /// Where in the condition, in characters from 1.
    pub column: usize,
    /// What, and what would be right.
    pub message: String,
}

/// A kernel with stops in it.
#[derive(Clone, Debug)]
pub struct Stopping {
    /// What to interpret.
    pub variant: Variant,
    /// Of each stop the variables in its condition, as they are written there, whose values the interpreter keeps.
    pub watched: Vec<Vec<String>>,
}

/// Most variables of a condition whose values are kept, and most components of each.
pub const MOST_WATCHED: usize = 8;
/// Most letters of a condition.
const MOST_LETTERS: usize = 4096;

const STOP: &str = "stop___";
const AT: &str = "at___";
const WATCH: &str = "watch___";
/// Whether the thread is the one that is followed, and where it is to be run to.
const NOW: &str = "now___";
/// The condition itself, and the value of an expression.
const WHOLE: &str = "c";

/// What a call is for the interpreter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Call {
    /// A stop, with its condition.
    Stop(usize),
    /// The beginning of a statement, which is the argument.
    At,
    /// Whether what follows concerns this thread now.
    Now,
}

/// What a function stands for.
pub(crate) fn call_of(function: &str) -> Option<Call> {
    match function {
        AT => Some(Call::At),
        NOW => Some(Call::Now),
        _ => function.strip_prefix(STOP)?.parse().ok().map(Call::Stop),
    }
}

/// The stop and the variable that a name is made for; [`MOST_WATCHED`] for the condition.
pub(crate) fn watched_by(name: &str) -> Option<(usize, usize)> {
    let (stop, index) = name.strip_prefix(WATCH)?.split_once('_')?;
    let index = if index == WHOLE { MOST_WATCHED } else { index.parse().ok()? };
    Some((stop.parse().ok()?, index))
}

fn watch(stop: usize, index: &str, expression: &str) -> String {
    format!("let {WATCH}{stop}_{index}=({expression});")
}

/// Statements for the thread that is followed alone: for others they may have no value.
fn now(put: &str) -> String {
    format!("if {NOW}() {{{put}}}")
}

impl Sourced {
    /// The kernel with stops, and if `is_traced` with a call before each statement that tells where the thread is.
    ///
    /// # Errors
    /// If a condition is none there.
    pub fn stopping(&self, stops: &[Stop], is_traced: bool) -> Result<Stopping, StopError> {
        let (mut before, mut watched) = (vec![String::new(); self.statements.starts.len()], Vec::new());
        let mut declared = String::new();
        for (index, stop) in stops.iter().enumerate() {
            let failed = |column, message: String| StopError { stop: index, column, message };
            if self.variant.source.contains(STOP) || self.variant.source.contains(WATCH) {
                return Err(failed(1, format!("names that begin with {STOP} or {WATCH} are reserved")));
            }
            let Some(put) = before.get_mut(stop.statement) else {
                return Err(failed(1, "no statement begins there".to_owned()));
            };
            let names = match &stop.when {
                None => {
                    let _ = write!(put, "{STOP}{index}(true);");
                    Vec::new()
                }
                Some(when) => {
                    let when = self.condition(stop.statement, when).map_err(|(column, why)| failed(column, why))?;
                    let names = self.variables(stop.statement, &when);
                    for (at, name) in names.iter().enumerate() {
                        *put += &watch(index, &at.to_string(), name);
                    }
                    *put += &watch(index, WHOLE, &when);
                    let _ = write!(put, "{STOP}{index}({WATCH}{index}_{WHOLE});");
                    names
                }
            };
            watched.push(names);
            let _ = writeln!(declared, "fn {STOP}{index}(holds: bool) {{}}");
        }
        if is_traced {
            before.iter_mut().filter(|put| !put.is_empty()).for_each(|put| *put = now(put));
            declared += &self.trace(&mut before);
        }
        let source = self.with(&before) + &declared;
        Ok(Stopping { variant: Variant { source, ..self.variant.clone() }, watched })
    }

    /// The kernel, traced as above, that computes an expression before a statement, under a name that views know.
    ///
    /// # Errors
    /// If it is no expression there.
    pub fn evaluating(&self, statement: usize, expression: &str) -> Result<Variant, StopError> {
        let failed = |(column, message)| StopError { stop: 0, column, message };
        let expression = cleaned(expression).map_err(failed)?;
        self.check(statement, &expression).map_err(failed)?;
        let mut before = vec![String::new(); self.statements.starts.len()];
        if let Some(put) = before.get_mut(statement) {
            *put = now(&watch(0, WHOLE, &expression));
        }
        let declared = self.trace(&mut before);
        let source = self.with(&before) + &declared;
        Ok(Variant { source, ..self.variant.clone() })
    }

    /// Puts a call before each statement, and returns the function that is called.
    fn trace(&self, before: &mut [String]) -> String {
        let open = self.statements.starts.iter().zip(before).enumerate();
        for (index, (_, put)) in open.filter(|(_, (start, _))| start.is_open) {
            let _ = write!(put, "{AT}({index}u);");
        }
        format!("fn {AT}(statement: u32) {{}}\nfn {NOW}() -> bool {{ return true; }}\n")
    }

    /// The names that can be used before a statement, the last declared first.
    #[must_use]
    pub fn names(&self, statement: usize) -> Vec<&str> {
        let at = self.statements.starts.get(statement).map_or(0, |start| start.at);
        self.statements.names(at).into_iter().map(|declared| declared.name.as_str()).collect()
    }

    /// The text with others before its statements.
    fn with(&self, before: &[String]) -> String {
        let source = &self.variant.source;
        let mut text = String::with_capacity(source.len() + before.iter().map(String::len).sum::<usize>());
        let mut end = 0;
        for (start, put) in self.statements.starts.iter().zip(before) {
            text += &source[end..start.at];
            text += put;
            end = start.at;
        }
        text + &source[end..]
    }

    /// The text with another before one of its statements, and where that is.
    fn with_one(&self, statement: usize, put: &str) -> (String, usize) {
        let at = self.statements.starts.get(statement).map_or(0, |start| start.at);
        let mut text = self.variant.source.clone();
        text.insert_str(at, put);
        (text, at)
    }

    /// A condition as it can be computed before a statement; or where and what is wrong.
    fn condition(&self, statement: usize, when: &str) -> Result<String, (usize, String)> {
        let when = cleaned(when)?;
        match self.check(statement, &when)? {
            TypeInner::Scalar(naga::Scalar { kind: ScalarKind::Bool, .. }) => Ok(when),
            other => {
                let (what, right) = match other {
                    TypeInner::Scalar(scalar) if scalar.kind == ScalarKind::Float => {
                        ("a float", "compare it, as in x < 0.0")
                    }
                    TypeInner::Scalar(_) => ("an integer", "compare it, as in x == 0"),
                    TypeInner::Vector { scalar, .. } if scalar.kind == ScalarKind::Bool => {
                        ("a vector of truth values", "use any(…) or all(…)")
                    }
                    TypeInner::Vector { .. } => ("a vector", "compare one of its components, as in x.y < 0.0"),
                    _ => ("something else", "compare a part of it"),
                };
                Err((1, format!("a condition is true or false, and this is {what}: {right}")))
            }
        }
    }

    /// The type of an expression before a statement; or where and what is wrong.
    fn check(&self, statement: usize, expression: &str) -> Result<TypeInner, (usize, String)> {
        let (text, at) = self.with_one(statement, &watch(0, WHOLE, expression));
        let first = at + watch(0, WHOLE, "").len() - ");".len();
        let inside = first..first + expression.len() + 1;
        let (module, info) = checked(&text, &inside).map_err(|(at, message)| {
            let column = expression.get(..at).map_or(1, |before| before.chars().count() + 1);
            (column, self.told(statement, message))
        })?;
        let plain = module.functions.iter().map(|(handle, function)| (function, &info[handle]));
        let entries = module.entry_points.iter().enumerate();
        let mut all = plain.chain(entries.map(|(at, entry)| (&entry.function, info.get_entry_point(at))));
        let found = all.find_map(|(function, info)| {
            let name = function.named_expressions.iter().find(|(_, name)| watched_by(name).is_some());
            name.map(|(handle, _)| info[*handle].ty.inner_with(&module.types).clone())
        });
        found.ok_or_else(|| (1, "it has no value".to_owned()))
    }

    /// A message with what could be meant.
    fn told(&self, statement: usize, message: String) -> String {
        if !message.contains("no definition in scope") {
            return message;
        }
        let mut names = self.names(statement);
        names.sort_unstable();
        match names.as_slice() {
            [] => message,
            names => format!("{message}; variables here: {}", names.join(", ")),
        }
    }

    /// The variables in a condition, with members, whose values can be shown.
    fn variables(&self, statement: usize, when: &str) -> Vec<String> {
        let found = paths(when);
        let puts = |names: &[String]| {
            let lets = names.iter().enumerate().map(|(index, name)| watch(0, &index.to_string(), name));
            let (text, _) = self.with_one(statement, &lets.collect::<String>());
            checked(&text, &(0..0)).is_ok()
        };
        if puts(&found) {
            return found;
        }
        found.into_iter().filter(|name| puts(std::slice::from_ref(name))).collect()
    }
}

/// A valid module; or the byte of a part of the text, and what is wrong.
fn checked(text: &str, inside: &Range<usize>) -> Result<(Module, ModuleInfo), (usize, String)> {
    let place = |range: Option<Range<usize>>| {
        let at = range.filter(|range| inside.contains(&range.start)).map(|range| range.start);
        at.map(|at| at - inside.start)
    };
    let module = naga::front::wgsl::parse_str(text).map_err(|error| {
        let at = error.labels().find_map(|(span, _)| place(span.to_range())).unwrap_or(0);
        (at, error.message().to_owned())
    })?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::all()).validate(&module).map_err(|error| {
        let at = error.spans().find_map(|(span, _)| place(span.to_range())).unwrap_or(0);
        let mut last: &dyn std::error::Error = error.as_inner();
        while let Some(inner) = last.source() {
            last = inner;
        }
        (at, last.to_string())
    })?;
    Ok((module, info))
}

/// An expression on one line without comments; or where and what is wrong.
fn cleaned(when: &str) -> Result<String, (usize, String)> {
    if when.len() > MOST_LETTERS {
        return Err((1, format!("longer than {MOST_LETTERS} letters")));
    }
    let all = words(when);
    let column = |word: &Word<'_>| when[..word.start].chars().count() + 1;
    let comments: Vec<_> = all.iter().filter(|w| w.kind == WordKind::Comment).map(|w| w.start..w.end()).collect();
    let code: Vec<_> = all.iter().filter(|word| word.kind != WordKind::Comment).collect();
    let expected = "expected one expression of WGSL, as in x < 0.0";
    if code.is_empty() {
        return Err((1, expected.to_owned()));
    }
    let mut open: Vec<&str> = Vec::new();
    for (index, word) in code.iter().enumerate() {
        let next = code.get(index + 1).map_or("", |next| next.text);
        let is_assigned = word.text == "="
            && next != "="
            && !index.checked_sub(1).is_some_and(|at| matches!(code[at].text, "=" | "<" | ">" | "!"));
        let closes = match word.text {
            "(" | "[" => {
                open.push(word.text);
                true
            }
            ")" => open.pop() == Some("("),
            "]" => open.pop() == Some("["),
            _ => true,
        };
        if is_assigned {
            return Err((column(word), "= stores a value: == compares two".to_owned()));
        }
        if !closes {
            return Err((column(word), format!("nothing is open here that {} closes", word.text)));
        }
        if matches!(word.text, ";" | "{" | "}") || word.kind == WordKind::Attribute {
            return Err((column(word), expected.to_owned()));
        }
        if [STOP, WATCH, AT, NOW].iter().any(|reserved| word.text.starts_with(reserved)) {
            return Err((column(word), format!("the name {} is reserved", word.text)));
        }
    }
    if let Some(open) = open.pop() {
        return Err((when.chars().count() + 1, format!("{open} is not closed")));
    }
    Ok(blanked(when, &comments).replace(['\n', '\r'], " "))
}

/// Names with their members that are no calls, each once, in their order.
fn paths(when: &str) -> Vec<String> {
    let all = words(when);
    let mut found: Vec<String> = Vec::new();
    let mut at = 0;
    while at < all.len() {
        let word = &all[at];
        let is_member = at > 0 && all[at - 1].text == ".";
        at += 1;
        if word.kind != WordKind::Name || is_member || matches!(word.text, "true" | "false") {
            continue;
        }
        let mut path = word.text.to_owned();
        while let [dot, member, ..] = &all[at.min(all.len())..]
            && dot.text == "."
            && member.kind == WordKind::Name
        {
            path = path + "." + member.text;
            at += 2;
        }
        let is_call = all.get(at).is_some_and(|next| next.text == "(");
        if !is_call && found.len() < MOST_WATCHED && !found.contains(&path) {
            found.push(path);
        }
    }
    found
}

#[cfg(test)]
mod tests;
