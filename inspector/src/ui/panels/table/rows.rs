//! What a table shows: its columns, and the texts, numbers and looks of its cells.

use egui::{Color32, Ui};

/// How a column is laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::ui) enum Kind {
    /// Left-aligned, one line.
    Text,
    /// Right-aligned, in monospaced digits.
    Number,
    /// As text; in a tree, indented, with arrows that fold.
    Tree,
    /// A sentence: wraps, and goes below the other columns where the panel is narrow. At most one column.
    Prose,
}

/// The head of a column.
#[derive(Clone, Copy, Debug)]
pub(in crate::ui) struct Head<'a> {
    /// Its name.
    pub(in crate::ui) name: &'a str,
    /// What it holds.
    pub(in crate::ui) about: &'a str,
    /// How it is laid out.
    pub(in crate::ui) kind: Kind,
    /// Whether it is left out where not all columns have room.
    pub(in crate::ui) is_minor: bool,
}

impl<'a> Head<'a> {
    /// A column of text.
    pub(in crate::ui) const fn text(name: &'a str, about: &'a str) -> Self {
        Self { name, about, kind: Kind::Text, is_minor: false }
    }

    /// A column of numbers.
    pub(in crate::ui) const fn number(name: &'a str, about: &'a str) -> Self {
        Self { name, about, kind: Kind::Number, is_minor: false }
    }

    /// The column of a tree's branches.
    pub(in crate::ui) const fn tree(name: &'a str, about: &'a str) -> Self {
        Self { name, about, kind: Kind::Tree, is_minor: false }
    }

    /// A column of sentences.
    pub(in crate::ui) const fn prose(name: &'a str, about: &'a str) -> Self {
        Self { name, about, kind: Kind::Prose, is_minor: false }
    }

    /// The same, left out where not all columns have room.
    pub(in crate::ui) const fn minor(self) -> Self {
        Self { is_minor: true, ..self }
    }
}

/// How a cell looks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::ui) struct Look {
    /// The text's colour, if it is not the usual one.
    pub(in crate::ui) color: Option<Color32>,
    /// Whether it is in italics.
    pub(in crate::ui) is_italic: bool,
    /// A swatch before the text.
    pub(in crate::ui) swatch: Option<Color32>,
    /// A bar behind the text: its part of the column's width, from 0 to 1.
    pub(in crate::ui) bar: Option<(f32, Color32)>,
}

/// How a row with others below it is folded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::ui) struct Fold {
    /// Whether the rows below it are shown.
    pub(in crate::ui) is_open: bool,
    /// Whether that cannot be changed.
    pub(in crate::ui) is_fixed: bool,
}

/// The rows of a table. Texts must depend only on the [version](super::View::version); looks may change at any time.
pub(in crate::ui) trait Rows {
    /// The number of rows.
    fn count(&self) -> usize;
    /// The rows of a tree that are shown, unless sorted or filtered, and their version; `None` if this is no tree.
    fn unfolded(&self) -> Option<(u64, &[usize])> {
        None
    }
    /// How deep in the tree a row is.
    fn depth(&self, _row: usize) -> usize {
        0
    }
    /// For a row with others below it, which only a tree shows.
    fn fold(&self, _row: usize) -> Option<Fold> {
        None
    }
    /// Its name, for screen readers.
    fn fold_name(&self, _row: usize) -> String {
        String::new()
    }
    /// A cell's text.
    fn text(&self, row: usize, column: usize) -> String;
    /// A cell's number, for sorting and comparing.
    fn number(&self, _row: usize, _column: usize) -> Option<f64> {
        None
    }
    /// More about a cell: all digits of its number.
    fn about(&self, _row: usize, _column: usize) -> Option<String> {
        None
    }
    /// Whether the cells of a column have swatches.
    fn has_swatches(&self, _column: usize) -> bool {
        false
    }
    /// How a cell looks.
    fn look(&self, _ui: &Ui, _row: usize, _column: usize) -> Look {
        Look::default()
    }
}

/// Rows of texts and numbers that are there already.
#[derive(Clone, Debug, Default)]
pub(in crate::ui) struct Listed {
    /// The cells of each row.
    pub(in crate::ui) rows: Vec<Vec<ListedCell>>,
}

/// A cell of [`Listed`].
#[derive(Clone, Debug, Default)]
pub(in crate::ui) struct ListedCell {
    /// Its text.
    pub(in crate::ui) text: String,
    /// Its number.
    pub(in crate::ui) number: Option<f64>,
    /// More about it.
    pub(in crate::ui) about: Option<String>,
    /// How it looks.
    pub(in crate::ui) look: Look,
}

impl ListedCell {
    /// A cell of text.
    pub(in crate::ui) fn text(text: impl Into<String>) -> Self {
        Self { text: text.into(), ..Self::default() }
    }

    /// A cell with a number.
    pub(in crate::ui) fn number(number: f64, text: impl Into<String>) -> Self {
        Self { text: text.into(), number: Some(number), ..Self::default() }
    }

    /// With more about it.
    pub(in crate::ui) fn about(self, about: impl Into<String>) -> Self {
        Self { about: Some(about.into()), ..self }
    }

    /// With a look.
    pub(in crate::ui) fn look(self, look: Look) -> Self {
        Self { look, ..self }
    }
}

impl Listed {
    fn cell(&self, row: usize, column: usize) -> Option<&ListedCell> {
        self.rows.get(row)?.get(column)
    }
}

impl Rows for Listed {
    fn count(&self) -> usize {
        self.rows.len()
    }

    fn text(&self, row: usize, column: usize) -> String {
        self.cell(row, column).map_or_else(String::new, |cell| cell.text.clone())
    }

    fn number(&self, row: usize, column: usize) -> Option<f64> {
        self.cell(row, column)?.number
    }

    fn about(&self, row: usize, column: usize) -> Option<String> {
        self.cell(row, column)?.about.clone()
    }

    fn has_swatches(&self, column: usize) -> bool {
        self.cell(0, column).is_some_and(|cell| cell.look.swatch.is_some())
    }

    fn look(&self, _ui: &Ui, row: usize, column: usize) -> Look {
        self.cell(row, column).map_or_else(Look::default, |cell| cell.look)
    }
}
