//! Expressions of `@if`: names of options, `!`, `&&`, `||` and parentheses.

use super::words::code;

/// Evaluates an expression, given the value of each option.
///
/// # Errors
/// With a message about the part that cannot be parsed, or the option that does not exist.
pub(super) fn holds(expression: &str, option: &dyn Fn(&str) -> Option<bool>) -> Result<bool, String> {
    let words: Vec<&str> = code(expression).into_iter().map(|word| word.text).collect();
    let mut parser = Parser { words, at: 0, option };
    let value = parser.or()?;
    match parser.word() {
        "" => Ok(value),
        more => Err(format!("{more:?} after the end of the expression")),
    }
}

struct Parser<'a> {
    words: Vec<&'a str>,
    at: usize,
    option: &'a dyn Fn(&str) -> Option<bool>,
}

impl<'a> Parser<'a> {
    fn word(&self) -> &'a str {
        self.words.get(self.at).copied().unwrap_or_default()
    }

    /// Consumes a sign of two equal characters if it comes next; returns whether it did.
    fn pair(&mut self, sign: &str) -> bool {
        let is_next = self.word() == sign && self.words.get(self.at + 1) == Some(&sign);
        if is_next {
            self.at += 2;
        }
        is_next
    }

    fn or(&mut self) -> Result<bool, String> {
        let mut value = self.and()?;
        while self.pair("|") {
            value |= self.and()?;
        }
        Ok(value)
    }

    fn and(&mut self) -> Result<bool, String> {
        let mut value = self.not()?;
        while self.pair("&") {
            value &= self.not()?;
        }
        Ok(value)
    }

    fn not(&mut self) -> Result<bool, String> {
        let word = self.word();
        self.at += 1;
        match word {
            "!" => Ok(!self.not()?),
            "(" => {
                let value = self.or()?;
                if self.word() != ")" {
                    return Err("a parenthesis is not closed".into());
                }
                self.at += 1;
                Ok(value)
            }
            "" => Err("the expression ends too early".into()),
            name => (self.option)(name).ok_or_else(|| format!("no option is named {name:?}")),
        }
    }
}
