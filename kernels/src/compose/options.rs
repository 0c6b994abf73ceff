//! `@if(expression)` and `@else`: what the options leave out of a module is cut from its text.

use std::ops::Range;

use super::condition::holds;
use super::words::{Word, line_of, with_comment_above, without, words};

/// The text with all options decided.
///
/// # Errors
/// The line, and what is not understood there.
pub(super) fn decided(text: &str, option: &dyn Fn(&str) -> Option<bool>) -> Result<String, (usize, String)> {
    let words = words(text);
    let mut removed: Vec<Range<usize>> = Vec::new();
    // For each open brace whether it is a struct's, whose members end with commas.
    let mut in_struct = Vec::new();
    // Where the last conditional ended and whether its expression held: an `@else` stands right there. Of every depth.
    let mut ended: Vec<(usize, bool)> = Vec::new();
    let mut struct_is_next = false;
    let mut at = 0;
    while at < words.len() {
        let word = &words[at];
        let failed = |message: String| (line_of(text, word.start), message);
        let (value, body) = match word.text {
            "@if" => {
                let close = closed(&words, at + 1).ok_or_else(|| failed("@if without (expression)".into()))?;
                let expression = &text[words[at + 1].end()..words[close].start];
                (holds(expression, option).map_err(failed)?, close + 1)
            }
            "@else" => {
                let before = ended.iter().rev().find(|(end, _)| *end == at);
                let (_, held) = before.ok_or_else(|| failed("@else without an @if right before it".into()))?;
                (!held, at + 1)
            }
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
        };
        let is_member = in_struct.last() == Some(&true);
        let end =
            node_end(&words, body, is_member).ok_or_else(|| failed("nothing complete comes after this".into()))?;
        let has_else = words.get(end).is_some_and(|next| next.text == "@else");
        ended.push((end, value));
        if value {
            let next = words.get(body).map_or(text.len(), |next| next.start);
            removed.push(word.start..next);
            at = body;
        } else {
            // What is said right above belongs to both arms where there are two.
            let start = if has_else { word.start } else { with_comment_above(text, word.start) };
            removed.push(start..words[end - 1].end());
            at = end;
        }
    }
    Ok(without(text, &removed))
}

/// The word that closes the parenthesis at a word.
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

/// The word after a declaration, a statement or a struct's member.
pub(super) fn node_end(words: &[Word<'_>], from: usize, is_member: bool) -> Option<usize> {
    let mut depth = 0usize;
    // The braces of an import are a list.
    let is_import = words.get(from)?.text == "import";
    // Of a member's type, `<` and `>` are brackets.
    let mut template = 0usize;
    for (at, word) in words.iter().enumerate().skip(from) {
        match word.text {
            "<" if is_member => template += 1,
            ">" if is_member => template = template.checked_sub(1)?,
            "," if is_member && depth == 0 && template == 0 => return Some(at + 1),
            ";" if depth == 0 => return Some(at + 1),
            "(" | "[" | "{" => depth += 1,
            // The end of what the node stands in: a last member needs no comma.
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
