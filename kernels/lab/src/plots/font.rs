//! The font of plots: how wide a text is, and its outlines.
//!
//! Arimo by Steve Matteson has the widths of Arial and Helvetica, which SVG files name, so a text is as wide there as it
//! is measured here. PDF files hold its outlines: publishers refuse fonts that a file does not contain. `arimo.ttf` is
//! `Arimo-Regular.ttf` 1.33 without hints, reduced to Latin, Greek, Cyrillic and signs by fonttools:
//!
//! ```text
//! pyftsubset Arimo-Regular.ttf --output-file=arimo.ttf --no-hinting --notdef-outline --no-glyph-names \
//!   --layout-features='' --drop-tables+=GDEF,GPOS,GSUB,kern,DSIG,gasp,meta --name-IDs=0,1,2,5,13,14 \
//!   --unicodes=20-7E,A0-17F,192,218-21B,370-3FF,400-45F,490-491,2010-2015,2018-201E,2020-2022,2026,2030,2032-2033,\
//! 2039-203A,2070-2094,20AC,2113,2116,2122,2190-2195,2202,2206,220F,2211-2212,2215,221A,221E,2229,222B,2248,2260-2261,\
//! 2264-2265,25A0-25CF,FFFD
//! ```

use skrifa::instance::{LocationRef, Size};
use skrifa::outline::{DrawSettings, OutlinePen};
use skrifa::{FontRef, MetadataProvider as _};

use crate::text::visible;

/// Under the SIL Open Font License 1.1, see `arimo.txt`.
const FONT: &[u8] = include_bytes!("arimo.ttf");

/// The fonts that an SVG file names, all of the same widths.
pub(super) const FAMILY: &str = "Arial, Helvetica, 'Liberation Sans', Arimo, sans-serif";

/// Units of the font's size.
pub(super) const EM: f64 = 2048.0;

/// Above and below the baseline, relative to the size: letters with ascenders and descenders.
pub(super) const REACH: [f64; 2] = [0.73, 0.22];

/// The baseline below the middle of a text, relative to the size: between the middles of small letters and digits.
pub(super) const MIDDLE: f64 = 0.3;

/// Width of a text in one line. Characters that the font lacks are as wide as the box that stands for them.
#[must_use]
pub fn width(text: &str, size: f64) -> f64 {
    let Ok(font) = FontRef::new(FONT) else { return 0.0 };
    let (glyphs, metrics) = (font.charmap(), font.glyph_metrics(Size::unscaled(), LocationRef::default()));
    let advance = |c| f64::from(metrics.advance_width(glyphs.map(c).unwrap_or_default()).unwrap_or_default());
    text.chars().map(advance).sum::<f64>() * size / EM
}

/// Draws the outlines of a text from its left end on the baseline, in units of the font, y upwards. `next` is told where
/// each glyph begins.
pub(super) fn outlines<P: OutlinePen>(text: &str, pen: &mut P, mut next: impl FnMut(&mut P, f32)) {
    let Ok(font) = FontRef::new(FONT) else { return };
    let (characters, glyphs) = (font.charmap(), font.outline_glyphs());
    let metrics = font.glyph_metrics(Size::unscaled(), LocationRef::default());
    let mut x = 0.0;
    for character in text.chars() {
        let glyph = characters.map(character).unwrap_or_default();
        next(pen, x);
        if let Some(outline) = glyphs.get(glyph) {
            // The font is a part of the program, so it has no glyph that cannot be drawn.
            let _ = outline.draw(DrawSettings::unhinted(Size::unscaled(), LocationRef::default()), pen);
        }
        x += metrics.advance_width(glyph).unwrap_or_default();
    }
}

/// The lines of a text of at most this width: broken between words, or, where one is wider, within it. No more than
/// [`MOST_LINES`]; what does not fit ends in "…".
pub(super) fn wrapped(text: &str, size: f64, most: f64) -> Vec<String> {
    let mut lines: Vec<String> = vec![String::new()];
    let text = visible(text);
    // What lies beyond all lines is not measured.
    for word in text.split_whitespace().take(MOST_WORDS) {
        let last = lines.last_mut().map(std::mem::take).unwrap_or_default();
        let joined = if last.is_empty() { word.to_owned() } else { format!("{last} {word}") };
        match width(&joined, size) <= most {
            true => lines.last_mut().into_iter().for_each(|line| line.clone_from(&joined)),
            false => {
                if last.is_empty() {
                    lines.pop();
                } else {
                    lines.last_mut().into_iter().for_each(|line| line.clone_from(&last));
                }
                lines.extend(pieces(word, size, most));
            }
        }
    }
    if lines.len() > MOST_LINES {
        lines.truncate(MOST_LINES);
        if let Some(last) = lines.last_mut() {
            while width(last, size) + width("…", size) > most && last.pop().is_some() {}
            last.push('…');
        }
    }
    lines
}

/// The most lines of a text.
const MOST_LINES: usize = 16;
/// The most words of a text, and the most characters of a word: more than all lines hold.
const MOST_WORDS: usize = 1000;

/// A word in pieces of at most this width; of one character at least.
fn pieces(word: &str, size: f64, most: f64) -> Vec<String> {
    let mut pieces = vec![String::new()];
    let mut reached = 0.0;
    for character in word.chars().take(MOST_WORDS) {
        let own = width(character.encode_utf8(&mut [0; 4]), size);
        if reached + own > most && reached > 0.0 {
            pieces.push(String::new());
            reached = 0.0;
        }
        reached += own;
        pieces.last_mut().into_iter().for_each(|piece| piece.push(character));
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_are_those_of_helvetica() {
        // From Adobe's metrics of Helvetica, in thousandths of its size.
        for (text, thousandths) in [("W", 944.0), ("i", 222.0), ("0", 556.0), ("Ab", 667.0 + 556.0), (" ", 278.0)] {
            let width = width(text, 1000.0);
            // Units of 1/2048 do not hit thousandths.
            assert!((width - thousandths).abs() < 1.0, "{text}: {width}");
        }
        assert!(width("≤ − × µ ² ⁻²⁴", 12.0) > 40.0);
    }

    #[test]
    fn lines_are_no_wider_than_asked_and_hold_the_whole_text() {
        let text = "irregular, compact, a_name_that_is_rather_longer_than_one_line_of_this_width";
        let lines = wrapped(text, 12.0, 120.0);
        assert!(lines.len() > 2 && lines.iter().all(|line| width(line, 12.0) <= 120.0), "{lines:?}");
        assert_eq!(lines.concat().replace(' ', ""), text.replace(' ', ""));
        assert_eq!(wrapped("", 12.0, 120.0), [""]);
        let endless = wrapped(&"x".repeat(1 << 20), 12.0, 120.0);
        assert!(endless.len() == MOST_LINES && endless[MOST_LINES - 1].ends_with('…'), "{endless:?}");
    }
}
