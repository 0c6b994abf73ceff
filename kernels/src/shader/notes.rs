//! What a user's kernel prints and asserts: `note("label", value)` and `assert_that(condition, "label")`.
//!
//! WGSL has no strings, so these statements become calls of functions without a body, whose names say which statement it is,
//! and every column of the file stays where it is. The interpreter knows the names. A device gets no notes at all, and counts
//! the assertions that do not hold.

use std::ops::Range;

use naga::valid::{Capabilities, ValidationFlags, Validator};
use naga::{ScalarKind, TypeInner};

use super::mistake::{Mistake, place_of};
use crate::compose::{Word, WordKind, blanked, words};
use crate::options::replacement::Replacement;
use crate::shared::constants::INF;

/// Most words of all notes of a kernel: each component of a value is one.
pub const MOST_NOTE_WORDS: u32 = 8;
/// Most assertions of a kernel: each has a counter of the pass.
pub const MOST_ASSERTIONS: usize = 8;

const NOTE: &str = "note___";
const ASSERTION: &str = "assert___";
/// As long as the beginning of a note's call.
const LET: &str = "let nt";

/// A value that a kernel prints.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Noted {
    /// Its label.
    pub label: String,
    /// Its type: that of a vector's components.
    pub kind: ScalarKind,
    /// Number of components.
    pub words: u32,
}

/// The last value that an element has printed by a note, and how often it has.
pub type Printed = ([u32; 4], u32);

/// What a kernel prints and asserts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Notes {
    /// The notes.
    pub noted: Vec<Noted>,
    /// Labels of the assertions.
    pub asserted: Vec<String>,
}

impl Noted {
    /// Whether its values are floats.
    #[must_use]
    pub fn is_float(&self) -> bool {
        self.kind == ScalarKind::Float
    }

    /// A value in words: `t = 0.5`, and how often it was printed, if several times. `None` if it was not printed.
    #[must_use]
    pub fn told(&self, (values, times): Printed) -> Option<String> {
        let number = |bits: u32| match self.kind {
            // As kernels write it.
            ScalarKind::Float if bits == INF.to_bits() => "INF".to_owned(),
            ScalarKind::Float | ScalarKind::AbstractFloat => f32::from_bits(bits).to_string(),
            ScalarKind::Sint | ScalarKind::AbstractInt => bits.cast_signed().to_string(),
            ScalarKind::Bool => (bits != 0).to_string(),
            ScalarKind::Uint => bits.to_string(),
        };
        let numbers: Vec<String> = values.into_iter().take(self.words as usize).map(number).collect();
        match times {
            0 => None,
            1 => Some(format!("{} = {}", self.label, numbers.join(" "))),
            _ => Some(format!("{} = {}, the last of {times}", self.label, numbers.join(" "))),
        }
    }
}

/// A user's text with calls in place of such statements.
pub(super) struct Marked {
    pub(super) text: String,
    notes: Vec<(String, usize)>,
    asserted: Vec<String>,
}

/// Which note or assertion a function stands for.
pub(crate) fn statement_of(function: &str) -> Option<(bool, usize)> {
    let note = function.strip_prefix(NOTE).map(|index| (false, index));
    let (is_assertion, index) = note.or(function.strip_prefix(ASSERTION).map(|index| (true, index)))?;
    Some((is_assertion, index.parse().ok()?))
}

impl Marked {
    /// Finds the statements.
    pub(super) fn new(by: &Replacement) -> Result<Self, Mistake> {
        let source = &by.source;
        let mistake = |at: usize, message: String| Mistake { place: place_of(by, at), message };
        let (mut text, mut notes, mut asserted) = (source.clone(), Vec::new(), Vec::new());
        let all = words(source);
        let code: Vec<_> = all.iter().filter(|word| word.kind != WordKind::Comment).collect();
        for (index, word) in code.iter().enumerate() {
            if word.text.starts_with(NOTE) || word.text.starts_with(ASSERTION) {
                return Err(mistake(word.start, reserved(word.text)));
            }
            let is_note = word.text == "note";
            let is_call = code.get(index + 1).is_some_and(|next| next.text == "(");
            if !is_call || !is_note && word.text != "assert_that" {
                continue;
            }
            if index > 0 && code[index - 1].text == "fn" {
                return Err(mistake(word.start, reserved(word.text)));
            }
            let right = if is_note { "note(\"label\", value);" } else { "assert_that(condition, \"label\");" };
            let wrong = || mistake(word.start, format!("expected {right}"));
            let open = code[index + 1].start;
            let close = open + length(&code[index + 1..]).ok_or_else(wrong)?;
            let quotes: Vec<usize> = source[open..close].match_indices('"').map(|(at, _)| open + at).collect();
            let &[first, last] = quotes.as_slice() else { return Err(wrong()) };
            let label = source[first + 1..last].to_owned();
            if !(1..=MOST_LETTERS).contains(&label.chars().count()) || label.contains(['/', '\n', '\r', '\\']) {
                let message = format!("a label has 1 to {MOST_LETTERS} characters, without slashes and line breaks");
                return Err(mistake(first, message));
            }
            // Everything keeps its place.
            let mut put = |removed: Range<usize>, at: usize, name: String| {
                text = blanked(&text, &[removed]);
                text.replace_range(at..at + name.len(), &name);
            };
            if is_note {
                let comma = last + 1 + source[last + 1..close].find(',').ok_or_else(wrong)?;
                if !source[open + 1..first].trim().is_empty() || !source[last + 1..comma].trim().is_empty() {
                    return Err(wrong());
                }
                put(word.start..comma + 1, word.start, format!("{NOTE}{}(", notes.len()));
                notes.push((label, word.start));
            } else {
                let before = source[..first].trim_end();
                if !before.ends_with(',') || !source[last + 1..close].trim().is_empty() {
                    return Err(wrong());
                }
                put(before.len() - 1..close, word.start, format!("{ASSERTION}{} ", asserted.len()));
                asserted.push(label);
            }
            if notes.len() > MOST_NOTE_WORDS as usize {
                return Err(mistake(word.start, format!("all notes of a kernel have at most {MOST_NOTE_WORDS} words")));
            }
            if asserted.len() > MOST_ASSERTIONS {
                return Err(mistake(word.start, format!("a kernel has at most {MOST_ASSERTIONS} assertions")));
            }
        }
        Ok(Self { text, notes, asserted })
    }

    /// The functions of the assertions.
    fn assertions(&self) -> String {
        (0..self.asserted.len()).map(|index| assertion(index) + "\n").collect()
    }

    /// Declares the functions that the composed text calls. The type of a note is that of a constant in its place.
    pub(super) fn declare(self, by: &Replacement, composed: &mut String) -> Result<Notes, Mistake> {
        let mut kinds: Vec<Option<(ScalarKind, u32)>> = vec![None; self.notes.len()];
        // Of two notes of one expression, naga keeps the name of the last: the other is found next time.
        for _ in 0..self.notes.len() {
            let mut text = composed.clone() + &self.assertions();
            for (index, kind) in kinds.iter().enumerate() {
                match kind {
                    Some(kind) => text += &declaration(index, *kind),
                    None => text = text.replace(&format!("{NOTE}{index}("), &format!("{LET}{index}=(")),
                }
            }
            // What is wrong with the text is told by whoever parses it next; its columns are those of the file.
            let module = naga::front::wgsl::parse_str(&text);
            let info = module.as_ref().ok().map(|module| {
                Validator::new(ValidationFlags::empty(), Capabilities::default()).validate(module).map_err(drop)
            });
            let (Ok(module), Some(Ok(info))) = (module, info) else {
                *composed = text;
                return Ok(Notes::default());
            };
            let plain = module.functions.iter().map(|(handle, function)| (function, &info[handle]));
            let entries = module.entry_points.iter().enumerate();
            let all = plain.chain(entries.map(|(at, entry)| (&entry.function, info.get_entry_point(at))));
            let mut is_new = false;
            for (function, info) in all {
                for (expression, name) in &function.named_expressions {
                    let index = name.strip_prefix(&LET["let ".len()..]).and_then(|index| index.parse::<usize>().ok());
                    let Some(index) = index.filter(|&index| kinds.get(index) == Some(&None)) else { continue };
                    let kind = match *info[*expression].ty.inner_with(&module.types) {
                        TypeInner::Scalar(scalar) => Some((scalar.kind, 1)),
                        TypeInner::Vector { size, scalar } => Some((scalar.kind, size as u32)),
                        _ => None,
                    };
                    let message = || "a note has a number, a truth value, or a vector of these".to_owned();
                    let at = self.notes[index].1;
                    kinds[index] = Some(kind.ok_or_else(|| Mistake { place: place_of(by, at), message: message() })?);
                    is_new = true;
                }
            }
            if !is_new {
                break;
            }
        }
        let words: u32 = kinds.iter().flatten().map(|(_, words)| words).sum();
        if let Some((_, at)) = self.notes.last().filter(|_| words > MOST_NOTE_WORDS) {
            let message = format!("all notes of a kernel have at most {MOST_NOTE_WORDS} words, and these have {words}");
            return Err(Mistake { place: place_of(by, *at), message });
        }
        *composed += &self.assertions();
        let known = kinds.iter().enumerate().filter_map(|(index, kind)| Some(declaration(index, (*kind)?)));
        known.for_each(|text| *composed += &text);
        // A note in a function that is never called has no type, and is never printed.
        let noted = self.notes.into_iter().zip(kinds).map(|((label, _), kind)| {
            let (kind, words) = kind.unwrap_or((ScalarKind::Uint, 0));
            Noted { label, kind, words }
        });
        Ok(Notes { noted: noted.collect(), asserted: self.asserted })
    }
}

/// Most characters of a label.
const MOST_LETTERS: usize = 32;

/// The function of an assertion.
pub(super) fn assertion(index: usize) -> String {
    format!("fn {ASSERTION}{index}(holds: bool) {{}}")
}

/// The function of a note.
fn declaration(index: usize, (kind, words): (ScalarKind, u32)) -> String {
    let scalar = match kind {
        ScalarKind::Float | ScalarKind::AbstractFloat => "f32",
        ScalarKind::Sint | ScalarKind::AbstractInt => "i32",
        ScalarKind::Uint => "u32",
        ScalarKind::Bool => "bool",
    };
    let ty = if words == 1 { scalar.to_owned() } else { format!("vec{words}<{scalar}>") };
    format!("fn {NOTE}{index}(value: {ty}) {{}}\n")
}

/// Bytes from an opening parenthesis to the one that closes it.
fn length(code: &[&Word<'_>]) -> Option<usize> {
    let mut depth = 0;
    let close = code.iter().find(|word| {
        depth += match word.text {
            "(" | "[" | "{" => 1,
            ")" | "]" | "}" => -1,
            _ => 0,
        };
        depth == 0
    });
    Some(close?.start - code.first()?.start)
}

fn reserved(name: &str) -> String {
    format!("the name {name} is reserved: choose another")
}

#[cfg(test)]
mod tests;
