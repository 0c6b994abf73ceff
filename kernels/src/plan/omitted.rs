//! What a plan leaves out, as `raystep plan` prints it: first of all what the scene does not need, a row each with the
//! reason; at the end the rest, of which each line names what would need it.

use std::fmt;

use super::{Because, LeftOut};

/// Most characters of a line, unless one name is longer.
const MOST_CHARS: usize = 100;

/// What the scene does not need.
pub(super) struct NotNeeded<'a>(pub(super) &'a [LeftOut]);

impl fmt::Display for NotNeeded<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let items: Vec<&LeftOut> = of(self.0, Because::Scene).collect();
        if !items.is_empty() {
            writeln!(f, "\nomitted, as the scene does not need it")?;
        }
        items.iter().try_for_each(|item| writeln!(f, "  {:<34} {}", item.what, item.reason))
    }
}

/// What else is left out.
pub(super) struct Omitted<'a>(pub(super) &'a [LeftOut]);

impl fmt::Display for Omitted<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (because, title) in
            [(Because::Options, "omitted with these options"), (Because::View, "omitted for this result")]
        {
            let groups = groups(of(self.0, because));
            if !groups.is_empty() {
                writeln!(f, "\n{title}")?;
            }
            for (reason, items) in groups {
                write_wrapped(f, &format!("{}: {reason}", in_words(&items)))?;
            }
        }
        Ok(())
    }
}

fn of(items: &[LeftOut], because: Because) -> impl Iterator<Item = &LeftOut> {
    items.iter().filter(move |item| item.because == because)
}

/// The things that are left out for the same reason, in order of first occurrence.
fn groups<'a>(items: impl Iterator<Item = &'a LeftOut>) -> Vec<(&'static str, Vec<&'a str>)> {
    let mut groups: Vec<(&'static str, Vec<&str>)> = Vec::new();
    for item in items {
        match groups.iter_mut().find(|(reason, _)| *reason == item.reason) {
            Some((_, of_group)) => of_group.push(&item.what),
            None => groups.push((item.reason, vec![&item.what])),
        }
    }
    groups
}

/// `kernel a; buffers b, c` of `kernel a`, `buffer b` and `buffer c`.
fn in_words(items: &[&str]) -> String {
    let kind = |item: &str| item.split(' ').next().unwrap_or_default().to_owned();
    let of_kind = items.chunk_by(|a, b| kind(a) == kind(b)).map(|items| match items {
        [only] => (*only).to_owned(),
        _ => {
            let kind = kind(items[0]);
            let names: Vec<&str> = items.iter().map(|item| item[kind.len()..].trim_start()).collect();
            format!("{kind}s {}", names.join(", "))
        }
    });
    of_kind.collect::<Vec<_>>().join("; ")
}

/// Writes words in lines of at most [`MOST_CHARS`], the first of which is indented less than the others.
fn write_wrapped(f: &mut fmt::Formatter<'_>, text: &str) -> fmt::Result {
    let mut line = String::from("  ");
    for word in text.split(' ') {
        if line.chars().count() + 1 + word.chars().count() > MOST_CHARS && !line.trim().is_empty() {
            writeln!(f, "{line}")?;
            line = String::from("      ");
        }
        if !line.trim().is_empty() {
            line.push(' ');
        }
        line += word;
    }
    writeln!(f, "{line}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn out(what: &str, because: Because, reason: &'static str) -> LeftOut {
        LeftOut { what: what.into(), because, reason, item: None }
    }

    #[test]
    fn what_the_scene_does_not_need_has_a_row_each_and_the_rest_is_grouped_by_what_would_need_it() {
        let all = [
            out("kernel b", Because::Options, "needed only with --b"),
            out("stream c", Because::Options, "needed only with --c"),
            out("stream b", Because::Options, "needed only with --b"),
            out("buffer normals", Because::Scene, "no vertex normals"),
            out("buffer b", Because::Options, "needed only with --b"),
            out("buffer bb", Because::Options, "needed only with --b"),
            out("kernel shade", Because::View, "the result is hits"),
        ];
        assert_eq!(
            NotNeeded(&all).to_string(),
            "\nomitted, as the scene does not need it\n  buffer normals                     no vertex normals\n"
        );
        assert_eq!(
            Omitted(&all).to_string(),
            "\nomitted with these options\n  kernel b; stream b; buffers b, bb: needed only with --b\n  stream c: needed \
             only with --c\n\nomitted for this result\n  kernel shade: the result is hits\n"
        );
        assert_eq!(format!("{}{}", NotNeeded(&[]), Omitted(&[])), "");
    }

    #[test]
    fn long_lines_are_wrapped_between_words() {
        let all: Vec<LeftOut> =
            (0..40).map(|i| out(&format!("buffer name_{i}"), Because::Options, "needed only with --b")).collect();
        let text = Omitted(&all).to_string();
        assert!(text.lines().count() > 4 && text.lines().all(|line| line.len() <= MOST_CHARS), "{text}");
        assert!((0..40).all(|i| text.contains(&format!("name_{i}"))));
    }
}
