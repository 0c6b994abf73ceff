//! `@if(expression)` and `@else`: cuts what the options leave out of a module's text.

use std::ops::Range;

use super::ComposeError;
use super::condition::holds;
use super::words::{Word, blanked, code, line_of, with_comment_above, without};

/// One branch of a choice: a declaration, import, statement or struct member that is kept or left out.
struct Arm {
    /// Byte offset of its attributes.
    start: usize,
    /// Byte offset of the item itself.
    body: usize,
    /// Byte offset after its last byte.
    end: usize,
    is_in: bool,
    /// Whether an `@else` follows directly.
    has_else: bool,
}

/// The text of a module after all options are decided; what they leave out is removed, or becomes spaces.
///
/// # Errors
/// If an attribute cannot be parsed.
pub(super) fn decided(
    module: &str,
    text: &str,
    option: &dyn Fn(&str) -> Option<bool>,
    is_in_place: bool,
) -> Result<String, ComposeError> {
    let removed = arms(module, text, option)?.into_iter().map(|arm| match arm {
        Arm { is_in: true, start, body, .. } => start..body,
        // A comment right above belongs to both branches, if there are two.
        Arm { has_else: true, start, end, .. } => start..end,
        Arm { start, end, .. } => with_comment_above(text, start)..end,
    });
    let removed: Vec<_> = removed.collect();
    Ok(if is_in_place { blanked(text, &removed) } else { without(text, &removed) })
}

/// The byte ranges that the options leave out of a module's text, attributes included, in order. Nested ranges are not
/// listed separately.
///
/// # Errors
/// If an attribute cannot be parsed.
pub fn left_out(
    module: &str,
    text: &str,
    option: &dyn Fn(&str) -> Option<bool>,
) -> Result<Vec<Range<usize>>, ComposeError> {
    let out = arms(module, text, option)?.into_iter().filter(|arm| !arm.is_in);
    Ok(out.map(|arm| arm.start..arm.end).collect())
}

/// All branches in a text, except those inside of one that is left out.
fn arms(module: &str, text: &str, option: &dyn Fn(&str) -> Option<bool>) -> Result<Vec<Arm>, ComposeError> {
    let words = code(text);
    let mut arms = Vec::new();
    // For each open brace, whether it opens a struct, whose members end with commas.
    let mut in_struct = Vec::new();
    // At every depth: where the branches ended, as an `@else` must follow right there, and whether one of their choice
    // was kept.
    let mut ended: Vec<(usize, bool)> = Vec::new();
    let mut struct_is_next = false;
    let mut at = 0;
    while at < words.len() {
        let word = &words[at];
        match word.text {
            "@if" | "@else" => {}
            other => {
                match other {
                    "struct" => struct_is_next = true,
                    "{" => in_struct.push(std::mem::take(&mut struct_is_next)),
                    "}" => drop(in_struct.pop()),
                    _ => {}
                }
                at += 1;
                continue;
            }
        }
        let failed = |message: &str| ComposeError::Malformed {
            module: module.to_owned(),
            line: line_of(text, word.start),
            message: message.to_owned(),
        };
        let mut was_in = false;
        if word.text == "@else" {
            let before = ended.iter().rev().find(|(end, _)| *end == at);
            was_in = before.ok_or_else(|| failed(LONE_ELSE))?.1;
            at += 1;
        }
        // All conditions must be true, and after `@else` no earlier branch may have been kept.
        let mut is_in = !was_in;
        while words.get(at).is_some_and(|next| next.text == "@if") {
            let close = closed(&words, at + 1).ok_or_else(|| failed("@if without (expression)"))?;
            let expression = &text[words[at + 1].end()..words[close].start];
            is_in &= holds(expression, option).map_err(|message| failed(&message))?;
            at = close + 1;
        }
        if words.get(at).is_some_and(|next| next.text == "@else") {
            return Err(failed(LONE_ELSE));
        }
        let is_member = in_struct.last() == Some(&true);
        let end = node_end(&words, at, is_member).ok_or_else(|| failed("nothing complete comes after this"))?;
        let has_else = words.get(end).is_some_and(|next| next.text == "@else");
        ended.push((end, was_in || is_in));
        arms.push(Arm { start: word.start, body: words[at].start, end: words[end - 1].end(), is_in, has_else });
        if !is_in {
            at = end;
        }
    }
    Ok(arms)
}

const LONE_ELSE: &str = "@else without an @if right before it";

/// The word that closes the parenthesis opened at a word.
fn closed(words: &[Word<'_>], open: usize) -> Option<usize> {
    if words.get(open)?.text != "(" {
        return None;
    }
    let mut depth = 0usize;
    for (at, word) in words.iter().enumerate().skip(open) {
        match word.text {
            "(" => depth += 1,
            ")" => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return Some(at);
        }
    }
    None
}

/// The index of the word after a declaration, a statement or a struct member.
pub(super) fn node_end(words: &[Word<'_>], from: usize, is_member: bool) -> Option<usize> {
    let mut depth = 0usize;
    // The braces of an import are a list.
    let is_import = words.get(from)?.text == "import";
    // In a member's type, `<` and `>` are brackets.
    let mut template = 0usize;
    for (at, word) in words.iter().enumerate().skip(from) {
        match word.text {
            "<" if is_member => template += 1,
            ">" if is_member => template = template.checked_sub(1)?,
            "," if is_member && depth == 0 && template == 0 => return Some(at + 1),
            ";" if depth == 0 => return Some(at + 1),
            "(" | "[" | "{" => depth += 1,
            // The enclosing block ends here: the last member needs no comma.
            "}" if depth == 0 => return (is_member && at > from).then_some(at),
            ")" | "]" | "}" => {
                depth = depth.checked_sub(1)?;
                let goes_on = is_import || words.get(at + 1).is_some_and(|next| next.text == "else");
                if depth == 0 && word.text == "}" && !goes_on {
                    return Some(at + 1);
                }
            }
            _ => {}
        }
    }
    None
}
