//! Sections 4.5 and 5.2: numbers of programs, textures and lines.

use std::collections::BTreeSet;

use raystep_kernels::shader::Resource;
use raystep_kernels::{Limits, Plan, Stream};

use super::{cells, options, titled};
use crate::tidy::{Row, Table};
use crate::{Error, Size, Subject};

pub(super) const COLUMNS: &[&str] = columns![schema_version name paper here];

/// What is counted, the paper's number, and ours.
#[derive(Clone, Debug)]
pub struct Counts(Vec<[String; 3]>);

/// Counts what a run of the paper's second strategy needs.
///
/// # Errors
/// If the scene cannot be planned.
pub fn counts(subject: &Subject) -> Result<Counts, Error> {
    let options = options(subject, Size { width: 512, height: 512 });
    let (plan, _) = Plan::new(&subject.scene, &options, &Limits::CPU)?;
    let accesses = || plan.variants.iter().flat_map(|variant| variant.streams());
    // One program for each output; a stream that a kernel reads and writes takes two textures (sections 4.4.1, 4.4.2).
    let draws = accesses().filter(|(_, binding)| binding.writes).count();
    let is_double = |stream: &Stream| accesses().any(|(of, binding)| of == *stream && binding.reads && binding.writes);
    let streams: Vec<Stream> = plan.streams.iter().map(|stream| stream.what).collect();
    let doubles = streams.iter().filter(|stream| is_double(stream)).count();
    let kernels = plan.variants.len();
    let bindings = plan.variants.iter().flat_map(|variant| &variant.bindings);
    let is_data = |resource| matches!(resource, Resource::Storage | Resource::Uniform);
    let buffers: BTreeSet<&str> =
        bindings.filter(|binding| is_data(binding.resource)).map(|binding| binding.name.as_str()).collect();
    let lines = lines(plan.variants.iter().map(|variant| variant.source.as_str()));
    let row = |what: &str, paper: &str, here: String| [what.to_owned(), paper.to_owned(), here];
    Ok(Counts(vec![
        row("programs", "16", format!("{draws} as fragment programs, one per output; {kernels} as compute shaders")),
        row(
            "textures",
            "20",
            format!(
                "{} streams; as fragment programs {} textures, {doubles} streams being read and written",
                streams.len(),
                streams.len() + doubles
            ),
        ),
        row("of these, outputs", "9", "all".to_owned()),
        row("the others, scene data", "11", format!("{} buffers and uniforms", buffers.len())),
        row("lines of Cg / WGSL", "912", format!("{lines}, without comments and blank lines")),
    ]))
}

/// Lines of code of all kernels; a declaration that several of them have counts once.
fn lines<'a>(sources: impl Iterator<Item = &'a str>) -> usize {
    let mut declarations = BTreeSet::new();
    for source in sources {
        let (mut depth, mut begin) = (0usize, 0);
        for (at, c) in source.char_indices() {
            match c {
                '{' => depth += 1,
                '}' => depth = depth.saturating_sub(1),
                _ => {}
            }
            if depth == 0 && matches!(c, '}' | ';') {
                declarations.insert(source[begin..=at].trim());
                begin = at + 1;
            }
        }
    }
    let is_code = |line: &&str| !line.trim().is_empty() && !line.trim().starts_with("//");
    declarations.iter().flat_map(|text| text.lines()).filter(is_code).count()
}

impl Counts {
    /// A table.
    #[must_use]
    pub fn text(&self) -> String {
        let head = std::iter::once(cells(["", "paper", "here"]));
        let lines: Vec<Vec<String>> = head.chain(self.0.iter().map(|row| row.to_vec())).collect();
        titled("Sections 4.5 and 5.2: what the ray tracer consists of", &lines, 3)
    }

    /// The CSV file.
    ///
    /// # Errors
    /// If memory is short.
    pub fn csv(&self) -> Result<Vec<u8>, Error> {
        let row = |[name, paper, here]: &[String; 3]| {
            Row::new(COLUMNS).set("name", name.as_str()).set("paper", paper.as_str()).set("here", here.as_str())
        };
        Ok(Table { columns: COLUMNS, rows: self.0.iter().map(row).collect() }.csv()?)
    }
}

#[cfg(test)]
mod tests {
    use super::lines;

    #[test]
    fn a_shared_declaration_and_comments_are_not_counted_again() {
        let shared = "// A comment.\nfn f() -> u32 {\n    // Another.\n    return 1;\n}\n";
        let first = format!("const A = 1;\n\n{shared}fn g() {{}}\n");
        assert_eq!(lines([first.as_str()].into_iter()), 5);
        assert_eq!(lines([first.as_str(), shared, "const B = 2;"].into_iter()), 6);
        assert_eq!(lines([""].into_iter()), 0);
    }
}
