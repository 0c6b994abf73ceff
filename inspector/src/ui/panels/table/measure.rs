//! Widths of columns and heights of rows, so that no text is cut off.

use egui::{FontId, TextStyle, Ui};

use super::rows::{Head, Kind, Rows};

/// Between columns, in points.
pub(super) const GAP: f32 = 8.0;
/// Left of the first column.
pub(super) const MARGIN: f32 = 4.0;
/// Room of a swatch before a text.
pub(super) const SWATCH: f32 = 11.0;
/// Indentation of each level of a tree.
pub(super) const INDENT: f32 = 12.0;
/// Room of an arrow that folds.
pub(super) const ARROW: f32 = 16.0;
/// Most lines of a sentence; more are shown when hovering.
pub(super) const MOST_LINES: f32 = 4.0;
/// The least width of a column of sentences beside the others.
const LEAST_PROSE: f32 = 260.0;

/// The font of a column.
pub(super) fn font(ui: &Ui, kind: Kind) -> FontId {
    let style = if kind == Kind::Number { TextStyle::Monospace } else { TextStyle::Body };
    style.resolve(ui.style())
}

/// The room before a text of the column of branches.
pub(super) fn indentation(rows: &dyn Rows, row: usize) -> f32 {
    if rows.unfolded().is_none() { 0.0 } else { INDENT * rows.depth(row) as f32 + ARROW }
}

/// The widths that texts need.
#[derive(Clone, Debug, Default)]
pub(super) struct Widths {
    /// What they were measured for: a version, and the fonts' sizes.
    known: Option<(u64, [u32; 3])>,
    /// Rows measured.
    rows: usize,
    /// By column.
    pub(super) columns: Vec<f32>,
    /// The width of each row's sentence in one line.
    pub(super) prose: Vec<f32>,
    /// Incremented when anything has changed.
    pub(super) edition: u64,
}

impl Widths {
    /// Measures what is new. Only added rows are measured if the version is the same.
    pub(super) fn update(&mut self, ui: &Ui, heads: &[Head<'_>], rows: &dyn Rows, version: u64) {
        let fonts = [Kind::Text, Kind::Number].map(|kind| font(ui, kind));
        let sizes = [fonts[0].size, fonts[1].size, ui.pixels_per_point()].map(f32::to_bits);
        let known = Some((version, sizes));
        if self.known != known || rows.count() < self.rows || self.columns.len() != heads.len() {
            *self = Self { known, columns: vec![0.0; heads.len()], edition: self.edition, ..Self::default() };
            for (width, head) in self.columns.iter_mut().zip(heads) {
                *width = wide(ui, &fonts[0], head.name) + 1.0;
            }
            self.edition += 1;
        } else if rows.count() == self.rows {
            return;
        }
        for row in self.rows..rows.count() {
            for (column, head) in heads.iter().enumerate() {
                let swatch = if rows.has_swatches(column) { SWATCH } else { 0.0 };
                let text = rows.text(row, column);
                let width = wide(ui, &fonts[usize::from(head.kind == Kind::Number)], &text) + swatch;
                match head.kind {
                    Kind::Prose => self.prose.push(width),
                    Kind::Text | Kind::Number => self.columns[column] = self.columns[column].max(width),
                    Kind::Tree => self.columns[column] = self.columns[column].max(width + indentation(rows, row)),
                }
            }
        }
        self.rows = rows.count();
        self.edition += 1;
    }

    /// A text turned out to be wider, by the shaping of its letters. Returns whether the column had to grow.
    pub(super) fn grow(&mut self, column: usize, width: f32) -> bool {
        let Some(known) = self.columns.get_mut(column).filter(|known| **known + 0.5 < width) else { return false };
        *known = width;
        self.edition += 1;
        true
    }
}

/// The width of a text in one line, without shaping.
fn wide(ui: &Ui, font: &FontId, text: &str) -> f32 {
    ui.fonts_mut(|fonts| text.chars().map(|c| fonts.glyph_width(font, c)).sum::<f32>()).ceil()
}

/// Where columns are.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Columns {
    /// Left edge and width of each.
    pub(super) at: Vec<[f32; 2]>,
    /// The whole width.
    pub(super) width: f32,
    /// Whether sentences are below the other columns.
    pub(super) is_below: bool,
    /// The width in which sentences wrap.
    pub(super) prose: f32,
    /// Columns without room.
    pub(super) left_out: Vec<usize>,
}

/// Places columns in the available width.
pub(super) fn place(heads: &[Head<'_>], widths: &Widths, available: f32) -> Columns {
    let is_prose = |i: usize| heads.get(i).is_some_and(|head| head.kind == Kind::Prose);
    let has_prose = heads.iter().any(|head| head.kind == Kind::Prose);
    let columns = widths.columns.iter().enumerate();
    let mut others: f32 = columns.filter(|(i, _)| !is_prose(*i)).map(|(_, width)| width + GAP).sum::<f32>() + MARGIN;
    let mut left_out = Vec::new();
    for (i, width) in widths.columns.iter().enumerate().rev() {
        if others > available && heads.get(i).is_some_and(|head| head.is_minor) {
            left_out.push(i);
            others -= width + GAP;
        }
    }
    let longest = widths.prose.iter().copied().fold(0.0, f32::max).max(80.0);
    let left_over = available - others - GAP;
    let is_below = has_prose && left_over < longest.min(LEAST_PROSE);
    let mut x = MARGIN;
    let mut at = Vec::with_capacity(heads.len());
    for (i, &width) in widths.columns.iter().enumerate() {
        let width = match (is_prose(i), is_below) {
            (false, _) => width,
            (true, false) => left_over.min(longest + 2.0),
            (true, true) => 0.0,
        };
        let width = if left_out.contains(&i) { 0.0 } else { width };
        at.push([x, width]);
        x += if width > 0.0 { width + GAP } else { 0.0 };
    }
    let prose = if is_below { available - 2.0 * GAP } else { left_over.min(longest + 2.0) };
    Columns { at, width: x.max(available), is_below, prose: prose.max(60.0), left_out }
}

/// The top of every row, and the bottom of the last.
pub(super) fn tops(order: impl Iterator<Item = usize>, widths: &Widths, columns: &Columns, line: f32) -> Vec<f32> {
    let mut top = 0.0;
    let mut tops = vec![top];
    for row in order {
        top += lines(widths.prose.get(row).copied(), columns) * line + PADDING;
        tops.push(top);
    }
    tops
}

/// Space around the text of a row.
pub(super) const PADDING: f32 = 4.0;

/// The lines of a row whose sentence takes this width in one line.
fn lines(prose: Option<f32>, columns: &Columns) -> f32 {
    let Some(prose) = prose else { return 1.0 };
    // Words do not break: a line is rarely full.
    let factor = if prose > columns.prose { 1.12 } else { 1.0 };
    let sentence = (prose * factor / columns.prose).ceil().clamp(0.0, MOST_LINES);
    if columns.is_below { 1.0 + sentence } else { sentence.max(1.0) }
}

#[cfg(test)]
mod tests {
    use super::super::rows::{Listed, ListedCell};
    use super::*;

    const HEADS: [Head<'_>; 3] = [Head::number("n", ""), Head::prose("why", ""), Head::text("name", "")];

    fn listed(rows: &[(&str, &str, &str)]) -> Listed {
        let row = |(n, why, name): &(&str, &str, &str)| [n, why, name].map(|text| ListedCell::text(*text)).to_vec();
        Listed { rows: rows.iter().map(row).collect() }
    }

    #[test]
    fn columns_fit_their_widest_text_and_only_new_rows_are_measured() {
        // The usual test context has no fonts.
        let output = egui::Context::default().run_ui(egui::RawInput::default(), |ui| {
            let mut widths = Widths::default();
            let long = "a".repeat(40);
            let few = listed(&[("1", "short", "b"), ("123456789", "short", "c")]);
            widths.update(ui, &HEADS, &few, 1);
            let number = ui.fonts_mut(|fonts| fonts.glyph_width(&font(ui, Kind::Number), '1')) * 9.0;
            assert!(number > 40.0);
            assert!((widths.columns[0] - number).abs() <= 1.0, "{} for {number}", widths.columns[0]);
            let (before, edition) = (widths.columns[2], widths.edition);
            widths.update(ui, &HEADS, &few, 1);
            assert_eq!(widths.edition, edition, "nothing is new");
            let more = listed(&[("1", "short", "b"), ("123456789", "short", "c"), ("2", "short", &long)]);
            widths.update(ui, &HEADS, &more, 1);
            assert!(widths.columns[2] > before && widths.prose.len() == 3 && widths.edition > edition);
            widths.update(ui, &HEADS, &few, 2);
            assert!(widths.columns[2] == before && widths.prose.len() == 2, "another version is measured anew");
            assert!(widths.grow(2, before + 5.0) && !widths.grow(2, before + 5.0));
        });
        output.drop_without_applying_deltas();
    }

    #[test]
    fn minor_columns_are_left_out_where_not_all_have_room() {
        let heads = [HEADS[0], HEADS[2].minor(), HEADS[0].minor(), HEADS[0]];
        let widths = Widths { columns: vec![40.0, 60.0, 30.0, 50.0], ..Widths::default() };
        let shown = |available: f32| {
            let columns = place(&heads, &widths, available);
            let shown: Vec<usize> = (0..4).filter(|&i| columns.at[i][1] > 0.0).collect();
            let [x, width] = columns.at[3];
            (shown, x + width)
        };
        assert_eq!(shown(300.0), (vec![0, 1, 2, 3], MARGIN + 180.0 + 3.0 * GAP));
        // From the right, and no more than it takes.
        assert_eq!(shown(200.0), (vec![0, 1, 3], MARGIN + 150.0 + 2.0 * GAP));
        for available in [150.0, 20.0] {
            assert_eq!(shown(available), (vec![0, 3], MARGIN + 90.0 + GAP));
        }
    }

    #[test]
    fn sentences_go_below_where_they_have_no_room_beside() {
        let widths = Widths { columns: vec![40.0, 30.0, 60.0], prose: vec![500.0, 90.0], ..Widths::default() };
        let wide = place(&HEADS, &widths, 800.0);
        assert!(!wide.is_below && wide.at[2][0] + 60.0 <= 800.0, "{wide:?}");
        let narrow = place(&HEADS, &widths, 300.0);
        assert!(narrow.is_below && narrow.width == 300.0 && narrow.at[1][1] == 0.0, "{narrow:?}");
        let tops = |columns: &Columns| tops([0, 1].into_iter(), &widths, columns, 16.0);
        assert_eq!(tops(&wide), [0.0, 20.0, 40.0]);
        // One line of columns, and two of the longer sentence.
        assert_eq!(tops(&narrow), [0.0, 52.0, 88.0]);
        let tiny = place(&HEADS, &widths, 30.0);
        assert!(tiny.prose >= 60.0 && tiny.width >= 100.0, "{tiny:?}");
    }
}
