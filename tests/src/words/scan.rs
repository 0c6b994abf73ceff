//! Parses an explanation from left to right.

use std::fmt::Debug;
use std::str::FromStr;

/// The remaining text.
pub(super) struct Scan<'a> {
    rest: &'a str,
}

/// Succeeds if both are equal; otherwise the error names them.
pub(super) fn same<T: PartialEq + Debug>(what: &str, said: T, is: T) -> Result<(), String> {
    if said == is { Ok(()) } else { Err(format!("{what}: {said:?} is said, and it is {is:?}")) }
}

impl<'a> Scan<'a> {
    pub(super) fn new(words: &'a str) -> Self {
        Self { rest: words }
    }

    /// Skips the text if it comes next.
    pub(super) fn is(&mut self, text: &str) -> bool {
        let rest = self.rest.strip_prefix(text);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    pub(super) fn literal(&mut self, text: &str) -> Result<(), String> {
        if self.is(text) { Ok(()) } else { Err(format!("{text:?} is wanted at {:?}", self.rest)) }
    }

    /// Parses a number, using all of its characters.
    pub(super) fn number<T: FromStr>(&mut self) -> Result<T, String> {
        let is_part = |c: char| c.is_ascii_alphanumeric() || "+-.".contains(c);
        let end = self.rest.find(|c| !is_part(c)).unwrap_or(self.rest.len());
        let (number, rest) = self.rest.split_at(end);
        self.rest = rest;
        number.parse().map_err(|_| format!("a number is wanted at {number:?}"))
    }

    /// `cell (1, 2, 3)`
    pub(super) fn cell(&mut self) -> Result<[i32; 3], String> {
        self.literal("cell (")?;
        let x = self.number()?;
        self.literal(", ")?;
        let y = self.number()?;
        self.literal(", ")?;
        let z = self.number()?;
        self.literal(")")?;
        Ok([x, y, z])
    }

    /// `+x`
    pub(super) fn way(&mut self) -> Result<(i32, usize), String> {
        let sign = if self.is("-") {
            -1
        } else {
            self.literal("+")?;
            1
        };
        Ok((sign, self.axis()?))
    }

    /// `x`
    pub(super) fn axis(&mut self) -> Result<usize, String> {
        let axis = ["x", "y", "z"].iter().position(|axis| self.is(axis));
        axis.ok_or_else(|| format!("an axis is wanted at {:?}", self.rest))
    }

    pub(super) fn end(&self) -> Result<(), String> {
        if self.rest.is_empty() { Ok(()) } else { Err(format!("nothing more is known at {:?}", self.rest)) }
    }
}
