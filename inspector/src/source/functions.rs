//! Where the functions of a source are, and which lines of a kernel's own files are which lines of its composed source.

use std::collections::HashSet;
use std::ops::Range;

use super::Mark;
use super::words::words;

/// A function: its name and its lines, from 0.
struct Function {
    name: String,
    lines: Range<usize>,
}

fn functions(text: &str) -> Vec<Function> {
    let line_starts: Vec<usize> = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
    let line = |at: usize| line_starts.partition_point(|&start| start <= at).saturating_sub(1);
    let words = words(text);
    let mut found = Vec::new();
    let mut open: Option<(String, usize, usize)> = None;
    for (i, word) in words.iter().enumerate() {
        match (&text[word.range.clone()], &mut open) {
            ("fn", None) => {
                let name = words.get(i + 1).map_or("", |next| &text[next.range.clone()]);
                open = Some((name.to_owned(), line(word.range.start), 0));
            }
            ("{", Some((.., depth))) => *depth += 1,
            ("}", Some((name, first, depth))) => {
                *depth = depth.saturating_sub(1);
                if *depth == 0 {
                    found.push(Function { name: std::mem::take(name), lines: *first..line(word.range.start) + 1 });
                    open = None;
                }
            }
            _ => {}
        }
    }
    found
}

/// The lines of the functions of a kernel's own files that are not in the composed source: nothing calls them.
pub(super) fn dropped(own: &str, composed: &str) -> Vec<Range<usize>> {
    let kept: HashSet<String> = functions(composed).into_iter().map(|function| function.name).collect();
    let is_dropped = |function: &Function| !kept.contains(&function.name);
    functions(own).into_iter().filter(is_dropped).map(|function| function.lines).collect()
}

/// For every line of a kernel's own files, the line of the composed source that it became; `None` for lines outside of
/// functions, and for those that were left out.
pub(super) fn in_composed(own: &str, marks: &[Mark], composed: &str) -> Vec<Option<usize>> {
    let own_lines: Vec<&str> = own.split('\n').collect();
    let composed_lines: Vec<&str> = composed.split('\n').collect();
    let composed_functions = functions(composed);
    let mut placed = vec![None; own_lines.len()];
    for function in functions(own) {
        let is_kept = marks.get(function.lines.start) != Some(&Mark::LeftOut);
        let Some(there) = composed_functions.iter().find(|f| is_kept && f.name == function.name) else { continue };
        let mut next = there.lines.start;
        for at in function.lines {
            let text = own_lines.get(at).map_or("", |line| decided(line));
            if text.is_empty() || marks.get(at) == Some(&Mark::LeftOut) {
                continue;
            }
            let rest = composed_lines.get(next..there.lines.end).unwrap_or_default();
            if let Some(skipped) = rest.iter().position(|line| line.trim() == text) {
                placed[at] = Some(next + skipped);
                next += skipped + 1;
            }
        }
    }
    placed
}

/// A line without the attributes that choose it.
fn decided(line: &str) -> &str {
    let mut text = line.trim();
    loop {
        let rest = if let Some(rest) = text.strip_prefix("@else") {
            rest
        } else if text.starts_with("@if(") {
            let mut depth = 0usize;
            let close = text.char_indices().find(|&(_, c)| {
                depth = match c {
                    '(' => depth + 1,
                    ')' => depth.saturating_sub(1),
                    _ => depth,
                };
                c == ')' && depth == 0
            });
            close.map_or("", |(at, _)| &text[at + 1..])
        } else {
            return text;
        };
        text = rest.trim_start();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_are_not_part_of_what_a_line_decides() {
        assert_eq!(decided("    @if(a && !(b || c)) let x = 1;"), "let x = 1;");
        assert_eq!(decided("@else @if(d) return (y);"), "return (y);");
        assert_eq!(decided("@if(a)"), "");
    }
}
