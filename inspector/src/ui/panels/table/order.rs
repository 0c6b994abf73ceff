//! Which rows are shown, and in which order.

use std::cmp::Ordering;

use super::rows::{Head, Kind, Rows};

/// The column by which rows are sorted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Sort {
    pub(super) column: usize,
    pub(super) is_descending: bool,
}

impl Sort {
    /// The order after a click on the head of a column: ascending, descending, then the natural order.
    pub(super) fn clicked(now: Option<Self>, column: usize) -> Option<Self> {
        match now.filter(|sort| sort.column == column) {
            None => Some(Self { column, is_descending: false }),
            Some(Self { is_descending: false, .. }) => Some(Self { column, is_descending: true }),
            Some(_) => None,
        }
    }
}

/// A condition of the filter; a row is shown if all hold.
#[derive(Clone, Debug, PartialEq)]
enum Term {
    /// A cell contains this, in lower case.
    Word(String),
    /// The number of a column compared with another.
    Compare(usize, &'static str, f64),
}

impl Term {
    /// `t<0.7` for a column `t`, else a word. Units after a column's name are not part of it.
    fn new(text: &str, heads: &[Head<'_>]) -> Self {
        let compared = || {
            let (at, sign) = ["<=", ">=", "<", ">", "="].into_iter().find_map(|sign| Some((text.find(sign)?, sign)))?;
            let (name, value) = (&text[..at], text[at + sign.len()..].parse().ok()?);
            let is_named = |head: &Head<'_>| {
                let first = head.name.split([' ', ',']).next();
                head.name.eq_ignore_ascii_case(name) || first.is_some_and(|first| first.eq_ignore_ascii_case(name))
            };
            Some(Self::Compare(heads.iter().position(is_named)?, sign, value))
        };
        compared().unwrap_or_else(|| Self::Word(text.to_lowercase()))
    }

    fn holds(&self, rows: &dyn Rows, row: usize, text: &str) -> bool {
        match self {
            Self::Word(word) => text.contains(word.as_str()),
            Self::Compare(column, sign, value) => rows.number(row, *column).is_some_and(|number| match *sign {
                "<=" => number <= *value,
                ">=" => number >= *value,
                "<" => number < *value,
                ">" => number > *value,
                _ => number == *value,
            }),
        }
    }
}

/// What a cell is sorted by; what is missing comes last in both directions.
#[derive(Clone, Debug)]
enum Key {
    Number(f64),
    Text(String),
    Missing,
}

impl Key {
    fn new(rows: &dyn Rows, head: Option<&Head<'_>>, row: usize, column: usize) -> Self {
        match rows.number(row, column) {
            Some(number) => Self::Number(number),
            None if head.is_some_and(|head| head.kind == Kind::Number) => Self::Missing,
            None => Self::Text(rows.text(row, column).to_lowercase()),
        }
    }

    fn compare(&self, other: &Self, is_descending: bool) -> Ordering {
        let directed = |order: Ordering| if is_descending { order.reverse() } else { order };
        match (self, other) {
            (Self::Missing, Self::Missing) => Ordering::Equal,
            (Self::Missing, _) => Ordering::Greater,
            (_, Self::Missing) => Ordering::Less,
            (Self::Number(a), Self::Number(b)) => directed(a.total_cmp(b)),
            (Self::Text(a), Self::Text(b)) => directed(a.cmp(b)),
            (Self::Number(_), Self::Text(_)) => directed(Ordering::Less),
            (Self::Text(_), Self::Number(_)) => directed(Ordering::Greater),
        }
    }
}

/// The rows to show, in order; `None` for all of them in their natural order.
pub(super) fn order(rows: &dyn Rows, heads: &[Head<'_>], sort: Option<Sort>, filter: &str) -> Option<Vec<usize>> {
    let terms: Vec<Term> = filter.split_whitespace().map(|word| Term::new(word, heads)).collect();
    if terms.is_empty() && sort.is_none() {
        return None;
    }
    let has_words = terms.iter().any(|term| matches!(term, Term::Word(_)));
    let is_shown = |&row: &usize| {
        if rows.fold(row).is_some() {
            return false;
        }
        let text = match has_words {
            true => (0..heads.len()).map(|column| rows.text(row, column).to_lowercase() + "\n").collect(),
            false => String::new(),
        };
        terms.iter().all(|term| term.holds(rows, row, &text))
    };
    let shown = (0..rows.count()).filter(is_shown);
    let Some(Sort { column, is_descending }) = sort else { return Some(shown.collect()) };
    let keyed = shown.map(|row| (Key::new(rows, heads.get(column), row, column), row));
    let mut keyed: Vec<(Key, usize)> = keyed.collect();
    // Stable: equal rows stay in their natural order.
    keyed.sort_by(|(a, _), (b, _)| a.compare(b, is_descending));
    Some(keyed.into_iter().map(|(_, row)| row).collect())
}

#[cfg(test)]
mod tests {
    use super::super::rows::{Listed, ListedCell};
    use super::*;

    const HEADS: [Head<'_>; 3] = [Head::text("kernel", ""), Head::number("t, scene units", ""), Head::prose("why", "")];

    fn rows() -> Listed {
        let row = |(kernel, t, why): (&str, Option<f64>, &str)| {
            let t = t.map_or_else(|| ListedCell::text("–"), |t| ListedCell::number(t, t.to_string()));
            vec![ListedCell::text(kernel), t, ListedCell::text(why)]
        };
        let rows = [
            ("intersect", Some(0.7), "Triangle 3"),
            ("traverse", None, "step +x"),
            ("intersect", Some(10.0), "triangle 4"),
            ("setup", Some(0.7), "starts"),
        ];
        Listed { rows: rows.map(row).to_vec() }
    }

    fn shown(sort: Option<(usize, bool)>, filter: &str) -> Vec<usize> {
        let sort = sort.map(|(column, is_descending)| Sort { column, is_descending });
        order(&rows(), &HEADS, sort, filter).unwrap_or_else(|| vec![99])
    }

    #[test]
    fn numbers_are_sorted_as_numbers_and_what_is_missing_is_last() {
        assert_eq!(shown(Some((1, false)), ""), [0, 3, 2, 1], "10 after 0.7; equal ones stay");
        assert_eq!(shown(Some((1, true)), ""), [2, 0, 3, 1]);
        assert_eq!(shown(Some((0, false)), ""), [0, 2, 3, 1]);
        assert_eq!(shown(None, "  "), [99], "the natural order takes no memory");
    }

    #[test]
    fn a_third_click_returns_to_the_natural_order() {
        let first = Sort::clicked(None, 2);
        let second = Sort::clicked(first, 2);
        assert_eq!(first, Some(Sort { column: 2, is_descending: false }));
        assert_eq!(second, Some(Sort { column: 2, is_descending: true }));
        assert_eq!(Sort::clicked(second, 2), None);
        assert_eq!(Sort::clicked(second, 0), Some(Sort { column: 0, is_descending: false }));
    }

    #[test]
    fn words_must_all_be_there_and_columns_are_compared() {
        assert_eq!(shown(None, "TRI inter"), [0, 2]);
        assert_eq!(shown(None, "tri 4"), [2]);
        assert_eq!(shown(None, "t<1"), [0, 3]);
        assert_eq!(shown(None, "t>=0.7 kernel"), Vec::<usize>::new(), "no cell contains the head's name");
        assert_eq!(shown(None, "T>=0.7 set"), [3]);
        assert_eq!(shown(None, "t=10"), [2]);
        assert_eq!(shown(None, "x<1"), Vec::<usize>::new(), "no such column: a word");
        assert_eq!(shown(Some((1, true)), "intersect"), [2, 0]);
    }
}
