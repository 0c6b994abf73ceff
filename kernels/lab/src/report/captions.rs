//! The captions of a report's figures for LaTeX: one file that defines all of them by the names of the figures' files.

use std::fmt::Write as _;

use super::page::{About, Figure, Scene, common};
use crate::html::plain;
use crate::plots::Format;

/// File name.
pub(super) const FILE: &str = "captions.tex";

/// What gives a caption. It is robust, so that it may stand in a caption; a list of figures needs its definitions, too.
const COMMAND: &str = "\\DeclareRobustCommand\\raystepcaption[1]{%
  \\ifcsname raystep-#1\\endcsname\\csname raystep-#1\\endcsname
  \\else\\errmessage{captions.tex has no figure #1}\\fi}
";

/// The file; `None` if there are no figures.
pub(super) fn tex(about: &About, scenes: &[Scene], seed: u32) -> Option<(String, Vec<u8>)> {
    let common = common(about, seed);
    let captions = scenes.iter().flat_map(|scene| {
        let caption = |(stem, figure): (String, &Figure)| {
            // On paper, the caption is also the heading.
            let text = format!("{}. {}", figure.plot.title(), plain(&scene.caption(figure, &common)));
            (stem, escaped(&text))
        };
        scene.named_figures().map(caption)
    });
    let captions: Vec<(String, String)> = captions.collect();
    let (first, _) = captions.first()?;
    let mut text = format!(
        "% Captions of the figures beside this file, in DIR. In the preamble of a document:\n%   \
         \\usepackage{{graphicx}}\n%   \\input{{DIR/captions}}\n% and where a figure belongs:\n%   \
         \\begin{{figure}}\\centering\n%     \\includegraphics{{DIR/{first}-{}.pdf}}\n%     \
         \\caption{{\\raystepcaption{{{first}}}}}\n%   \\end{{figure}}\n{COMMAND}",
        Format::OneColumn.name()
    );
    for (stem, caption) in &captions {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "\\expandafter\\def\\csname raystep-{stem}\\endcsname{{%\n  {caption}}}");
    }
    Some((FILE.to_owned(), text.into_bytes()))
}

/// Text as LaTeX.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    let mut before = None;
    for character in text.chars() {
        match (command(character), character) {
            (Some(command), _) => escaped += command,
            (None, '{' | '}' | '$' | '&' | '#' | '%' | '_') => escaped.extend(['\\', character]),
            // Two of them would be a dash, or other quotes.
            (None, '-' | '\'' | '`') if before == Some(character) => escaped.extend(['{', '}', character]),
            (None, _) => escaped.push(character),
        }
        before = Some(character);
    }
    escaped
}

/// The command for a sign that is none as it is, or that some engines lack. They have letters.
fn command(character: char) -> Option<&'static str> {
    Some(match character {
        '\\' => "\\textbackslash{}",
        '~' => "\\textasciitilde{}",
        '^' => "\\textasciicircum{}",
        '<' => "\\textless{}",
        '>' => "\\textgreater{}",
        '|' => "\\textbar{}",
        '"' => "''",
        '…' => "\\dots{}",
        '−' => "$-$",
        '×' => "$\\times$",
        '≤' => "$\\leq$",
        '≥' => "$\\geq$",
        '²' => "$^2$",
        'µ' => "$\\mu$",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plots::{Axis, Plot, Scale, Series};
    use crate::report::page::Part;
    use crate::subject::Size;

    #[test]
    fn what_latex_would_obey_is_text() {
        assert_eq!(escaped("95% of #1 & a_b"), "95\\% of \\#1 \\& a\\_b");
        assert_eq!(escaped("\\input{x} $y$"), "\\textbackslash{}input\\{x\\} \\$y\\$");
        assert_eq!(
            escaped("--seed ~1 <2^3> ≤ 4 µs"),
            "-{}-seed \\textasciitilde{}1 \\textless{}2\\textasciicircum{}3\\textgreater{} $\\leq$ 4 $\\mu$s"
        );
        assert_eq!(escaped("ÜberTrace, сцена"), "ÜberTrace, сцена");
    }

    #[test]
    fn every_figure_has_a_caption_by_the_name_of_its_files() {
        let scene = |slug: &str, has_figure: bool| {
            let mut part = Part::default();
            let axis = |label: &str| Axis::new(label, Scale::Linear);
            let (title, series) = ("Time".to_owned(), vec![Series::line("a", 0, vec![(1.0, 2.0), (2.0, 1.0)])]);
            if has_figure {
                let plot = Plot::new(title, axis("x"), axis("y"), series);
                part.figure("time", plot, "Median &lt; <b>5</b>.");
            }
            let (name, size) = ("a_<b>".to_owned(), Size { width: 3, height: 2 });
            let parts = vec![("grid", part)];
            Scene { name, file: String::new(), slug: slug.into(), triangles: 7, size, rays: None, parts }
        };
        let about: About = vec![("adapter", "GPU #1".into())];
        assert_eq!(tex(&about, &[scene("a", false)], 5), None);
        let (name, bytes) = tex(&about, &[scene("a", true), scene("b", true)], 5).expect("figures");
        let text = String::from_utf8(bytes).expect("UTF-8");
        assert_eq!(name, "captions.tex");
        for slug in ["a", "b"] {
            let expected = format!(
                "\\csname raystep-{slug}-grid-time\\endcsname{{%\n  Time. Median \\textless{{}} 5. \
                 a\\_\\textless{{}}b\\textgreater{{}}, GPU \\#1; seed 5.}}\n"
            );
            assert!(text.contains(&expected), "{text}");
        }
        assert!(text.contains("\\includegraphics{DIR/a-grid-time-one-column.pdf}"), "{text}");
    }
}
